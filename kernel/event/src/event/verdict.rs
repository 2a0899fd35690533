//! The verdict on channels that can never continue.

use super::FileId;
use super::declare::{record, words};
use super::fields::{Datum, Field, Fields, Record, Source, Value};

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
        pub members: Vec<Member> = 4,
    }
}

/// A channel in a verdict.
#[derive(Debug, Clone, PartialEq)]
pub struct Member {
    /// Channel number.
    pub channel: u16,
    /// File of the line where it is stopped.
    pub file: FileId,
    /// That line, 0 when it has none (never started).
    pub line: u32,
    /// Channels it waits for, ascending; empty for an ended, alarmed or absent partner.
    pub waiting_for: Vec<u16>,
}

impl Record for Member {
    fn fields(&self, out: &mut impl Fields) {
        self.channel.put(Field::new(1, "channel"), out);
        out.put(Field::new(2, "file"), Value::File(self.file, self.line));
        self.line.put(Field::new(3, "line"), out);
        self.waiting_for.put(Field::new(4, "waiting_for"), out);
    }

    fn read(from: &impl Source) -> Option<Self> {
        Some(Self {
            channel: Datum::get(1, from)?,
            file: Datum::get(2, from)?,
            line: Datum::get(3, from)?,
            waiting_for: Datum::get(4, from)?,
        })
    }
}
