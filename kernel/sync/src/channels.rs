//! Numbers of channels and their places in the lists of a job.
//!
//! Invariant: numbers are names: they need not start at 1 nor follow one another. Lists are dense and in ascending
//! order of the numbers.

/// The channels of a job.
#[derive(Debug, Clone, Default)]
pub struct Channels {
    numbers: Box<[u16]>,
    /// Place in `numbers` by number, plus one; 0: no such channel.
    places: Box<[u16]>,
}

impl Channels {
    /// Channels with these numbers, ascending.
    pub fn new(numbers: impl IntoIterator<Item = u16>) -> Self {
        let numbers: Box<[u16]> = numbers.into_iter().collect();
        let largest = numbers.iter().copied().max().unwrap_or(0);
        let mut places = vec![0; usize::from(largest) + 1].into_boxed_slice();
        for (number, place) in numbers.iter().zip(1..) {
            if let Some(slot) = places.get_mut(usize::from(*number)) {
                *slot = place;
            }
        }
        Self { numbers, places }
    }

    /// Place of a channel in the lists; beyond their end if there is no such channel.
    #[inline]
    pub fn index(&self, number: u16) -> usize {
        usize::from(self.places.get(usize::from(number)).copied().unwrap_or(0)).wrapping_sub(1)
    }

    /// Numbers, ascending.
    pub fn numbers(&self) -> &[u16] {
        &self.numbers
    }

    /// Number of channels.
    pub fn count(&self) -> usize {
        self.numbers.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_dense_places() {
        let channels = Channels::new([1, 3, 99]);
        assert_eq!([1, 3, 99].map(|n| channels.index(n)), [0, 1, 2]);
        for absent in [0, 2, 4, 100, u16::MAX] {
            assert!(channels.index(absent) >= channels.count(), "{absent}");
        }
        assert_eq!((channels.numbers(), channels.count()), (&[1, 3, 99][..], 3));
    }
}
