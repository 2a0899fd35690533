//! The macros of a machine: hooks, code macros, data macros, user functions.
//!
//! Invariant: one row for each macro, in the order in which it is requested; text and JSON are made from the same rows.

use serde_json::{Value, json};

use super::grid::TextTable;
use super::text::{dash, yes};
use crate::macros::condition::{BlockIdentifier, ConditionStep, MacroCondition};
use crate::macros::model::{FIRST_HOOK_ID, Hook, TriggeredMacro};
use crate::model::Machine;

/// One macro.
struct MacroRow {
    /// Key of the machine file: that of the hook, `code`, `data` or `functions`.
    key: &'static str,
    /// Number that switches it; functions have none and are always on.
    id: Option<u32>,
    name: String,
    enabled: bool,
    /// Identifiers that fire it.
    matches: Vec<String>,
    /// Additional conditions.
    condition: String,
    file: String,
}

pub(super) fn text(machine: &Machine) -> TextTable {
    let mut grid = TextTable::new(&["macro", "key", "name", "on", "match", "if", "file"]);
    for row in rows(machine) {
        grid.row([
            row.id.map_or_else(|| "-".to_owned(), |id| id.to_string()),
            row.key.to_owned(),
            row.name,
            yes(row.enabled),
            dash(row.matches.join(" ")),
            dash(row.condition),
            row.file,
        ]);
    }
    grid
}

pub(super) fn json(machine: &Machine) -> Vec<Value> {
    let row = |row: MacroRow| {
        json!({
            "id": row.id,
            "key": row.key,
            "name": row.name,
            "enabled": row.enabled,
            "match": row.matches,
            "condition": row.condition,
            "file": row.file,
        })
    };
    rows(machine).into_iter().map(row).collect()
}

fn rows(machine: &Machine) -> Vec<MacroRow> {
    let Some(macros) = machine.macros.as_deref() else { return Vec::new() };
    let file = |code: u16| macros.program.macros.get(usize::from(code)).map_or("", |code| &code.source.name).to_owned();
    let mut rows = Vec::new();
    for (hook, id) in Hook::ALL.into_iter().zip(FIRST_HOOK_ID..) {
        let Some(code) = macros.hook(hook) else { continue };
        rows.push(MacroRow {
            key: hook.key(),
            id: Some(id),
            name: hook.title().to_owned(),
            enabled: true,
            matches: Vec::new(),
            condition: String::new(),
            file: file(code),
        });
    }
    let name = |item: BlockIdentifier| match item {
        BlockIdentifier::Code(id) => machine.code_name(id).to_owned(),
        BlockIdentifier::Data(id) => machine.data_name(id).to_owned(),
    };
    let named = |key, one: &TriggeredMacro| MacroRow {
        key,
        id: Some(one.id),
        name: one.name.clone(),
        enabled: one.enabled,
        matches: one.matches.iter().map(|item| name(*item)).collect(),
        condition: condition(&one.condition, &name),
        file: file(one.code),
    };
    rows.extend(macros.codes.iter().map(|row| named("code", row)));
    rows.extend(macros.data.iter().map(|row| named("data", row)));
    rows.extend(macros.program.functions().into_iter().map(|(name, code)| MacroRow {
        key: "functions",
        id: None,
        name: name.to_owned(),
        enabled: true,
        matches: Vec::new(),
        condition: String::new(),
        file: file(code),
    }));
    rows
}

/// A condition in the notation of the machine file.
fn condition(condition: &MacroCondition, name: &impl Fn(BlockIdentifier) -> String) -> String {
    let list = |items: &[BlockIdentifier]| items.iter().map(|item| name(*item)).collect::<Vec<_>>().join(" ");
    let mut parts = Vec::new();
    if !condition.present.is_empty() {
        parts.push(format!("present {}", list(&condition.present)));
    }
    if !condition.absent.is_empty() {
        parts.push(format!("absent {}", list(&condition.absent)));
    }
    if !condition.steps.is_empty() {
        parts.push(written(&condition.steps, name));
    }
    parts.join(", ")
}

