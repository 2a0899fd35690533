//! Memory of variables that all kernels share.

use counterpoint_lang::value::MacroValue;
use counterpoint_lang::vm::MemoryTally;

/// Variables that many kernels may write to, with their memory. They are weighed when the text written since could be
/// too much.
#[derive(Debug, Clone, Default)]
pub struct Hoard {
    kept: u64,
    fresh: u64,
}

impl Hoard {
    /// Counts a change that adds this many bytes at most; true if all together is more than `limit`.
    pub fn grown(&mut self, bytes: usize, limit: u64, weigh: impl FnOnce() -> u64) -> bool {
        self.fresh += bytes as u64;
        if self.kept + self.fresh <= limit {
            return false;
        }
        (self.kept, self.fresh) = (weigh(), 0);
        self.kept > limit - limit / 8
    }
}

/// Bytes of values.
pub fn weight<'v>(values: impl Iterator<Item = &'v MacroValue>) -> u64 {
    let mut scale = MemoryTally::default();
    values.for_each(|value| scale.add(value));
    scale.bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hoard_is_weighed_when_it_could_be_too_much() {
        let mut hoard = Hoard::default();
        assert!(!hoard.grown(600, 1000, || unreachable!("it fits for sure")));
        assert!(!hoard.grown(600, 1000, || 100), "most of it is gone again");
        assert!(!hoard.grown(800, 1000, || unreachable!("it fits for sure")));
        assert!(hoard.grown(200, 1000, || 900), "too little would be left");
    }
}
