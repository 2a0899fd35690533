//! Dialogs in the machine file and beside it.

use super::*;
use counterpoint_ports::dialog::answers::DialogValue;
use counterpoint_ports::dialog::{ButtonKind, FieldKind};

#[test]
fn dialogs_of_the_file_and_of_a_file_beside_it() {
    let mut files = MemoryFiles::default();
    let rows = r#"
[[dialogs]]
file = "clamp.toml"
[[dialogs]]
name = "Bar"
fields = [{ kind = "check", variable = "FEED", default = true }]
buttons = [{ label = "Go" }, { label = "Clamp", type = "call", dialog = "CLAMP" }]
"#;
    let clamp = r#"
name = "Clamp"
[[fields]]
kind = "number"
variable = "FORCE"
label = "Force, kN"
min = 1
max = 40
whole = true
default = 20
[[fields]]
kind = "choice"
variable = "JAWS"
choices = ["soft", { label = "hard", value = 2 }]
"#;
    files.insert("m/machine.toml", format!("{BASE}{rows}"));
    files.insert("m/clamp.toml", clamp);
    let loaded = load(&files, "m");
    assert_eq!(loaded.findings, []);
    let dialogs = loaded.machine.unwrap().dialogs;
    assert_eq!(dialogs[0].buttons.iter().map(|b| b.label.as_str()).collect::<Vec<_>>(), ["OK", "Cancel"]);
    assert_eq!(dialogs[0].fields[0].default, Some(DialogValue::Number(20.0)));
    let jaws = [("soft".to_owned(), DialogValue::Text("soft".into())), ("hard".to_owned(), DialogValue::Number(2.0))];
    assert_eq!(dialogs[0].fields[1].kind, FieldKind::Choice(jaws.into()));
    assert_eq!(dialogs[1].buttons[1].kind, ButtonKind::Call("CLAMP".into()));
}

#[test]
fn mistakes_in_dialogs() {
    let text = r#"[[dialogs]]
name = "A"
fields = [{ kind = "number", variable = "N", max = 3, default = 5 }]
buttons = [{ label = "No", type = "cancel" }]
[[dialogs]]
name = " a"
[[dialogs]]
name = "A"
fields = [{ kind = "choice", variable = "C" }, { kind = "text" }]
[[dialogs]]
file = "none.toml"
"#;
    let findings = after(text);
    for part in [
        "N must be -",
        "4:11: error: a dialog needs a button of type \"ok\"",
        "there is already a dialog \"A\"",
        "a choice needs `choices`",
        "a field needs `variable`",
        "the file m/none.toml does not exist",
    ] {
        assert!(findings.iter().any(|f| f.contains(part)), "{part}: {findings:#?}");
    }
}
