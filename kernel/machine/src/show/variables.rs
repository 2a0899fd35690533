//! A numbered variable of the pre-processor in words.
//!
//! Invariant: the words are made from the row that the kernel reads, so they name the value that the number shows and
//! sets.

use serde_json::{Value, json};

use crate::model::Machine;
use crate::system_variables::{FIRST, MODAL_CALLS, Means, OffsetColumn, PositionReference};

/// Last number of a local variable.
const LAST_LOCAL: u32 = 33;

/// The variable with this number on this machine, if any.
#[must_use]
pub fn variable(machine: &Machine, number: u32) -> Option<Value> {
    let variables = &machine.variables;
    let within =
        |ranges: &[(u32, u32)]| ranges.iter().find(|(first, last)| (*first..=*last).contains(&number)).copied();
    let known = |means: String, range: (u32, u32), write: bool| {
        let range = json!({ "first": range.0, "last": range.1 });
        Some(json!({ "number": number, "means": means, "write": write, "range": range }))
    };
    if let Some((row, at)) = variables.system.find(number) {
        let first = number - at;
        let range = (first, first + (row.last - row.first));
        return known(means(machine, &row.means, at), range, row.writable);
    }
    if let Some(range) = within(&variables.shared) {
        return known("common variable, shared by all channels".to_owned(), range, true);
    }
    if let Some(range) = within(&variables.channel) {
        return known("common variable of each channel".to_owned(), range, true);
    }
    if machine.preprocessor.row().name != "fanuc" || number >= FIRST {
        return None;
    }
    match number {
        0 => known("always vacant".to_owned(), (0, 0), false),
        1..=LAST_LOCAL => known("local variable of the program or macro".to_owned(), (1, LAST_LOCAL), true),
        _ => None,
    }
}

/// The value that the number at this place of its row shows.
fn means(machine: &Machine, means: &Means, at: u32) -> String {
    let axis = |at: u32| format!("axis {} of the channel", at + 1);
    match means {
        Means::Kept(first) => format!("a value that is kept, {first} at the start"),
        Means::Bit(first) => format!("0 or 1, {first} at the start"),
        Means::Bits(of) => format!("#{of} to #{} as the bits of a whole number", of + 31),
        Means::Alias(of) => format!("the same as #{}", of + at),
        Means::Milliseconds => "milliseconds since the start of the job".to_owned(),
        Means::Hours => "hours since the start of the job".to_owned(),
        Means::Date => "date as yyyymmdd".to_owned(),
        Means::TimeOfDay => "time of day as hhmmss".to_owned(),
        Means::Settings => "settings of the control, bit 2 is the inch system".to_owned(),
        Means::Mirrors => "mirrored axes as bits".to_owned(),
        Means::MainProgram => "number of the main program".to_owned(),
        Means::Modal(groups) => match groups.get(at as usize) {
            Some((MODAL_CALLS, _)) => "G number of the active modal macro call".to_owned(),
            Some((group, none)) => {
                let subject = super::groups::subject(*group);
                let subject = if subject == "-" { String::new() } else { format!(" ({subject})") };
                format!("G number that is active in group {group}{subject}, {none} without one")
            }
            None => "nothing".to_owned(),
        },
        Means::Address(letters) => {
            letters.get(at as usize).map_or_else(String::new, |letter| format!("last value of {}", char::from(*letter)))
        }
        Means::Position(frame, axes) => {
            let letter = axes.as_ref().map(|axes| axes.get(at as usize).map_or('?', |axis| char::from(*axis)));
            let axis = letter.map_or_else(|| axis(at), |letter| format!("axis {letter}"));
            format!("{}, {axis}", frame_name(*frame))
        }
        Means::WorkOffset { from, stride } => {
            format!("{}, {}", offset(from + at / stride), axis(at % stride))
        }
        Means::WorkOffsetAxis { from, axis: of } => format!("{}, {}", offset(from + at), axis(u32::from(*of))),
        Means::ToolOffset(column, wear) => {
            let wear = if *wear { "wear of the" } else { "the" };
            let column = match column {
                OffsetColumn::Axis(0) => "value along X",
                OffsetColumn::Axis(1) => "value along Y",
                OffsetColumn::Axis(_) => "value along Z",
                OffsetColumn::Radius => "radius",
                OffsetColumn::Diameter => "diameter",
                OffsetColumn::Tip => "direction of the imaginary tip",
            };
            let known = machine.tool.offsets.iter().any(|offset| offset.number == at + 1);
            let none = if known { "" } else { ", which the machine does not define" };
            format!("{wear} {column} of tool offset {}{none}", at + 1)
        }
    }
}

fn offset(number: u32) -> String {
    match number {
        0 => "external work offset".to_owned(),
        1..=6 => format!("work offset {number} (G{})", 53 + number),
        _ => format!("work offset {number}"),
    }
}

fn frame_name(frame: PositionReference) -> &'static str {
    match frame {
        PositionReference::Local => "shift of the local coordinate system",
        PositionReference::BlockEnd => "end of the previous block in the frame of the program",
        PositionReference::Machine => "position in the frame of the machine",
        PositionReference::Work => "position in the work frame, without the tool",
        PositionReference::Skip => "end of the last probing move in the work frame",
        PositionReference::Tool => "tool compensation in force",
        PositionReference::Wear => "wear in force",
        PositionReference::Geometry => "geometry in force",
        PositionReference::Zero => "following error, handle or distance to go: always 0",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{load, package};

    #[test]
    fn numbers_are_what_the_manual_says() {
        let machine = load(&package::shipped(), "fanuc-mill").machine.expect("a machine");
        let means =
            |number: u32| variable(&machine, number).map(|found| found["means"].as_str().unwrap_or("").to_owned());
        // #5021 and following: machine coordinates; #5221 and following: G54; #4001: group 1; #4109: F; #2001: length
        // of offset 1.
        assert_eq!(means(5021).as_deref(), Some("position in the frame of the machine, axis 1 of the channel"));
        assert_eq!(means(5222).as_deref(), Some("work offset 1 (G54), axis 2 of the channel"));
        assert!(means(4001).is_some_and(|text| text.starts_with("G number that is active in group 1 (motion)")));
        assert_eq!(means(4109).as_deref(), Some("last value of F"));
        assert_eq!(means(5).as_deref(), Some("local variable of the program or macro"));
        assert!(means(100).is_some_and(|text| text.starts_with("common variable")));
        assert_eq!(means(99), None);
    }
}
