//! The checked machine definition as the kernel uses it.

use super::ident::{CodeId, DataId};
use super::tables::Tables;
use crate::log::event::{MAX_AXES, Position};
use crate::log::info::Unit;

/// A machine with its control.
#[derive(Debug, Clone)]
pub struct Machine {
    /// Name, 1–32 characters.
    pub name: String,
    /// Number 1–999999.
    pub number: u32,
    /// Revision.
    pub revision: u32,
    /// Author, free text.
    pub author: String,
    /// One line on what the machine is.
    pub description: String,
    /// Primary unit of length; positions in events are in this unit.
    pub unit: Unit,
    /// Kind of machine.
    pub kind: MachineKind,
    /// What evaluates variables, branches and macro calls in the program.
    pub preprocessor: Preprocessor,
    /// Shape of program text.
    pub format: Format,
    /// Registers in list order; `Word::register` of the kernel is an index into this list.
    pub registers: Vec<Register>,
    /// Code rows in file order.
    pub codes: Vec<CodeRow>,
    /// Data rows in file order.
    pub data: Vec<DataRow>,
    /// Names of custom code identifiers; `CodeId(codes::TABLE.len() + i)` is the i-th.
    pub custom_codes: Vec<String>,
    /// Names of custom data identifiers, likewise.
    pub custom_data: Vec<String>,
    /// All axes of the machine.
    pub axes: Vec<Axis>,
    /// Channels in ascending number.
    pub channels: Vec<Channel>,
    /// Spindles.
    pub spindles: Vec<Spindle>,
    /// Codes active at program start.
    pub initial: Vec<CodeId>,
    /// Subprogram calls.
    pub subprograms: Subprograms,
    /// Channel synchronisation.
    pub sync: Sync,
    /// Times.
    pub time: Time,
    /// Canned cycles.
    pub cycles: Cycles,
    /// Circles.
    pub arcs: super::paths::Arcs,
    /// Threading cycles.
    pub threads: super::paths::Threads,
    /// Direction of the tool, from its tip to the spindle, with all rotary axes at zero.
    pub tool_direction: [f64; 3],
    /// Pump of the coolant.
    pub pump: Pump,
    /// Cutter and nose radius compensation.
    pub compensation: Compensation,
    /// Program variables of the pre-processor.
    pub variables: Variables,
    /// Tool word and tool offsets.
    pub tool: Tool,
    /// Work offsets 1 (G54) to n: per machine axis (index into `axes`), axis units.
    pub work_offsets: Vec<Vec<f64>>,
    /// Macros, none if the machine has none.
    pub macros: Option<std::sync::Arc<crate::macros::model::Macros>>,
    /// Rules that change the text of every block before anything else, in order.
    pub tape_editor: Vec<TapeRule>,
    /// Dialogs, by name.
    pub dialogs: Vec<crate::dialog::Dialog>,
    /// What the machine changes about diagnostics.
    pub diagnostics: Diagnostics,
    /// Files stored with the machine, `//ICAMFS/…`, sorted by path.
    pub storage: Vec<StoredFile>,
    /// Dense lookups compiled from the rows.
    pub tables: Tables,
}

/// What a machine changes about diagnostics.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Diagnostics {
    /// Rules, ascending by number.
    pub rules: Vec<DiagnosticRule>,
    /// Diagnostics below this severity are not logged.
    pub min_severity: u8,
}

/// What a machine changes about one number.
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
}

/// A file stored with the machine; it is never written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StoredFile {
    /// Path below `//ICAMFS/`.
    pub path: String,
    /// Content.
    pub content: crate::files::Bytes,
}

/// A rule of the tape editor.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TapeRule {
    /// Expression in the dialect of `ed`; it is correct.
    pub find: String,
    /// What takes the place of its first match, `\1` to `\9` are groups.
    pub replace: String,
    /// Switched on at program start.
    pub on: bool,
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

/// Program pre-processor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Preprocessor {
    /// None: plain words only.
    None,
    /// Fanuc custom macro B.
    Fanuc,
}

/// Shape of program text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Format {
    /// Rewind-stop text alone on a line, empty = none.
    pub rws: String,
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

