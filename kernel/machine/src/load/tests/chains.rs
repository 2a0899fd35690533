//! Families: inherited, replaced and added parts of a child, and chains that cannot be followed.

use super::*;
use crate::ident::codes;
use crate::ident::dimension::Dimension;
use crate::model::Machine;
use crate::rows::{CodeForm, CodeRow, Modality};

fn load_over_base(child: &str) -> Loaded {
    let mut files = MemoryFiles::default();
    files.insert("base/machine.toml", BASE);
    files.insert("m/machine.toml", format!("extends = \"base\"\n[ce]\nname = \"child\"\n{child}"));
    load(&files, "m")
}

fn machine(child: &str) -> Machine {
    let loaded = load_over_base(child);
    // Codes of its own have no macros here, which is worth a warning.
    let others = loaded.findings.iter().filter(|finding| !finding.text.contains("is a code of your own"));
    assert_eq!(others.count(), 0, "{:#?}", loaded.findings);
    loaded.machine.unwrap()
}

fn row(machine: &Machine, id: crate::ident::CodeId) -> &CodeRow {
    machine.codes.iter().find(|row| row.id == id).unwrap()
}

#[test]
fn rows_keep_the_file_and_line_that_define_them() {
    let machine = machine("[[codes]]\nid = \"CODE_STOP\"\nword = \"M0\"");
    assert_eq!((row(&machine, codes::STOP).file.as_str(), row(&machine, codes::STOP).line), ("m/machine.toml", 4));
    assert_eq!(row(&machine, codes::RAPID).file, "base/machine.toml");
}

#[test]
fn a_row_of_the_same_name_is_replaced_as_a_whole_and_in_its_place() {
    let machine = machine(
        "[[codes]]\nid = \"code_rapid\"\nword = \"G0\"\nenable = false\n[[registers]]\nname = \"M\"\nwhole = 3\n\
         [[axes]]\nname = \"X1\"\nrapid = 5\n[[channels]]\nnumber = 1\nname = \"ONLY\"\naxes = [\"X1\"]",
    );
    assert_eq!(machine.codes.len(), 2);
    assert!(!machine.codes.as_slice()[0].enable);
    assert_eq!(machine.registers.iter().map(|r| r.name.as_str()).collect::<Vec<_>>(), ["G", "M", "X", "P"]);
    assert_eq!(machine.axes.as_slice()[0].rapid, 5.0);
    assert_eq!(machine.channels[0].name, "ONLY");
}

#[test]
fn tables_merge_key_by_key_and_other_lists_are_replaced() {
    let mut files = MemoryFiles::default();
    files.insert(
        "base/machine.toml",
        format!("initial = [\"CODE_RAPID\"]\n{BASE}[time]\ntool_change = 3\nstations = 8\n[variables]\nshared = [[100, 199]]\n"),
    );
    files.insert(
        "mid/machine.toml",
        "extends = \"base\"\ninitial = []\n[time]\nstations = 12\n[variables]\nshared = [[500, 599]]",
    );
    files.insert("m/machine.toml", "extends = \"mid\"\n[ce]\nname = \"x\"");
    let machine = load(&files, "m").machine.unwrap();
    assert_eq!((machine.time.tool_change, machine.time.stations), (3.0, 12));
    assert_eq!(machine.variables.shared, [(500, 599)]);
    assert!(machine.initial.is_empty());
}

#[test]
fn identity_is_not_inherited() {
    let mut files = MemoryFiles::default();
    files.insert("base/machine.toml", format!("abstract = true\n{BASE}"));
    files.insert("m/machine.toml", "extends = \"base\"");
    let findings = load(&files, "m").findings;
    assert_eq!(findings.len(), 1, "{findings:?}");
    assert_eq!(findings[0].text, "[ce] needs `name`: 1 to 32 characters");
    let family = load(&files, "base");
    assert!(family.machine.is_none());
    let text = "base is a family (abstract = true), not a machine; name a machine that extends it";
    assert_eq!(family.findings.iter().map(|f| f.text.as_str()).collect::<Vec<_>>(), [text]);
}

#[test]
fn a_missing_parent_names_those_that_exist() {
    let mut files = MemoryFiles::default();
    files.insert("fanuc-turning/machine.toml", BASE);
    files.insert("other/machine.toml", BASE);
    files.insert("m/machine.toml", "\nextends = \"fanuc-turnin\"");
    let findings = load(&files, "m").findings;
    assert_eq!(
        findings.iter().map(ToString::to_string).collect::<Vec<_>>(),
        ["m/machine.toml:2:11: error: no machine to extend of the name \"fanuc-turnin\"; did you mean \
          \"fanuc-turning\"?; there are: fanuc-turning, m, other"]
    );
}

