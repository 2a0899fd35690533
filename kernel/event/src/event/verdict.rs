//! The verdict on channels that can never continue.

use super::FileId;
use super::declare::{record, words};
use super::fields::{EventField, EventRecord, EventValue, FieldReader, FieldType, FieldWriter};

words! {
    /// Why channels can never continue.
    pub enum VerdictKind {
        /// Each waits for another one of the circle.
        Cycle = 1 "CYCLE",
        /// Waits that the control refuses to pair.
        Mismatch = 2 "MISMATCH",
        /// The partner's program has ended.
        PartnerEnded = 3 "PARTNER_ENDED",
        /// The partner is stopped by an alarm.
        PartnerAlarmed = 4 "PARTNER_ALARMED",
        /// The partner has no program.
        PartnerNeverStarted = 5 "PARTNER_NEVER_STARTED",
        /// The partner polls for something that never comes.
        PartnerSpinning = 6 "PARTNER_SPINNING",
        /// Axis or spindle ownership in a circle.
        LeaseCycle = 7 "LEASE_CYCLE",
        /// A limit of the job ended the run.
        Limit = 8 "LIMIT",
    }
}

record! {
    /// The verdict on a job.
    #[derive(Debug, Clone, PartialEq)]
    pub struct Verdict {
        /// Its class.
        pub kind: VerdictKind = 1 [as "verdict"],
        /// Simulated time at which it became certain.
        pub at_ns: i64 = 2,
        /// The whole story for people.
        pub text: Box<str> = 3,
        /// The channels concerned, ascending.
        pub members: Vec<VerdictMember> = 4,
    }
}

/// A channel in a verdict.
#[derive(Debug, Clone, PartialEq)]
pub struct VerdictMember {
    /// Channel number.
    pub channel: u16,
    /// File of the line where it is stopped.
    pub file: FileId,
    /// That line, 0 when it has none (never started).
    pub line: u32,
    /// Channels it waits for, ascending; empty for an ended, alarmed or absent partner.
    pub waiting_for: Vec<u16>,
}

impl EventRecord for VerdictMember {
    fn fields(&self, out: &mut impl FieldWriter) {
        self.channel.put(EventField::new(1, "channel"), out);
        out.put(EventField::new(2, "file"), EventValue::File(self.file, self.line));
        self.line.put(EventField::new(3, "line"), out);
        self.waiting_for.put(EventField::new(4, "waiting_for"), out);
    }

    fn read(from: &impl FieldReader) -> Option<Self> {
        Some(Self {
            channel: FieldType::get(1, from)?,
            file: FieldType::get(2, from)?,
            line: FieldType::get(3, from)?,
            waiting_for: FieldType::get(4, from)?,
        })
    }
}