/// A register: a letter (or text) with a number.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Register {
    /// Index of the definition, 1–99.
    pub index: u8,
    /// Name: one capital letter for a regular register.
    pub name: String,
    /// Second name: incremental form.
    pub second: Option<String>,
    /// Text before the number; the name itself for a regular register.
    pub before: String,
    /// Text after the number, empty for a regular register.
    pub after: String,
    /// Number format in primary units.
    pub format: NumberFormat,
    /// Number format in secondary units.
    pub secondary: NumberFormat,
    /// Values may be negative.
    pub signed: bool,
}

impl Register {
    /// One capital letter and nothing after the number; everything else is a special register.
    #[must_use]
    pub fn is_regular(&self) -> bool {
        self.after.is_empty() && matches!(self.before.as_bytes(), [letter] if letter.is_ascii_uppercase())
    }
}

/// Format of a register's number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NumberFormat {
    /// Digits before the point.
    pub whole: u8,
    /// Digits after the point.
    pub frac: u8,
    /// Decimal point.
    pub point: Point,
    /// Leading zeros.
    pub lead: Zeros,
    /// Trailing zeros.
    pub trail: Zeros,
    /// Plus sign is shown.
    pub plus: bool,
}

/// Decimal point of a register.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Point {
    /// Always written if fractional digits exist.
    Keep,
    /// Written only if needed.
    Fractional,
    /// Implied: never written.
    Omit,
}

/// Zeros of a register.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Zeros {
    /// All are written.
    Keep,
    /// One is written.
    One,
    /// None is written.
    Omit,
}

/// A row of the code table.
#[derive(Debug, Clone, PartialEq)]
pub struct CodeRow {
    /// What fires.
    pub id: CodeId,
    /// How it is written.
    pub form: CodeForm,
    /// `false` = the row does not exist for the scanner.
    pub enable: bool,
    /// `false` = recognised and swallowed.
    pub process: bool,
    /// 1–999, small first.
    pub order: u16,
    /// 0–999, 0 = none.
    pub group: u16,
    /// Modality.
    pub modality: Modality,
    /// value' = value · mul + add.
    pub mul: f64,
    /// See `mul`.
    pub add: f64,
    /// Row matches only if one of these registers (index into `registers`) is on the block; empty = always.
    pub with: Vec<u8>,
    /// Row matches only if none of these registers is on the block.
    pub without: Vec<u8>,
    /// Seconds this code takes (machine's time table), 0 = none.
    pub seconds: f64,
    /// Axis role that a canned cycle works along (0 X, 1 Y, 2 Z), none = the one that the plane leaves.
    pub axis: Option<u8>,
    /// Line in `file` where the row is defined.
    pub line: u32,
    /// File where the row is defined (relative to the machines folder).
    pub file: String,
}

/// Written form of a code.
#[derive(Debug, Clone, PartialEq)]
pub enum CodeForm {
    /// No form in the program; only macros fire it.
    NotApplicable,
    /// Literal text.
    Text(String),
    /// Register (index into `registers`) with a value range, inclusive.
    Register {
        /// Index into `Machine::registers`.
        register: u8,
        /// Smallest value.
        min: f64,
        /// Largest value.
        max: f64,
    },
    /// The same, and the value is handed over as data.
    RegisterAsData {
        /// Index into `Machine::registers`.
        register: u8,
        /// Smallest value.
        min: f64,
        /// Largest value.
        max: f64,
        /// Data identifier that receives value · mul + add.
        data: DataId,
    },
}

/// Modality of a code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Modality {
    /// Acts on its block.
    NonModal,
    /// Active until another code of its group.
    Modal,
    /// Modal, and fires again on every block.
    Persistent,
}

/// A row of the data table.
#[derive(Debug, Clone, PartialEq)]
pub struct DataRow {
    /// What it supplies.
    pub id: DataId,
    /// Register (index into `registers`), `None` = not in the program text.
    pub register: Option<u8>,
    /// `false` = the word is not recognised through this row.
    pub enable: bool,
    /// `false` = recognised and dropped.
    pub process: bool,
    /// The last value is remembered.
    pub modal: bool,
    /// Smallest value accepted, before `mul` and `add`.
    pub min: Option<f64>,
    /// Largest value accepted.
    pub max: Option<f64>,
    /// value' = value · mul + add.
    pub mul: f64,
    /// See `mul`.
    pub add: f64,
    /// Dimension, for the change of units.
    pub dimension: Dimension,
    /// Line where the row is defined.
    pub line: u32,
    /// File where the row is defined.
    pub file: String,
}

