//! The machine of a job without `--machine`: guessed by the signs of the shipped machines.

use std::ops::RangeInclusive;

use counterpoint_kernel::log::info::MachineUnit;
use counterpoint_kernel::machine::length_units::{begins_in_inches, unit_words};
use counterpoint_kernel::machine::signs::{self, ExaminedProgram, Guess};
use counterpoint_kernel::machine::{candidates, package};

use crate::error::Error;
use crate::local_machine::LocalMachine;
use crate::pack::Pack;
use crate::settings::MachineSetting;

/// The remedy when no machine can be guessed.
const ASK: &str = "use --machine NAME (`counterpoint machine list` shows the names) or --machine DIR";

/// Bytes of a program that are searched for words that select a unit.
const SEARCHED: usize = 4 << 20;

/// The machine for the programs of a job. `waits` are the M codes that are waiting codes, if they differ from those of
/// the machines.
pub(crate) fn machine(pack: &Pack, waits: Option<&RangeInclusive<u32>>) -> Result<Guess, Error> {
    let mut programs = Vec::new();
    for program in &pack.programs {
        let Some(blob) = pack.files.0.get(&program.path) else { continue };
        if let Some(number) = program.number.filter(|number| !signs::has_program(blob.content(), *number)) {
            return Err(Error::Usage(format!("'{}' has no program O{number}", program.path)));
        }
        programs.push(ExaminedProgram {
            name: program.path.clone(),
            content: blob.content().clone(),
            number: program.number,
            part: program.number.is_some() || program.section.is_some(),
        });
    }
    let candidates = candidates(&package::shipped(), &package::shipped_names());
    signs::guess(&candidates, &programs, waits, &|| false)
        .map_err(|why| Error::Usage(format!("no machine given, and {why}; {ASK}")))
}

/// The initial unit of a guessed machine, as part of a sentence; `None` if a program has a word that selects a unit.
pub(crate) fn unit(machine: &str, pack: &Pack, set: &[MachineSetting]) -> Option<String> {
    let machine = LocalMachine::shipped(machine).load().ok()?;
    let first = machine.of_channel(machine.channels.first()?.number);
    let words = unit_words(first);
    let named = |content: &[u8]| {
        let content = content.get(..SEARCHED).unwrap_or(content);
        let has = |word: &str| content.windows(word.len()).any(|part| part.eq_ignore_ascii_case(word.as_bytes()));
        words.split('/').filter(|word| !word.is_empty()).any(has)
    };
    if pack.programs.iter().any(|program| pack.files.0.get(&program.path).is_some_and(|blob| named(blob.content()))) {
        return None;
    }
    let set = set.iter().rev().find_map(|setting| match setting {
        MachineSetting::Units(unit) => Some(*unit),
        _ => None,
    });
    let own = if begins_in_inches(first) { MachineUnit::Inch } else { MachineUnit::Mm };
    let unit = set.unwrap_or(own).name();
    Some(if words.is_empty() { format!("reads in {unit}") } else { format!("no {words}: begins in {unit}") })
}
