//! The blocks that a machine's control refuses, a row for each rule.
//!
//! Invariant: text and JSON are made from the same rows, in the order in which the rules are asked.

use serde_json::{Value, json};

use super::grid::TextTable;
use super::text::dash;
use crate::index::RegisterId;
use crate::model::Machine;
use crate::refusals::{Active, BlockRefusal, CodeReference};

/// One rule in words.
struct RefusalRow<'m> {
    rule: &'m BlockRefusal,
    codes: Vec<String>,
    with: Vec<&'m str>,
    without: Vec<&'m str>,
    active: Vec<&'m str>,
    inactive: Vec<&'m str>,
    /// Requirement for its word: `P 2 to 4, whole`.
    word: String,
}

pub(super) fn text(machine: &Machine) -> TextTable {
    let mut grid = TextTable::new(&["alarm", "codes", "with", "without", "active", "inactive", "word", "text"]);
    for row in rows(machine) {
        grid.row([
            row.rule.alarm.clone(),
            dash(row.codes.join(" ")),
            dash(row.with.join(" ")),
            dash(row.without.join(" ")),
            dash(row.active.join(" ")),
            dash(row.inactive.join(" ")),
            dash(row.word),
            row.rule.text.clone(),
        ]);
    }
    grid
}

pub(super) fn json(machine: &Machine) -> Vec<Value> {
    let row = |row: RefusalRow<'_>| {
        json!({
            "name": row.rule.name,
            "alarm": row.rule.alarm,
            "text": row.rule.text,
            "codes": row.codes,
            "implied": row.rule.implied,
            "with": row.with,
            "without": row.without,
            "active": row.active,
            "inactive": row.inactive,
            "word": row.word,
            "file": row.rule.file,
            "line": row.rule.line,
        })
    };
    rows(machine).map(row).collect()
}

fn rows(machine: &Machine) -> impl Iterator<Item = RefusalRow<'_>> {
    let register = |id: RegisterId| machine.registers[id].name.as_str();
    let registers =
        move |bits: u128| machine.registers.ids().filter(|id| bits & id.bit() != 0).map(register).collect::<Vec<_>>();
    let code = move |code: &CodeReference| match *code {
        CodeReference::Id(id) => machine.code_name(id).to_owned(),
        CodeReference::Word { register: id, min, max } => {
            let letter = register(id);
            if min == max { format!("{letter}{min}") } else { format!("{letter}{min}-{letter}{max}") }
        }
    };
    let states = move |states: &[Active]| states.iter().map(|state| machine.code_name(state.id)).collect::<Vec<_>>();
    machine.diagnostics.refusals.iter().map(move |rule| {
        let word = rule.word.map(|word| {
            let mut text = register(word.register).to_owned();
            match (word.min.is_finite(), word.max.is_finite()) {
                (true, true) => text += &format!(" {} to {}", word.min, word.max),
                (true, false) => text += &format!(" from {}", word.min),
                (false, true) => text += &format!(" up to {}", word.max),
                (false, false) => {}
            }
            if word.whole {
                text += ", whole";
            }
            if let Some(most) = word.most {
                text += &format!(", at most {most}");
            }
            text
        });
        RefusalRow {
            rule,
            codes: rule.codes.iter().map(code).collect(),
            with: registers(rule.with),
            without: registers(rule.without),
            active: states(&rule.active),
            inactive: states(&rule.inactive),
            word: word.unwrap_or_default(),
        }
    })
}

#[cfg(test)]
mod tests {
    use super::super::{Show, json_part, show};
    use crate::load;
    use crate::package::shipped;

    #[test]
    fn rules_are_shown_in_words() {
        let machine = load(&shipped(), "fanuc-mill").machine.expect("a machine");
        let text = show(&machine, Show::Refusals);
        let line = |alarm: &str| text.lines().find(|line| line.starts_with(alarm)).expect("a row").to_owned();
        let shown = line("PS0046");
        for part in ["G30", "P 2 to 4, whole", "there are only reference points 2, 3 and 4"] {
            assert!(shown.contains(part), "{shown}");
        }
        assert!(line("PS0335").contains("M, at most 3"), "{text}");
        assert!(line("PS0021").contains("CODE_PLANE_XY") && line("PS0021").contains("I J R"), "{text}");
        let json = json_part(&machine, Show::Refusals);
        let rules = json["refusals"].as_array().expect("rules");
        assert_eq!(rules.len(), machine.diagnostics.refusals.len());
        assert!(rules.iter().any(|rule| rule["alarm"] == "PS0046" && rule["codes"][0] == "G30"));
    }
}
