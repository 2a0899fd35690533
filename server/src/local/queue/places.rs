//! Places of ordinals among those that are left.
//!
//! Invariant: a question about a place costs the logarithm of the distance between the first and the last ordinal.

/// Counts of ordinals in a binary indexed tree. Ordinals begin at 1 and ascend.
#[derive(Debug, Default)]
pub(super) struct OrdinalTree {
    /// `tree[i]` counts the ordinals of a range that ends with `base + i`; `tree[0]` is not used.
    tree: Vec<u32>,
    base: u64,
}

/// Smallest tree.
const SMALLEST: usize = 1024;

impl OrdinalTree {
    /// Counts an ordinal that is larger than all before; `kept` are those that have not been removed, ascending,
    /// without the new one.
    pub(super) fn push<'a>(&mut self, ordinal: u64, kept: impl Iterator<Item = &'a u64> + Clone) {
        if ordinal.saturating_sub(self.base) >= self.tree.len() as u64 {
            self.base = kept.clone().next().map_or(ordinal, |first| *first) - 1;
            let span = usize::try_from(ordinal - self.base).unwrap_or(usize::MAX / 4);
            self.tree = vec![0; (2 * span).max(SMALLEST)];
            for ordinal in kept {
                self.add(*ordinal, 1);
            }
        }
        self.add(ordinal, 1);
    }

    pub(super) fn remove(&mut self, ordinal: u64) {
        self.add(ordinal, -1);
    }

    fn index(&self, ordinal: u64) -> usize {
        usize::try_from(ordinal.saturating_sub(self.base)).unwrap_or(usize::MAX)
    }

    fn add(&mut self, ordinal: u64, count: i32) {
        let mut at = self.index(ordinal);
        while let Some(slot) = self.tree.get_mut(at).filter(|_| at > 0) {
            *slot = slot.wrapping_add_signed(count);
            at += at & at.wrapping_neg();
        }
    }

    /// Ordinals before this one.
    pub(super) fn before(&self, ordinal: u64) -> usize {
        let (mut at, mut sum) = (self.index(ordinal).saturating_sub(1), 0);
        while at > 0 {
            sum += self.tree.get(at).map_or(0, |count| *count as usize);
            at &= at - 1;
        }
        sum
    }
}
