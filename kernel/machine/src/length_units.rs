//! The unit in which programs of a machine begin, and the words that select a unit.

use counterpoint_event::MachineUnit;

use crate::ident::codes;
use crate::model::Machine;
use crate::rows::{CodeForm, CodeRow};

/// Whether programs of a machine begin in inches, by its unit and its start state.
#[must_use]
pub fn begins_in_inches(machine: &Machine) -> bool {
    let is_secondary = |id: &_| matches!(*id, codes::UNITS_SECONDARY | codes::UNITS_SECONDARY_LENGTHS);
    (machine.unit == MachineUnit::Inch) != machine.initial.iter().any(is_secondary)
}

/// Numbers of the G codes that select a unit, ascending.
#[must_use]
pub fn unit_codes(machine: &Machine) -> Vec<f64> {
    let number = |row: &CodeRow| match &row.form {
        CodeForm::Register { register, min, .. } if machine.registers[*register].name == "G" => Some(*min),
        _ => None,
    };
    let mut numbers: Vec<f64> = rows(machine).filter_map(number).collect();
    numbers.sort_by(f64::total_cmp);
    numbers.dedup();
    numbers
}

/// The words of programs that select a unit, separated by strokes: `G20/G21`, `MM/INCH`. Empty if there are none.
#[must_use]
pub fn unit_words(machine: &Machine) -> String {
    let mut words: Vec<String> = unit_codes(machine).iter().map(|number| format!("G{number}")).collect();
    for row in rows(machine) {
        if let CodeForm::Text(text) = &row.form
            && !words.contains(text)
        {
            words.push(text.clone());
        }
    }
    words.join("/")
}

fn rows(machine: &Machine) -> impl Iterator<Item = &CodeRow> {
    machine.codes.iter().filter(|row| {
        matches!(row.id, codes::UNITS_PRIMARY | codes::UNITS_SECONDARY | codes::UNITS_SECONDARY_LENGTHS) && row.enable
    })
}
