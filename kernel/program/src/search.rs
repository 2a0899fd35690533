//! Where jumps and calls lead: one table of labels and one search for all dialects.
//!
//! *Invariant:* the result depends only on the text of the program and on the start of the search.

use std::borrow::Borrow;
use std::hash::Hash;

use rustc_hash::FxHashMap;

use crate::kept::CachedTable;

/// In which order a control looks at the blocks with a label.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LabelSearchOrder {
    /// From the start of the program.
    FromTop,
    /// From the next block on, then from the start of the program.
    Around,
    /// From the next block on.
    Forward,
    /// Back from this block, which counts too.
    Back,
    /// Back from this block, then from the next one on.
    BackThenForward,
}

impl LabelSearchOrder {
    /// One of some places in ascending order, none of them before `first` or after `last`; `next` comes after the block
    /// that looks.
    pub fn find<T: Ord + Copy>(self, places: &[T], next: T, (first, last): (T, T)) -> Option<T> {
        let from = places.partition_point(|place| *place < first);
        let to = places.partition_point(|place| *place <= last).max(from);
        let inside = places.get(from..to).unwrap_or_default();
        let (before, after) = inside.split_at_checked(inside.partition_point(|place| *place < next))?;
        let (back, forward) = (before.last(), after.first());
        match self {
            Self::FromTop => inside.first(),
            Self::Around => forward.or(inside.first()),
            Self::Forward => forward,
            Self::Back => back,
            Self::BackThenForward => back.or(forward),
        }
        .copied()
    }
}

/// Lines of a file by label.
#[derive(Debug)]
pub struct Labels<K> {
    lines: FxHashMap<K, Vec<u32>>,
}

impl<K> Default for Labels<K> {
    fn default() -> Self {
        Self { lines: FxHashMap::default() }
    }
}

impl<K: Eq + Hash> Labels<K> {
    /// A label at a line; lines come in ascending order.
    pub fn add(&mut self, label: K, line: u32) {
        self.lines.entry(label).or_default().push(line);
    }

    /// Lines with a label, ascending.
    pub fn lines<Q: Eq + Hash + ?Sized>(&self, label: &Q) -> &[u32]
    where
        K: Borrow<Q>,
    {
        self.lines.get(label).map_or(&[], Vec::as_slice)
    }

    /// The line to go to from another one, within some lines.
    pub fn find<Q: Eq + Hash + ?Sized>(
        &self,
        label: &Q,
        search: LabelSearchOrder,
        here: u32,
        around: (u32, u32),
    ) -> Option<u32>
    where
        K: Borrow<Q>,
    {
        search.find(self.lines(label), here.saturating_add(1), around)
    }
}

impl<K> CachedTable for Labels<K> {
    fn bytes(&self) -> usize {
        self.lines.values().map(|lines| 80 + lines.len() * 4).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_control_looks_in_its_order() {
        let places = [2, 5, 9, 12];
        for (search, next, expected) in [
            (LabelSearchOrder::Around, 1, Some(5)),
            (LabelSearchOrder::Around, 6, Some(9)),
            (LabelSearchOrder::Around, 10, Some(5)),
            (LabelSearchOrder::FromTop, 10, Some(5)),
            (LabelSearchOrder::Forward, 6, Some(9)),
            (LabelSearchOrder::Forward, 10, None),
            (LabelSearchOrder::Back, 6, Some(5)),
            (LabelSearchOrder::Back, 5, None),
            (LabelSearchOrder::BackThenForward, 5, Some(5)),
            (LabelSearchOrder::BackThenForward, 10, Some(9)),
        ] {
            assert_eq!(search.find(&places, next, (4, 10)), expected, "{search:?} {next}");
        }
        assert_eq!(LabelSearchOrder::Around.find(&places, 1, (6, 8)), None);
        assert_eq!(LabelSearchOrder::Around.find(&places, 1, (8, 6)), None);
    }

    #[test]
    fn a_label_may_stand_at_several_lines() {
        let mut labels = Labels::default();
        for (label, line) in [("A", 1), ("B", 2), ("A", 7)] {
            labels.add(label.to_owned(), line);
        }
        assert_eq!(labels.find("A", LabelSearchOrder::Around, 1, (1, 9)), Some(7));
        assert_eq!(labels.find("A", LabelSearchOrder::Around, 7, (1, 9)), Some(1));
        assert_eq!((labels.find("C", LabelSearchOrder::Around, 1, (1, 9)), labels.lines("B")), (None, &[2][..]));
        assert!(labels.bytes() > 0);
    }
}
