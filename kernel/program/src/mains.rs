//! The main programs of a file: those that channels run by themselves.
//!
//! Facts: reference control-emulator.md 5.7, 8.1. *Invariant:* a file with text has a main program.

use super::callers::{CalledPrograms, Callers};
use super::shape::ProgramRange;
use super::source::ProgramSource;

/// Main programs of a file: those that no other program of the file calls; the first one if all are called. Text before
/// the first definition is one of its own if it comes to an end code or the program after it is called; otherwise that
/// program begins with it, since nothing skips a definition (reference control-emulator.md 5.7). Of a job archive those
/// with the number 0, in the order of their channels.
pub(super) fn mains(source: &ProgramSource, callers: &Callers) -> Vec<ProgramRange> {
    let ranges = source.programs();
    if ranges.len() < 2 {
        return ranges.to_vec();
    }
    let mut called = CalledPrograms::default();
    ranges.iter().for_each(|&range| callers.called(source, range, &mut called));
    let is_main =
        |range: ProgramRange| !called.has(source, range) && !callers.by_word(range) && !callers.returns(source, range);
    let mut mains: Vec<ProgramRange> = ranges.iter().copied().filter(|&range| is_main(range)).collect();
    if let [heading, next, ..] = ranges
        && source.is_plain(*heading)
        && is_main(*next)
        && !callers.ends_in(source, *heading)
    {
        mains.retain(|range| range != heading);
        if let Some(first) = mains.first_mut() {
            first.first = heading.first;
        }
    }
    let place = |range: &ProgramRange| callers.in_archive(source, *range);
    if mains.iter().filter_map(place).any(|(_, number)| number == 0) {
        mains.retain(|range| place(range).is_none_or(|(_, number)| number == 0));
        mains.sort_by_key(|range| place(range).map(|(channel, _)| channel));
    }
    if mains.is_empty() {
        mains.extend(ranges.first());
    }
    mains
}
