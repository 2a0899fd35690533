//! The reader of the texts of a job's programs: the machine, or the first component with each pre-processor if the
//! components of a composite have different ones.
//!
//! Decision: a program file is read by the component with which its channel begins. *Invariant:* the readers are in the
//! order of [`Machine::readers`].

use std::sync::Arc;

use super::callers::Callers;
use super::shape::ProgramDelimiters;
use super::syntax::Syntax;
use crate::spec::ProgramSelection;
use counterpoint_machine::Machine;

/// A definition that reads texts.
pub(super) struct ProgramReader<'a> {
    /// The definition.
    pub(super) machine: &'a Machine,
    /// The rules for separating programs.
    pub(super) shape: Arc<ProgramDelimiters>,
    /// Which programs call others.
    pub(super) callers: Callers,
}

/// All readers of a machine.
pub(super) struct Readers<'a> {
    machine: &'a Machine,
    first: ProgramReader<'a>,
    others: Vec<ProgramReader<'a>>,
}

impl<'a> Readers<'a> {
    /// Of a machine.
    pub(super) fn of(machine: &'a Machine, syntax: impl Fn(&Machine) -> &'static Syntax) -> Self {
        let reader = |machine: &'a Machine| {
            let syntax = syntax(machine);
            ProgramReader {
                machine,
                shape: Arc::new(ProgramDelimiters::of(machine, syntax)),
                callers: Callers::of(machine, syntax),
            }
        };
        let mut all = machine.readers().into_iter().map(reader);
        let first = all.next().unwrap_or_else(|| reader(machine));
        Self { machine, first, others: all.collect() }
    }

    /// How many there are.
    pub(super) fn count(&self) -> usize {
        self.others.len() + 1
    }

    /// One of them; the first, if there is no such one.
    pub(super) fn at(&self, place: usize) -> &ProgramReader<'a> {
        place.checked_sub(1).and_then(|place| self.others.get(place)).unwrap_or(&self.first)
    }

    /// Place of the component that reads a program of the job: that of the channel which the program names, otherwise
    /// that of the next channel from the left that no program names.
    pub(super) fn of_program(&self, programs: &[ProgramSelection], place: usize) -> usize {
        if self.others.is_empty() {
            return 0;
        }
        let named = |channel: u16| programs.iter().any(|program| program.channel == Some(channel));
        let before = programs.iter().take(place).filter(|program| program.channel.is_none()).count();
        let mut free = self.machine.channels.iter().map(|channel| channel.number).filter(|&channel| !named(channel));
        let channel = programs.get(place).and_then(|program| program.channel).or_else(|| free.nth(before));
        channel.map_or(0, |channel| self.machine.reader_for(self.machine.of_channel(channel).preprocessor))
    }
}