/// Postfix steps as they are written; only an OR inside an AND needs parentheses.
fn written(steps: &[ConditionStep], name: &impl Fn(BlockIdentifier) -> String) -> String {
    let mut stack: Vec<(String, bool)> = Vec::new();
    for step in steps {
        let is_or = *step == ConditionStep::Or;
        if let ConditionStep::Present(item) = step {
            stack.push((name(*item), false));
            continue;
        }
        let (Some(right), Some(left)) = (stack.pop(), stack.pop()) else { break };
        let side = |(text, either): (String, bool)| if either && !is_or { format!("({text})") } else { text };
        let sign = if is_or { "OR" } else { "AND" };
        stack.push((format!("{} {sign} {}", side(left), side(right)), is_or));
    }
    stack.pop().map_or_else(String::new, |(text, _)| text)
}

#[cfg(test)]
mod tests {
    use crate::load;
    use crate::package::{Overlay, shipped};
    use crate::show::{Show, json_part, show};
    use counterpoint_ports::files::MemoryFiles;

    fn machine() -> crate::Machine {
        let mut files = MemoryFiles::default();
        files.insert(
            "own/machine.toml",
            r#"
extends = "fanuc-mill"

[ce]
name = "own"

[macros]
functions = ["f.mac"]
block_startup = "b.mac"

[[macros.code]]
name = "Guard"
match = ["CODE_SPINDLE_CLW", "CODE_SPINDLE_CCLW"]
present = ["REG_SPINDLE_RPM"]
absent = ["CODE_STOP"]
file = "c.mac"

[[macros.code]]
id = 40
condition = "CODE_COOLANT_FLOOD && (CODE_DELAY || CODE_STOP)"
enabled = false
file = "c.mac"

[[macros.data]]
match = ["REG_AXIS_X"]
file = "d.mac"
"#,
        );
        files.insert("own/f.mac", "MACRO/TWICE(REAL,N)\nTWICE=N*2\nENDMAC\nMACRO/HALF(REAL,N)\nHALF=N/2\nENDMAC\n");
        files.insert("own/b.mac", "%L01=1\n");
        files.insert("own/c.mac", "OUTPUT\n");
        files.insert("own/d.mac", "$P2=1\n");
        let loaded = load(&Overlay::new(files, shipped()), "own");
        loaded.machine.unwrap_or_else(|| panic!("{:?}", loaded.findings))
    }

    #[test]
    fn every_macro_has_its_row() {
        let text = show(&machine(), Show::Macros);
        let rows: Vec<Vec<&str>> = text
            .lines()
            .map(|line| line.split("  ").map(str::trim).filter(|cell| !cell.is_empty()).collect())
            .collect();
        let guard = ["1", "code", "Guard", "yes", "CODE_SPINDLE_CLW CODE_SPINDLE_CCLW"];
        let guard = [guard.as_slice(), &["present REG_SPINDLE_RPM, absent CODE_STOP", "own/c.mac"]].concat();
        let coolant = "CODE_COOLANT_FLOOD CODE_DELAY CODE_STOP";
        let hand_written = "CODE_COOLANT_FLOOD AND (CODE_DELAY OR CODE_STOP)";
        assert_eq!(
            rows,
            [
                vec!["macro", "key", "name", "on", "match", "if", "file"],
                vec!["9010", "block_startup", "Block Startup Macro", "yes", "-", "-", "own/b.mac"],
                guard,
                vec![
                    "40",
                    "code",
                    "CODE_COOLANT_FLOOD, CODE_DELAY, CODE_STOP",
                    "-",
                    coolant,
                    hand_written,
                    "own/c.mac"
                ],
                vec!["41", "data", "REG_AXIS_X", "yes", "REG_AXIS_X", "-", "own/d.mac"],
                vec!["-", "functions", "HALF", "yes", "-", "-", "own/f.mac"],
                vec!["-", "functions", "TWICE", "yes", "-", "-", "own/f.mac"],
            ],
            "{text}"
        );
    }

    #[test]
    fn json_has_the_same_rows_and_all_shows_them() {
        let value = json_part(&machine(), Show::Macros);
        assert_eq!(value["macros"].as_array().map(Vec::len), Some(6));
        assert_eq!(value["macros"][2]["condition"], "CODE_COOLANT_FLOOD AND (CODE_DELAY OR CODE_STOP)");
        assert_eq!(value["macros"][2]["enabled"], false);
        assert_eq!(value["macros"][1]["match"], serde_json::json!(["CODE_SPINDLE_CLW", "CODE_SPINDLE_CCLW"]));
        assert_eq!(value["macros"][4]["id"], serde_json::Value::Null);
        assert!(show(&machine(), Show::All).contains("Guard"));
    }
}
