//! Sets of channels.

use std::fmt::Write as _;

/// Set of channels, bit `n − 1` for channel `n`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct ChannelSet(pub u128);

impl ChannelSet {
    /// All channels up to `count`.
    pub fn up_to(count: u16) -> Self {
        (1..=count).collect()
    }

    /// With one more channel; numbers outside 1–128 are ignored.
    #[must_use]
    pub fn with(self, channel: u16) -> Self {
        if (1..=128).contains(&channel) { Self(self.0 | 1 << (channel - 1)) } else { self }
    }

    /// Without a channel.
    #[must_use]
    pub fn without(self, channel: u16) -> Self {
        Self(self.0 & !Self::default().with(channel).0)
    }

    /// Channels of both.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    /// Membership.
    pub fn has(self, channel: u16) -> bool {
        (1..=128).contains(&channel) && self.0 & (1 << (channel - 1)) != 0
    }

    /// How many.
    pub fn count(self) -> u16 {
        self.0.count_ones() as u16
    }

    /// No channel.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Channels, ascending.
    pub fn iter(self) -> impl Iterator<Item = u16> {
        let mut left = self.0;
        std::iter::from_fn(move || {
            let channel = left.trailing_zeros() as u16 + 1;
            left &= left.checked_sub(1)?;
            Some(channel)
        })
    }
}

impl FromIterator<u16> for ChannelSet {
    fn from_iter<I: IntoIterator<Item = u16>>(channels: I) -> Self {
        channels.into_iter().fold(Self::default(), Self::with)
    }
}

/// `1, 2 and 3`.
pub fn words(channels: &[u16]) -> String {
    let mut out = String::new();
    for (index, channel) in channels.iter().enumerate() {
        let separator = match index {
            0 => "",
            i if i + 1 == channels.len() => " and ",
            _ => ", ",
        };
        let _ = write!(out, "{separator}{channel}");
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_hold_channels_1_to_128() {
        let set: ChannelSet = [3, 1, 128, 0, 129].into_iter().collect();
        assert_eq!(set.iter().collect::<Vec<_>>(), [1, 3, 128]);
        assert!(set.has(128) && !set.has(0) && !set.has(129) && set.count() == 3);
        assert_eq!(set.without(3).without(0).and(ChannelSet::up_to(5)), ChannelSet::up_to(1));
    }

    #[test]
    fn channels_in_words() {
        assert_eq!(words(&[1]), "1");
        assert_eq!(words(&[1, 2, 10]), "1, 2 and 10");
    }
}
