//! One kernel: runs the program of one channel block by block.
//!
//! Facts: reference control-emulator.md 2 (processing order). Invariants: the clock never goes back; every access to
//! data that other channels can see or change is a shared operation at the kernel's tag; in the steady state a block
//! allocates nothing.

pub(crate) mod access;
pub(crate) mod actions;
mod addresses;
mod alone;
mod burden;
mod calls;
pub mod carried;
mod code_time;
pub mod components;
mod coupling;
pub(crate) mod custom_macro;
mod cycle_codes;
mod cycle_event;
pub(crate) mod cycle_moves;
pub(crate) mod data;
mod diagnostics;
pub(crate) mod dialect_state;
mod driven_spindle;
pub mod emit;
mod exchange;
pub(crate) mod flow;
mod frame;
pub(crate) mod hook_points;
mod host;
mod known_blocks;
mod left_words;
mod letter_zero;
pub(crate) mod life;
mod motion;
mod names;
mod pace;
pub mod parts;
mod passes;
pub mod plan;
pub(crate) mod refusals;
pub(crate) mod report;
mod search;
mod separate;
mod spindle;
mod statement;
pub mod step;
mod system_variables;
mod tool_data;
mod travel;
mod unknown;
mod unknown_codes;
pub(crate) mod variables;
mod wait;

use components::Components;
use counterpoint_fault::Halt;
use counterpoint_lang::pattern::Memory;
use counterpoint_sync::backlog::blank;
use dialect_state::DialectState;
use emit::Emitter;
use flow::Flow;
use parts::{Ports, Setup};
use plan::Plan;

use crate::macros::runtime::Runtime;
use crate::state::State;
use crate::state::burden::Burden;
use crate::state::channel::{Acting, At, BlockText, Channel, Reports};
use crate::state::pace::Pace;
use counterpoint_event::event::{Event, Kind};
use counterpoint_machine::model::Channel as MachineChannel;
use counterpoint_program::block::Block;
use counterpoint_sync::order::Order;
use counterpoint_sync::tag::Tag;
use counterpoint_waits::rules;

/// The kernel of one channel.
pub struct Kernel<'a> {
    /// The view of actions: the block, the position of the kernel, its memory.
    pub channel: Channel<'a>,
    /// The paths out of the kernel.
    pub ports: Ports<'a>,
    pub(crate) plan: &'a Plan,
    pub(crate) flow: Flow,
    pub(crate) dialect: DialectState,
    /// The memory of the macros of the machine; empty without any.
    pub macros: Box<Runtime>,
    /// Components of a composite machine.
    pub(crate) components: Components<'a>,
}

impl<'a> Kernel<'a> {
    /// A kernel at the start of its life.
    pub fn new(setup: Setup<'a>, channel: &MachineChannel) -> Self {
        let Setup { env, ports, plan, components } = setup;
        let tape = (plan.edits.tape.as_ref().map(|tape| tape.start).unwrap_or_default(), Memory::default());
        let machine = env.machine;
        Self {
            channel: Channel {
                env,
                at: At { channel: channel.number, ..At::default() },
                block: Block::default(),
                text: BlockText { tape, ..BlockText::default() },
                acting: Acting::default(),
                state: State::new(machine, channel),
                reports: Reports::new(rules(env.whole)),
                burden: Burden::default(),
                held: None,
                pace: Pace::of(machine, channel, env.options),
            },
            ports,
            plan,
            flow: Flow::default(),
            dialect: DialectState::new(machine, !env.options.lint),
            macros: Box::default(),
            components: Components::of(components, channel.number),
        }
    }
}

