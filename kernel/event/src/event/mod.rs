//! The events of a job, in the order of the log.
//!
//! Everything a user sees (listing, timeline, toolpath, summary, live progress) is read off these events;
//! nothing prints on the side. Each kind of event is a type in a file of its own, which names its fields once
//! ([`fields`]). *Invariant:* an event is complete when it is emitted and is never changed later,
//! and the log is sorted by `(t_ns, micro, stream channel, order within the stream)`.

mod block;
mod call;
mod coolant;
mod declare;
mod diagnostic;
mod dwell;
pub mod fields;
mod frame;
mod function;
mod law;
mod lifecycle;
mod message;
mod mode;
mod motion;
mod spindle;
mod stop;
mod tool;
mod trace;
mod verdict;
mod wait;
mod work;

use std::sync::Arc;

pub use block::BlockEvent;
pub use call::{Return, SubprogramEntry};
pub use coolant::{Coolant, Outlet};
pub use diagnostic::{Diagnostic, DiagnosticOrigin, RaceWith, Unrecognised};
pub use dwell::Dwell;
pub use frame::FrameShift;
pub use function::TimedFunction;
pub use law::{AxesLaw, LawArc, LawDriver, LawForm, LawRamp, LawSurface, LawTurning, MotionLaw, UnknownLaw};
pub use lifecycle::Phase;
pub use message::OperatorMessage;
pub use mode::{CarriedMove, ModalChange, OffsetKind, OffsetSelection};
pub use motion::{FeedUnit, Motion, MotionKind};
pub use spindle::{SpindleChange, SpindleDirection};
pub use stop::StopCode;
pub use tool::{ToolAction, ToolChange, ToolData};
pub use trace::{Listing, Trace};
pub use verdict::{Verdict, VerdictKind, VerdictMember};
pub use wait::{Primitive, Release, WaitArrival};
pub use work::WorkClass;

pub use crate::{FileId, MAX_AXES, Position, SourcePlace};

use fields::{EventField, EventValue, FieldType, FieldWriter, Texts};

/// An event on one channel, at one instant or during one stretch of simulated time.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    /// Start, nanoseconds of simulated time since the start of the job.
    pub t_ns: i64,
    /// Order of causally related events at the same nanosecond (superdense time).
    pub micro: u32,
    /// Duration in nanoseconds; 0 for events that take no time.
    pub dur_ns: i64,
    /// Channel number, 0 for the master kernel.
    pub channel: u16,
    /// Source file of the block; meaningless when `line` is 0.
    pub file: FileId,
    /// Line in the file, from 1; 0 when the event belongs to no line.
    pub line: u32,
    /// Where the user's program called the resident program to which the block belongs; none for the user's own blocks.
    pub caller: SourcePlace,
    /// Its kind.
    pub kind: Kind,
}

declare::kinds! {
    /// The kinds of events.
    pub enum Kind {
        /// A kernel entered a phase of its life.
        10 "lifecycle" Lifecycle(Phase),
        /// A block was read and is about to act.
        11 "block" Block(BlockEvent),
        /// One motion (boxed nowhere: this is the hot kind).
        12 "motion" Motion(Motion),
        /// Programmed dwell.
        13 "dwell" Dwell(Dwell),
        /// A tool was selected or loaded.
        14 "tool" Tool(ToolChange),
        /// Spindle state after a spindle code.
        15 "spindle" Spindle(SpindleChange),
        /// Coolant switched.
        16 "coolant" Coolant(Coolant),
        /// A word that only takes time from the machine's table.
        17 "function" Function(TimedFunction),
        /// A modal state changed.
        18 "mode" Mode(ModalChange),
        /// The work frame moved.
        19 "frame" Frame(FrameShift),
        /// The program stops or ends here.
        20 "stop" Stop(StopCode),
        /// A subprogram was entered.
        21 "call" Call(SubprogramEntry),
        /// A subprogram was left.
        22 "return" Return(Return),
        /// A message to the operator, or a line that a macro prints.
        23 "message" Message(OperatorMessage),
        /// The channel arrived at a sync point and may now have to wait.
        24 "wait" Wait(Arc<WaitArrival>),
        /// The channel continues after a wait.
        25 "release" Release(Release),
        /// A diagnostic of the program, the machine or a limit.
        26 "diagnostic" Diagnostic(Box<Diagnostic>),
        /// The verdict on channels that can never continue.
        27 "verdict" Verdict(Box<Verdict>),
        /// A line of the trace.
        28 "trace" Trace(Trace),
        /// The data of a tool have changed.
        29 "tool_data" ToolData(Box<ToolData>),
        /// The law of the preceding motion, if the job records laws.
        30 "law" Law(MotionLaw),
    }
}

impl Kind {
    /// Bytes of the texts that it carries.
    pub fn text_bytes(&self) -> usize {
        let mut texts = Texts::default();
        self.fields(&mut texts);
        texts.0
    }
}

impl Event {
    /// Writes the fields that every event has; `seq` is its number in the log, from 1. Those of its kind follow. The
    /// fingerprint does not count the caller: it follows from the events before.
    #[inline]
    pub fn head(&self, seq: u64, out: &mut impl FieldWriter) {
        seq.put(EventField::new(1, "seq"), out);
        self.t_ns.put(EventField::new(2, "t_ns"), out);
        self.micro.put(EventField::wire(3), out);
        self.dur_ns.put(EventField::new(4, "dur_ns"), out);
        self.channel.put(EventField::new(5, "channel"), out);
        out.put(EventField::shown("kind"), EventValue::Text(self.kind.word()));
        out.put(EventField::new(6, "file"), EventValue::File(self.file, self.line));
        self.line.put(EventField::new(7, "line"), out);
        if self.caller.is_some() {
            out.put(EventField::new(8, "caller_file"), EventValue::File(self.caller.file, self.caller.line));
            self.caller.line.put(EventField::new(9, "caller_line"), out);
        }
    }

    /// The innermost place of the block in the programs of the user.
    #[inline(always)]
    #[must_use]
    pub fn user_place(&self) -> SourcePlace {
        self.caller.or(SourcePlace::new(self.file, self.line))
    }

    /// Reads an event and its number in the log; the fields of its kind are in `kind`, of this number in the oneof.
    #[must_use]
    pub fn read<S: fields::FieldReader>(head: &S, (number, kind): (u64, &S)) -> Option<(u64, Self)> {
        let kind = Kind::read(number, kind)?;
        let seq = FieldType::get(1, head)?;
        let event = Self {
            t_ns: FieldType::get(2, head)?,
            micro: FieldType::get(3, head)?,
            dur_ns: FieldType::get(4, head)?,
            channel: FieldType::get(5, head)?,
            file: FieldType::get(6, head)?,
            line: FieldType::get(7, head)?,
            caller: SourcePlace::new(FieldType::get(8, head)?, FieldType::get(9, head)?),
            kind,
        };
        Some((seq, event))
    }
}
