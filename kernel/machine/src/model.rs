//! The checked machine definition as the kernel uses it.

mod behaviour;
mod components;
mod corners;
mod external;
pub mod paths;
mod tools;
mod waits;

pub use behaviour::*;
pub use components::Component;
pub use corners::CornerShape;
pub use external::*;
pub use tools::*;
pub use waits::*;

use super::ident::{CodeId, DataId, Name};
use super::index::{AxisId, AxisSlot, CodeRowId, DataRowId, IdTable, RegisterId, SpindleId};
use super::macros::environment::MachineEnvironment;
use super::preprocessor::Preprocessor;
use super::rows::{CodeForm, CodeRow, DataRow, Register, TimeOverlap};
use super::stored::StoredFile;
use super::tables::LookupTables;
use counterpoint_event::MachineUnit;
use counterpoint_event::{MAX_AXES, Position};

/// A machine with its control.
#[derive(Debug, Clone)]
pub struct Machine {
    /// Name, 1–32 characters.
    pub name: String,
    /// Number 1–999999.
    pub number: u32,
    /// Revision.
    pub revision: u32,
    /// When it was made, as the file says; empty when it does not.
    pub created: String,
    /// File it was loaded from: folder and name.
    pub file: String,
    /// Author, free text.
    pub author: String,
    /// One line that describes the machine.
    pub description: String,
    /// Primary unit of length; positions in events are in this unit.
    pub unit: MachineUnit,
    /// Kind of machine.
    pub kind: MachineKind,
    /// The evaluator of variables, branches and macro calls in the program.
    pub preprocessor: Preprocessor,
    /// Shape of program text.
    pub format: ProgramTextFormat,
    /// Registers in list order.
    pub registers: IdTable<RegisterId, Register>,
    /// Code rows in file order.
    pub codes: IdTable<CodeRowId, CodeRow>,
    /// Data rows in file order.
    pub data: IdTable<DataRowId, DataRow>,
    /// Names of all code identifiers, those of the machine's own after the built-in ones.
    pub code_names: IdTable<CodeId, Name>,
    /// Names of all data identifiers, likewise.
    pub data_names: IdTable<DataId, Name>,
    /// All axes of the machine.
    pub axes: IdTable<AxisId, Axis>,
    /// Channels in ascending number.
    pub channels: Vec<Channel>,
    /// Spindles.
    pub spindles: IdTable<SpindleId, Spindle>,
    /// Codes active at program start.
    pub initial: Vec<CodeId>,
    /// Subprogram calls.
    pub subprograms: Subprograms,
    /// Channel synchronisation.
    pub sync: Sync,
    /// Times.
    pub time: Time,
    /// Canned cycles.
    pub cycles: CycleRules,
    /// Circles.
    pub arcs: paths::ArcRules,
    /// Threading cycles.
    pub threads: paths::ThreadingRules,
    /// Turning cycles.
    pub turning: paths::TurningRules,
    /// The tool in space.
    pub kinematics: paths::Kinematics,
    /// Pump of the coolant.
    pub pump: Pump,
    /// Data that its words leave open.
    pub habits: super::habits::Habits,
    /// The file of printing statements.
    pub output: PrintFileFormat,
    /// Cutter and nose radius compensation.
    pub compensation: CompensationRules,
    /// Corners between lines.
    pub corners: Corners,
    /// Program variables of the pre-processor.
    pub variables: ProgramVariables,
    /// Tool word and tool offsets.
    pub tool: ToolSetup,
    /// Work offsets 1 (G54) to n: per machine axis, axis units.
    pub work_offsets: Vec<IdTable<AxisId, f64>>,
    /// Macros, none if the machine has none.
    pub macros: Option<std::sync::Arc<crate::macros::model::Macros>>,
    /// Rules that change the text of every block before anything else, in order.
    pub tape_editor: Vec<TapeRule>,
    /// Dialogs, by name.
    pub dialogs: Vec<counterpoint_ports::dialog::Dialog>,
    /// Changes of the machine to diagnostics.
    pub diagnostics: Diagnostics,
    /// Files stored with the machine, `//ICAMFS/…`, sorted by path.
    pub storage: Vec<StoredFile>,
    /// Components of a composite machine; empty for any other machine.
    pub components: Vec<Component>,
    /// Dense lookups compiled from the rows.
    pub tables: LookupTables,
}

