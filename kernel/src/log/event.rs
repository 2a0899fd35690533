//! The events of a job, in the order of the log.
//!
//! Everything a user sees (listing, timeline, toolpath, summary, live progress) is read off these events;
//! nothing prints on the side. Invariant: an event is complete when it is emitted and is never changed later,
//! and the log is sorted by `(t_ns, micro, stream rank, order within the stream)`.

use std::sync::Arc;

pub use counterpoint_event::{FileId, MAX_AXES, Position};
pub use counterpoint_fault::Stop;
use serde::{Deserialize, Serialize};

/// What happened on one channel at one instant or during one stretch of simulated time.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    /// Start, nanoseconds of simulated time since the start of the job.
    pub t_ns: i64,
    /// Order of causally related events at the same nanosecond (superdense time).
    pub micro: u32,
    /// Duration in nanoseconds; 0 for what takes no time.
    pub dur_ns: i64,
    /// Channel number, 0 for the master kernel.
    pub channel: u16,
    /// Source file of the block; meaningless when `line` is 0.
    pub file: FileId,
    /// Line in the file, from 1; 0 when the event belongs to no line.
    pub line: u32,
    /// What it is.
    pub kind: Kind,
}

/// The kinds of events.
#[derive(Debug, Clone, PartialEq)]
pub enum Kind {
    /// A kernel entered a phase of its life.
    Lifecycle(Phase),
    /// A block was read and is about to act; `number` counts the blocks of the channel from 1.
    Block {
        /// Ordinal of the block within its channel, from 1.
        number: u64,
    },
    /// One motion (boxed nowhere: this is the hot kind).
    Motion(Motion),
    /// Programmed dwell of `dur_ns`.
    Dwell,
    /// A tool was selected or loaded; `dur_ns` is the change time.
    Tool {
        /// Preselect or load.
        action: ToolAction,
        /// Tool number as programmed (station on a turret).
        tool: u32,
        /// Offset number, 0 = none or cancelled.
        offset: u32,
    },
    /// What is known about a tool has changed.
    ToolData(Box<ToolData>),
    /// Spindle state after a spindle code; `dur_ns` is run-up time if the machine has any.
    Spindle(Spindle),
    /// Coolant switched.
    Coolant(Coolant),
    /// An M function (or other word) that only takes time from the machine's table.
    Function {
        /// Register letter, `M` mostly.
        letter: char,
        /// Its value.
        value: f64,
    },
    /// A modal state changed; `text` is the action wording of the listing (`plane zx`, `comp diam left n=3`).
    Mode {
        /// Action wording.
        text: Box<str>,
    },
    /// The work frame moved: machine position = programmed position + `shift`, axis by axis (axis units).
    Frame {
        /// Shift from the work frame to the machine base frame.
        shift: Box<Position>,
    },
    /// The program stops or ends here.
    Stop(Stop),
    /// A subprogram was entered.
    Call {
        /// Program number or name as written.
        program: Box<str>,
        /// Nesting level inside the subprogram, from 1.
        level: u16,
    },
    /// A subprogram was left.
    Return {
        /// Nesting level that was left, from 1.
        level: u16,
    },
    /// An operator message or comment shown to the operator, or a line that a macro prints.
    Message {
        /// Its text.
        text: Box<str>,
        /// A macro has printed it (PPRINT): it is a line of the listing.
        printed: bool,
    },
    /// The channel arrived at a meeting point and may now stand still.
    Wait(Arc<Wait>),
    /// The channel goes on after a wait that began at `since_ns`.
    Release(Release),
    /// A diagnostic of the program, the machine or a limit.
    Diagnostic(Box<Diagnostic>),
    /// A line of the trace.
    Trace {
        /// Its letter.
        letter: char,
        /// The whole line.
        text: Box<str>,
    },
    /// The verdict on channels that can never go on.
    Verdict(Box<Verdict>),
}

impl Kind {
    /// Bytes of the text that it carries.
    pub(crate) fn text_bytes(&self) -> usize {
        match self {
            Self::Message { text, .. } | Self::Trace { text, .. } | Self::Mode { text } => text.len(),
            Self::Diagnostic(diagnostic) => diagnostic.text.len(),
            Self::Call { program, .. } => program.len(),
            _ => 0,
        }
    }
}