/// Dimension of a value: decides what a switch between mm and inch scales.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dimension {
    /// A number.
    None,
    /// Length.
    Length,
    /// Length in least increments: 0.001 mm or 0.0001 inch, which the factor of the row brings in.
    Increments,
    /// Degrees.
    Angle,
    /// Length per minute or per revolution.
    Feed,
    /// m/min or ft/min.
    SurfaceSpeed,
    /// Seconds.
    Time,
}

impl Dimension {
    /// Dimension of a value that is given without the factor of its row.
    pub(crate) fn plain(self) -> Self {
        if self == Self::Increments { Self::Length } else { self }
    }
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
    /// Acceleration, axis units per second squared; `None` = speed changes take no time.
    pub acceleration: Option<f64>,
    /// Start position and first reference point in the machine frame (as programmed: diameter on a diameter axis).
    pub home: f64,
    /// Second to fourth reference points.
    pub references: [Option<f64>; 3],
    /// Travel limits in the machine frame, as programmed.
    pub limits: Option<(f64, f64)>,
    /// Direction about which the tool turns right-handed relative to the workpiece, on a rotary axis.
    pub vector: [f64; 3],
    /// A point on a rotary axis, machine frame with all axes at zero, geometry units.
    pub center: [f64; 3],
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
    /// Axes (index into `Machine::axes`) in display order, at most [`MAX_AXES`].
    pub axes: Vec<usize>,
    /// Spindle number its feed per revolution and S word mean.
    pub spindle: Option<u16>,
    /// Sub-spindle, for `CODE_SPINDLE_REAR`.
    pub rear: Option<u16>,
    /// Spindle of the milling mode.
    pub milling: Option<u16>,
    /// Linear and rotary axis of polar interpolation (index into `Machine::axes`).
    pub polar: Option<[usize; 2]>,
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
}

/// Subprogram calls.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Subprograms {
    /// Where they are looked for after the calling file.
    pub placement: Placement,
    /// Extension of subprogram files, without dot (`tps`).
    pub extension: String,
    /// How P of a call is read.
    pub call: CallForm,
    /// Repeat word counts executions (`true`) or extra passes (`false`).
    pub repeat_is_executions: bool,
    /// What a return in the main program does.
    pub main_return: MainReturn,
}

/// Where subprograms are looked for besides the calling file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Placement {
    /// In the main file, by definition word.
    SameFile,
    /// All in one file, the main file's stem with the extension.
    OneFile,
    /// One file each.
    FileEach,
}

/// Form of the program number in a call.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CallForm {
    /// P is the number only.
    Number,
    /// P of more than four digits holds the repeat count before the last four (Fanuc).
    RepeatAndNumber,
}

/// What a return code does in a main program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MainReturn {
    /// One cycle ends the run of the channel.
    End,
    /// The program starts again at its top.
    Restart,
}

/// Channel synchronisation.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Sync {
    /// Dialect of the meeting codes.
    pub dialect: SyncDialect,
    /// How the list of channels is written.
    pub paths: PathsForm,
    /// What stops when one channel alarms.
    pub alarm_scope: AlarmScope,
    /// Release delay, ns.
    pub release_ns: i64,
    /// Tick of a polling loop, ns.
    pub poll_ns: i64,
}

/// Dialect of the meeting codes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SyncDialect {
    /// No synchronisation.
    None,
    /// Fanuc waiting M codes.
    Fanuc,
}

/// Form of the channel list of a Fanuc waiting M code (parameter 8103 bit 1).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PathsForm {
    /// Sum of 2^(n−1).
    Bits,
    /// Path numbers side by side; 0 = path 10.
    List,
    /// Either form, where it is unambiguous (two channels only).
    Either,
}

/// What stops when one channel alarms.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AlarmScope {
    /// That channel only.
    Own,
    /// All channels.
    All,
}

/// Times of the machine.
#[derive(Debug, Clone, PartialEq)]
pub struct Time {
    /// Seconds of a tool change (constant part).
    pub tool_change: f64,
    /// Seconds per station step of a turret, the shorter way round.
    pub tool_step: f64,
    /// Stations of the turret, 0 = no stepping.
    pub stations: u32,
    /// Rapid moves: each axis at its own rate (slowest decides), or along a straight line.
    pub rapid: RapidPath,
    /// Seconds of an S word that changes speed.
    pub spindle_speed: f64,
}

