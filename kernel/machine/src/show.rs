//! A machine as text for people and as JSON for programs.
//!
//! Invariant: both are made from the checked machine alone, so they show the behaviour of the control, families and
//! defaults included.

mod components;
mod grid;
mod groups;
mod json;
mod macros;
mod refusals;
mod text;
mod variables;

pub use groups::subject as group_subject;
pub use json::{code as code_json, data as data_json, json, part as json_part, register_json};
pub use text::word_call;
pub use variables::variable;

use super::model::Machine;
use crate::index::RegisterId;

/// The content to show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Show {
    /// Everything below, one after the other.
    All,
    /// Name, kind, format, synchronisation, times, variables.
    Summary,
    /// Registers.
    Registers,
    /// Code table.
    Codes,
    /// Data table.
    Data,
    /// Axes.
    Axes,
    /// Channels and spindles.
    Channels,
    /// Modal groups with their codes.
    Groups,
    /// Macros the machine declares.
    Macros,
    /// Blocks that the control refuses.
    Refusals,
}

/// The machine, or a part of it, as aligned tables.
#[must_use]
pub fn show(machine: &Machine, what: Show) -> String {
    match what {
        Show::All => {
            let mut parts =
                vec![Show::Summary, Show::Channels, Show::Axes, Show::Registers, Show::Codes, Show::Groups, Show::Data];
            let any =
                |has: fn(&Machine) -> bool| components::with_macros(machine).iter().any(|(_, machine)| has(machine));
            parts.extend(any(|machine| !machine.diagnostics.refusals.is_empty()).then_some(Show::Refusals));
            parts.extend(any(|machine| machine.macros.is_some()).then_some(Show::Macros));
            parts.into_iter().map(|part| show(machine, part)).collect::<Vec<_>>().join("\n")
        }
        Show::Summary => text::summary(machine),
        Show::Registers => components::text(components::of(machine), text::registers),
        Show::Codes => components::text(components::of(machine), text::codes),
        Show::Data => components::text(components::of(machine), text::data),
        Show::Axes => text::axes(machine),
        Show::Channels => text::channels(machine),
        Show::Groups => components::text(components::of(machine), groups::text),
        Show::Macros => components::text(components::with_macros(machine), macros::text),
        Show::Refusals => components::text(components::of(machine), refusals::text),
    }
}

/// Code rows as the emulated control lists them: by register, then by value, texts after them, at last the rows
/// without a written form.
fn sorted_codes(machine: &Machine) -> Vec<&super::rows::CodeRow> {
    use super::rows::CodeForm;
    let place = |form: &CodeForm| match form {
        CodeForm::Register { register, min, max } | CodeForm::RegisterAsData { register, min, max, .. } => {
            (0, register.index(), *min, *max)
        }
        CodeForm::Text(_) => (1, 0, 0.0, 0.0),
        CodeForm::NotApplicable => (2, 0, 0.0, 0.0),
    };
    let mut rows: Vec<_> = machine.codes.iter().collect();
    rows.sort_by(|a, b| {
        let (a_place, b_place) = (place(&a.form), place(&b.form));
        let texts = |row: &super::rows::CodeRow| match &row.form {
            CodeForm::Text(text) => text.clone(),
            _ => String::new(),
        };
        a_place
            .partial_cmp(&b_place)
            .unwrap_or(std::cmp::Ordering::Equal)
            .then_with(|| texts(a).cmp(&texts(b)))
            .then(a.order.cmp(&b.order))
    });
    rows
}

/// Whether a row is a second form of its identifier, which an earlier row of the file also has.
fn is_alias(machine: &Machine, row: &super::rows::CodeRow) -> bool {
    machine.codes.iter().take_while(|other| !std::ptr::eq(*other, row)).any(|other| other.id == row.id)
}

/// Name of a register.
fn register(machine: &Machine, id: RegisterId) -> &str {
    &machine.registers[id].name
}

/// How a code is written (`G1`, `G54-G59`, `"TEXT"`, `-`).
fn written(machine: &Machine, form: &super::rows::CodeForm) -> String {
    use super::rows::CodeForm;
    match form {
        CodeForm::NotApplicable => "-".to_owned(),
        CodeForm::Text(text) => format!("\"{text}\""),
        CodeForm::Register { register: index, min, max }
        | CodeForm::RegisterAsData { register: index, min, max, .. } => {
            let letter = register(machine, *index);
            if min == max { format!("{letter}{min}") } else { format!("{letter}{min}-{letter}{max}") }
        }
    }
}