#[test]
fn a_parent_is_a_plain_name() {
    let mut files = MemoryFiles::default();
    files.insert("a/b/machine.toml", BASE);
    for name in ["a/b", "../m", ".", "", "a\\\\b"] {
        files.insert("m/machine.toml", format!("extends = \"{name}\""));
        let findings = load(&files, "m").findings;
        assert!(findings[0].text.starts_with("no machine to extend of the name"), "{findings:?}");
    }
}

#[test]
fn a_circle_is_named() {
    let mut files = MemoryFiles::default();
    files.insert("a/machine.toml", "extends = \"b\"");
    files.insert("b/machine.toml", "extends = \"a\"");
    let findings = load(&files, "a").findings;
    assert_eq!(
        findings.iter().map(ToString::to_string).collect::<Vec<_>>(),
        ["b/machine.toml:1:11: error: `extends` runs in a circle: a -> b -> a"]
    );
}

#[test]
fn a_missing_machine_is_one_finding() {
    let loaded = load(&MemoryFiles::default(), "nothing");
    assert!(loaded.machine.is_none());
    let texts: Vec<&str> = loaded.findings.iter().map(|f| f.text.as_str()).collect();
    assert_eq!(texts, ["no machine of the name \"nothing\"; there are none"]);
}

#[test]
fn mistakes_of_a_family_are_reported_in_its_file() {
    let mut files = MemoryFiles::default();
    files.insert("base/machine.toml", format!("{BASE}[time]\nrapid = 7\n"));
    files.insert("m/machine.toml", "extends = \"base\"\n[ce]\nname = \"x\"\nnumber = 0");
    let findings: Vec<String> = load(&files, "m").findings.iter().map(ToString::to_string).collect();
    let line = BASE.lines().count() + 2;
    assert_eq!(
        findings,
        [
            format!("base/machine.toml:{line}:9: error: `rapid` must be text in quotes, not a whole number"),
            "m/machine.toml:4:10: error: `number` must be a whole number from 1 to 999999, not 0".to_owned(),
        ]
    );
}

#[test]
fn times_of_m_codes_go_to_their_rows_and_make_rows_where_there_is_none() {
    let machine = machine("[time]\nm_codes = { \"3\" = 1.5, \"60\" = 8 }");
    assert_eq!(row(&machine, codes::SPINDLE_CLW).seconds, 1.5);
    let function = row(&machine, codes::FUNCTION);
    assert_eq!((function.seconds, function.modality), (8.0, Modality::NonModal));
    let m = machine.registers.find(|register| register.name == "M").unwrap();
    assert!(matches!(function.form, CodeForm::RegisterAsData { register, min: 60.0, max: 60.0, .. } if register == m));
    assert_eq!(crate::index::places(machine.tables.code(m, 60.0)), [2]);
}

#[test]
fn custom_names_follow_the_built_in_ones() {
    let machine = machine(
        "[[codes]]\nid = \"CODE_CUSTOM_1\"\nword = \"M50\"\ncustom = true\nas_data = \"REG_CUSTOM_1\"\n\
         [[codes]]\nid = \"CODE_IGNORE\"\ntext = \"G710\"\n\
         [[data]]\nid = \"REG_CUSTOM_1\"\nregister = \"P\"\ncustom = true\ndimension = \"length\"",
    );
    let custom = machine.codes.iter().find(|row| machine.code_name(row.id) == "CODE_CUSTOM_1").unwrap();
    assert_eq!((custom.order, custom.group, custom.process), (300, 0, true));
    let ignore = machine.codes.iter().find(|row| machine.code_name(row.id) == "CODE_IGNORE").unwrap();
    assert!(!ignore.process);
    let data = machine.data.iter().last().unwrap();
    assert_eq!((machine.data_name(data.id), data.dimension), ("REG_CUSTOM_1", Dimension::Length));
    assert_eq!(machine.tables.data(data.id).len(), 1);
}

#[test]
fn offsets_have_a_value_per_axis_of_the_machine() {
    let machine = machine(
        "[[axes]]\nname = \"X2\"\nrapid = 1\n[[channels]]\nnumber = 2\naxes = [\"X2\"]\n[tool]\n[[tool.offsets]]\nnumber = 2\nvalues = { X2 = -1.5 }\n\
         [[tool.offsets]]\nnumber = 1\nradius = 0.4\ntip = 3\n[[work_offsets]]\nnumber = 8\nvalues = { X1 = 7 }",
    );
    let offsets = &machine.tool.offsets;
    assert_eq!(offsets.iter().map(|o| (o.number, o.radius, o.tip)).collect::<Vec<_>>(), [(1, 0.4, 3), (2, 0.0, 0)]);
    assert_eq!(offsets[1].values.as_slice(), [0.0, -1.5]);
    assert_eq!(machine.work_offsets.len(), 8);
    assert_eq!(machine.work_offsets[7].as_slice(), [7.0, 0.0]);
    assert_eq!(machine.work_offsets[0].as_slice(), [0.0, 0.0]);
}
