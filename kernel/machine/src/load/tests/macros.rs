//! Macros of families and their children, and mistakes in their files.

use super::*;
use crate::index::places;
use crate::macros::model::Hook;

fn family() -> MemoryFiles {
    let mut files = MemoryFiles::default();
    let rows = r#"
[[codes]]
id = "CODE_TOOL_LOAD"
word = "M6"
[macros]
declaration = "declare.mac"
functions = ["sub/functions.mac"]
motion = "own.mac"
[[macros.code]]
name = "guard"
id = 5
match = ["CODE_RAPID", "CODE_SPINDLE_CLW"]
file = "own.mac"
[[macros.code]]
name = "watch"
match = ["CODE_RAPID"]
file = "own.mac"
[[macros.data]]
match = ["REG_AXIS_X"]
file = "own.mac"
"#;
    files.insert("family/machine.toml", format!("{BASE}{rows}"));
    files.insert("family/declare.mac", "DECLAR/OBJECT,REAL,TOP=TWICE(2)");
    files.insert("family/own.mac", "%G01=TWICE(2)");
    files.insert("family/sub/functions.mac", "MACRO/TWICE(N)\nTWICE=N*2\nENDMAC");
    files
}

#[test]
fn a_family_brings_its_macros_and_a_child_replaces_rows() {
    let mut files = family();
    // The declaration is before the functions and may not call them: it is another file in the child.
    let child = r#"extends = "family"
[ce]
name = "child"
[macros]
declaration = "first.mac"
tool = "own.mac"
[[macros.code]]
name = "guard"
id = 9
match = ["CODE_SPINDLE_CLW"]
enabled = false
file = "own.mac"
"#;
    files.insert("child/machine.toml", child);
    files.insert("child/first.mac", "DECLAR/OBJECT,REAL,PARTS");
    files.insert("child/own.mac", "PARTS=TWICE(3)");
    let loaded = load(&files, "child");
    let findings: Vec<String> = loaded.findings.iter().map(ToString::to_string).collect();
    assert_eq!(findings, [""; 0]);
    let machine = loaded.machine.unwrap();
    let macros = machine.macros.as_deref().unwrap();
    let file = |code: u16| macros.program.macros[usize::from(code)].name.clone();
    assert_eq!(macros.hook(Hook::Declaration).map(file).as_deref(), Some("child/first.mac"));
    assert_eq!(macros.hook(Hook::Motion).map(file).as_deref(), Some("family/own.mac"));
    assert_eq!(macros.hook(Hook::Tool).map(file).as_deref(), Some("child/own.mac"));
    assert_eq!(macros.hook(Hook::BlockStartup), None);
    let rows: Vec<_> =
        macros.codes.iter().map(|row| (row.id, row.name.as_str(), row.enabled, file(row.code))).collect();
    let (family, child) = ("family/own.mac".to_owned(), "child/own.mac".to_owned());
    assert_eq!(rows, [(9, "guard", false, child), (10, "watch", true, family)]);
    assert_eq!(macros.data.as_slice()[0].name, "REG_AXIS_X");
    let rapid = crate::ident::codes::RAPID;
    assert_eq!(places(macros.of_code(rapid)), [1]);
    assert_eq!(places(macros.of_code(crate::ident::codes::SPINDLE_CLW)), [0]);
}

#[test]
fn mistakes_of_a_family_stand_where_they_are() {
    let mut files = family();
    files.insert("family/sub/functions.mac", "MACRO/TWICE(N)\nTWICE=N*$XYZ\nENDMAC");
    let found: Vec<String> = load(&files, "family").findings.iter().map(ToString::to_string).collect();
    // The declaration comes before the functions.
    assert!(found[0].starts_with("family/declare.mac:1:24: error: 02910021"), "{found:?}");
    assert!(found[1].starts_with("family/sub/functions.mac:2:9: error: 02910020"), "{found:?}");
    assert_eq!(found.len(), 2, "{found:?}");
}

#[test]
fn a_code_without_a_row_is_a_warning() {
    let text = "[[macros.code]]\nmatch = [\"CODE_COOLANT_OFF\"]\nfile = \"a.mac\"\n";
    let mut files = MemoryFiles::default();
    files.insert("m/machine.toml", format!("{BASE}{text}"));
    files.insert("m/a.mac", "OUTPUT");
    let loaded = load(&files, "m");
    assert!(loaded.machine.is_some());
    assert_eq!(loaded.findings.len(), 1);
    assert!(!loaded.findings[0].error && loaded.findings[0].text.contains("never fires"));
}
