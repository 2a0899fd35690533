//! Which rules of a tape editor are meant.

/// Rules by number, from 0; a machine has 256 at most.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct TapeRuleSet([u64; 4]);

impl TapeRuleSet {
    /// Switches a rule.
    pub fn set(&mut self, rule: usize, on: bool) {
        if let Some(bits) = self.0.get_mut(rule / 64) {
            let bit = 1 << (rule % 64);
            *bits = if on { *bits | bit } else { *bits & !bit };
        }
    }

    /// Whether a rule is on.
    pub fn has(&self, rule: usize) -> bool {
        self.0.get(rule / 64).is_some_and(|bits| bits & 1 << (rule % 64) != 0)
    }

    /// Whether no rule is in both.
    #[inline]
    pub(super) fn is_apart(&self, from: &Self) -> bool {
        self.0.iter().zip(&from.0).fold(0, |both, (one, other)| both | one & other) == 0
    }

    /// The first rule from `from` on that is in both.
    pub(super) fn next(&self, from: usize, and: &Self) -> Option<usize> {
        (from / 64..4).find_map(|word| {
            let both = self.0.get(word)? & and.0.get(word)?;
            let wanted = if word == from / 64 { both & (u64::MAX << (from % 64)) } else { both };
            (wanted != 0).then(|| word * 64 + wanted.trailing_zeros() as usize)
        })
    }
}
