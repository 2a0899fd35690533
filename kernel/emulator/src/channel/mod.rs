//! One kernel: runs the program of one channel block by block.
//!
//! Facts: reference control-emulator.md 2 (processing order). Invariants: the clock never goes back; every access to
//! data that other channels can see or change is a shared operation at the kernel's tag; in the steady state a block
//! allocates nothing.

pub mod access;
pub mod actions;
pub mod alone;
mod burden;
mod calls;
pub mod carried;
pub mod chucks;
pub mod components;
pub mod coupling;
pub mod custom_macro;
pub(crate) mod cycle_moves;
pub mod data;
pub mod dialect_state;
mod driven_spindle;
mod exchange;
mod fixed_stops;
mod frame;
pub mod hook_points;
mod host;
pub(crate) mod known_blocks;
mod left_words;
pub(crate) mod life;
pub mod macro_queries;
mod motion;
pub mod paired_spindles;
pub mod part_data;
pub mod parts;
mod passes;
pub mod plan;
pub mod plan_tables;
pub(crate) mod refusals;
pub mod report;
pub mod search;
mod separate;
mod spindle;
pub mod statement;
pub mod step;
mod system_variables;
pub mod tool_events;
mod travel;
pub mod unit_switch;
mod unknown;
pub(crate) mod unknown_codes;
pub(crate) mod variables;
mod wait;

use components::Components;
use counterpoint_channel::ChannelMemory;
use counterpoint_channel::at::ExecutionPoint;
use counterpoint_channel::burden::Burden;
use counterpoint_channel::channel_context::{Acting, BlockText, ChannelContext, Reports};
use counterpoint_channel::context::BlockContext;
use counterpoint_channel::emitter::Emitter;
use counterpoint_channel::flow::ProgramFlow;
use counterpoint_channel::macros::runtime::Runtime;
use counterpoint_channel::pace::FeedPlanner;
use counterpoint_fault::Halt;
use counterpoint_lang::pattern::SearchMemory;
use counterpoint_machine::model::Channel as MachineChannel;
use counterpoint_program::block::Block;
use counterpoint_sync::order::Order;
use counterpoint_sync::tag::Tag;
use counterpoint_waits::rules;
use dialect_state::DialectState;
use parts::{Ports, Setup};
use plan::ExecutionPlan;

/// The kernel of one channel.
pub struct Kernel<'a> {
    /// The view of actions: the block, the position of the kernel, its memory.
    pub channel: ChannelContext<'a>,
    /// The paths out of the kernel.
    pub ports: Ports<'a>,
    /// The machine as the block loop needs it.
    pub plan: &'a ExecutionPlan,
    /// Programs that run, and the request of the block to the flow.
    pub flow: ProgramFlow,
    /// The pre-processor with its variables.
    pub dialect: DialectState,
    /// The memory of the macros of the machine; empty without any.
    pub macros: Box<Runtime>,
    /// Components of a composite machine.
    pub components: Components<'a>,
}

impl<'a> Kernel<'a> {
    /// A kernel at the start of its life.
    pub fn new(setup: Setup<'a>, channel: &MachineChannel) -> Self {
        let Setup { env, emitter, ports, plan, components } = setup;
        let tape =
            (plan.tables.edits.tape.as_ref().map(|tape| tape.start).unwrap_or_default(), SearchMemory::default());
        let machine = env.machine;
        let mut state = ChannelMemory::new(machine, channel);
        state.times.record_motions(plan.hooks.is_some());
        state.law = env.options.timing.law.then(Box::default);
        Self {
            channel: ChannelContext {
                env,
                at: ExecutionPoint { channel: channel.number, ..ExecutionPoint::default() },
                block: Block::default(),
                text: BlockText { tape, ..BlockText::default() },
                context: BlockContext::default(),
                tables: &plan.tables,
                acting: Acting::default(),
                state,
                reports: Reports::new(rules(env.whole)),
                burden: Burden::default(),
                emitter: emitter.paced(FeedPlanner::of(machine, channel, env.options)),
            },
            ports,
            plan,
            flow: ProgramFlow::default(),
            dialect: DialectState::new(machine, !env.options.lint),
            macros: Box::default(),
            components: Components::of(components, channel.number),
        }
    }
}

impl Kernel<'_> {
    /// Runs an operation on the data that channels share, in tag order.
    ///
    /// # Errors
    /// When the job was stopped before.
    pub(crate) fn shared<R>(&mut self, operation: impl FnOnce(&mut Order) -> R) -> Result<R, Halt> {
        let coordinator = self.ports.coordinator;
        if self.channel.at.channel == 0 {
            // The master works while no channel does.
            return Ok(coordinator.unordered(operation));
        }
        if self.channel.emitter.held_since().is_some_and(|since| since.t < self.channel.at.clock) {
            self.flush_lookahead()?;
        }
        self.channel.come_to_rest();
        let tag = self.channel.at.tag();
        in_order(&mut self.channel, &self.ports, tag, operation)
    }

    /// The same for statements, which are read ahead of a waiting move: at the time of its beginning. The path of the
    /// move does not depend on shared variables.
    ///
    /// # Errors
    /// When the job was stopped before.
    pub(crate) fn shared_ahead<R>(&mut self, operation: impl FnOnce(&mut Order) -> R) -> Result<R, Halt> {
        let Some(since) = self.channel.emitter.held_since().filter(|_| self.channel.at.channel != 0) else {
            return self.shared(operation);
        };
        self.channel.come_to_rest();
        let since = self.channel.emitter.held_since().unwrap_or(since);
        in_order(&mut self.channel, &self.ports, since, operation)
    }

    /// The same while the path continues: at the time of its end as far as that is known.
    ///
    /// # Errors
    /// When the job was stopped before.
    pub(crate) fn shared_in_motion<R>(&mut self, operation: impl FnOnce(&mut Order) -> R) -> Result<R, Halt> {
        if !self.channel.emitter.has_pace() || self.channel.at.channel == 0 {
            return self.shared(operation);
        }
        if self.channel.emitter.held_since().is_some_and(|since| since.t < self.channel.at.clock) {
            self.flush_lookahead()?;
        }
        let tag = Tag { t: self.channel.now(), ..self.channel.at.tag() };
        self.channel.emitter.act_in_motion(tag.t);
        in_order(&mut self.channel, &self.ports, tag, operation)
    }
}

/// Runs a shared operation at this tag, when it is this kernel's turn.
pub(crate) fn in_order<R>(
    channel: &mut ChannelContext<'_>,
    ports: &Ports<'_>,
    tag: Tag,
    operation: impl FnOnce(&mut Order) -> R,
) -> Result<R, Halt> {
    let coordinator = ports.coordinator;
    ports.control.disturb(channel.at.channel);
    let upto = channel.emitter.promise(&channel.at);
    let flush = |emitter: &mut Emitter<'_>| emitter.flush(upto);
    let mut turn = coordinator.enter_keeping((tag, upto), &mut channel.emitter, flush).map_err(|_| Halt::Stopped)?;
    let result = operation(&mut turn);
    drop(turn);
    ports.control.disturb(channel.at.channel);
    Ok(result)
}
