//! One kernel: runs the program of one channel block by block.
//!
//! Facts: reference control-emulator.md 2 (processing order). Invariants: the clock never goes back; whatever other
//! channels can see or change goes through a shared operation at the kernel's tag; in the steady state a block
//! allocates nothing.

pub(crate) mod actions;
mod burden;
mod calls;
pub mod carried;
mod code_time;
pub(crate) mod custom_macro;
mod cycle_codes;
mod cycle_event;
pub(crate) mod data;
mod diagnostics;
pub mod emit;
pub(crate) mod flow;
mod frame;
pub(crate) mod hook_points;
mod host;
mod letter_zero;
pub(crate) mod life;
mod motion;
pub mod parts;
mod passes;
pub mod plan;
mod refusals;
pub(crate) mod report;
mod search;
mod spindle;
mod statement;
mod tool_data;
mod unknown;
pub(crate) mod variables;
mod wait;

use counterpoint_fault::Halt;
use counterpoint_lang::pattern::Memory;
use flow::Flow;
use parts::{DialectState, Ports, Setup};
use plan::Plan;

use crate::macros::runtime::Runtime;
use crate::state::State;
use crate::state::burden::Burden;
use crate::state::channel::{Acting, At, BlockText, Channel, Reports};
use crate::waits::rules;
use counterpoint_event::event::Kind;
use counterpoint_machine::model::Channel as MachineChannel;
use counterpoint_program::block::Block;
use counterpoint_sync::order::Order;
use counterpoint_sync::tag::Tag;

/// The kernel of one channel.
pub struct Kernel<'a> {
    /// What actions see: the block, where the kernel is, what it remembers.
    pub channel: Channel<'a>,
    /// The ways out of the kernel.
    pub ports: Ports<'a>,
    pub(crate) plan: &'a Plan,
    pub(crate) flow: Flow,
    pub(crate) dialect: DialectState,
    /// What the macros of the machine remember; empty without any.
    pub macros: Box<Runtime>,
}

impl<'a> Kernel<'a> {
    /// A kernel at the start of its life.
    pub fn new(setup: Setup<'a>, channel: &MachineChannel) -> Self {
        let Setup { env, ports, plan } = setup;
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
                reports: Reports::new(rules(machine)),
                burden: Burden::default(),
            },
            ports,
            plan,
            flow: Flow::default(),
            dialect: DialectState::new(machine),
            macros: Box::default(),
        }
    }
}

impl Kernel<'_> {
    /// Where the kernel stands in the order of everything.
    pub fn tag(&self) -> Tag {
        self.channel.at.tag()
    }

    /// Adds an event of this block at the clock.
    #[inline]
    pub(crate) fn emit(&mut self, dur_ns: i64, kind: Kind) {
        let bytes = kind.text_bytes();
        self.emit_as(dur_ns, |slot| *slot = kind);
        if bytes > 0 && self.ports.emitter.carries(bytes) {
            self.ports.emitter.flush(self.tag());
        }
    }

    /// Adds an event whose kind is written where it stays.
    #[inline(always)]
    pub(crate) fn emit_as(&mut self, dur_ns: i64, write: impl FnOnce(&mut Kind)) {
        let (t_ns, micro) = (self.channel.at.clock, self.channel.at.micro);
        if let Some(event) = self.ports.emitter.slot(t_ns, micro) {
            (event.t_ns, event.micro, event.dur_ns) = (t_ns, micro, dur_ns);
            (event.channel, event.file, event.line) =
                (self.channel.at.channel, self.channel.at.file, self.channel.at.line);
            write(&mut event.kind);
        }
    }

    /// Runs an operation on what the channels share, in tag order.
    ///
    /// # Errors
    /// When the job was stopped before.
    pub(crate) fn shared<R>(&mut self, operation: impl FnOnce(&mut Order) -> R) -> Result<R, Halt> {
        let coordinator = self.ports.coordinator;
        if self.channel.at.channel == 0 {
            // The master works while no channel does.
            return Ok(coordinator.unordered(operation));
        }
        if self.ports.emitter.is_late(self.channel.at.clock) {
            self.flush_lookahead()?;
        }
        self.ports.control.disturb(self.channel.at.channel);
        let tag = self.tag();
        let mut turn =
            coordinator.enter(tag, &mut self.ports.emitter, |emitter| emitter.flush(tag)).map_err(|_| Halt::Stopped)?;
        let result = operation(&mut turn);
        drop(turn);
        self.ports.control.disturb(self.channel.at.channel);
        Ok(result)
    }
}