/// The changes of a machine to diagnostics.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Diagnostics {
    /// Rules, ascending by number.
    pub rules: Vec<DiagnosticRule>,
    /// Diagnostics below this severity are not logged.
    pub min_severity: u8,
    /// Blocks that the control refuses with an alarm.
    pub refusals: Vec<super::refusals::BlockRefusal>,
}

/// The changes of a machine to one number.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DiagnosticRule {
    /// The number; one of the kernel, or one of the machine's own.
    pub number: u32,
    /// Severity 0–99 instead of the built-in one.
    pub severity: Option<u8>,
    /// Text instead of the built-in one; `!(*)` in it is the built-in text.
    pub text: Option<String>,
    /// `false` = never shown.
    pub enable: bool,
    /// How often a channel shows it.
    pub repeat: Option<u32>,
    /// It stops the channel, or does not; `None` = as `[control] stops` says of alarms.
    pub stops: Option<bool>,
    /// It is an alarm of this control, also where it is none of the kernel.
    pub alarm: bool,
}

/// A rule of the tape editor.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TapeRule {
    /// Expression in the dialect of `ed`; it is correct.
    pub find: String,
    /// The replacement of its first match; `\1` to `\9` are groups.
    pub replace: String,
    /// Switched on at program start.
    pub on: bool,
    /// It sees words only: no comments, no quoted texts, no parts of names.
    pub words: bool,
    /// Line in `file`.
    pub line: u32,
    /// File where it is defined.
    pub file: String,
}

/// Kind of machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MachineKind {
    /// Milling machine.
    Mill,
    /// Lathe with one or more independent turrets.
    Lathe,
    /// Upper and lower turret under one definition.
    MergingLathe,
    /// Composite of components.
    Composite,
}

/// Shape of program text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ProgramTextFormat {
    /// Rewind-stop text alone on a line, empty = none.
    pub rws: String,
    /// Text may be beside it: after it leader that is skipped, before it the last block of the tape.
    pub rws_inline: bool,
    /// A comment continues over lines until its end.
    pub long_comments: bool,
    /// Where it is expected.
    pub rws_at: RewindStop,
    /// Comment start and end; an empty end = to the end of the block.
    pub comment: Option<(String, String)>,
    /// Operator message start and end.
    pub message: Option<(String, String)>,
    /// Optional-skip mark.
    pub opskip_mark: Option<char>,
    /// Level of a mark without digit.
    pub opskip_default: u8,
    /// Extra end-of-block character.
    pub eob: Option<char>,
}

impl ProgramTextFormat {
    /// Whether a line is a rewind-stop.
    #[must_use]
    pub fn is_rewind_stop(&self, line: &[u8]) -> bool {
        is_rewind_stop(self.rws.as_bytes(), self.rws_inline, line)
    }
}

/// Whether a line has nothing but the rewind-stop or, where text may be beside it, begins with it.
#[must_use]
pub fn is_rewind_stop(rws: &[u8], inline: bool, line: &[u8]) -> bool {
    let line = line.trim_ascii();
    !rws.is_empty() && if inline { line.starts_with(rws) } else { line == rws }
}

/// Expected place of the rewind-stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RewindStop {
    /// No rewind-stop is expected.
    None,
    /// Before the first block: everything up to it is skipped.
    Start,
    /// May stand before the first block; its absence is not worth a message.
    Optional,
}

