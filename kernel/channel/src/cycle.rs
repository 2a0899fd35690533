//! The memory of a channel about its cycle.
//!
//! *Invariant:* heights and amounts belong to one run of cycles, from the first code to the cancellation; a macro that
//! sets a value before the first code begins that run. Facts: reference system-variables.md 8.

use super::modal::group;
use crate::ChannelMemory;
use counterpoint_event::event::{FeedUnit, Position};
use counterpoint_machine::Machine;
use counterpoint_machine::ident::kind::CodeKind;
use counterpoint_machine::ident::kind::cycle::HoleCycle;
use counterpoint_machine::ident::{CodeId, codes};
use counterpoint_machine::index::CodeRowId;
use counterpoint_machine::index::{AxisSlot, BySlot};

/// A height: a position, or a distance from another height, as programmed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Height {
    /// The position or the distance, geometry units.
    pub value: f64,
    /// It is a distance.
    pub relative: bool,
}

impl Height {
    /// The position; a distance counts from `base`.
    pub fn from(self, base: f64) -> f64 {
        if self.relative { base + self.value } else { self.value }
    }
}

/// Webs after the first one.
pub const FURTHER_WEBS: usize = 3;

/// One hole: where it is and between which heights, all in the work frame as programmed.
#[derive(Debug, Clone, Copy)]
pub struct CycleHole {
    /// Position; its value along the axis of the cycle does not count.
    pub target: Position,
    /// Axes that were coded, bit by axis.
    pub coded: u8,
    /// Axis of the cycle in channel order.
    pub axis: AxisSlot,
    /// Height where feeding begins.
    pub clear: f64,
    /// Height where the tool is left.
    pub back: f64,
    /// Depth; none if it was never programmed.
    pub depth: Option<f64>,
    /// Lower clearance of back boring.
    pub bottom: Option<f64>,
    /// Start and depth of the webs after the first one.
    pub webs: [Option<[f64; 2]>; FURTHER_WEBS],
}

/// Heights of a cycle along its axis.
#[derive(Debug, Clone, Copy, Default)]
pub struct CycleHeights {
    /// Level along the axis when it began.
    pub initial: f64,
    /// Level that heights count from under a code that executes.
    pub reference: f64,
    /// Clearance, where the feed begins.
    pub clear: Option<Height>,
    /// Depth of the hole.
    pub depth: Option<Height>,
    /// Height to which the tool retracts.
    pub retract: Option<Height>,
    /// Bottom of the hole, if the cycle gives it in addition to the depth.
    pub bottom: Option<Height>,
    /// Start and depth of further webs.
    pub webs: [[Option<Height>; 2]; FURTHER_WEBS],
}

/// Pecks of a cycle, geometry units.
#[derive(Debug, Clone, Copy)]
pub struct PeckPlan {
    /// The first one.
    pub first: Option<f64>,
    /// Reduction of each step against the previous one.
    pub decrement: f64,
    /// The smallest one.
    pub least: f64,
    /// The way back after each.
    pub retract: f64,
    /// Depth after which the tool leaves the hole, 0 for never.
    pub out: f64,
}

/// Feed and dwells of a cycle.
#[derive(Debug, Clone, Copy)]
pub struct CycleRates {
    /// The feed is the cycle's own, not that of the feed mode.
    pub own_feed: bool,
    /// The feed and its unit.
    pub feed: (Option<f64>, FeedUnit),
    /// Feed out of the hole as a multiple of the feed into it.
    pub ratio: f64,
    /// Dwell at depth, per peck, at the top: positive seconds, negative revolutions.
    pub dwell: [f64; 3],
}

/// How a boring cycle leaves the wall.
#[derive(Debug, Clone, Copy, Default)]
pub struct Boring {
    /// Shift of the tool, and its parts along X, Y, Z.
    pub shift: f64,
    /// Shift along X, Y, Z.
    pub shifts: [Option<f64>; 3],
    /// Angle of the oriented spindle.
    pub orient: f64,
}

