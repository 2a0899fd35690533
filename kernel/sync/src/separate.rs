//! Common variables that each channel has of its own: those that one channel reads in vain while another one writes
//! them.
//!
//! *Invariant:* a variable is found at most once for a reader. Facts: reference channel-synchronisation.md 1.3
//! (parameters 6036 and 6037 of Fanuc controls say how many variables are one set for all paths).

use std::collections::BTreeMap;

/// Where a block is: file and line.
pub type Place = (u16, u32);

/// Variables that are remembered for a channel at most, of each kind.
const MOST: usize = 1_000;

/// The separate variables that a channel has used, by number, each with its first place.
#[derive(Debug, Clone, Default)]
pub struct SeparateVariableUses {
    /// Read while they had no value.
    vacant: BTreeMap<u32, Place>,
    /// Written.
    written: BTreeMap<u32, Place>,
}

impl SeparateVariableUses {
    /// Whether nothing has been used.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.vacant.is_empty() && self.written.is_empty()
    }

    /// A variable without a value is read.
    pub fn read_in_vain(&mut self, index: u32, place: Place) {
        if self.vacant.len() < MOST {
            self.vacant.entry(index).or_insert(place);
        }
    }

    /// A variable is written.
    pub fn write(&mut self, index: u32, place: Place) {
        if self.written.len() < MOST {
            self.written.entry(index).or_insert(place);
        }
    }
}

/// A variable that one channel reads and only another one writes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct InVain {
    /// Its number.
    pub index: u32,
    /// Channel that reads it, and where.
    pub reader: (u16, Place),
    /// Channel that writes it, and where.
    pub writer: (u16, Place),
}

/// The uses of channels that have ended.
#[derive(Debug, Clone, Default)]
pub struct Separate {
    ended: Vec<(u16, SeparateVariableUses)>,
}

impl Separate {
    /// Compares the uses of a channel that ends with those of the channels before it, and keeps them.
    pub fn end(&mut self, channel: u16, uses: SeparateVariableUses) -> Vec<InVain> {
        let mut found: Vec<InVain> = Vec::new();
        for (other, theirs) in &self.ended {
            in_vain(&mut found, (channel, &uses), (*other, theirs));
            in_vain(&mut found, (*other, theirs), (channel, &uses));
        }
        self.ended.push((channel, uses));
        found
    }
}

fn in_vain(
    found: &mut Vec<InVain>,
    (reader, reads): (u16, &SeparateVariableUses),
    (writer, writes): (u16, &SeparateVariableUses),
) {
    for (&index, &read) in reads.vacant.iter().filter(|(index, _)| !reads.written.contains_key(index)) {
        let known = found.iter().any(|one| one.index == index && one.reader.0 == reader);
        if let Some(&written) = writes.written.get(&index).filter(|_| !known && reader != writer) {
            found.push(InVain { index, reader: (reader, read), writer: (writer, written) });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_variable_that_only_another_channel_writes_is_found_whoever_ends_first() {
        let mut writer = SeparateVariableUses::default();
        writer.write(500, (0, 3));
        writer.write(500, (0, 9));
        writer.write(501, (0, 4));
        let mut reader = SeparateVariableUses::default();
        reader.read_in_vain(500, (1, 2));
        // A value that a channel itself writes, at any time, is its own.
        reader.read_in_vain(501, (1, 5));
        reader.write(501, (1, 6));
        reader.read_in_vain(502, (1, 7));
        let found = [InVain { index: 500, reader: (2, (1, 2)), writer: (1, (0, 3)) }];
        let mut separate = Separate::default();
        assert_eq!(separate.end(1, writer.clone()), []);
        assert_eq!(separate.end(2, reader.clone()), found);
        let mut separate = Separate::default();
        assert_eq!(separate.end(2, reader), []);
        assert_eq!(separate.end(1, writer), found);
    }
}
