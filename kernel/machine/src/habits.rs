//! Behaviour of a control that its words leave open: answers of the questionnaire that are neither words nor formats.
//!
//! Facts: reference control-emulator.md 1.5. Invariant: a machine that says nothing has the habits it would have
//! without the section.

/// Habits of a control.
#[derive(Debug, Clone, PartialEq)]
pub struct Habits {
    /// A speed word without a spindle code changes the speed; otherwise it waits for the next spindle code.
    pub speed_word: bool,
    /// How reference points and the tool-change position are reached.
    pub home: Home,
    /// The axes of three angles of a rotation.
    pub rotations: Rotations,
    /// Feed per minute that counts where none is programmed, or zero; without one such moves are timed as rapid ones.
    pub least_feed: Option<f64>,
    /// Whether the feed of the path counts only for X, Y and Z unless the program selects axes; other axes move along.
    pub feed_of_geometry: bool,
    /// Incremental words travel changes of frames, offsets and tool lengths too.
    pub frame_increments: bool,
    /// How the programs of channels stand in one file.
    pub programs: FileLayout,
    /// Of several G codes of one group in a block only the last one acts.
    pub last_of_group: bool,
    /// One-shot codes count as one such group.
    pub one_shots_of_group: bool,
    /// Most levels of brackets in an expression; none: as many as fit.
    pub brackets: Option<u8>,
    /// A code of a reference point without axes sends all axes there.
    pub bare_home: bool,
    /// How a dwell tells its time.
    pub dwell: DwellRules,
    /// Values of expressions at addresses are rounded to the least increment of the register.
    pub rounded: bool,
    /// Sums at addresses need no brackets: `X#1+.1`.
    pub bare_sums: bool,
    /// A statement may follow a condition without THEN: `IF[#1EQ1.]G65P2`.
    pub bare_conditions: bool,
    /// Largest number of a loop; none: that of the pre-processor.
    pub loops: Option<u8>,
    /// THEN takes one statement; otherwise a list of assignments too.
    pub one_then: bool,
    /// THEN takes only a macro statement; otherwise any block.
    pub macro_then: bool,
    /// Sequence and program numbers are digits; otherwise they may be expressions.
    pub digits_of_numbers: bool,
    /// Angle of a rotation whose block has none.
    pub rotation_angle: Option<f64>,
    /// Factor of a scale whose block has none.
    pub scale_factor: Option<f64>,
    /// A factor with a decimal point is the factor itself, for any unit.
    pub pointed_factors: bool,
    /// Of several words with one address in a block the last one counts; otherwise the others are unused words.
    pub last_of_address: bool,
    /// Angles of arc functions are from 0 to 360 degrees: those of ATAN of two values and negative ones of ASIN.
    pub full_angles: bool,
    /// Codes, addresses and statements that nothing knows are alarms of the control; otherwise they are diagnosed and
    /// the rest of the block acts.
    pub unknown_alarms: bool,
    /// An alarm of the real control stops the channel; otherwise the rest of the block is dropped and the program
    /// continues.
    pub stops: bool,
    /// Whether a position of the machine frame is reached at rapid under any motion code.
    pub machine_frame_rapid: bool,
    /// Whether a move at feed while the spindle is off is reported.
    pub feed_needs_spindle: bool,
    /// Whether a speed word beside a function without effect is an alarm: the function may turn another spindle.
    pub guards_speed: bool,
    /// Whether a speed and its mode belong to the spindle of the block's spindle code, else to the spindle that the
    /// channel started last; otherwise they belong to the active spindle.
    pub speed_follows_codes: bool,
    /// Whether constant surface speed and its limit belong to the spindle at which the turret works.
    pub surface_of_side: bool,
    /// Whether the active scale also applies to the centre of a rotation.
    pub scaled_center: bool,
    /// Whether a preset ends the local shift of its axes.
    pub preset_ends_shift: bool,
    /// Whether each work offset has a local shift of its own.
    pub shift_of_each: bool,
    /// Whether a code of extended work offsets without a number selects the first offset.
    pub first_extended: bool,
    /// Limits of the working area count in all directions of all axes unless the program says otherwise.
    pub work_area: bool,
    /// Areas that the program sets.
    pub stored_limits: StoredLimits,
    /// Answers to questions of the machine's own that are texts, `$TUDQ`.
    pub texts: Vec<String>,
    /// Those that are whole numbers, `$IUDQ`.
    pub integers: Vec<f64>,
    /// Those that are numbers, `$WUDQ`.
    pub numbers: Vec<f64>,
}

