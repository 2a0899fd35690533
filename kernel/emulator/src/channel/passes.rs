//! Passes of loops: a pass that takes no time costs a tick, and one that only polls may be hopeless.
//!
//! A loop is known by its jump back. *Invariant:* time passes in every loop that takes none, whatever loops, calls or jumps
//! lie inside it. Facts: reference channel-synchronisation.md (polling), control-emulator.md 5.7.

use super::Kernel;
use counterpoint_event::event::FileId;
use counterpoint_fault::Acted;

/// Loops that are remembered at a time. After as many jumps back without time a tick passes in any case.
const MOST: usize = 32;

/// What identifies a loop: file, first line, line of the jump back.
type Key = (FileId, u32, u32);

/// A loop as seen by its last jump back.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Pass {
    pub(crate) key: Key,
    /// Running programs, the one with the loop included.
    depth: usize,
    /// Passes so far.
    pub(crate) count: u64,
    /// Clock at the last jump.
    clock: i64,
    /// Ticks and dwells since, ns.
    ticks: i64,
    /// Something happened since that a later pass could see.
    effects: bool,
    /// A shared variable was read since.
    polled: bool,
    /// Nobody else was left to change a variable when this pass began.
    alone: bool,
}

/// The loops that a channel is in, the one that jumped back last at the end.
#[derive(Debug, Default)]
pub(crate) struct Passes {
    /// Something happened since the last jump back that a later pass could see.
    pub(crate) effects: bool,
    /// A shared variable was read since the last jump back.
    pub(crate) polled: bool,
    /// The condition of a loop is evaluated.
    pub(crate) condition: bool,
    loops: Vec<Pass>,
    /// Jumps back since the clock stood at `clock`.
    jumps: usize,
    clock: i64,
}

impl Passes {
    /// The loop that jumped back last.
    pub(crate) fn last(&self) -> Pass {
        self.loops.last().copied().unwrap_or_default()
    }

    /// Time passes without any other effect, ns.
    #[inline]
    pub(crate) fn dwell(&mut self, ns: i64) {
        self.loops.iter_mut().for_each(|pass| pass.ticks += ns);
    }

    /// A block of the loop that jumped back last, which has done nothing since but look.
    fn looks(&self, (file, line): (FileId, u32), depth: usize) -> bool {
        let (of, first, last) = self.last().key;
        !self.effects && self.last().depth == depth && of == file && (first..=last).contains(&line)
    }

    /// The loop jumps back at this clock: what it was at its last jump, if it is known. Loops inside it are forgotten:
    /// they begin again.
    fn jump(&mut self, key: Key, depth: usize, clock: i64) -> Option<Pass> {
        let (effects, polled) = (std::mem::take(&mut self.effects), std::mem::take(&mut self.polled));
        for pass in &mut self.loops {
            pass.effects |= effects;
            pass.polled |= polled;
        }
        if self.clock != clock {
            (self.clock, self.jumps) = (clock, 0);
        }
        self.jumps += 1;
        // The usual case: the same loop again.
        if self.loops.last().is_some_and(|pass| pass.key == key && pass.depth == depth) {
            return self.loops.pop();
        }
        let (file, first, last) = key;
        let inside = |pass: &Pass| pass.key.1 >= first && pass.key.2 <= last;
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
    /// Counts a pass of the loop from `target` to `from` in the current program. A pass that took no time costs a tick, and
    /// one that only polls is hopeless once nobody is left to change what it reads.
    ///
    /// # Errors
    /// When the loop is hopeless.
    pub(crate) fn end_pass(&mut self, target: u32, from: u32) -> Acted {
        self.flow.repeats = true;
        let (file, depth) =
            (self.flow.frames.last().map_or(self.channel.at.file, |frame| frame.file), self.flow.frames.len());
        let key = (file, target, from);
        let known = self.flow.pass.jump(key, depth, self.channel.at.clock);
        let mut next = Pass { key, depth, count: 1, ..Pass::default() };
        if let Some(mut pass) = known {
            next.count = pass.count + 1;
            if pass.clock == self.channel.at.clock {
                pass.ticks += self.tick();
            }
            if pass.polled {
                // A tick is not progress, unless the loop looks at what others may change.
                self.channel.at.idle_blocks = 0;
            }
            if pass.polled && !pass.effects && pass.clock + pass.ticks == self.channel.at.clock {
                next.alone = self.is_alone()?;
                if next.alone && pass.alone {
                    self.flow.pass.loops.push(next);
                    return Err(self.spinning(target));
                }
            }
        } else if self.flow.pass.jumps > MOST {
            self.tick();
        }
        next.clock = self.channel.at.clock;
        self.flow.pass.loops.push(next);
        Ok(())
    }

    /// A variable that is read now decides how long a loop waits.
    pub(crate) fn is_polling(&self) -> bool {
        let at = (self.channel.at.file, self.channel.at.line);
        self.flow.pass.condition || self.flow.pass.looks(at, self.flow.frames.len())
    }

    /// Lets a tick pass, which is no progress. Gives it, ns.
    fn tick(&mut self) -> i64 {
        let (idle, tick) = (self.channel.at.idle_blocks, self.channel.env.machine.sync.poll_ns);
        self.channel.advance(tick);
        self.channel.at.idle_blocks = idle;
        self.flow.pass.dwell(tick);
        tick
    }
}
