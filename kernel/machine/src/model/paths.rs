//! The rules of a machine for circles, threads and the tool in space.
//!
//! Facts: reference control-emulator.md 1.5 (questions on circles and threads), 6.1, 6.5. Invariant: distances are zero
//! or more, in the unit of the machine.

use counterpoint_motion::frame::orient;

use crate::model::DistanceMode;

/// Circles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ArcRules {
    /// Centre words are offsets from the start, positions, or follow the mode.
    pub center: DistanceMode,
    /// How far an end may be off its circle.
    pub tolerance: f64,
    /// Share of the radius that an end may be off instead, if that is more than `tolerance`.
    pub tolerance_share: f64,
    /// Upper limit of that distance; infinite without a limit.
    pub largest_tolerance: f64,
    /// Largest radius; infinite without a limit.
    pub max_radius: f64,
    /// Which codes may move a further axis along.
    pub helix: Helix,
    /// Which circles take a number of turns.
    pub turns: MultiTurnCircles,
    /// Whether a circle by its radius to its own start moves nothing; otherwise it is reported.
    pub stands: bool,
    /// A circle with neither centre nor radius is a straight line; otherwise it is reported.
    pub straight: bool,
}

impl ArcRules {
    /// How far the end of a circle of a radius may be off it.
    #[must_use]
    pub fn end_tolerance(&self, radius: f64) -> f64 {
        self.tolerance.max((self.tolerance_share * radius).min(self.largest_tolerance))
    }
}

/// Codes that may make helices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Helix {
    /// All codes of circles.
    Any,
    /// Those of helices only.
    Codes,
    /// None.
    Off,
}

/// Circles of several turns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MultiTurnCircles {
    /// Every circle.
    Always,
    /// Helices only.
    Helical,
    /// None.
    Never,
}

/// Turning cycles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TurningRules {
    /// A block without the numbers of contour blocks, or without a position, only tells settings.
    pub two_lines: bool,
    /// Depth of a level where the program has told none; 0 for none.
    pub depth: f64,
    /// Retraction at the end of a cut.
    pub retract: f64,
    /// Way back after a peck.
    pub back: f64,
    /// A contour whose first block moves both axes may have pockets.
    pub pockets: bool,
    /// A rapid move at the end of a contour is the path off it, and none of it.
    pub retracts: bool,
    /// Distance of two opposite turrets, for codes that mirror X.
    pub opposite: f64,
}

/// Threading cycles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ThreadingRules {
    /// A block of a cycle of several passes without a position only tells its settings.
    pub two_lines: bool,
    /// The code of threads with one lead takes a change of the lead too.
    pub changes: bool,
    /// In-feed, `$THMODE` 0 to 4.
    pub infeed: u8,
    /// Smallest step.
    pub min_step: f64,
    /// Finishing passes.
    pub finish_cuts: u16,
    /// The remaining work.
    pub finish: f64,
    /// Angle of the nose, degrees.
    pub nose: f64,
    /// Angles that the word of a cycle may give, bit by degree; 0: any.
    pub noses: u128,
    /// Threads end in a chamfer.
    pub chamfer: bool,
    /// Its length along the thread, 0 = by the lead.
    pub chamfer_length: f64,
    /// Its angle to the thread, degrees.
    pub chamfer_angle: f64,
}

/// The tool in space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Kinematics {
    /// Direction of the tool, from its tip to the spindle, with all rotary axes at zero.
    pub tool: [f64; 3],
    /// Value of a word of a tool direction that is missing in the block.
    pub missing: DirectionDefault,
    /// Tilted planes.
    pub tilting: Tilting,
}

/// How the control turns into tilted planes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Tilting {
    /// A plane counts as turned into from its definition on, not from the turn on.
    pub assumed: bool,
    /// Which turn of an angle.
    pub turns: orient::TurnChoice,
    /// Which of two ways.
    pub way: orient::PairChoice,
    /// A request for a side means the larger or smaller angle, not its sign.
    pub larger: bool,
    /// An axis that has nothing to do goes to zero.
    pub zero: bool,
    /// A local frame that was made in the plane stays when the plane ends.
    pub keeps_local: bool,
}

impl Default for Tilting {
    fn default() -> Self {
        Self {
            assumed: false,
            turns: orient::TurnChoice::Nearest,
            way: orient::PairChoice::Least,
            larger: false,
            zero: false,
            keeps_local: false,
        }
    }
}

/// Words of a tool direction that the block does not have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DirectionDefault {
    /// They keep their value.
    Keep,
    /// They are zero.
    Zero,
}