/// Phases in the life of the job and its kernels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Phase {
    /// Master kernel: declaration and machine startup done.
    MachineStart,
    /// A channel's kernel begins its program.
    ProgramStart,
    /// A channel's kernel has no program.
    NotStarted,
    /// A channel's program has ended.
    ProgramEnd,
    /// A channel stopped on an alarm.
    Alarmed,
    /// A channel was stopped by a limit, an alarm of the machine or a cancel.
    Stopped,
    /// A channel stands at a wait that can never be released.
    Blocked,
    /// Master kernel: machine shutdown.
    MachineEnd,
}

/// How the tool moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum MotionKind {
    /// Positioning.
    Rapid,
    /// Straight feed.
    Linear,
    /// Circle, clockwise seen along the negative normal of the plane.
    ArcCw,
    /// Circle, counter-clockwise.
    ArcCcw,
    /// Circle in space.
    ArcSpace,
    /// Thread cut: feed locked to the spindle.
    Thread,
}

/// What a feed value means.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum FeedUnit {
    /// Machine units per minute.
    PerMinute,
    /// Machine units per revolution of the spindle.
    PerRevolution,
    /// Inverse time: one over minutes for the block.
    InverseTime,
    /// No feed: rapid traverse.
    Rapid,
}

/// One motion in the work frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    /// Rapid, linear, arc or thread.
    pub kind: MotionKind,
    /// Bit `i` set: axis `i` of the channel was coded in the block or moves.
    pub moving: u8,
    /// Start position.
    pub from: Position,
    /// End position.
    pub to: Position,
    /// Arc centre by the two plane axes of `plane_axes`, in programmed units (radius values are given as
    /// diameters on a diameter axis); of a circle in space where its middle is over the chord, as
    /// `counterpoint_motion::space::Circle::bulge` tells it by radius values of X, Y and Z; unused otherwise.
    pub center: [f64; 2],
    /// Axis indices (channel order) of the first and second axis of the arc's plane; 255 = none.
    pub plane_axes: [u8; 2],
    /// Full turns in addition to the arc from start to end.
    pub turns: u16,
    /// Feed in `feed_unit`; thread: lead in machine units per revolution; 0 for rapid.
    pub feed: f64,
    /// Unit of `feed`.
    pub feed_unit: FeedUnit,
    /// Length of the tool path in machine units (rotary axes do not count unless nothing else moves).
    pub length: f64,
}

impl Motion {
    /// A move along a straight line in the axes' space.
    #[must_use]
    pub fn straight(
        kind: MotionKind,
        moving: u8,
        [from, to]: [Position; 2],
        (feed, feed_unit): (f64, FeedUnit),
        length: f64,
    ) -> Self {
        let (center, plane_axes, turns) = ([0.0; 2], [255; 2], 0);
        Self { kind, moving, from, to, center, plane_axes, turns, feed, feed_unit, length }
    }
}

/// What a tool code did.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ToolAction {
    /// Preselected, not yet in the spindle.
    Select,
    /// Loaded or indexed.
    Load,
    /// Only the offset of the loaded tool changed.
    Offset,
}

/// What is known about a tool: the whole of it, whenever something changes.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct ToolData {
    /// Tool number as programmed.
    pub tool: u32,
    /// Name, empty without one.
    pub name: Box<str>,
    /// Diameter in machine units.
    pub diameter: Option<f64>,
    /// Corner radius in machine units.
    pub radius: Option<f64>,
    /// Length in machine units.
    pub length: Option<f64>,
    /// Its place among the tools of the channel, from 1; 0 = by its first load.
    pub place: u16,
}

/// State of a spindle after a spindle code.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spindle {
    /// Spindle number of the machine.
    pub spindle: u16,
    /// Rotation.
    pub direction: Direction,
    /// `true` = constant surface speed.
    pub css: bool,
    /// Revolutions per minute, or surface speed in m/min (ft/min in inch) when `css`.
    pub speed: f64,
    /// Speed limit in rev/min; infinite when none.
    pub limit: f64,
    /// Angle of an oriented stop, degrees; 0 otherwise.
    pub angle: f64,
}

/// Rotation of a spindle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Direction {
    /// Standing.
    Off,
    /// M3.
    Clockwise,
    /// M4.
    CounterClockwise,
    /// Oriented, M19.
    Oriented,
    /// Held in its place.
    Locked,
    /// Free to be turned by hand.
    Neutral,
}

/// A coolant that was switched.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Coolant {
    /// `true` = on.
    pub on: bool,
    /// What flows, by the numbers of `$COOLTYP`: 1 flood, 2 mist, 3 tapping oil, 4 through the tool, 5 to 9 of the
    /// machine's own; 0 = off, or not said.
    pub fluid: u8,
    /// Where.
    pub outlet: Outlet,
}