/// The cycle of a channel.
#[derive(Debug, Clone, Copy)]
pub struct Cycle {
    /// A code of its own executes cycles; cycle codes only define them.
    pub activator: bool,
    /// Row of the code that cancels, none on a machine without such a code.
    pub off: Option<CodeRowId>,
    /// A cycle is in effect (`$CYMCH`).
    pub running: bool,
    /// A macro has set values for the cycle that is to begin.
    prepared: bool,
    /// Block on which a cycle code acted last.
    pub block: u64,
    /// `$CYTYPE`
    pub number: f64,
    /// The code that defined it.
    pub code: Option<CodeId>,
    /// Role and channel axis that it works along.
    pub axis: Option<(usize, AxisSlot)>,
    /// Its heights.
    pub heights: CycleHeights,
    /// Type of a tap as programmed.
    pub tap: Option<f64>,
    /// Its feed and dwells.
    pub rates: CycleRates,
    /// Its pecks.
    pub pecks: PeckPlan,
    /// How it leaves the wall, if it bores.
    pub boring: Boring,
    /// `$CYRIGID`
    pub rigid: f64,
    /// `$CYDIR`
    pub direction: f64,
}

impl Cycle {
    /// Whether a synchronised tap is in effect.
    pub fn is_rigid(&self) -> bool {
        self.running && HoleCycle::numbered(self.number).is_some_and(HoleCycle::is_rigid)
    }

    /// No cycle yet.
    pub fn new(machine: &Machine) -> Self {
        let row = |id| machine.codes.find(|row| row.id == id && row.enable);
        Self::blank(row(codes::CYCLE_ON).is_some(), row(codes::CYCLE_OFF), machine)
    }

    fn blank(activator: bool, off: Option<CodeRowId>, machine: &Machine) -> Self {
        Self {
            activator,
            off,
            running: false,
            prepared: false,
            block: 0,
            number: 0.0,
            code: None,
            axis: None,
            heights: CycleHeights::default(),
            tap: None,
            rates: CycleRates { own_feed: false, feed: (None, FeedUnit::PerMinute), ratio: 1.0, dwell: [0.0; 3] },
            pecks: PeckPlan {
                first: None,
                decrement: 0.0,
                least: machine.cycles.min_step,
                retract: machine.cycles.step_back,
                out: 0.0,
            },
            boring: Boring::default(),
            rigid: 0.0,
            direction: 0.0,
        }
    }

    /// Forgets the values of the last cycle, unless one is in effect; then a macro may set new ones.
    pub fn prepare(&mut self, machine: &Machine) {
        if self.running || self.prepared {
            return;
        }
        let Self { number, code, axis, rigid, block, pecks: PeckPlan { least, .. }, .. } = *self;
        let blank = Self::blank(self.activator, self.off, machine);
        let pecks = PeckPlan { least, ..blank.pecks };
        *self = Self { prepared: true, number, code, axis, rigid, block, pecks, ..blank };
    }

    /// A cycle code acts: begins a cycle, or continues with another kind.
    pub fn begin(&mut self, machine: &Machine, kind: HoleCycle, code: CodeId, (axis, level): ((usize, AxisSlot), f64)) {
        self.running &= !self.activator;
        self.prepare(machine);
        if !self.running || self.axis != Some(axis) {
            self.heights.initial = level;
            self.heights.reference = level;
        }
        self.running = !self.activator;
        self.prepared = false;
        (self.number, self.code, self.axis) = (kind.number(), Some(code), Some(axis));
        self.direction = kind.direction();
    }

    /// The work frame has changed: levels where the tool has been stay where they are.
    pub fn reframed(&mut self, old: &Position, new: &Position) {
        if let Some((_, axis)) = self.axis {
            let change = old.at(axis) - new.at(axis);
            self.heights.initial += change;
            self.heights.reference += change;
        }
    }

    /// The cycle is over; its values can still be read.
    pub fn end(&mut self) {
        self.running = false;
        self.prepared = false;
        self.number = 0.0;
        self.rigid = 0.0;
    }
}

impl ChannelMemory {
    /// Whether the active code of the cycle group acts on every position.
    pub fn cycle_repeats(&self) -> bool {
        match self.modal.code(group::CYCLE).map(|code| (code, code.kind())) {
            Some((_, CodeKind::Cycle(_))) => !self.cycle.activator,
            Some((codes::CYCLE_ON, _) | (_, CodeKind::ThreadCycle(_))) => true,
            _ => false,
        }
    }

    /// Follows active codes that were set without acting: no cycle code, no cycle.
    pub fn follow_cycle(&mut self) {
        if self.cycle.running && !self.cycle_repeats() {
            self.cycle.end();
        }
    }
}
