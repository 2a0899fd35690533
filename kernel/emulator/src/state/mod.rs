//! The memory of a channel from block to block: plain structs with their own methods.
//!
//! *Invariant:* nothing here knows the kernel, its plan or its actions; one box holds the data that few machines use,
//! and the block loop never looks into it for functions that a machine does not use.

pub(crate) mod alarm_effect;
pub(crate) mod alarms;
pub(crate) mod arc;
pub(crate) mod area;
pub(crate) mod at;
pub(crate) mod beside;
pub(crate) mod burden;
pub mod channel;
pub(crate) mod channel_axis;
pub(crate) mod clamps;
pub(crate) mod compensation;
pub(crate) mod context;
pub(crate) mod coolant;
pub(crate) mod corner;
pub(crate) mod coupling;
pub(crate) mod cutter;
pub(crate) mod cycle;
pub mod emitter;
pub(crate) mod feed_group;
pub(crate) mod figure;
pub(crate) mod frame_transforms;
pub(crate) mod frames;
pub(crate) mod modal;
pub(crate) mod pace;
pub(crate) mod plausible;
pub(crate) mod position;
pub(crate) mod probing;
pub(crate) mod remembered;
pub(crate) mod smooth;
pub(crate) mod spindle;
pub(crate) mod stored;
pub(crate) mod stretch;
pub(crate) mod swallowed;
pub(crate) mod text;
pub(crate) mod thread;
pub(crate) mod times;
pub(crate) mod tool_names;
pub(crate) mod turning;
pub(crate) mod units;
pub(crate) mod waits;

use counterpoint_event::event::Position;
use counterpoint_machine::Machine;
use counterpoint_machine::model::{Channel, MachineKind};
use counterpoint_sync::wait::Wait;
use modal::ModalCodes;
use position::MotionState;
use remembered::RememberedWords;
use spindle::SpindleState;

/// The memory of a channel from block to block.
#[derive(Debug)]
pub(crate) struct ChannelMemory {
    /// Modal codes.
    pub(crate) modal: ModalCodes,
    /// Words that the control remembers.
    pub(crate) remembered: RememberedWords,
    /// Axes, positions and offsets.
    pub(crate) place: MotionState,
    /// Spindle of the channel.
    pub(crate) spindle: SpindleState,
    /// Secondary units are active.
    pub(crate) secondary: bool,
    /// Canned cycle.
    pub(crate) cycle: cycle::Cycle,
    /// Data of circles to come.
    pub(crate) arcs: arc::ArcState,
    /// Data of threads to come.
    pub(crate) threads: Box<thread::ThreadingState>,
    /// Data of probing moves.
    pub(crate) skip: Box<probing::Probing>,
    /// Times of motions and of waiting.
    pub(crate) times: Box<times::TimeRecord>,
    /// The memory of other actions.
    pub(crate) others: Box<RareState>,
}

impl ChannelMemory {
    /// The state of a channel at the start of its program.
    pub(crate) fn new(machine: &Machine, channel: &Channel) -> Self {
        let id = channel.spindle;
        let shared = id.is_some_and(|id| spindle::is_shared(machine, id));
        Self {
            modal: ModalCodes::new(),
            remembered: RememberedWords::new(machine),
            place: MotionState::new(machine, channel),
            spindle: SpindleState { id, shared, ..SpindleState::default() },
            secondary: false,
            cycle: cycle::Cycle::new(machine),
            arcs: arc::ArcState::default(),
            threads: Box::new(thread::ThreadingState::new(machine)),
            skip: Box::default(),
            times: Box::default(),
            others: Box::new(RareState::new(machine, channel)),
        }
    }

    /// The record of times, for moves at feed that are timed now.
    pub(crate) fn move_times(&mut self) -> times::MoveTimes<'_> {
        times::MoveTimes { record: &mut self.times, command: &self.spindle.command }
    }

    /// Resets modal codes and remembered words.
    pub(crate) fn forget_words(&mut self, machine: &Machine) {
        (self.modal, self.remembered) = (ModalCodes::new(), RememberedWords::new(machine));
    }
}

/// Rarely used state of channels.
#[derive(Debug)]
pub(crate) struct RareState {
    /// Coolant.
    pub(crate) coolant: coolant::CoolantState,
    /// Spindles.
    pub(crate) spindles: spindle::Spindles,
    /// Tool tip control.
    pub(crate) tip: frames::tip::TipSettings,
    /// A tilted plane to come.
    pub(crate) tilt: frame_transforms::PlanePreferences,
    /// Number of the active head.
    pub(crate) head: u32,
    /// Turning cycles.
    pub(crate) turning: turning::TurningState,
    /// Where the axes were before they went to the change position.
    pub(crate) before_change: Option<Position>,
    /// Names and reports of tools.
    pub(crate) tools: tool_names::ToolRecords,
    /// Functions still running beside the block, and beside all blocks before the next move at feed.
    pub(crate) running: [Option<RunningFunction>; 2],
    /// Where the channel waits before its cuts, while two channels begin them together.
    pub(crate) balance: Option<Wait>,
    /// Axes that move to a position independently of the path of the block.
    pub(crate) beside: Option<Box<beside::PositioningAxes>>,
    /// The working area of the program.
    pub(crate) area: Option<Box<area::WorkArea>>,
    /// Axes that are coupled with axes of other channels.
    pub(crate) couplings: Vec<coupling::Coupling>,
    /// Couplings that one channel commands alone.
    pub(crate) alone: coupling::OneSidedCouplings,
    /// Radius of the last cylinder that was mapped.
    pub(crate) cylinder: Option<f64>,
}

/// A function of the machine that takes its time beside others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RunningFunction {
    /// Its code as written.
    pub(crate) letter: char,
    pub(crate) value: f64,
    /// When it is over, ns.
    pub(crate) end_ns: i64,
}

impl RareState {
    /// At the start of the program.
    pub(crate) fn new(machine: &Machine, channel: &Channel) -> Self {
        let side = machine.kind == MachineKind::MergingLathe && channel.number == 2;
        Self {
            coolant: coolant::CoolantState::default(),
            spindles: spindle::Spindles::new(machine, channel),
            tip: frames::tip::TipSettings::default(),
            tilt: frame_transforms::PlanePreferences::default(),
            head: if side { 2 } else { 1 },
            turning: turning::TurningState::new(machine),
            before_change: None,
            tools: tool_names::ToolRecords::default(),
            running: [None; 2],
            balance: None,
            beside: None,
            area: None,
            couplings: Vec::new(),
            alone: coupling::OneSidedCouplings::default(),
            cylinder: None,
        }
    }

    /// Whether each move must be checked.
    #[inline(always)]
    pub(crate) fn attends(&self) -> bool {
        self.balance.is_some() | self.beside.is_some() | self.area.is_some() | self.spindles.chucks
    }
}
