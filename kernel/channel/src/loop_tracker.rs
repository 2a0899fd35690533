//! Passes of loops: the loop that a program runs, and whether a pass has changed anything.

use crate::shared_target::SharedTarget;
use counterpoint_event::event::FileId;
use counterpoint_sync::races::RaceVariable;
use std::sync::Arc;

/// Loops that are remembered at a time. After as many jumps back without time a tick passes in any case.
pub const MOST: usize = 32;

/// Identity of a loop: file, first line, line of the jump back.
type Key = (FileId, u32, u32);

/// A loop as seen by its last jump back.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct TrackedLoop {
    /// Identity of the loop.
    pub key: Key,
    /// Running programs, including that of the loop.
    pub depth: usize,
    /// Passes so far.
    pub count: u64,
    /// Clock at the last jump.
    pub clock: i64,
    /// Ticks and dwells since, ns.
    pub ticks: i64,
    /// Something happened since that a later pass could see.
    pub effects: bool,
    /// Shared variables read since, by place in the list of [`LoopTracker`].
    pub reads: u64,
    /// Macro steps until then.
    pub steps: u64,
    /// If nothing has happened but reading: the changes of shared data until then, and the print of the channel's own
    /// state.
    pub begun: Option<(u64, u64)>,
}

/// The loops that a channel is in; the last to jump back is at the end.
#[derive(Debug, Default)]
pub struct LoopTracker {
    /// Something happened since the last jump back that a later pass could see.
    pub effects: bool,
    /// An own variable has changed since the last jump back, or a program was called. The same values at the start and
    /// at the end of a pass mean the same next pass.
    pub changes: bool,
    /// Shared variables read since the last jump back, by place in the list.
    pub reads: u64,
    /// Those that have been read in this program; from the 64th on all have one place.
    pub variables: Vec<RaceVariable>,
    /// The names of some of them.
    pub names: Option<(u64, Arc<str>)>,
    /// The condition of a loop is evaluated.
    pub condition: bool,
    /// The loops, the last to jump back at the end.
    pub loops: Vec<TrackedLoop>,
    /// Jumps back since the clock stood at `clock`.
    pub jumps: usize,
    /// Clock at the last jump back, ns.
    pub clock: i64,
}

impl LoopTracker {
    /// The loop that jumped back last.
    pub fn last(&self) -> TrackedLoop {
        self.loops.last().copied().unwrap_or_default()
    }

    /// Time passes without any other effect, ns.
    #[inline]
    pub fn dwell(&mut self, ns: i64) {
        self.loops.iter_mut().for_each(|pass| pass.ticks += ns);
    }

    /// Records a read of shared data; accesses that lead to no variable do not count.
    pub fn polls(&mut self, door: SharedTarget<'_>) {
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
    pub fn leave(&mut self, depth: usize) {
        self.loops.retain(|pass| pass.depth <= depth);
    }

    /// Whether a block of the loop that jumped back last has only read since.
    pub fn looks(&self, (file, line): (FileId, u32), depth: usize) -> bool {
        let (of, first, last) = self.last().key;
        !self.effects && !self.changes && self.last().depth == depth && of == file && (first..=last).contains(&line)
    }

    /// The usual jump back: that of the last loop again, which reads nothing that is shared. Whether time has passed
    /// since its last one; its next pass begins with [`begin`](Self::begin).
    pub fn again(&mut self, key: Key, depth: usize, clock: i64) -> Option<bool> {
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
    pub fn begin(&mut self, clock: i64, steps: u64) {
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
    pub fn jump(&mut self, key: Key, depth: usize, clock: i64) -> Option<TrackedLoop> {
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
