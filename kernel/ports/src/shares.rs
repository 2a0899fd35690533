//! How the memory of a job is divided.

use counterpoint_event::info::ResultBudget;

use crate::options::JobLimits;

/// Division of the memory of a job: a quarter is for data that all kernels share, the rest for the kernels in equal
/// parts; of such a part, two thirds are for the values of macros. Results are made coarser so that they take no more
/// than their part of the rest, for any program.
#[derive(Debug, Clone, Copy)]
pub struct MemoryShares {
    /// Variables and files that all kernels share.
    pub common: u64,
    /// Values of the macros of one kernel.
    pub macros: u64,
    /// Everything else of one kernel.
    pub rest: u64,
}

impl MemoryShares {
    /// The shares of a job with this many kernels.
    #[must_use]
    pub fn of(limits: &JobLimits, kernels: usize) -> Self {
        let common = limits.memory / 4;
        let each = (limits.memory - common) / kernels.max(1) as u64;
        Self { common, macros: each - each / 3, rest: each / 3 }
    }

    /// The shares of a job on a machine with this many channels: several channels have a master, which also runs
    /// macros.
    #[must_use]
    pub fn of_channels(limits: &JobLimits, channels: usize) -> Self {
        Self::of(limits, channels + usize::from(channels > 1))
    }

    /// How much of the rest results and events may take; there is a least that is of any use.
    #[must_use]
    pub fn room(&self) -> ResultBudget {
        ResultBudget {
            path: (self.rest / 2).max(32 << 10),
            bars: (self.rest / 8).max(16 << 10),
            waiting: (self.rest / 8).max(64 << 10),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shares_are_never_more_than_the_memory() {
        for kernels in 1..20 {
            let limits = JobLimits::default();
            let shares = MemoryShares::of(&limits, kernels);
            let all = shares.common + (shares.macros + shares.rest) * kernels as u64;
            assert!(all <= limits.memory && all > limits.memory - 100, "{all}");
        }
    }

    #[test]
    fn results_leave_room_for_the_rest() {
        for kernels in 1..40 {
            let shares = MemoryShares::of(&JobLimits::default(), kernels);
            let room = shares.room();
            assert!((room.path + room.bars + room.waiting) * 4 <= shares.rest * 3, "{kernels}: {room:?}");
        }
    }
}
