//! The memory of a channel about its turning cycles, and a contour that is being read.
//!
//! *Invariant:* settings last until they are changed; the end of a single cycle lasts as long as its code.

use std::sync::Arc;

use super::modal::{group, plane};
use super::thread::Screw;
use crate::ChannelMemory;
use counterpoint_control_api::NamedContour;
use counterpoint_event::event::{FeedUnit, Position};
use counterpoint_machine::Machine;
use counterpoint_machine::index::{AxisSlot, BySlot};
use counterpoint_motion::contour::element::{Element, Spot};
use counterpoint_motion::turning::{pattern, rough};

/// Turning cycles of a channel; lengths are geometry units, pairs along Z and X.
#[derive(Debug)]
pub struct TurningState {
    /// Depth of a level; 0 for none.
    pub depth: f64,
    /// Retraction at the end of a cut.
    pub retract: f64,
    /// Distance of the first from the last repetition of a contour.
    pub relief: Spot,
    /// Repetitions.
    pub repeats: f64,
    /// Way back after a peck.
    pub back: f64,
    /// End of single cycles as programmed.
    pub end: [Option<f64>; 2],
    /// Their taper.
    pub taper: f64,
    /// The contour that is being read.
    pub reading: RecordedContour,
    /// Moves are recorded, not made.
    pub reads: bool,
    /// The contour that a subprogram has described.
    pub kept: RecordedContour,
    /// The contour that the block of a cycle names, until the cycle takes it.
    pub shape: Option<NamedContour>,
    /// The tool stays at the end of the next cycle along a named contour.
    pub stays: bool,
    /// Passes of the thread that comes: how far off the contour, and how far along it.
    pub passes: Vec<[f64; 2]>,
}

impl TurningState {
    /// Settings of the machine.
    pub fn new(machine: &Machine) -> Self {
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
pub struct First {
    /// At rapid.
    pub rapid: bool,
    /// Axes that were programmed, bit by axis.
    pub coded: u8,
}

/// A contour that is being read.
#[derive(Debug, Default)]
pub struct RecordedContour {
    /// Where the tool was.
    pub start: Spot,
    /// The plane of the contour; none for that of turning.
    pub plane: Option<LathePlane>,
    /// The first move; none before it.
    pub first: Option<First>,
    /// Pieces after it.
    pub elements: Vec<Element>,
    /// Heights of their ends across the plane.
    pub heights: Vec<[f64; 2]>,
    /// Pieces of the shape of the blank.
    pub blank: Vec<Element>,
    /// Feeds that rough cycles have along them.
    pub feeds: Vec<Option<f64>>,
    /// The feed of pieces to come.
    pub feed: Option<f64>,
    /// Their threads.
    pub screws: Vec<Option<Screw>>,
    /// The last piece is a rapid move.
    pub ends_rapid: bool,
    /// The side on which the nose goes beside it, +1 left of the path, −1 right.
    pub side: Option<f64>,
    /// Pieces before it goes on the contour again.
    pub beside: Option<usize>,
}

/// Where the blocks of a contour are.
#[derive(Debug, Clone, PartialEq)]
pub enum ContourBlocks {
    /// Sequence numbers of the first and last block.
    Numbers(u32, u32),
    /// A subprogram, or the blocks from a sequence number on.
    Program(u32),
    /// First and last line of a contour with a name.
    Named {
        /// Its name.
        name: Arc<str>,
        /// First line.
        first: u32,
        /// Last line.
        last: u32,
        /// Those of the shape of its blank.
        blank: Option<(u32, u32)>,
    },
}

/// A cycle along contour blocks.
#[derive(Debug, Clone, PartialEq)]
pub struct ContourCycle {
    /// The blocks.
    pub blocks: ContourBlocks,
    /// Their treatment.
    pub task: ContourTask,
    /// Feed of the cuts.
    pub feed: (Option<f64>, FeedUnit),
    /// Feeds of levels from changes on.
    pub feeds: [Option<f64>; 2],
}

/// The treatment of contour blocks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ContourTask {
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
pub struct PocketCycle {
    /// The distance of cuts, along Y if they go along X.
    pub step: f64,
    /// Cuts go along Y.
    pub across: bool,
    /// Allowance for a last pass.
    pub finish: f64,
    /// Depth of a level.
    pub level: f64,
    /// Height above which the tool is free.
    pub clear: f64,
    /// Depth of cut.
    pub depth: f64,
}

/// The plane of a contour: two channel axes with their factors to geometry, Z and X for turning.
#[derive(Debug, Clone, Copy)]
pub struct LathePlane {
    /// The channel axes.
    pub axes: [AxisSlot; 2],
    /// Factors from their positions to geometry.
    pub scales: [f64; 2],
}

impl LathePlane {
    /// The point of the plane at a position.
    pub fn point(&self, position: &Position) -> Spot {
        let [z, x] = self.axes.map(|axis| position.at(axis));
        [z * self.scales[0], x * self.scales[1]]
    }

    /// A position moved to a point of the plane. Digits of sums after the ninth were not programmed.
    pub fn position(&self, mut from: Position, point: Spot) -> Position {
        for ((axis, scale), value) in self.axes.into_iter().zip(self.scales).zip(point) {
            let wanted = (value / scale * 1e9).round() / 1e9 + 0.0;
            let slot = from.at_mut(axis);
            *slot = if (wanted - *slot).abs() < 1e-9 { *slot } else { wanted };
        }
        from
    }

    /// Bits of its axes in which two positions differ.
    pub fn moved(&self, from: &Position, to: &Position) -> u8 {
        let moves = |axis: &AxisSlot| from.at(*axis) != to.at(*axis);
        self.axes.into_iter().filter(moves).fold(0, |bits, axis| bits | axis.bit())
    }
}

impl ChannelMemory {
    /// The active plane; none without its axes.
    pub fn active_plane(&self) -> Option<LathePlane> {
        let layout = &self.place.layout;
        let axis = |role: usize| layout.cartesian.get(role).copied().flatten();
        let plane = self.modal.code(group::PLANE).and_then(plane)?;
        let (first, second) = (plane.first, plane.second);
        let axes = [axis(first)?, axis(second)?];
        Some(LathePlane { axes, scales: axes.map(|axis| layout.axes[axis].scale) })
    }

    /// The plane of turning; none without X and Z.
    pub fn lathe_plane(&self) -> Option<LathePlane> {
        let layout = &self.place.layout;
        let axis = |role: usize| layout.cartesian.get(role).copied().flatten();
        let axes = [axis(2)?, axis(0)?];
        Some(LathePlane { axes, scales: axes.map(|axis| layout.axes[axis].scale) })
    }

    /// The point of the plane of turning at a position.
    pub fn flat(&self, position: &Position) -> Spot {
        self.lathe_plane().map_or([0.0; 2], |plane| plane.point(position))
    }
}
