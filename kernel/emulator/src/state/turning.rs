//! The memory of a channel about its turning cycles, and a contour that is being read.
//!
//! *Invariant:* settings last until they are changed; the end of a single cycle lasts as long as its code.

use std::sync::Arc;

use super::channel::ChannelContext;
use super::modal::{group, plane};
use super::thread::Screw;
use counterpoint_control_api::NamedContour;
use counterpoint_event::event::{FeedUnit, Position};
use counterpoint_machine::Machine;
use counterpoint_machine::index::{AxisSlot, BySlot};
use counterpoint_motion::contour::element::{Element, Spot};
use counterpoint_motion::turning::{pattern, rough};

/// Turning cycles of a channel; lengths are geometry units, pairs along Z and X.
#[derive(Debug)]
pub(crate) struct TurningState {
    /// Depth of a level; 0 for none.
    pub(crate) depth: f64,
    /// Retraction at the end of a cut.
    pub(crate) retract: f64,
    /// Distance of the first from the last repetition of a contour.
    pub(crate) relief: Spot,
    /// Repetitions.
    pub(crate) repeats: f64,
    /// Way back after a peck.
    pub(crate) back: f64,
    /// End of single cycles as programmed.
    pub(crate) end: [Option<f64>; 2],
    /// Their taper.
    pub(crate) taper: f64,
    /// The contour that is being read.
    pub(crate) reading: RecordedContour,
    /// Moves are recorded, not made.
    pub(crate) reads: bool,
    /// The contour that a subprogram has described.
    pub(crate) kept: RecordedContour,
    /// The contour that the block of a cycle names, until the cycle takes it.
    pub(crate) shape: Option<NamedContour>,
    /// The tool stays at the end of the next cycle along a named contour.
    pub(crate) stays: bool,
    /// Passes of the thread that comes: how far off the contour, and how far along it.
    pub(crate) passes: Vec<[f64; 2]>,
}

impl TurningState {
    /// Settings of the machine.
    pub(crate) fn new(machine: &Machine) -> Self {
        let settings = &machine.turning;
        Self {
            depth: settings.depth,
            retract: settings.retract,
            relief: [0.0; 2],
            repeats: 1.0,
            back: settings.back,
            end: [None; 2],
            taper: 0.0,
            reading: RecordedContour::default(),
            reads: false,
            kept: RecordedContour::default(),
            shape: None,
            stays: false,
            passes: Vec::new(),
        }
    }
}

/// The first move of a contour.
#[derive(Debug, Clone, Copy)]
pub(crate) struct First {
    /// At rapid.
    pub(crate) rapid: bool,
    /// Axes that were programmed, bit by axis.
    pub(crate) coded: u8,
}

/// A contour that is being read.
#[derive(Debug, Default)]
pub(crate) struct RecordedContour {
    /// Where the tool was.
    pub(crate) start: Spot,
    /// The plane of the contour; none for that of turning.
    pub(crate) plane: Option<LathePlane>,
    /// The first move; none before it.
    pub(crate) first: Option<First>,
    /// Pieces after it.
    pub(crate) elements: Vec<Element>,
    /// Heights of their ends across the plane.
    pub(crate) heights: Vec<[f64; 2]>,
    /// Pieces of the shape of the blank.
    pub(crate) blank: Vec<Element>,
    /// Feeds that rough cycles have along them.
    pub(crate) feeds: Vec<Option<f64>>,
    /// The feed of pieces to come.
    pub(crate) feed: Option<f64>,
    /// Their threads.
    pub(crate) screws: Vec<Option<Screw>>,
    /// The last piece is a rapid move.
    pub(crate) ends_rapid: bool,
    /// The side on which the nose goes beside it, +1 left of the path, −1 right.
    pub(crate) side: Option<f64>,
    /// Pieces before it goes on the contour again.
    pub(crate) beside: Option<usize>,
}

/// Where the blocks of a contour are.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum ContourBlocks {
    /// Sequence numbers of the first and last block.
    Numbers(u32, u32),
    /// A subprogram, or the blocks from a sequence number on.
    Program(u32),
    /// First and last line of a contour with a name.
    Named {
        /// Its name.
        name: Arc<str>,
        first: u32,
        last: u32,
        /// Those of the shape of its blank.
        blank: Option<(u32, u32)>,
    },
}

