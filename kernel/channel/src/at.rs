//! Where a kernel is: channel, time, and the place of its block.
//!
//! *Invariant:* the clock never goes back.

use counterpoint_event::SourcePlace;
use counterpoint_event::event::FileId;
use counterpoint_sync::tag::Tag;

/// Where a kernel is: channel, time, and the block in process.
#[derive(Debug, Default)]
pub struct ExecutionPoint {
    /// Number of the channel.
    pub channel: u16,
    /// Simulated time, ns.
    pub clock: i64,
    /// Order of shared operations at the same time.
    pub micro: u32,
    /// File of the block being processed.
    pub file: FileId,
    /// Line of the block being processed.
    pub line: u32,
    /// Where the user's program called the resident program of the block; none in the user's own programs.
    pub caller: SourcePlace,
    /// Blocks read.
    pub blocks: u64,
    /// Blocks of the user's programs among them.
    pub user_blocks: u64,
    /// Blocks among them that the control has made of a cycle; events name the block that calls it.
    pub made_blocks: u64,
    /// Consecutive blocks without time.
    pub idle_blocks: u64,
    /// The innermost place in the user's programs of the last block that took time.
    pub timed: SourcePlace,
}

/// Where a block is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BlockPlace {
    /// The file.
    pub file: FileId,
    /// Its line, from 1.
    pub line: u32,
    /// Where the user's program called the resident program of the block.
    pub caller: SourcePlace,
}

impl ExecutionPoint {
    /// The innermost place of the block in the programs of the user.
    pub fn user_place(&self) -> SourcePlace {
        self.caller.or(SourcePlace::new(self.file, self.line))
    }

    /// The place of the block, for a later return.
    pub fn block_place(&self) -> BlockPlace {
        BlockPlace { file: self.file, line: self.line, caller: self.caller }
    }

    /// Goes to a block.
    #[inline(always)]
    pub fn go_to(&mut self, place: BlockPlace) {
        (self.file, self.line, self.caller) = (place.file, place.line, place.caller);
    }

    /// The tag of the kernel's current operation.
    pub fn tag(&self) -> Tag {
        Tag { t: self.clock, micro: self.micro, channel: self.channel }
    }

    /// Advances the clock.
    pub fn advance(&mut self, ns: i64) {
        if ns > 0 {
            self.clock = self.clock.saturating_add(ns);
            self.micro = 0;
            self.idle_blocks = 0;
            self.timed = self.user_place();
        }
    }
}

/// Nanoseconds of a duration in seconds, rounded once; never negative, never beyond the maximum duration of a job.
pub fn nanoseconds(seconds: f64) -> i64 {
    const MOST: f64 = 1e18;
    if seconds.is_nan() || seconds <= 0.0 { 0 } else { ((seconds * 1e9).min(MOST) + 0.5) as i64 }
}