/// Where coolant flows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outlet {
    /// At the main head.
    Main,
    /// At the side head.
    Side,
    /// From an auxiliary device, 1 to 9.
    Device(u8),
}

impl Coolant {
    /// Names of what flows, by number.
    pub const FLUIDS: [&'static str; 10] =
        ["on", "flood", "mist", "tapkul", "thru", "type5", "type6", "type7", "type8", "type9"];

    /// What flows, in one word; `off` when nothing does.
    #[must_use]
    pub fn word(&self) -> &'static str {
        if self.on { Self::FLUIDS.get(usize::from(self.fluid)).copied().unwrap_or("on") } else { "off" }
    }
}

/// The words of the listing.
impl std::fmt::Display for Coolant {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.outlet {
            Outlet::Main => write!(f, "coolant {}", self.word()),
            Outlet::Side => write!(f, "coolant side {}", self.word()),
            Outlet::Device(number) => write!(f, "coolant dev{number} {}", self.word()),
        }
    }
}

/// Arrival at a meeting point.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Wait {
    /// Mark as shown to people: `M101`, `M101 P12`.
    pub key: Arc<str>,
    /// Primitive that waits.
    pub primitive: Primitive,
    /// Channels that take part, own one included, ascending.
    pub participants: Arc<[u16]>,
}

/// The primitives of channel synchronisation (reference: channel-synchronisation.md 0 and 1.1).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub enum Primitive {
    /// All named channels meet.
    Barrier,
    /// A set flag lets others pass.
    Flag,
    /// Ascending order numbers.
    Order,
    /// The k-th meets the k-th.
    Count,
    /// One sender, one receiver.
    Signal,
    /// Waits for the end of others.
    Join,
}

/// A wait that came true.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Release {
    /// Same text as in [`Wait::key`].
    pub key: Arc<str>,
    /// Primitive that waited.
    pub primitive: Primitive,
    /// When this channel arrived, ns.
    pub since_ns: i64,
    /// Ordinal of the meeting in the job, from 1, the same in all channels of one meeting.
    pub meeting: u64,
}

/// One diagnostic.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct Diagnostic {
    /// Stable number with a page in `docs/diagnostics/`.
    pub number: u32,
    /// 0–3 message, 4–7 warning, 8–15 error, 16–99 fatal.
    pub severity: u8,
    /// Text for people, one line.
    pub text: Box<str>,
    /// Name of the operation as macros have set it (`$OPNAME`), empty without one.
    pub operation: Box<str>,
    /// Name of the kernel as macros have set it (`$MCENAM`), empty while it is that of the channel.
    pub kernel: Box<str>,
    /// The statement of a macro that raised it, none if no macro did.
    pub origin: Option<Box<Origin>>,
}

/// A statement of a macro that raised a diagnostic.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Origin {
    /// Name of the macro as the trace shows it.
    #[serde(rename = "macro")]
    pub name: Box<str>,
    /// Its file.
    pub file: Box<str>,
    /// Line in that file, from 1.
    pub line: u32,
    /// The statement as the trace shows it.
    pub statement: Box<str>,
}

/// Why channels can never go on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum VerdictKind {
    /// Each waits for another one of the circle.
    Cycle,
    /// Waits that the control refuses to pair.
    Mismatch,
    /// The partner's program has ended.
    PartnerEnded,
    /// The partner stands on an alarm.
    PartnerAlarmed,
    /// The partner has no program.
    PartnerNeverStarted,
    /// The partner polls for something that never comes.
    PartnerSpinning,
    /// Axis or spindle ownership in a circle.
    LeaseCycle,
    /// A limit of the job ended the run.
    Limit,
}

/// The verdict on a job.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdict {
    /// Its class.
    pub kind: VerdictKind,
    /// Simulated time at which it became certain.
    pub at_ns: i64,
    /// The whole story for people.
    pub text: Box<str>,
    /// The channels concerned, ascending.
    pub members: Vec<Member>,
}

/// A channel in a verdict.
#[derive(Debug, Clone, PartialEq)]
pub struct Member {
    /// Channel number.
    pub channel: u16,
    /// File of the line where it stands.
    pub file: FileId,
    /// That line, 0 when it has none (never started).
    pub line: u32,
    /// Channels it waits for, ascending; empty for an ended, alarmed or absent partner.
    pub waiting_for: Vec<u16>,
}