/// A cycle along contour blocks.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ContourCycle {
    /// The blocks.
    pub(crate) blocks: ContourBlocks,
    /// Their treatment.
    pub(crate) task: ContourTask,
    /// Feed of the cuts.
    pub(crate) feed: (Option<f64>, FeedUnit),
    /// Feeds of levels from changes on.
    pub(crate) feeds: [Option<f64>; 2],
}

/// The treatment of contour blocks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum ContourTask {
    /// They run once.
    Finish {
        /// The tool stays where they end.
        stays: bool,
        /// Axes that go back before the others, bit by axis.
        off: u8,
    },
    /// They are roughed, with pockets if the program says so; otherwise as their first block tells.
    Rough(rough::RoughSettings, Option<bool>),
    /// A thread is cut along them, in a face if they are of one.
    Thread {
        /// The depth is along Z.
        face: bool,
    },
    /// They are repeated.
    Pattern(pattern::PatternRepeatSettings),
    /// Their inside is cleared.
    Pocket(PocketCycle),
}

/// A pocket that a subprogram draws; lengths are geometry units, heights those of the axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PocketCycle {
    /// The distance of cuts, along Y if they go along X.
    pub(crate) step: f64,
    /// Cuts go along Y.
    pub(crate) across: bool,
    /// Allowance for a last pass.
    pub(crate) finish: f64,
    /// Depth of a level.
    pub(crate) level: f64,
    /// Height above which the tool is free.
    pub(crate) clear: f64,
    pub(crate) depth: f64,
}

/// The plane of a contour: two channel axes with their factors to geometry, Z and X for turning.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LathePlane {
    pub(crate) axes: [AxisSlot; 2],
    pub(crate) scales: [f64; 2],
}

impl LathePlane {
    /// The point of the plane at a position.
    pub(crate) fn point(&self, position: &Position) -> Spot {
        let [z, x] = self.axes.map(|axis| position.at(axis));
        [z * self.scales[0], x * self.scales[1]]
    }

    /// A position moved to a point of the plane. Digits of sums after the ninth were not programmed.
    pub(crate) fn position(&self, mut from: Position, point: Spot) -> Position {
        for ((axis, scale), value) in self.axes.into_iter().zip(self.scales).zip(point) {
            let wanted = (value / scale * 1e9).round() / 1e9 + 0.0;
            let slot = from.at_mut(axis);
            *slot = if (wanted - *slot).abs() < 1e-9 { *slot } else { wanted };
        }
        from
    }

    /// Bits of its axes in which two positions differ.
    pub(crate) fn moved(&self, from: &Position, to: &Position) -> u8 {
        let moves = |axis: &AxisSlot| from.at(*axis) != to.at(*axis);
        self.axes.into_iter().filter(moves).fold(0, |bits, axis| bits | axis.bit())
    }
}

impl ChannelContext<'_> {
    /// The active plane; none without its axes.
    pub(crate) fn active_plane(&self) -> Option<LathePlane> {
        let layout = &self.state.place.layout;
        let axis = |role: usize| layout.cartesian.get(role).copied().flatten();
        let plane = self.state.modal.code(group::PLANE).and_then(plane)?;
        let (first, second) = (plane.first, plane.second);
        let axes = [axis(first)?, axis(second)?];
        Some(LathePlane { axes, scales: axes.map(|axis| layout.axes[axis].scale) })
    }

    /// The plane of turning; none without X and Z.
    pub(crate) fn lathe_plane(&self) -> Option<LathePlane> {
        let layout = &self.state.place.layout;
        let axis = |role: usize| layout.cartesian.get(role).copied().flatten();
        let axes = [axis(2)?, axis(0)?];
        Some(LathePlane { axes, scales: axes.map(|axis| layout.axes[axis].scale) })
    }

    /// The point of the plane of turning at a position.
    pub(crate) fn flat(&self, position: &Position) -> Spot {
        self.lathe_plane().map_or([0.0; 2], |plane| plane.point(position))
    }
}
