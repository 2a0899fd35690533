//! The machine of a job without `--machine`: guessed by the signs of the shipped machines.

use std::ops::RangeInclusive;

use counterpoint_kernel::machine::signs::{self, Guess, Program};
use counterpoint_kernel::machine::{candidates, package};

use crate::error::Error;
use crate::pack::Pack;

/// The remedy when no machine can be guessed.
const ASK: &str = "use --machine NAME (`counterpoint machine list` shows the names) or --machine DIR";

/// The machine for the programs of a job. `waits` are the M codes that are waiting codes, if they differ from those of
/// the machines.
pub(crate) fn machine(pack: &Pack, waits: Option<&RangeInclusive<u32>>) -> Result<Guess, Error> {
    let mut programs = Vec::new();
    for program in &pack.programs {
        let Some(blob) = pack.files.0.get(&program.path) else { continue };
        if let Some(number) = program.number.filter(|number| !signs::has_program(blob.content(), *number)) {
            return Err(Error::Usage(format!("'{}' has no program O{number}", program.path)));
        }
        programs.push(Program {
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
