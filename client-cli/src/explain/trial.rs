//! The response of the control to a block of one word.
//!
//! *Invariant:* the block runs as in any job, so a program gets the same response.

use std::sync::Arc;

use counterpoint_kernel::control::JobControl;
use counterpoint_kernel::diag;
use counterpoint_kernel::event::event::{Event, Kind};
use counterpoint_kernel::files::MemoryFiles;
use counterpoint_kernel::job::{Job, LogSink, ProgramSelection, Spec};
use counterpoint_kernel::machine::Machine;
use counterpoint_kernel::options::JobOptions;
use serde_json::{Value, json};

use super::words;
use crate::fields::JsonFields as _;

/// Maximum number of blocks of the run.
const BLOCKS: u64 = 100;

/// Diagnostics of the first line.
#[derive(Default)]
struct OfFirstLine(Vec<Value>);

impl LogSink for OfFirstLine {
    fn events(&mut self, _first_seq: u64, batch: &[Event]) -> bool {
        for event in batch.iter().filter(|event| event.user_place().line == 1) {
            if let Kind::Diagnostic(told) = &event.kind {
                self.0.push(json!({ "number": told.number, "severity": told.severity, "text": told.text }));
            }
        }
        true
    }
}

/// A block with a word that the control accepts although no table has the word. The block is the word alone, such as
/// the name of a sequence, or assigns a value to it, such as a parameter of the control.
pub(super) fn accepted(machine: &Machine, word: &str) -> Option<String> {
    let name = word.bytes().all(|b| b.is_ascii_alphanumeric() || matches!(b, b'_' | b'$' | b'.'));
    if !name || !word.contains(|c: char| c.is_ascii_alphabetic()) || words::register_of(machine, word).is_some() {
        return None;
    }
    let blocks = [word.to_uppercase(), format!("{}=1", word.to_uppercase())];
    blocks.into_iter().find(|block| diagnostics(machine.clone(), block).is_empty())
}

/// Whether the control refuses the word alone as an unknown code.
pub(super) fn is_unknown_code(machine: &Machine, word: &str) -> bool {
    let found = words::register_of(machine, word).and_then(|found| found.register);
    let code = found.is_some_and(|(register, value)| value.is_some() && machine.tables.has_codes(register));
    let unknown = |told: &Value| told.at("number") == diag::UNKNOWN_CODE.number;
    code && diagnostics(machine.clone(), word).iter().any(unknown)
}

/// The diagnostics of a block, or the reason why it cannot be run.
pub(super) fn diagnostics(machine: Machine, block: &str) -> Vec<Value> {
    let name = "block.nc";
    let mut files = MemoryFiles::default();
    files.insert(name, format!("{block}\nM30\n"));
    let control = JobControl::new(machine.channels.len());
    let mut options = JobOptions { threads: 1, ..JobOptions::default() };
    options.limits.blocks = BLOCKS;
    let program = ProgramSelection { file: name.to_owned(), number: None, section: None, channel: None };
    let spec = Spec { machine: Arc::new(machine), programs: vec![program], options };
    match Job::prepare(spec, &files) {
        Ok(job) => {
            let mut sink = OfFirstLine::default();
            job.run(&files, &control, &mut sink);
            sink.0
        }
        Err(error) => vec![json!({ "number": 0, "severity": 8, "text": error.to_string() })],
    }
}
