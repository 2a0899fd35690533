//! The transforms between programmed points and the machine, as data.

use std::collections::BTreeMap;

use counterpoint_event::event::Position;
use counterpoint_machine::index::AxisSlot;
use counterpoint_motion::frame::affine::Affine;
use counterpoint_motion::frame::beside::{AuxiliaryFrame, Lines};
use counterpoint_motion::frame::kinematics::Chain;
use counterpoint_motion::frame::local::{LocalFrame, Programmed};

/// Transformations between the words of the program and the axes, besides the plain shift.
#[derive(Debug, Clone, Default)]
pub struct FrameTransforms {
    /// The local frame.
    pub local: LocalFrame,
    /// The same for axes other than X, Y and Z.
    pub beside: Option<Box<AuxiliaryFrame>>,
    /// Polar or cylindrical interpolation.
    pub polar: Option<PolarInterpolation>,
    /// Words of the plane are a radius and an angle: those of the last block.
    pub words: Option<PolarWords>,
    /// A tilted plane.
    pub tilt: Option<Box<Tilted>>,
    /// A tilted plane whose definition is not complete.
    pub parts: Option<Box<PartialPlane>>,
    /// Tool tip control.
    pub tip: Option<Box<Tip>>,
    /// Compensation of the cutter radius.
    pub cutter: Option<Box<super::cutter::CutterCompensation>>,
    /// All corners are rounded, with this radius.
    pub rounding: Option<f64>,
    /// Feeds that depend on the way.
    pub feeds: Feeds,
    /// Distance that incremental words travel in addition to their value, by axis.
    pub ways: Option<Box<Position>>,
    /// Local shifts of inactive work offsets.
    pub shifts: Option<BTreeMap<u32, Shift>>,
    /// The last point that the program reached: in the work frame, and as programmed.
    pub(super) reached: Option<[Position; 2]>,
}

/// A local shift of X, Y and Z, and of their parallel axes.
pub type Shift = (Option<Programmed>, Option<Lines>);

/// The axes of the interpolation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PolarInterpolation {
    /// Channel axis that goes to the centre and away.
    pub linear: AxisSlot,
    /// Channel axis that turns.
    pub rotary: AxisSlot,
    /// Words are coordinates.
    pub cartesian: bool,
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
pub type Turned = Vec<(AxisSlot, f64)>;

/// An active plane.
#[derive(Debug, Clone)]
pub struct Tilted {
    /// From the plane to the frame that the program has without it.
    pub(super) map: Affine,
    pub(super) back: Affine,
    /// The local frame around it.
    pub(super) outer: LocalFrame,
    /// Where the rotary axes are to be, once that is known.
    pub angles: Option<Turned>,
    /// Where the tables bring the part, the way back, and where the heads bring the tool; nothing before it is turned
    /// into.
    pub(super) bring: Option<[Affine; 3]>,
    /// Part of the shift that is the tool, by channel axis.
    pub(super) tool: Position,
}

/// The program's data for a later plane.
#[derive(Debug, Clone, Default)]
pub struct PlanePreferences {
    /// Of two solutions the one with the tilting axis on this side.
    pub side: Option<bool>,
    /// An axis that has nothing to do turns the plane.
    pub table: bool,
}

/// Blocks of a definition that is not complete.
#[derive(Debug, Clone, Copy)]
pub struct PartialPlane {
    /// Three points, otherwise two directions.
    pub points: bool,
    /// Coordinates of a point and parts of a direction, by number of the block.
    pub known: [Option<[f64; 6]>; 4],
    /// Rotation in the end.
    pub rotation: f64,
}

/// Properties of feeds.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Feeds {
    /// Part of the feed that moves against the tool axis keep to.
    pub down: Option<f64>,
    /// The feed of rotary axes is that of the tip on the part.
    pub rotary_length: bool,
}

/// Active tool tip control.
#[derive(Debug, Clone)]
pub struct Tip {
    /// Rotary axes from the tool to the part.
    pub chain: Chain<AxisSlot>,
    /// Part of the shift that is the tool, by channel axis.
    pub(super) tool: Position,
    /// It began with a length offset of its own and ends with it.
    pub with_length: bool,
}

/// A word, and whether it is a distance.
pub type Word = (f64, bool);

/// The words of a block.
#[derive(Debug, Clone, Copy, Default)]
pub struct PolarWords {
    /// Distance from the pole.
    pub radius: Option<Word>,
    /// Degrees.
    pub angle: Option<Word>,
}
