//! The memory of a channel about its threads and threading cycles.
//!
//! *Invariant:* settings last until they are changed; depth, first step and number of passes belong to one cycle, and a
//! macro that sets one of them before its code sets it for that cycle. Facts: reference system-variables.md 8.

use counterpoint_machine::Machine;
use counterpoint_machine::ident::kind::thread::ThreadCycle;
use counterpoint_machine::index::AxisSlot;

/// A thread as words tell it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Screw {
    /// Length per revolution; 0 and less is none.
    pub lead: f64,
    /// Change of the lead with each revolution.
    pub change: f64,
    /// Axis along which the lead counts; none for the axis with the longer travel.
    pub along: Option<AxisSlot>,
}

/// Data of the threads of a channel.
#[derive(Debug, Clone, Copy)]
pub struct ThreadingState {
    /// Starts of the last thread.
    pub starts: f64,
    /// The axis, X (0) or Z (2), that leads count along, if the program says one.
    pub along: Option<usize>,
    /// The move that is made is a thread along a circle.
    pub rounds: bool,
    /// The thread of the move that a contour records.
    pub recorded: Option<Screw>,
    /// Its cycles.
    pub cycle: Threading,
}

impl ThreadingState {
    /// No thread yet.
    pub fn new(machine: &Machine) -> Self {
        Self { starts: 1.0, along: None, rounds: false, recorded: None, cycle: Threading::new(machine) }
    }
}

/// How the tool leaves a thread: along a chamfer.
#[derive(Debug, Clone, Copy)]
pub struct PullOut {
    /// The tool pulls out.
    pub on: bool,
    /// Its length along the thread, 0 = by the lead.
    pub length: f64,
    /// Its length in leads, if it was given in leads.
    pub leads: Option<f64>,
    /// Its angle to the thread, degrees.
    pub angle: f64,
}

/// Threading cycles of a channel.
#[derive(Debug, Clone, Copy)]
pub struct Threading {
    /// The cycle that acted last, and on which block.
    pub kind: Option<ThreadCycle>,
    /// Number of that block.
    pub block: u64,
    /// A macro has set depth, step or passes of the cycle to come.
    prepared: bool,
    /// `$THMODE`
    pub mode: u8,
    /// Whole depth, first step: radius values.
    pub depth: Option<f64>,
    /// First step in depth, as a radius value.
    pub step: Option<f64>,
    /// Number of passes, if programmed.
    pub cuts: Option<f64>,
    /// Passes that were made without being programmed.
    pub made: u32,
    /// Smallest step.
    pub least: f64,
    /// Number of finishing passes.
    pub finish_cuts: f64,
    /// Allowance for the finishing passes.
    pub finish: f64,
    /// Angle of the nose, degrees.
    pub nose: f64,
    /// How the tool leaves the thread.
    pub pull_out: PullOut,
    /// End of threads of one pass along X and Z, as programmed, and their taper; they last as long as their code.
    pub end: [Option<f64>; 2],
    /// Taper of a single pass, as a radius value.
    pub taper: f64,
}

impl Threading {
    /// Settings of the machine.
    pub fn new(machine: &Machine) -> Self {
        let threads = &machine.threads;
        Self {
            kind: None,
            block: 0,
            prepared: false,
            mode: threads.infeed,
            depth: None,
            step: None,
            cuts: None,
            made: 0,
            least: threads.min_step,
            finish_cuts: f64::from(threads.finish_cuts),
            finish: threads.finish,
            nose: threads.nose,
            pull_out: PullOut {
                on: threads.chamfer,
                length: threads.chamfer_length,
                leads: None,
                angle: threads.chamfer_angle,
            },
            end: [None; 2],
            taper: 0.0,
        }
    }

    /// A macro sets something of the cycle to come.
    pub fn prepare(&mut self) {
        if !self.prepared {
            self.forget();
            self.prepared = true;
        }
    }

    /// A cycle begins.
    pub fn begin(&mut self) {
        if !self.prepared {
            self.forget();
        }
        self.prepared = false;
    }

    fn forget(&mut self) {
        (self.depth, self.step, self.cuts) = (None, None, None);
    }

    /// The kind that acts in a block.
    pub fn acting(&self, block: u64) -> Option<ThreadCycle> {
        self.kind.filter(|_| self.block == block)
    }

    /// A length of the chamfer, 0 = by the lead.
    pub fn set_chamfer(&mut self, length: f64) {
        (self.pull_out.length, self.pull_out.leads) = (length, None);
    }

    /// `$THCUTS`
    pub fn passes(&self) -> f64 {
        self.cuts.unwrap_or(f64::from(self.made))
    }
}