impl Kernel<'_> {
    /// This kernel's current tag, at rest.
    pub fn tag(&mut self) -> Tag {
        self.come_to_rest();
        self.channel.at.tag()
    }

    /// Adds an event of this block at the clock.
    #[inline]
    pub(crate) fn emit(&mut self, dur_ns: i64, kind: Kind) {
        let bytes = kind.text_bytes();
        self.emit_as(dur_ns, |slot| *slot = kind);
        if bytes > 0 && self.ports.emitter.carries(bytes) {
            self.flush();
        }
    }

    /// Adds an event whose kind is written where it stays.
    #[inline(always)]
    pub(crate) fn emit_as(&mut self, dur_ns: i64, write: impl FnOnce(&mut Kind)) {
        let At { channel, clock, micro, file, line, caller, .. } = self.channel.at;
        let slot = match self.ports.emitter.slot() {
            Some(event) => Some(event),
            None => self.other_slot(Tag { t: clock, micro, channel }),
        };
        if let Some(event) = slot {
            (event.t_ns, event.micro, event.dur_ns) = (clock, micro, dur_ns);
            (event.channel, event.file, event.line, event.caller) = (channel, file, line, caller);
            write(&mut event.kind);
        }
    }

    /// Adds a complete event.
    pub(crate) fn push_event(&mut self, event: Event) {
        let tag = Tag { t: event.t_ns, micro: event.micro, channel: self.channel.at.channel };
        let slot = match self.ports.emitter.slot() {
            Some(slot) => Some(slot),
            None => self.other_slot(tag),
        };
        if let Some(slot) = slot {
            *slot = event;
        }
    }

    /// The place of an event at this tag where the chunk of the emitter has none: among the events held back, or in the
    /// next chunk.
    #[cold]
    #[inline(never)]
    fn other_slot(&mut self, tag: Tag) -> Option<&mut Event> {
        if self.channel.held.is_none() && self.channel.pace.as_ref().is_some_and(|pace| pace.is_active()) {
            return self.paced_slot();
        }
        let emitter = &mut self.ports.emitter;
        match &mut self.channel.held {
            Some(held) => {
                held.events.push(blank());
                let count = emitter.held_count() + 1;
                emitter.holds_back(Some(count));
                held.events.last_mut()
            }
            None => {
                emitter.flush(tag);
                emitter.slot()
            }
        }
    }

    /// Sends the events so far. Events held back stay.
    pub(crate) fn flush(&mut self) {
        let upto = self.channel.promise();
        self.ports.emitter.flush(upto);
    }

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
        if self.channel.held.as_ref().is_some_and(|held| held.since.t < self.channel.at.clock) {
            self.flush_lookahead()?;
        }
        self.come_to_rest();
        self.in_order(self.channel.at.tag(), operation)
    }

    /// The same for statements, which are read ahead of a waiting move: at the time of its beginning. The path of the
    /// move does not depend on shared variables.
    ///
    /// # Errors
    /// When the job was stopped before.
    pub(crate) fn shared_ahead<R>(&mut self, operation: impl FnOnce(&mut Order) -> R) -> Result<R, Halt> {
        if self.channel.held.is_none() || self.channel.at.channel == 0 {
            return self.shared(operation);
        }
        self.come_to_rest();
        let tag = self.channel.held.as_ref().map_or_else(|| self.channel.at.tag(), |held| held.since);
        self.in_order(tag, operation)
    }

    /// The same while the path continues: at the time of its end as far as that is known.
    ///
    /// # Errors
    /// When the job was stopped before.
    pub(crate) fn shared_in_motion<R>(&mut self, operation: impl FnOnce(&mut Order) -> R) -> Result<R, Halt> {
        if self.channel.pace.is_none() || self.channel.at.channel == 0 {
            return self.shared(operation);
        }
        if self.channel.held.as_ref().is_some_and(|held| held.since.t < self.channel.at.clock) {
            self.flush_lookahead()?;
        }
        let tag = Tag { t: self.channel.now(), ..self.channel.at.tag() };
        if let Some(pace) = &mut self.channel.pace {
            pace.acted = tag.t;
        }
        self.in_order(tag, operation)
    }

    /// Runs a shared operation at this tag, when it is this kernel's turn.
    fn in_order<R>(&mut self, tag: Tag, operation: impl FnOnce(&mut Order) -> R) -> Result<R, Halt> {
        let coordinator = self.ports.coordinator;
        self.ports.control.disturb(self.channel.at.channel);
        let upto = self.channel.promise();
        let flush = |emitter: &mut Emitter<'_>| emitter.flush(upto);
        let mut turn =
            coordinator.enter_keeping((tag, upto), &mut self.ports.emitter, flush).map_err(|_| Halt::Stopped)?;
        let result = operation(&mut turn);
        drop(turn);
        self.ports.control.disturb(self.channel.at.channel);
        Ok(result)
    }
}
