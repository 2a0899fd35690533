//! Phases in the life of the job and its kernels.

use super::declare::words;
use super::fields::{EventField, EventRecord, FieldReader, FieldType, FieldWriter};

words! {
    /// Phases in the life of the job and its kernels.
    pub enum Phase {
        /// Master kernel: declaration and machine startup done.
        MachineStart = 1 "machine_start",
        /// A channel's kernel starts its program.
        ProgramStart = 2 "program_start",
        /// A channel's kernel has no program.
        NotStarted = 3 "not_started",
        /// A channel's program has ended.
        ProgramEnd = 4 "program_end",
        /// A channel stopped on an alarm.
        Alarmed = 5 "alarmed",
        /// A channel was stopped by a limit, an alarm of the machine or a cancel.
        Stopped = 6 "stopped",
        /// A channel is blocked at a wait that can never be released.
        Blocked = 7 "blocked",
        /// Master kernel: machine shutdown.
        MachineEnd = 8 "machine_end",
    }
}

impl EventRecord for Phase {
    fn fields(&self, out: &mut impl FieldWriter) {
        self.put(EventField::new(1, "phase"), out);
    }

    fn read(from: &impl FieldReader) -> Option<Self> {
        Self::get(1, from)
    }
}
