//! Modal groups: which codes exclude each other, and which is active at program start.
//!
//! Invariant: codes of group 0 belong to no modal group and are not listed. Facts: reference control-emulator.md 3.2.

use serde_json::{Value, json};

use super::grid::TextTable;
use super::{is_alias, sorted_codes, word, written};
use crate::model::Machine;
use crate::rows::CodeRow;

/// Documented subjects of the main groups; `-` for the others.
#[must_use]
pub fn subject(group: u16) -> &'static str {
    match group {
        1 => "motion",
        2 => "plane",
        3 => "absolute, incremental",
        5 => "feed mode",
        6 => "units",
        7 => "cutter compensation",
        8 => "length compensation",
        9 => "cycles",
        10 => "retract plane",
        11 => "scale",
        13 => "spindle speed mode",
        14 => "work offsets",
        15 => "exact stop",
        16 => "rotation",
        17 => "shift",
        18 => "mirror",
        20 => "tool centre point",
        26 => "polar interpolation",
        50 => "rotary direction",
        54 => "coolant",
        64 => "spindle",
        65 => "gear",
        67 => "front and rear spindle",
        68 => "head",
        70..=85 => "clamp",
        86 => "probe alarm",
        96 => "surface speed head",
        101 => "rigid tapping",
        107 => "corner",
        109 => "diameter and radius of X",
        540 => "coolant, side",
        541..=549 => "auxiliary coolant",
        550 => "coolant pressure",
        641..=645 => "numbered spindle",
        800 => "additive",
        _ => "-",
    }
}

/// Groups in ascending number with their rows.
fn groups(machine: &Machine) -> Vec<(u16, Vec<&CodeRow>)> {
    let rows = sorted_codes(machine);
    let mut numbers: Vec<u16> = rows.iter().map(|row| row.group).filter(|&group| group != 0).collect();
    numbers.sort_unstable();
    numbers.dedup();
    let of = |group: u16| rows.iter().copied().filter(|row| row.group == group).collect();
    numbers.into_iter().map(|group| (group, of(group))).collect()
}

fn starts(machine: &Machine, row: &CodeRow) -> bool {
    machine.initial.contains(&row.id) && !is_alias(machine, row)
}

/// One line a code.
pub(super) fn text(machine: &Machine) -> TextTable {
    let mut grid = TextTable::new(&["group", "word", "code", "modality", "subject", "notes"]);
    for (group, rows) in groups(machine) {
        for row in rows {
            let mut notes = Vec::new();
            notes.extend(starts(machine, row).then_some("active at start"));
            notes.extend(is_alias(machine, row).then_some("alias"));
            notes.extend((!row.enable).then_some("off"));
            grid.row([
                group.to_string(),
                written(machine, &row.form),
                machine.code_name(row.id).to_owned(),
                word(row.modality),
                subject(group).to_owned(),
                if notes.is_empty() { "-".to_owned() } else { notes.join(", ") },
            ]);
        }
    }
    grid
}

/// One object a group.
pub(super) fn json(machine: &Machine) -> Vec<Value> {
    let code = |row: &&CodeRow| {
        json!({
            "id": machine.code_name(row.id),
            "word": written(machine, &row.form),
            "modality": word(row.modality),
            "enable": row.enable,
        })
    };
    let group = |(group, rows): (u16, Vec<&CodeRow>)| {
        let start = rows.iter().find(|row| starts(machine, row)).map(|row| machine.code_name(row.id));
        json!({
            "group": group,
            "subject": subject(group),
            "start": start,
            "codes": rows.iter().map(code).collect::<Vec<_>>(),
        })
    };
    groups(machine).into_iter().map(group).collect()
}
