//! Limits of memory and of work within blocks.

use super::Kernel;
use counterpoint_channel::burden::{BAR, BLOCK, EVENT, LOOK_EVERY, PATH, PER_BLOCK};
use counterpoint_fault::{Acted, Halt};
use counterpoint_ports::control::Limit;

impl Kernel<'_> {
    /// Counts work within a block, in elements, and looks whether the job is to end.
    ///
    /// # Errors
    /// It is.
    pub fn work(&mut self, elements: usize) -> Acted {
        let before = self.channel.burden.work;
        self.channel.burden.work = before.saturating_add(elements as u64);
        self.channel.at.idle_blocks += self.channel.burden.work / PER_BLOCK - before / PER_BLOCK;
        if self.channel.burden.work / LOOK_EVERY == before / LOOK_EVERY {
            return Ok(());
        }
        if self.ports.control.cancelled_once_resumed() {
            return Err(Halt::Stopped);
        }
        self.check_limits()
    }

    /// Data of the kernel besides values of macros, if they are too much: their largest part.
    pub(crate) fn overburdened(&self) -> Option<String> {
        let shares = self.channel.env.shares();
        let (limit, room) = (shares.rest, shares.room());
        // Kernels may be ahead of their results, so the number of events gives the maximum size of the results.
        let events = self.channel.emitter.count();
        let several = self.channel.env.machine.channels.len() > 1;
        let kept = self.components.turns.dialects.iter().map(|resting| &resting.dialect);
        let interpreters = || kept.clone().chain([&self.dialect]).filter_map(|dialect| dialect.interpreter.as_deref());
        let interpreter = interpreters().map(|interpreter| interpreter.memory()).sum();
        let compiled: u64 = interpreters().map(|interpreter| interpreter.tables()).sum();
        let tables = self.flow.known.tables as u64 + compiled;
        let parts = [
            (self.channel.burden.results, "diagnostics and waits"),
            (interpreter, "variables of the program"),
            (tables, "tables of the program's labels and lines"),
            (room.path.min(events.saturating_mul(PATH)), "the toolpath"),
            (room.bars.min(events.saturating_mul(BAR)), "the bars of the timeline"),
            (
                room.waiting.min(events.saturating_mul(EVENT)) * u64::from(several),
                "events that wait for other channels",
            ),
        ];
        let all: u64 = parts.iter().map(|(bytes, _)| bytes).sum();
        let largest = parts.iter().max_by_key(|(bytes, _)| *bytes).map_or("", |(_, name)| name);
        let channel = self.channel.at.channel;
        (all > limit).then(|| format!("channel {channel} keeps more than {limit} bytes, most of them in {largest}"))
    }

    /// Ends the job: its memory is used up.
    pub fn out_of_memory(&mut self, what: &str) -> Halt {
        self.limit(&format!("the memory of the job is exhausted: {what}"), Some(Limit::Memory))
    }

    /// Between two holes of a block: publishes the progress of this kernel and checks the limits of the job. A hole
    /// counts as much work as a block.
    pub fn count_as_block(&mut self) -> Acted {
        if !self.ports.coordinator.publish(self.channel.at.channel, self.channel.emitter.bound(&self.channel.at))
            || self.ports.control.cancelled()
        {
            return Err(Halt::Stopped);
        }
        self.work(BLOCK)?;
        self.check_limits()
    }
}