/// How the programs of channels stand in one file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FileLayout {
    /// One after the other, by the numbers or names that define them.
    #[default]
    Numbers,
    /// Codes of heads say whose the blocks after them are.
    Heads,
    /// `$1`, `$2`, … say that, and `$0` data of all.
    Sections,
}

/// Areas that the program sets and that the tool must not enter or leave.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct StoredLimits {
    /// The side that is forbidden for the tool.
    pub forbidden: Forbidden,
    /// Whether their limits are in the work frame active when they are set; otherwise in the machine frame.
    pub in_work_frame: bool,
}

/// A side of an area.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Forbidden {
    /// The area itself.
    #[default]
    Inside,
    /// All but the area.
    Outside,
}

/// How a dwell tells its time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct DwellRules {
    /// A dwell in thousandths of a second is one in seconds where its word has a decimal point.
    pub pointed: bool,
    /// A dwell without a time is an exact stop.
    pub bare: bool,
}

/// How reference points are reached.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Home {
    /// Via the given point of the work frame to the point of the machine.
    Workpiece,
    /// Straight to the given point of the machine frame, without words to the point of the machine.
    Machine,
}

/// Axes that three angles turn about, each as the turns before have left it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rotations {
    /// As `$LCSORD` tells them: A, B, C for X, Y, Z.
    pub name: &'static str,
    /// 0 X, 1 Y, 2 Z.
    pub axes: [usize; 3],
}

impl Rotations {
    /// All orders without a direction twice in a row.
    pub const ALL: [Self; 12] = [
        Self { name: "ABA", axes: [0, 1, 0] },
        Self { name: "ABC", axes: [0, 1, 2] },
        Self { name: "ACA", axes: [0, 2, 0] },
        Self { name: "ACB", axes: [0, 2, 1] },
        Self { name: "BAB", axes: [1, 0, 1] },
        Self { name: "BAC", axes: [1, 0, 2] },
        Self { name: "BCA", axes: [1, 2, 0] },
        Self { name: "BCB", axes: [1, 2, 1] },
        Self { name: "CAB", axes: [2, 0, 1] },
        Self { name: "CAC", axes: [2, 0, 2] },
        Self { name: "CBA", axes: [2, 1, 0] },
        Self { name: "CBC", axes: [2, 1, 2] },
    ];
}

impl Default for Habits {
    fn default() -> Self {
        Self {
            speed_word: true,
            home: Home::Workpiece,
            rotations: Rotations { name: "CAC", axes: [2, 0, 2] },
            least_feed: None,
            feed_of_geometry: false,
            frame_increments: false,
            programs: FileLayout::Numbers,
            last_of_group: false,
            one_shots_of_group: false,
            rounded: false,
            bare_sums: false,
            bare_conditions: false,
            loops: None,
            one_then: false,
            macro_then: false,
            digits_of_numbers: false,
            rotation_angle: None,
            scale_factor: None,
            pointed_factors: false,
            last_of_address: false,
            full_angles: false,
            brackets: None,
            bare_home: false,
            dwell: DwellRules::default(),
            unknown_alarms: false,
            stops: false,
            machine_frame_rapid: false,
            feed_needs_spindle: false,
            guards_speed: false,
            speed_follows_codes: false,
            surface_of_side: false,
            scaled_center: false,
            preset_ends_shift: false,
            shift_of_each: false,
            first_extended: false,
            work_area: false,
            stored_limits: StoredLimits::default(),
            texts: Vec::new(),
            integers: Vec::new(),
            numbers: Vec::new(),
        }
    }
}
