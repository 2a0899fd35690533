//! Data of the part that a divided file carries: values of common variables that hold when its programs begin.
//!
//! Facts: reference channel-synchronisation.md 1.6 (`$0`). Decision: lines `#814=0000002500` of sections `$0`; a value
//! without a decimal point counts least increments, 0.001 mm or 0.0001 inch, of the unit in which the machine begins: no
//! program has selected another one by then. *Invariant:* only variables that all channels share; of several values of
//! one variable the last one holds.

use counterpoint_machine::length_units::begins_in_inches;
use counterpoint_machine::model::Machine;

use super::source::ProgramSource;

/// Common variables and their values, as the sections `$0` of a file give them. `begins` is the definition with which
/// the channels of the file begin.
pub fn of<'s>(
    machine: &'s Machine,
    begins: &Machine,
    source: &'s ProgramSource,
) -> impl Iterator<Item = (u32, f64)> + use<'s> {
    let step = step(begins_in_inches(begins));
    lines(machine, source).map(move |(_, text)| (text.number, text.value(step)))
}

/// The first value without a decimal point.
#[must_use]
pub fn whole(machine: &Machine, source: &ProgramSource) -> Option<Whole> {
    let (line, first) = lines(machine, source).find(|(_, text)| !text.pointed)?;
    let text = String::from_utf8_lossy(source.line(line)).trim().to_owned();
    let values = [false, true].map(|inches| first.value(step(inches)));
    Some(Whole { line, text, values })
}

/// A value without a decimal point.
#[derive(Debug)]
pub struct Whole {
    /// Its line.
    pub line: u32,
    /// The text of the line.
    pub text: String,
    /// The value if the machine begins in millimetres, and in inches.
    pub values: [f64; 2],
}

/// Least increments in a millimetre or an inch.
fn step(inches: bool) -> f64 {
    if inches { 10_000.0 } else { 1000.0 }
}

/// The lines that set variables which all channels share.
fn lines<'s>(machine: &'s Machine, source: &'s ProgramSource) -> impl Iterator<Item = (u32, Preset)> + use<'s> {
    let data = source.sections().iter().filter(|section| section.channel == 0);
    let lines = data.flat_map(|section| source.walk(section.lines.0, section.lines.1));
    let is_shared =
        |number: u32| machine.variables.shared.iter().any(|(first, last)| (*first..=*last).contains(&number));
    lines
        .filter_map(move |line| Some((line, preset(source.line(line))?)))
        .filter(move |(_, text)| is_shared(text.number))
}

/// A value as it is written.
struct Preset {
    number: u32,
    written: f64,
    pointed: bool,
}

impl Preset {
    /// The value, if whole numbers count increments; `step` increments make a unit.
    fn value(&self, step: f64) -> f64 {
        if self.pointed { self.written } else { self.written / step }
    }
}

/// The variable of a line and its value.
fn preset(line: &[u8]) -> Option<Preset> {
    let text = std::str::from_utf8(line).ok()?.trim();
    let (number, value) = text.strip_prefix('#')?.split_once('=')?;
    // A comment in parentheses may follow.
    let value = value.split('(').next()?;
    let (number, value) = (number.trim(), value.trim());
    let is_number =
        |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit() || b".+-".contains(&byte));
    if !is_number(value) || !number.bytes().all(|byte| byte.is_ascii_digit()) {
        return None;
    }
    Some(Preset { number: number.parse().ok()?, written: value.parse().ok()?, pointed: value.contains('.') })
}

#[cfg(test)]
mod tests {
    fn preset(line: &[u8], step: f64) -> Option<(u32, f64)> {
        super::preset(line).map(|preset| (preset.number, preset.value(step)))
    }

    #[test]
    fn values_count_least_increments_or_have_a_point() {
        assert_eq!(preset(b"#814=0000002500", 10_000.0), Some((814, 0.25)));
        assert_eq!(preset(b" #824 = -000001000 \r", 1000.0), Some((824, -1.0)));
        assert_eq!(preset(b"#500=1.5", 1000.0), Some((500, 1.5)));
        assert_eq!(preset(b"#814=2500 (X)", 1000.0), Some((814, 2.5)));
        for line in [&b"A"[..], b"#500", b"#=1", b"#5OO=1", b"#500=[1]", b"#500=", b"#500=#501", b"#99999999999=1"] {
            assert_eq!(preset(line, 1000.0), None);
        }
    }
}
