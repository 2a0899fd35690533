//! Behaviour of a control: subprograms, meetings, times, cycles, compensation, variables.

use super::corners::CornerShape;
use crate::index::RegisterId;

/// Subprogram calls.
#[derive(Debug, Clone, PartialEq)]
pub struct Subprograms {
    /// Where they are looked for after the calling file.
    pub placement: Placement,
    /// Extension of subprogram files, without dot (`tps`).
    pub extension: String,
    /// How P of a call is read.
    pub call: CallForm,
    /// Repeat word counts executions (`true`) or extra passes (`false`).
    pub repeat_is_executions: bool,
    /// The effect of a return in the main program.
    pub main_return: MainReturn,
    /// Whether an end code in a subprogram ends the program; otherwise it returns.
    pub end_ends: bool,
    /// Words that call programs, in file order.
    pub calls: Vec<WordCall>,
    /// Which words still call in a program that a word has called.
    pub nested: NestedCalls,
    /// How deep calls may nest.
    pub levels: CallLevels,
    /// Which words of a block are arguments of its macro call.
    pub macro_words: MacroWords,
    /// Which variables I, J and K of a call give values.
    pub ijk: Triples,
}

/// Which variables I, J and K of a macro call give values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Triples {
    /// The n-th I, J or K is in the n-th triple.
    ByLetter,
    /// Each triple has I, J, K in this order: a letter that is not after the one before it begins the next triple.
    InOrder,
    /// All are in the first triple: the last one of a letter counts.
    First,
}

/// Which words of a block are arguments of its macro call (G65, G66, G66.1).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MacroWords {
    /// All of them; a further G word is unknown text.
    Anywhere,
    /// Those after the word that calls. A word before it, or a G word after it, stops the channel.
    Behind,
    /// Those after the word that calls. The words before it act first, as in a block of their own.
    ActBefore,
}

/// How deep calls may nest on the control; none: the limit of the job alone counts.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct CallLevels {
    /// Subprograms without arguments.
    pub subprograms: Option<u16>,
    /// Macros with arguments.
    pub macros: Option<u16>,
    /// Both together.
    pub all: Option<u16>,
}

/// A word that calls a program, or a range of such words.
#[derive(Debug, Clone, PartialEq)]
pub struct WordCall {
    /// Register of the word.
    pub register: RegisterId,
    /// Smallest value, minus infinity for a letter alone.
    pub min: f64,
    /// Largest value.
    pub max: f64,
    /// Program of the smallest value.
    pub program: u32,
    /// The next values call the next programs; otherwise all call the same one.
    pub consecutive: bool,
    /// How it calls.
    pub how: CallHow,
    /// Common variable that gets the value of the word.
    pub variable: Option<u32>,
    /// Line of the row, and its file.
    pub line: u32,
    /// File of the row.
    pub file: String,
}

impl WordCall {
    /// The program that a word of this value calls.
    #[must_use]
    pub fn program_of(&self, register: RegisterId, value: f64) -> Option<u32> {
        let within = self.register == register && self.min <= value && value <= self.max;
        if !within || self.min != self.max && self.max.is_finite() && value.fract() != 0.0 {
            return None;
        }
        let step = if self.consecutive { (value - self.min) as u32 } else { 0 };
        self.program.checked_add(step)
    }

    /// Programs that it calls, the smallest and the largest number.
    #[must_use]
    pub fn programs(&self) -> (u32, u32) {
        let span = if self.consecutive { (self.max - self.min) as u32 } else { 0 };
        (self.program, self.program.saturating_add(span))
    }
}

/// How a word calls.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CallHow {
    /// A macro, with the other words of the block as arguments (G65).
    Macro,
    /// A subprogram, after the other words of the block have acted (M98).
    Subprogram,
    /// A macro after every block that moves (G66).
    Moves,
    /// A macro with the words of every block (G66.1).
    Blocks,
}

/// Which words still call in a program that a word has called.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NestedCalls {
    /// Those of the other kind; the kinds are G codes and all other words.
    OtherKind,
    /// None.
    Never,
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

/// Action of a return code in a main program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MainReturn {
    /// One cycle ends the run of the channel.
    End,
    /// The program starts again at its top.
    Restart,
}

/// Channel synchronisation.
#[derive(Debug, Clone, PartialEq)]
pub struct Sync {
    /// Dialect of the meeting codes.
    pub dialect: SyncDialect,
    /// How the list of channels is written.
    pub paths: PathsForm,
    /// The channels that stop when one channel alarms.
    pub alarm_scope: AlarmScope,
    /// Release delay, ns.
    pub release_ns: i64,
    /// Tick of a polling loop, ns.
    pub poll_ns: i64,
    /// Most signals and waits for signals that are kept at one time.
    pub signals: Option<u32>,
    /// A word of an axis that channels exchange asks for the axis by itself.
    pub asks_for_axes: bool,
    /// An axis that programs of another channel command in composite control has its own place in their machine frame;
    /// otherwise their frame continues, and words move it by as much.
    pub composite_places: bool,
    /// Words whose macros start synchronous control of axes.
    pub coupling_words: Vec<String>,
    /// Words and texts of `[[waits]]`.
    pub waits: Vec<super::WaitRow>,
}

impl Sync {
    /// Whether programs can start the programs of other channels.
    #[must_use]
    pub fn starts_channels(&self) -> bool {
        self.waits.iter().any(|row| row.act == super::WaitAct::Start)
    }
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

/// The channels that stop when one channel alarms.
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
    /// Actions that run in parallel with a tool change.
    pub tool_overlap: crate::rows::TimeOverlap,
    /// Rapid moves: each axis at its own rate (slowest decides), or along a straight line.
    pub rapid: RapidPath,
    /// Seconds of an S word that changes speed.
    pub spindle_speed: f64,
    /// Moves at feed that the control plans at a time, in continuous mode.
    pub look_ahead: u32,
    /// Largest distance from a corner that is passed without a stop, geometry units; `None`: 0.01 mm, unless axes limit
    /// their corners themselves.
    pub corner_deviation: Option<f64>,
    /// Least time of a block with a move at feed, seconds.
    pub block_time: f64,
}

