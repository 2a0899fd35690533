//! A code of a machine: its row, its group, its data, its macro, and the refusals of blocks with it.
//!
//! *Invariant:* everything comes from the checked machine, with the file and the line that define it.

use counterpoint_kernel::machine::Machine;
use counterpoint_kernel::machine::ident::kind::CodeKind;
use counterpoint_kernel::machine::ident::kind::thread::ThreadCycle;
use counterpoint_kernel::machine::ident::{CodeId, meaning, takes};
use counterpoint_kernel::machine::index::{CodeRowId, DataRowId, RegisterId};
use counterpoint_kernel::machine::rows::{CodeRow, DataRow};
use counterpoint_kernel::machine::show::{self, Show};
use counterpoint_kernel::machine::tables::form_range;
use serde_json::{Value, json};

use crate::fields::JsonFields as _;

use super::register;
use super::related::{macros, of_code, refusals};

/// One row of the code table.
pub(super) fn code(machine: &Machine, id: CodeRowId) -> Value {
    let row = &machine.codes[id];
    let mut value = show::code_json(machine, row);
    let name = machine.code_name(row.id);
    let (group, others) = group(machine, row);
    let more = json!({
        "meaning": meaning_of(machine, row),
        "tool_digits": tool_digits(machine, row),
        "subject": group,
        "same_group": others,
        "active_at_start": machine.initial.contains(&row.id),
        "reads": reads(machine, row.id).into_iter().map(|id| read(machine, row, id)).collect::<Vec<_>>(),
        "macros": macros(machine, name),
        "waits": waits(machine, row),
        "refusals": refusals(machine, |rule| of_code(rule, row)),
    });
    if let (Value::Object(value), Value::Object(more)) = (&mut value, more) {
        value.extend(more);
    }
    value
}

/// The subject of its group, and the words of the other codes in it.
fn group(machine: &Machine, row: &CodeRow) -> (&'static str, Vec<Value>) {
    if row.group == 0 {
        return ("-", Vec::new());
    }
    let same = machine.codes.iter().filter(|other| other.group == row.group && other.id != row.id && other.enable);
    let same = same.map(|other| show::code_json(machine, other).at("word").clone());
    let mut words: Vec<Value> = Vec::new();
    same.filter(|word| word != "-").for_each(|word| {
        if !words.contains(&word) {
            words.push(word);
        }
    });
    (show::group_subject(row.group), words)
}

/// Meaning of a code; a code of the machine's own without an effect is ignored.
fn meaning_of(machine: &Machine, row: &CodeRow) -> String {
    let own = || if row.process { "a code of the machine's own" } else { "ignored by the machine" };
    meaning::of(machine.code_name(row.id)).unwrap_or_else(|| own().to_owned())
}

/// Number of digits of a tool word that are the number of the offset.
fn tool_digits(machine: &Machine, row: &CodeRow) -> Option<u32> {
    let tool = matches!(row.id.kind(), CodeKind::Tool);
    let digits = u32::from(machine.tool.offset_digits);
    (tool && form_range(&row.form).is_some() && digits > 0).then_some(digits)
}

/// A data row that a code reads, with the block in which the code reads it.
fn read(machine: &Machine, row: &CodeRow, id: DataRowId) -> Value {
    let mut value = register::data(machine, id);
    let two_lines =
        machine.threads.two_lines && matches!(row.id.kind(), CodeKind::ThreadCycle(ThreadCycle { multi: true, .. }));
    if two_lines && let Some(block) = block_of(machine.data_name(machine.data[id].id)) {
        value.set("block", json!(block));
    }
    value
}

/// Block of a two-block threading cycle that has a datum.
fn block_of(data: &str) -> Option<&'static str> {
    let rest = data.strip_prefix("REG_THREAD_MULTI_")?;
    match rest {
        "PWORD" | "STEP_MIN" | "FINISH_X" | "FINISH_Z" => Some("without X and Z"),
        "HEIGHT_X" | "HEIGHT_Z" | "STEP_X" | "STEP_Z" | "TAPER_X" | "TAPER_Z" => Some("with X or Z"),
        _ => None,
    }
}

/// Data rows whose values the action of a code takes, if the machine has the axes of their words.
pub(super) fn reads(machine: &Machine, code: CodeId) -> Vec<DataRowId> {
    let patterns = takes::data_of(machine.code_name(code));
    let missing = |row: &DataRow| {
        let axis = machine.data_name(row.id).starts_with("REG_AXIS_");
        axis && machine.axes.iter().all(|axis| axis.data != row.id)
    };
    let read = |id: &DataRowId| {
        let row = &machine.data[*id];
        row.enable && !missing(row) && patterns.iter().any(|pattern| takes::fits(pattern, machine.data_name(row.id)))
    };
    machine.data.ids().filter(read).collect()
}

/// The effect of a word of `[[waits]]`.
fn waits(machine: &Machine, row: &CodeRow) -> Vec<Value> {
    let rows = show::json_part(machine, Show::All);
    let rows = rows.at("sync").at("waits").as_array().cloned().unwrap_or_default();
    let own = machine.sync.waits.iter().zip(rows).filter(|(wait, _)| wait.is_of(&row.form));
    own.map(|(_, value)| value).collect()
}

/// A range of words as programs write it: `TOOL CALL 0 to 32767`.
fn as_written(machine: &Machine, register: RegisterId, word: &str) -> String {
    let (name, before) = (&machine.registers[register].name, &machine.registers[register].before);
    if before.trim().is_empty() || before == name {
        return word.to_owned();
    }
    let range = word.replace(&format!("-{name}"), " to ");
    range.strip_prefix(name.as_str()).map_or(range.clone(), |number| format!("{before}{number}"))
}

/// Codes that are written with a register.
pub(super) fn of_register(machine: &Machine, register: RegisterId) -> Vec<Value> {
    let of = |row: &&CodeRow| form_range(&row.form).is_some_and(|(id, ..)| id == register);
    let rows = machine.codes.iter().filter(|row| row.enable).filter(of);
    rows.map(|row| {
        let name = machine.code_name(row.id);
        let word = show::code_json(machine, row).at("word").as_str().unwrap_or_default().to_owned();
        json!({ "word": as_written(machine, register, &word), "id": name, "meaning": meaning::of(name) })
    })
    .collect()
}
