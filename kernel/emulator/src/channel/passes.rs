//! Passes of loops: a pass that takes no time costs a tick, and one that only polls may be hopeless.
//!
//! A loop is identified by its jump back. *Invariant:* time passes in every loop that takes none, regardless of the
//! loops, calls or jumps inside it. A kernel whose passes are all alike rests; the passes that it skips would only have
//! taken time. Facts: reference channel-synchronisation.md (polling), control-emulator.md 5.7.

use std::sync::Arc;

use super::Kernel;
use super::access::Door;
use counterpoint_event::event::FileId;
use counterpoint_event::event::Kind;
use counterpoint_fault::{Acted, Halt};
use counterpoint_sync::order::Wake;
use counterpoint_sync::order::spin::{LoopPass, PassOutcome};
use counterpoint_sync::races::RaceVariable;

/// Loops that are remembered at a time. After as many jumps back without time a tick passes in any case.
const MOST: usize = 32;

/// Identity of a loop: file, first line, line of the jump back.
type Key = (FileId, u32, u32);

/// A loop as seen by its last jump back.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct TrackedLoop {
    pub(crate) key: Key,
    /// Running programs, including that of the loop.
    depth: usize,
    /// Passes so far.
    pub(crate) count: u64,
    /// Clock at the last jump.
    clock: i64,
    /// Ticks and dwells since, ns.
    ticks: i64,
    /// Something happened since that a later pass could see.
    effects: bool,
    /// Shared variables read since, by place in the list of [`LoopTracker`].
    reads: u64,
    /// Macro steps until then.
    steps: u64,
    /// If nothing has happened but reading: the changes of shared data until then, and the print of the channel's own
    /// state.
    begun: Option<(u64, u64)>,
}

/// The loops that a channel is in; the last to jump back is at the end.
#[derive(Debug, Default)]
pub struct LoopTracker {
    /// Something happened since the last jump back that a later pass could see.
    pub effects: bool,
    /// An own variable has changed since the last jump back, or a program was called. The same values at the start and
    /// at the end of a pass mean the same next pass.
    pub(crate) changes: bool,
    /// Shared variables read since the last jump back, by place in the list.
    reads: u64,
    /// Those that have been read in this program; from the 64th on all have one place.
    variables: Vec<RaceVariable>,
    /// The names of some of them.
    names: Option<(u64, Arc<str>)>,
    /// The condition of a loop is evaluated.
    pub(crate) condition: bool,
    loops: Vec<TrackedLoop>,
    /// Jumps back since the clock stood at `clock`.
    jumps: usize,
    clock: i64,
}

impl LoopTracker {
    /// The loop that jumped back last.
    pub(crate) fn last(&self) -> TrackedLoop {
        self.loops.last().copied().unwrap_or_default()
    }

    /// Time passes without any other effect, ns.
    #[inline]
    pub fn dwell(&mut self, ns: i64) {
        self.loops.iter_mut().for_each(|pass| pass.ticks += ns);
    }

    /// Records a read of shared data; accesses that lead to no variable do not count.
    pub(crate) fn polls(&mut self, door: Door<'_>) {
        let known = self.variables.iter().position(|known| door.leads_to(known));
        let Some(place) = known.or_else(|| self.note(door.variable()?)) else { return };
        self.reads |= 1 << place;
    }

    /// The place of one more variable; the last one is that of all that find no room.
    fn note(&mut self, variable: RaceVariable) -> Option<usize> {
        if self.variables.len() < 64 {
            self.variables.push(variable);
        }
        self.variables.len().checked_sub(1)
    }

    /// The program of a loop has returned: its loops are over.
    pub(crate) fn leave(&mut self, depth: usize) {
        self.loops.retain(|pass| pass.depth <= depth);
    }

    /// Whether a block of the loop that jumped back last has only read since.
    fn looks(&self, (file, line): (FileId, u32), depth: usize) -> bool {
        let (of, first, last) = self.last().key;
        !self.effects && !self.changes && self.last().depth == depth && of == file && (first..=last).contains(&line)
    }

    /// The usual jump back: that of the last loop again, which reads nothing that is shared. Whether time has passed
    /// since its last one; its next pass begins with [`begin`](Self::begin).
    fn again(&mut self, key: Key, depth: usize, clock: i64) -> Option<bool> {
        let pass = self.loops.last()?;
        if self.reads != 0 || pass.reads != 0 || pass.key != key || pass.depth != depth {
            return None;
        }
        let passed = pass.clock != clock;
        self.changes = false;
        if std::mem::take(&mut self.effects) {
            self.loops.iter_mut().for_each(|pass| pass.effects = true);
        }
        self.count_jump(clock);
        Some(passed)
    }