/// The behaviour of canned cycles on this machine.
#[derive(Debug, Clone, PartialEq)]
pub struct CycleRules {
    /// How the tool comes to the clearance height.
    pub approach: CycleApproach,
    /// How clearance, return and bottom heights are read.
    pub clearance: DistanceMode,
    /// How depths are read.
    pub depth: DistanceMode,
    /// A cycle without its clearance height is diagnosed; otherwise it starts where it is.
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
    /// Whether only the later of a cycle and a motion code in one block acts.
    pub last_of_block: bool,
    /// The feed of a tap whose type is rigid is its pitch.
    pub tap_pitch: bool,
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
pub struct CompensationRules {
    /// A rapid move may switch it on and off.
    pub rapid: bool,
    /// A circle may switch it on and off.
    pub arcs: bool,
    /// Outside corners until the program says otherwise.
    pub corner: OutsideCorner,
    /// Largest turn, degrees, that corners by angle make sharp.
    pub corner_angle: f64,
    /// Limits of sharp and round corners; none if codes alone decide which corners are sharp.
    pub corner_shape: Option<CornerShape>,
    /// Circles around corners belong to the move after the corner, and come after the blocks between the moves.
    pub corner_after: bool,
    /// The word of an offset number alone selects the offset while its compensation is active.
    pub numbers_alone: bool,
    /// Blocks between two moves.
    pub between: Between,
    /// Compensation without a tool is an alarm; otherwise the tool moves on the contour.
    pub needs_tool: bool,
    /// Centre words beside the code that ends it are the direction of the wall behind the contour.
    pub wall: bool,
    /// Centre words beside the codes that switch compensation on give the direction to which the vector at the end of
    /// the block is perpendicular.
    pub vector: bool,
    /// Offset number zero ends compensation as its code does; otherwise the radius becomes zero.
    pub zero_cancels: bool,
    /// Length compensation.
    pub length: LengthRules,
}

/// How far compensation reads ahead to the next move in its plane.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Between {
    /// Blocks without a move in the plane that are looked through to the next move.
    pub looked_through: u32,
    /// More of them are an alarm; otherwise the first move ends beside its own end.
    pub alarm_beyond: bool,
    /// A program stop does not end reading ahead; otherwise the move before it ends beside its own end.
    pub past_stops: bool,
    /// The number of such blocks that a move of length zero counts as.
    pub zero_move: u32,
}

/// How length compensation comes into force and leaves it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct LengthRules {
    /// At a reference point.
    pub at_reference: LengthThere,
    /// In moves to positions of the machine frame.
    pub in_machine_frame: LengthInMachineFrame,
    /// A new value of the active offset counts from the next block with the code or the word of its number.
    pub by_word: bool,
    /// Codes and numbers move the axis by the change; otherwise they shift the frame, and nothing moves.
    pub moves: bool,
}

/// Effect of a reference point on length compensation.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum LengthThere {
    /// It stays.
    #[default]
    Stays,
    /// It is taken off the axes that go there until the code or a number brings it back.
    Off,
    /// It ends, whichever axes go there.
    Ends,
}

/// Role of length compensation in a move to positions of the machine frame.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum LengthInMachineFrame {
    /// The positions are those of the axes without it; it is active again in the next block.
    #[default]
    Stays,
    /// The same, and it is suspended for the axes that move until the next length code or number.
    Off,
    /// The positions are those of the tip of the tool: it is added to them.
    Added,
}

/// Words that make corners and directions of lines.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Corners {
    /// Blocks without a move in the plane that may come between the two lines of a corner.
    pub between: u32,
    /// Such a block is a dwell; any other one is an error.
    pub dwell_only: bool,
    /// A corner that is too large for its lines is made smaller.
    pub reduces: bool,
    /// Rapid moves have corners too.
    pub rapid: bool,
}

/// The file that printing statements of the program write, and how numbers are in it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PrintFileFormat {
    /// Its name.
    pub file: String,
    /// Leading zeros are spaces; otherwise they are left out.
    pub padded: bool,
    /// A positive number has a space for its sign where numbers are padded.
    pub sign_column: bool,
    /// The end of a line.
    pub line_end: &'static str,
    /// Output is meant only between POPEN and PCLOS.
    pub opened: bool,
}

/// How the tool goes around an outside corner.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OutsideCorner {
    /// Sharp up to an angle, round beyond.
    Angle,
    /// Straight on, cut off beyond a right angle.
    Linear,
    /// Around the point of the contour.
    Arc,
}

/// Way of a cycle to its clearance height.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CycleApproach {
    /// All axes in one move.
    Direct,
    /// First to the position, then along the axis of the cycle.
    PositionFirst,
}

/// How heights of a cycle are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DistanceMode {
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
#[derive(Debug, Clone, PartialEq)]
pub struct ProgramVariables {
    /// Ranges of common variables that all channels share, inclusive.
    pub shared: Vec<(u32, u32)>,
    /// Ranges of common variables of each channel's own.
    pub channel: Vec<(u32, u32)>,
    /// Common variables with names (VC1) are each channel's own too.
    pub own_common: bool,
    /// Variables that programs and the PLC share.
    pub external: super::Externals,
    /// Those of the system.
    pub system: crate::system_variables::SystemVariables,
}