/// A name of an enumeration in the notation of the machine file (`SlowestAxis` as `slowest-axis`).
fn word(value: impl std::fmt::Debug) -> String {
    let name = format!("{value:?}");
    if name.len() == 1 {
        return name;
    }
    let mut word = String::new();
    for c in name.chars() {
        if c.is_ascii_uppercase() && !word.is_empty() {
            word.push('-');
        }
        word.push(c.to_ascii_lowercase());
    }
    word
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{load, package};

    fn lathe() -> Machine {
        load(&package::shipped(), "fanuc-2path-lathe").machine.expect("the shipped machine is correct")
    }

    #[test]
    fn axes_are_an_aligned_table() {
        let expected = "\
axis  letter  data         role    diameter  rapid  acceleration  home  part zero  limits
X1    X       REG_AXIS_X   X       yes       20000  4000          0     -300       -900 to 300
Z1    Z       REG_AXIS_Z   Z       -         24000  5000          0     -500       -1700 to 700
C1    C       REG_AXIS_CT  rotary  -         72000  2000          0     0          -
X2    X       REG_AXIS_X   X       yes       20000  4000          0     -300       -900 to 300
Z2    Z       REG_AXIS_Z   Z       -         24000  5000          0     -500       -1700 to 700
";
        assert_eq!(show(&lathe(), Show::Axes), expected);
    }

    #[test]
    fn codes_name_their_words_conditions_and_source() {
        let codes = show(&lathe(), Show::Codes);
        let line = |part: &str| codes.lines().find(|line| line.contains(part)).unwrap_or_default().to_owned();
        assert!(line("CODE_SPINDLE_MAXRPM").starts_with("G50 "), "{codes}");
        assert!(line("CODE_SPINDLE_MAXRPM").contains("with S"));
        assert!(line("CODE_SYNC_REG").contains("M100-M199"));
        assert!(line("CODE_SYNC_REG").contains("fanuc-2path-lathe/machine.toml:"));
        assert!(line("CODE_COMP_WORKP_ON").contains("REG_COMP_WORKP"));
    }

    #[test]
    fn codes_stand_by_register_and_value() {
        let codes = show(&lathe(), Show::Codes);
        let words: Vec<&str> = codes.lines().skip(1).filter_map(|line| line.split_whitespace().next()).collect();
        assert_eq!(words.first(), Some(&"G0"));
        let place = |word: &str| words.iter().position(|w| *w == word).unwrap();
        assert!(place("G9") < place("G17") && place("G54-G59") < place("G96") && place("G99") < place("M0"));
    }

    #[test]
    fn groups_have_a_heading_and_their_start_code() {
        let groups = show(&lathe(), Show::Groups);
        let lines: Vec<&str> = groups.lines().collect();
        assert!(lines.first().is_some_and(|line| line.starts_with("group  word")), "{groups}");
        assert!(
            lines.iter().any(|line| line.starts_with("1      G0") && line.ends_with("active at start")),
            "{groups}"
        );
        assert!(lines.iter().any(|line| line.starts_with("motion") || line.contains("  motion")), "{groups}");
        assert!(!groups.contains("CODE_DELAY"), "group 0 is not a modal group");
    }

    #[test]
    fn a_part_as_json_has_only_that_part() {
        let value = json_part(&lathe(), Show::Groups);
        assert_eq!(value["groups"][0]["group"], 1);
        assert_eq!(value["groups"][0]["start"], "CODE_RAPID");
        assert_eq!(value["groups"][0]["codes"][0]["word"], "G0");
        assert_eq!(value.as_object().map(serde_json::Map::len), Some(1));
        assert_eq!(json_part(&lathe(), Show::Codes)["codes"][0]["word"], "G0");
        assert!(json_part(&lathe(), Show::Macros)["macros"].is_array());
    }

    #[test]
    fn everything_is_shown_and_no_line_ends_in_blanks() {
        let all = show(&lathe(), Show::All);
        for part in ["UPPER", "LOWER", "MAIN", "REG_SYNC_PATHS", "either", "#100-#199", "G-code system A"] {
            assert!(all.contains(part), "{part} is not in\n{all}");
        }
        assert!(all.lines().all(|line| line.trim_end() == line));
    }

    #[test]
    fn json_has_the_same_content() {
        let value = json(&lathe());
        assert_eq!(value["name"], "fanuc-2path-lathe");
        assert_eq!(value["channels"][1]["name"], "LOWER");
        assert_eq!(value["channels"][1]["axes"], serde_json::json!(["X2", "Z2"]));
        assert_eq!(value["sync"]["paths"], "either");
        assert_eq!(value["codes"].as_array().map(Vec::len), Some(lathe().codes.len()));
        assert_eq!(value["initial"][0], "CODE_RAPID");
    }
}