    /// The next pass of the last loop begins at this clock, after this many macro steps.
    fn begin(&mut self, clock: i64, steps: u64) {
        if let Some(pass) = self.loops.last_mut() {
            pass.count += 1;
            (pass.clock, pass.steps, pass.ticks, pass.effects, pass.begun) = (clock, steps, 0, false, None);
        }
    }

    fn count_jump(&mut self, clock: i64) {
        if self.clock != clock {
            (self.clock, self.jumps) = (clock, 0);
        }
        self.jumps += 1;
    }

    /// The loop jumps back at this clock. Returns the clock of its last jump, if known. Loops inside it are forgotten:
    /// they start again.
    fn jump(&mut self, key: Key, depth: usize, clock: i64) -> Option<TrackedLoop> {
        let (effects, reads) = (std::mem::take(&mut self.effects), std::mem::take(&mut self.reads));
        self.changes = false;
        for pass in &mut self.loops {
            pass.effects |= effects;
            pass.reads |= reads;
        }
        self.count_jump(clock);
        // The usual case: the same loop again.
        if self.loops.last().is_some_and(|pass| pass.key == key && pass.depth == depth) {
            return self.loops.pop();
        }
        let (file, first, last) = key;
        let inside = |pass: &TrackedLoop| pass.key.1 >= first && pass.key.2 <= last;
        let mut known = None;
        self.loops.retain(|pass| {
            if pass.key == key && pass.depth == depth {
                known = Some(*pass);
                return false;
            }
            pass.depth < depth || pass.depth == depth && pass.key.0 == file && !inside(pass)
        });
        if self.loops.len() >= MOST {
            self.loops.remove(0);
        }
        known
    }
}

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
                self.tick();
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
                let tick = self.tick();
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
            self.tick();
        }
        (next.clock, next.steps) = (self.channel.at.clock, self.channel.burden.steps);
        self.flow.pass.loops.push(next);
        Ok(())
    }

    /// Ends a pass that has only read. If it took no time but its tick, the channel may rest: `every` is the tick, ns.
    fn end_lap(&mut self, mut lap: LoopPass, pass: TrackedLoop, mut next: TrackedLoop, every: Option<i64>) -> Acted {
        let print = self.own_print();
        let begun = pass.begun.filter(|(_, before)| *before == print).map(|(changes, _)| changes);
        let names = self.names(lap.reads);
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

    /// The shared variables in these places, by their names in programs; made once for the passes of a loop.
    fn names(&mut self, reads: u64) -> Arc<str> {
        if let Some((of, names)) = &self.flow.pass.names
            && *of == reads
        {
            return Arc::clone(names);
        }
        let read = self.flow.pass.variables.iter().enumerate().filter(|(at, _)| reads >> at & 1 == 1);
        let names: Vec<String> = read.map(|(_, variable)| self.macros.variable_name(variable)).collect();
        let names: Arc<str> = names.join(", ").into();
        self.flow.pass.names = Some((reads, Arc::clone(&names)));
        names
    }

    /// Print of the state that determines the course of the channel besides the shared data: its variables, and the
    /// repeats of its programs.
    fn own_print(&self) -> u64 {
        let repeats = self.flow.frames.iter().filter(|frame| frame.repeats > 0);
        repeats.fold(self.dialect.variables.print(), |all, frame| {
            (all ^ u64::from(frame.repeats)).wrapping_mul(0x9e37_79b9_7f4a_7c15)
        })
    }

    /// Whether a variable that is read now decides how long a loop waits.
    pub(crate) fn is_polling(&self) -> bool {
        let at = (self.channel.at.file, self.channel.at.line);
        self.flow.pass.condition || self.flow.pass.looks(at, self.flow.frames.len())
    }

    /// Lets a tick pass, which is not progress. Returns it, ns.
    fn tick(&mut self) -> i64 {
        let (idle, tick) = (self.channel.at.idle_blocks, self.channel.env.machine.sync.poll_ns);
        self.channel.advance(tick);
        self.channel.at.idle_blocks = idle;
        self.flow.pass.dwell(tick);
        tick
    }
}