/// An axis of the machine.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Name, unique in the machine (`X`, `X2`, `C1`).
    pub name: String,
    /// Name shown in a channel (`X` for both `X1` and `X2`).
    pub letter: String,
    /// Which axis data identifier moves it (`REG_AXIS_X`, …).
    pub data: DataId,
    /// Geometry role.
    pub role: AxisRole,
    /// Programmed and shown as diameter.
    pub diameter: bool,
    /// Rapid rate, axis units per minute (radius on a diameter axis).
    pub rapid: f64,
    /// How fast its speed changes.
    pub dynamics: Dynamics,
    /// Start position and first reference point in the machine frame (as programmed: diameter on a diameter axis).
    pub home: f64,
    /// Further points that codes send it to, and the path there.
    pub positioning: ReferencePoints,
    /// Travel limits in the machine frame, as programmed.
    pub limits: Option<(f64, f64)>,
    /// Direction about which the tool turns right-handed relative to the workpiece, on a rotary axis.
    pub vector: [f64; 3],
    /// A point on a rotary axis, machine frame with all axes at zero, geometry units.
    pub center: [f64; 3],
    /// How absolute words turn a rotary axis.
    pub turn: RotaryPositioning,
    /// Channels exchange it; this one has it at the start.
    pub master: Option<u16>,
    /// The name of the axis in codes that couple axes of channels, and its behaviour when coupled.
    pub coupling: AxisCoupling,
}

/// Points of an axis in the machine frame, as programmed: the part zero, points that codes send the axis to, and the path
/// there.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ReferencePoints {
    /// The part zero where a work offset has no value.
    pub part_zero: f64,
    /// Second to fourth reference points.
    pub references: [Option<f64>; 3],
    /// Floating reference point.
    pub floating: Option<f64>,
    /// How far one-way positioning goes past its end before it comes back; its sign is the direction in which it comes.
    /// 0 = not.
    pub one_way: f64,
    /// Where the axis meets a part or a stop.
    pub stop: FixedStop,
}

/// Position at which an axis meets a part or a stop, in the machine frame, as programmed; unknown without both fields.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FixedStop {
    /// The position.
    pub at: Option<f64>,
    /// Number of a variable whose value takes precedence.
    pub variable: Option<u32>,
}

/// An axis in codes that couple axes of channels (Fanuc G51.4, G51.5, G51.6).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct AxisCoupling {
    /// Number by which programs name it (Fanuc parameter 12600); none: it cannot be coupled.
    pub number: Option<u16>,
    /// Its positive direction is against that of the other axes with a number.
    pub mirrored: bool,
}

/// How fast the speed of an axis changes, in axis units (radius on a diameter axis).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Dynamics {
    /// Acceleration, units per second squared; `None` = speed changes take no time.
    pub acceleration: Option<f64>,
    /// Jerk, units per second cubed; `None` = the acceleration changes at once.
    pub jerk: Option<f64>,
    /// Largest change of its speed at a corner that is passed without a stop, units per minute; `None` = any.
    pub corner_speed: Option<f64>,
}

impl Dynamics {
    /// The same with the corner speed per second.
    #[must_use]
    pub fn per_second(self) -> Self {
        Self { corner_speed: self.corner_speed.map(|speed| speed / 60.0), ..self }
    }
}

/// How an absolute word turns a rotary axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RotaryPositioning {
    /// It is the position, whole turns counted.
    Position,
    /// It is the angle, reached the shorter path.
    Shortest,
    /// It is the angle, its sign the direction.
    Sign,
}

/// Geometry role of an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AxisRole {
    /// First linear axis.
    X,
    /// Second linear axis.
    Y,
    /// Third linear axis.
    Z,
    /// Linear, outside the three.
    Linear,
    /// Rotary, degrees.
    Rotary,
}

impl AxisRole {
    /// Degrees instead of length.
    #[must_use]
    pub fn is_rotary(self) -> bool {
        matches!(self, Self::Rotary)
    }
}

/// A channel (path, turret).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Channel {
    /// Number from 1.
    pub number: u16,
    /// Name (`UPPER`).
    pub name: String,
    /// Its axes, in display order.
    pub axes: IdTable<AxisSlot, AxisId>,
    /// Spindle that its feed per revolution and S word mean.
    pub spindle: Option<SpindleId>,
    /// Sub-spindle, for `CODE_SPINDLE_REAR`.
    pub rear: Option<SpindleId>,
    /// Spindle of the milling mode.
    pub milling: Option<SpindleId>,
    /// Linear and rotary axis of polar interpolation.
    pub polar: Option<[AxisSlot; 2]>,
    /// Its tools work from below the turning axis: toolpath pictures show it there.
    pub lower: bool,
}

