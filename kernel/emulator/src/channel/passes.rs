//! Passes of loops: a pass that takes no time costs a tick, and one that only polls may be hopeless.
//!
//! A loop is identified by its jump back. *Invariant:* time passes in every loop that takes none, regardless of the
//! loops, calls or jumps inside it. A kernel whose passes are all alike rests; the passes that it skips would only have
//! taken time. Facts: reference channel-synchronisation.md (polling), control-emulator.md 5.7.

use std::sync::Arc;

use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::flow::ProgramFlow;
use counterpoint_channel::loop_tracker::{MOST, TrackedLoop};
use counterpoint_channel::macros::runtime::Runtime;
use counterpoint_event::event::Kind;
use counterpoint_fault::{Acted, Halt};
use counterpoint_sync::order::Wake;
use counterpoint_sync::order::spin::{LoopPass, PassOutcome};

use super::Kernel;
use crate::channel::dialect_state::DialectState;

impl Kernel<'_> {
    /// Counts a pass of the loop from `target` to `from` in the current program. A pass that took no time costs a tick.
    /// A loop that only polls is hopeless once no channel is left to change the variables that it reads.
    ///
    /// # Errors
    /// When the loop is hopeless.
    pub(crate) fn end_pass(&mut self, target: u32, from: u32) -> Acted {
        self.flow.repeats = true;
        if self.channel.env.options.lint {
            // Without values no loop waits for one.
            return Ok(());
        }
        let (file, depth) =
            (self.flow.frames.last().map_or(self.channel.at.file, |frame| frame.file), self.flow.frames.len());
        let key = (file, target, from);
        if let Some(passed) = self.flow.pass.again(key, depth, self.channel.at.clock) {
            if !passed {
                pass_tick(&mut self.channel, &mut self.flow);
            }
            self.flow.pass.begin(self.channel.at.clock, self.channel.burden.steps);
            return Ok(());
        }
        let known = self.flow.pass.jump(key, depth, self.channel.at.clock);
        let mut next = TrackedLoop { key, depth, count: 1, ..TrackedLoop::default() };
        if let Some(mut pass) = known {
            next.count = pass.count + 1;
            let mut every = None;
            if pass.reads != 0 && !pass.effects && !self.ports.coordinator.is_single() {
                // Changes by other channels are seen at their time, so no move waits for such a loop.
                self.flush_lookahead()?;
            }
            if pass.clock == self.channel.at.clock {
                let tick = pass_tick(&mut self.channel, &mut self.flow);
                pass.ticks += tick;
                every = Some(tick);
            }
            if pass.reads != 0 {
                // A tick is not progress, unless the loop reads data that other channels may change.
                self.channel.at.idle_blocks = 0;
            }
            let waits = pass.clock + pass.ticks == self.channel.at.clock;
            if pass.reads != 0 && !pass.effects && waits && pass.steps == self.channel.burden.steps {
                let lap = LoopPass { file, lines: (target, from), count: next.count, reads: pass.reads };
                return self.end_lap(lap, pass, next, every);
            }
        } else if self.flow.pass.jumps > MOST {
            pass_tick(&mut self.channel, &mut self.flow);
        }
        (next.clock, next.steps) = (self.channel.at.clock, self.channel.burden.steps);
        self.flow.pass.loops.push(next);
        Ok(())
    }

    /// Ends a pass that has only read. If it took no time but its tick, the channel may rest: `every` is the tick, ns.
    fn end_lap(&mut self, mut lap: LoopPass, pass: TrackedLoop, mut next: TrackedLoop, every: Option<i64>) -> Acted {
        let print = own_print(&self.flow, &self.dialect);
        let begun = pass.begun.filter(|(_, before)| *before == print).map(|(changes, _)| changes);
        let names = names(&mut self.flow, &self.macros, lap.reads);
        let changes = loop {
            let tag = self.channel.tag();
            match self.shared_ahead(|order| order.lap(tag, lap, begun, &names, every))? {
                PassOutcome::Pass(changes) => break changes,
                PassOutcome::Hopeless => {
                    self.flow.pass.loops.push(next);
                    return Err(self.spinning(lap.lines.0, &names));
                }
                PassOutcome::Rest => {
                    let passes = self.rest(every.unwrap_or_default(), &names)?;
                    lap.count += passes;
                    next.count = lap.count;
                }
            }
        };
        next.begun = Some((changes, print));
        (next.clock, next.steps) = (self.channel.at.clock, self.channel.burden.steps);
        self.flow.pass.loops.push(next);
        Ok(())
    }

    /// Rests while all passes are alike: those left out.
    fn rest(&mut self, every: i64, names: &str) -> Result<u64, Halt> {
        let (coordinator, channel) = (self.ports.coordinator, self.channel.at.channel);
        let wake = coordinator.wait(channel, self, |kernel| kernel.channel.flush());
        self.ports.control.disturb(channel);
        let Wake::Roused { tag, passes } = wake else { return Err(Halt::Stopped) };
        let time = tag.t - self.channel.at.clock;
        debug_assert_eq!(u128::try_from(time), Ok(u128::from(passes) * every as u128));
        self.channel.advance(time);
        self.flow.pass.dwell(time);
        self.channel.emit(0, Kind::mode(format!("polled {names} {passes} times")));
        Ok(passes)
    }
}

/// The shared variables in these places, by their names in programs; made once for the passes of a loop.
fn names(flow: &mut ProgramFlow, macros: &Runtime, reads: u64) -> Arc<str> {
    if let Some((of, names)) = &flow.pass.names
        && *of == reads
    {
        return Arc::clone(names);
    }
    let read = flow.pass.variables.iter().enumerate().filter(|(at, _)| reads >> at & 1 == 1);
    let names: Vec<String> = read.map(|(_, variable)| macros.variable_name(variable)).collect();
    let names: Arc<str> = names.join(", ").into();
    flow.pass.names = Some((reads, Arc::clone(&names)));
    names
}

/// Print of the state that determines the course of the channel besides the shared data: its variables, and the
/// repeats of its programs.
fn own_print(flow: &ProgramFlow, dialect: &DialectState) -> u64 {
    let repeats = flow.frames.iter().filter(|frame| frame.repeats > 0);
    repeats.fold(dialect.variables.print(), |all, frame| {
        (all ^ u64::from(frame.repeats)).wrapping_mul(0x9e37_79b9_7f4a_7c15)
    })
}

/// Whether a variable that is read now decides how long a loop waits.
pub(crate) fn is_polling(channel: &ChannelContext<'_>, flow: &ProgramFlow) -> bool {
    let at = (channel.at.file, channel.at.line);
    flow.pass.condition || flow.pass.looks(at, flow.frames.len())
}

/// Lets a tick pass, which is not progress. Returns it, ns.
fn pass_tick(channel: &mut ChannelContext<'_>, flow: &mut ProgramFlow) -> i64 {
    let (idle, tick) = (channel.at.idle_blocks, channel.env.machine.sync.poll_ns);
    channel.advance(tick);
    channel.at.idle_blocks = idle;
    flow.pass.dwell(tick);
    tick
}
