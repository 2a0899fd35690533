//! The memory of a channel from block to block: plain structs with their own methods.
//!
//! *Invariant:* nothing here knows the kernel, its plan or its actions; one box holds the data that few machines use,
//! and the block loop never looks into it for functions that a machine does not use.

pub mod addresses;
pub mod alarm_effect;
pub mod alarms;
pub mod arc;
pub mod area;
pub mod at;
pub mod axis_rates;
pub mod beside;
pub mod block_places;
pub mod block_tables;
pub mod burden;
pub mod callee;
pub mod calling_words;
pub mod channel_axis;
pub mod channel_context;
pub mod channel_variables;
pub mod circular_move;
pub mod clamps;
pub mod code_time;
pub mod compensation;
pub mod conditions;
pub mod context;
pub mod coolant;
pub mod corner;
pub mod coupled_axes;
pub mod coupling;
pub mod custom_diagnostics;
pub mod cutter;
pub mod cycle;
pub mod emitter;
pub mod feed_group;
pub mod figure;
pub mod fixed_stops;
pub mod flow;
pub mod frame_transforms;
pub mod frames;
pub mod kept_blocks;
pub mod laws;
pub mod length_words;
pub mod loop_tracker;
pub mod macro_queries;
pub mod macros;
pub mod modal;
pub mod modal_calls;
pub mod offset_tables;
pub mod pace;
pub mod path_lengths;
pub mod plane_points;
pub mod plausible;
pub mod position;
pub mod probing;
pub mod program_places;
pub mod queued_codes;
pub mod remembered;
pub mod rotary_words;
pub mod round_centre;
pub mod shared_target;
pub mod smooth;
pub mod spindle;
pub mod stored;
pub mod stretch;
pub mod swallowed;
pub mod system_values;
pub mod text;
pub mod thread;
pub mod thread_passes;
pub mod timed_path;
pub mod times;
pub mod tool_data;
pub mod tool_names;
pub mod tool_radius;
pub mod trace;
pub mod travel_limits;
pub mod turning;
pub mod units;
pub mod unknown_words;
pub mod waits;
pub mod word_values;

use counterpoint_event::event::Position;
use counterpoint_machine::Machine;
use counterpoint_machine::model::Channel;
use counterpoint_machine::model::MachineKind;
use counterpoint_sync::wait::Wait;
use modal::ModalCodes;
use position::MotionState;
use remembered::RememberedWords;
use spindle::SpindleState;

/// The memory of a channel from block to block.
#[derive(Debug)]
pub struct ChannelMemory {
    /// Modal codes.
    pub modal: ModalCodes,
    /// Words that the control remembers.
    pub remembered: RememberedWords,
    /// Axes, positions and offsets.
    pub place: MotionState,
    /// Spindle of the channel.
    pub spindle: SpindleState,
    /// Secondary units are active.
    pub secondary: bool,
    /// Canned cycle.
    pub cycle: cycle::Cycle,
    /// Data of circles to come.
    pub arcs: arc::ArcState,
    /// Data of threads to come.
    pub threads: Box<thread::ThreadingState>,
    /// Data of probing moves.
    pub skip: Box<probing::Probing>,
    /// The law of the next move, if the job records laws.
    pub law: Option<Box<laws::LawDraft>>,
    /// Times of motions and of waiting.
    pub times: Box<times::TimeRecord>,
    /// The memory of other actions.
    pub others: Box<RareState>,
}

impl ChannelMemory {
    /// The state of a channel at the start of its program.
    pub fn new(machine: &Machine, channel: &Channel) -> Self {
        let id = channel.spindle;
        let shared = id.is_some_and(|id| spindle::is_shared(machine, id));
        Self {
            modal: ModalCodes::empty(),
            remembered: RememberedWords::new(machine),
            place: MotionState::new(machine, channel),
            spindle: SpindleState { id, shared, ..SpindleState::default() },
            secondary: false,
            cycle: cycle::Cycle::new(machine),
            arcs: arc::ArcState::default(),
            threads: Box::new(thread::ThreadingState::new(machine)),
            skip: Box::default(),
            law: None,
            times: Box::default(),
            others: Box::new(RareState::new(machine, channel)),
        }
    }

    /// The record of times, for moves at feed that are timed now.
    pub fn move_times(&mut self) -> times::MoveTimes<'_> {
        times::MoveTimes { record: &mut self.times, command: &self.spindle.command }
    }

    /// Resets modal codes and remembered words.
    pub fn forget_words(&mut self, machine: &Machine) {
        (self.modal, self.remembered) = (ModalCodes::empty(), RememberedWords::new(machine));
    }
}

/// Rarely used state of channels.
#[derive(Debug)]
pub struct RareState {
    /// Coolant.
    pub coolant: coolant::CoolantState,
    /// Spindles.
    pub spindles: spindle::Spindles,
    /// Tool tip control.
    pub tip: frames::tip::TipSettings,
    /// A tilted plane to come.
    pub tilt: frame_transforms::PlanePreferences,
    /// Number of the active head.
    pub head: u32,
    /// Turning cycles.
    pub turning: turning::TurningState,
    /// Where the axes were before they went to the change position.
    pub before_change: Option<Position>,
    /// Names and reports of tools.
    pub tools: tool_names::ToolRecords,
    /// Functions still running beside the block, and beside all blocks before the next move at feed.
    pub running: [Option<RunningFunction>; 2],
    /// Where the channel waits before its cuts, while two channels begin them together.
    pub balance: Option<Wait>,
    /// Axes that move to a position independently of the path of the block.
    pub beside: Option<Box<beside::PositioningAxes>>,
    /// The working area of the program.
    pub area: Option<Box<area::WorkArea>>,
    /// Axes that are coupled with axes of other channels.
    pub couplings: Vec<coupling::Coupling>,
    /// Couplings that one channel commands alone.
    pub alone: coupling::OneSidedCouplings,
    /// Radius of the last cylinder that was mapped.
    pub cylinder: Option<f64>,
}

/// A function of the machine that takes its time beside others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RunningFunction {
    /// Its code as written.
    pub letter: char,
    /// Its value as written.
    pub value: f64,
    /// When it is over, ns.
    pub end_ns: i64,
}

impl RareState {
    /// At the start of the program.
    pub fn new(machine: &Machine, channel: &Channel) -> Self {
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
    pub fn attends(&self) -> bool {
        self.balance.is_some()
            | self.beside.is_some()
            | self.area.is_some()
            | self.spindles.chucks
            | self.spindles.fixed_stops.any()
    }
}