/// A spindle.
#[derive(Debug, Clone, PartialEq)]
pub struct Spindle {
    /// Number.
    pub number: u16,
    /// Name.
    pub name: String,
    /// Largest speed, rev/min.
    pub max: f64,
    /// Smallest speed under constant surface speed and feed per revolution, rev/min.
    pub min: f64,
    /// Seconds from standing to largest speed; 0 = at once.
    pub run_up: f64,
    /// The actions that the change of its speed runs in parallel with.
    pub overlap: TimeOverlap,
    /// Number of the spindle that it follows when a coupling code names no spindle.
    pub follows: Option<u16>,
    /// Seconds to reach its phase to the leading spindle.
    pub phase: f64,
    /// State of its chuck when a program begins, if the machine knows chucks.
    pub chuck: Option<ChuckAtStart>,
    /// The axis that moves it to the part and back.
    pub slide: Option<AxisId>,
    /// Its chuck may close on a turning part only in phase.
    pub takes_in_phase: bool,
}

/// State of a chuck when a program begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ChuckAtStart {
    /// Closed on a bar.
    Bar,
    /// Closed on a part.
    Part,
    /// Closed, without a part.
    Empty,
    /// Open.
    Open,
}

impl ChuckAtStart {
    /// The words of machine files.
    pub(crate) const WORDS: [(&'static str, Self); 4] =
        [("bar", Self::Bar), ("part", Self::Part), ("empty", Self::Empty), ("open", Self::Open)];
}

impl Machine {
    /// The two spindles that transfer parts, leader first, if the machine knows their chucks.
    #[must_use]
    pub fn chucks(&self) -> Option<(SpindleId, SpindleId)> {
        let follower = self.spindles.find(|spindle| spindle.follows.is_some() && spindle.chuck.is_some())?;
        let leader = self.spindles.find(|spindle| Some(spindle.number) == self.spindles[follower].follows)?;
        self.spindles[leader].chuck.map(|_| (leader, follower))
    }
}

impl Spindle {
    /// Seconds for a change of its speed by `change`, rev/min.
    #[must_use]
    pub fn ramp(&self, change: f64) -> f64 {
        if self.run_up > 0.0 && self.max > 0.0 { self.run_up * change.abs() / self.max } else { 0.0 }
    }
}

impl Machine {
    /// Start position of a channel: home of its axes.
    #[must_use]
    pub fn home(&self, channel: &Channel) -> Position {
        let mut position = [0.0; MAX_AXES];
        for (slot, &axis) in position.iter_mut().zip(&channel.axes) {
            *slot = self.axes[axis].home;
        }
        position
    }

    /// Data of the machine for the compiler of macros while a program runs: nothing is included then.
    #[must_use]
    pub fn macro_environment(&self) -> MachineEnvironment<'_> {
        MachineEnvironment { codes: &self.code_names, data: &self.data_names, files: None, stored: &self.storage }
    }

    /// Full name of a code identifier.
    #[must_use]
    pub fn code_name(&self, id: CodeId) -> &str {
        &self.code_names[id]
    }

    /// Letter with which a code is written, `?` for a code without a register.
    #[must_use]
    pub fn letter_of(&self, form: &CodeForm) -> char {
        let register = match form {
            CodeForm::Register { register, .. } | CodeForm::RegisterAsData { register, .. } => Some(*register),
            CodeForm::Text(_) | CodeForm::NotApplicable => None,
        };
        register.and_then(|register| self.registers[register].name.chars().next()).unwrap_or('?')
    }

    /// Full name of a data identifier.
    #[must_use]
    pub fn data_name(&self, id: DataId) -> &str {
        &self.data_names[id]
    }
}
