//! The transforms between programmed points and the machine, as data.

use std::collections::BTreeMap;

use counterpoint_event::event::Position;
use counterpoint_machine::index::AxisSlot;
use counterpoint_motion::frame::affine::Affine;
use counterpoint_motion::frame::beside::{AuxiliaryFrame, Lines};
use counterpoint_motion::frame::kinematics::Chain;
use counterpoint_motion::frame::local::{LocalFrame, Programmed};

use super::frames::feeds;

/// Transformations between the words of the program and the axes, besides the plain shift.
#[derive(Debug, Clone, Default)]
pub(crate) struct FrameTransforms {
    /// The local frame.
    pub(crate) local: LocalFrame,
    /// The same for axes other than X, Y and Z.
    pub(crate) beside: Option<Box<AuxiliaryFrame>>,
    /// Polar or cylindrical interpolation.
    pub(crate) polar: Option<PolarInterpolation>,
    /// Words of the plane are a radius and an angle: those of the last block.
    pub(crate) words: Option<PolarWords>,
    /// A tilted plane.
    pub(crate) tilt: Option<Box<Tilted>>,
    /// A tilted plane whose definition is not complete.
    pub(crate) parts: Option<Box<PartialPlane>>,
    /// Tool tip control.
    pub(crate) tip: Option<Box<Tip>>,
    /// Compensation of the cutter radius.
    pub(crate) cutter: Option<Box<super::cutter::CutterCompensation>>,
    /// All corners are rounded, with this radius.
    pub(crate) rounding: Option<f64>,
    /// Feeds that depend on the way.
    pub(crate) feeds: feeds::Feeds,
    /// Distance that incremental words travel in addition to their value, by axis.
    pub(crate) ways: Option<Box<Position>>,
    /// Local shifts of inactive work offsets.
    pub(crate) shifts: Option<BTreeMap<u32, Shift>>,
    /// The last point that the program reached: in the work frame, and as programmed.
    pub(super) reached: Option<[Position; 2]>,
}

/// A local shift of X, Y and Z, and of their parallel axes.
pub(crate) type Shift = (Option<Programmed>, Option<Lines>);

/// The axes of the interpolation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PolarInterpolation {
    /// Channel axis that goes to the centre and away.
    pub(crate) linear: AxisSlot,
    /// Channel axis that turns.
    pub(crate) rotary: AxisSlot,
    /// Words are coordinates.
    pub(crate) cartesian: bool,
    pub(super) shape: InterpolationSurface,
}

/// The part of the workpiece that the axes reach.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum InterpolationSurface {
    Face {
        /// Angle of the rotary axis in the machine frame where the first coordinate points along the linear axis.
        zero: f64,
        /// Side of the centre where the linear axis works, 1 or −1.
        side: f64,
    },
    Cylinder {
        /// Way on the surface for each degree.
        per_degree: f64,
        /// The way round is the first coordinate of the plane.
        round_first: bool,
    },
}

/// Angles of the rotary axes in the machine frame.
pub(crate) type Turned = Vec<(AxisSlot, f64)>;

/// An active plane.
#[derive(Debug, Clone)]
pub(crate) struct Tilted {
    /// From the plane to the frame that the program has without it.
    pub(super) map: Affine,
    pub(super) back: Affine,
    /// The local frame around it.
    pub(super) outer: LocalFrame,
    /// Where the rotary axes are to be, once that is known.
    pub(crate) angles: Option<Turned>,
    /// Where the tables bring the part, the way back, and where the heads bring the tool; nothing before it is turned
    /// into.
    pub(super) bring: Option<[Affine; 3]>,
    /// Part of the shift that is the tool, by channel axis.
    pub(super) tool: Position,
}

/// The program's data for a later plane.
#[derive(Debug, Clone, Default)]
pub(crate) struct PlanePreferences {
    /// Of two solutions the one with the tilting axis on this side.
    pub(crate) side: Option<bool>,
    /// An axis that has nothing to do turns the plane.
    pub(crate) table: bool,
}

/// Blocks of a definition that is not complete.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PartialPlane {
    /// Three points, otherwise two directions.
    pub(crate) points: bool,
    /// Coordinates of a point and parts of a direction, by number of the block.
    pub(crate) known: [Option<[f64; 6]>; 4],
    /// Rotation in the end.
    pub(crate) rotation: f64,
}

/// Active tool tip control.
#[derive(Debug, Clone)]
pub(crate) struct Tip {
    pub(crate) chain: Chain<AxisSlot>,
    /// Part of the shift that is the tool, by channel axis.
    pub(super) tool: Position,
    /// It began with a length offset of its own and ends with it.
    pub(crate) with_length: bool,
}

/// A word, and whether it is a distance.
pub(crate) type Word = (f64, bool);

/// The words of a block.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct PolarWords {
    pub(crate) radius: Option<Word>,
    /// Degrees.
    pub(crate) angle: Option<Word>,
}