/// What canned cycles do on this machine.
#[derive(Debug, Clone, PartialEq)]
pub struct Cycles {
    /// How the tool comes to the clearance height.
    pub approach: Approach,
    /// How clearance, return and bottom heights are read.
    pub clearance: Heights,
    /// How depths are read.
    pub depth: Heights,
    /// A cycle without its clearance height is diagnosed; otherwise it starts where it stands.
    pub clearance_required: bool,
    /// A deep or chip-breaking cycle without a step is a mistake, not a plain cycle.
    pub step_required: bool,
    /// Way back of a chip-breaking cycle, distance above the last depth of a deep one, in geometry units.
    pub step_back: f64,
    /// Smallest step, geometry units.
    pub min_step: f64,
    /// A cycle has to be cancelled before another one or a motion code.
    pub cancel_required: bool,
    /// A motion code of the program cancels the cycle.
    pub motion_cancels: bool,
}

/// Pump of the coolant.
#[derive(Debug, Clone, PartialEq)]
pub struct Pump {
    /// Largest pressure, 0 = no limit.
    pub max_pressure: f64,
    /// Pressures of `CODE_COOLANT_PRESSURE_0` and the following ones; the number of the code beyond the list.
    pub pressures: Vec<f64>,
}

/// How cutter and nose radius compensation begins, ends and goes around corners.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Compensation {
    /// A rapid move may switch it on and off.
    pub rapid: bool,
    /// A circle may switch it on and off.
    pub arcs: bool,
    /// Largest turn, degrees, that corners by angle make sharp.
    pub corner_angle: f64,
}

/// Way of a cycle to its clearance height.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Approach {
    /// All axes in one move.
    Direct,
    /// First to the position, then along the axis of the cycle.
    PositionFirst,
}

/// How heights of a cycle are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Heights {
    /// By absolute or incremental positioning.
    Mode,
    /// Always positions.
    Absolute,
    /// Always distances.
    Incremental,
}

/// Path of a rapid move.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RapidPath {
    /// Every axis at its own rate; the slowest decides the time.
    SlowestAxis,
    /// Straight line: rates scaled by the axes' share of the path.
    Linear,
}

/// Program variables of the pre-processor.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Variables {
    /// Ranges of common variables that all channels share, inclusive.
    pub shared: Vec<(u32, u32)>,
    /// Ranges of common variables of each channel's own.
    pub channel: Vec<(u32, u32)>,
}

/// Tool word and offsets.
#[derive(Debug, Clone, PartialEq)]
pub struct Tool {
    /// Digits at the end of the tool word that are the offset number (Fanuc lathe T0101: 2); 0 = tool number only.
    pub offset_digits: u8,
    /// Offsets by number: per machine axis, axis units, and nose radius.
    pub offsets: Vec<ToolOffset>,
    /// Tool-change position in the machine frame, per machine axis, as programmed.
    pub change_point: Vec<Option<f64>>,
    /// The axes go there before a tool is loaded.
    pub change_motion: bool,
}

/// One tool offset.
#[derive(Debug, Clone, PartialEq)]
pub struct ToolOffset {
    /// Number.
    pub number: u32,
    /// Value per machine axis (index into `axes`), as programmed (diameter on a diameter axis).
    pub values: Vec<f64>,
    /// Nose or cutter radius.
    pub radius: f64,
    /// Imaginary tip direction 0–9.
    pub tip: u8,
}

impl Machine {
    /// Start position of a channel: home of its axes.
    #[must_use]
    pub fn home(&self, channel: &Channel) -> Position {
        let mut position = [0.0; MAX_AXES];
        for (slot, &axis) in position.iter_mut().zip(&channel.axes) {
            *slot = self.axes.get(axis).map_or(0.0, |a| a.home);
        }
        position
    }

    /// Full name of a code identifier, custom ones included.
    #[must_use]
    pub fn code_name(&self, id: CodeId) -> &str {
        match super::ident::code_facts(id) {
            Some(facts) => facts.name,
            None => self
                .custom_codes
                .get(usize::from(id.0) - super::ident::codes::TABLE.len())
                .map_or("CODE_?", String::as_str),
        }
    }

    /// Full name of a data identifier, custom ones included.
    #[must_use]
    pub fn data_name(&self, id: DataId) -> &str {
        match super::ident::data_facts(id) {
            Some(facts) => facts.name,
            None => self
                .custom_data
                .get(usize::from(id.0) - super::ident::data::TABLE.len())
                .map_or("REG_?", String::as_str),
        }
    }
}
