//! Parsed parts of programs, kept for the next time: lines, and tables of labels and blocks.
//!
//! *Invariant:* the store is bounded in bytes. When it would exceed its bound, all of it is dropped, so its content
//! depends only on the texts that were read.

use std::hash::Hash;
use std::sync::Arc;

use rustc_hash::FxHashMap;

use counterpoint_event::FileId;

/// Bytes of lines that are kept.
const MOST: usize = 8 << 20;
/// Bytes that a line takes in addition to its content.
const LINE: usize = 256;
/// Bytes that a byte of its text takes once it is read.
const PER_BYTE: usize = 16;

/// Lines that are at hand without a search: those of a loop of usual length. A power of two.
const AT_HAND: usize = 64;

/// File and line number.
type Key = (FileId, u32);

/// Lines by file and line number.
#[derive(Debug)]
pub struct LineCache<L> {
    lines: FxHashMap<Key, Arc<L>>,
    /// Those that were requested last, each at the place that its number gives it; none where it is not kept, or taken.
    at_hand: Box<[Option<Arc<L>>; AT_HAND]>,
    /// The key requested at each place.
    keys: Box<[Key; AT_HAND]>,
    bytes: usize,
}

/// No line has the number 0.
const NOTHING: Key = (0, 0);

impl<L> Default for LineCache<L> {
    fn default() -> Self {
        let (at_hand, keys) = (Box::new([const { None }; AT_HAND]), Box::new([NOTHING; AT_HAND]));
        Self { lines: FxHashMap::default(), at_hand, keys, bytes: 0 }
    }
}

impl<L> LineCache<L> {
    /// A line that was kept.
    #[inline(always)]
    pub fn get(&mut self, key: Key) -> Option<&Arc<L>> {
        let place = key.1 as usize % AT_HAND;
        if self.keys.get(place) != Some(&key) {
            self.take_in_hand(key);
        }
        self.at_hand.get(place)?.as_ref()
    }

    /// Takes a line that was kept out of those at hand; [`give_back`](Self::give_back) makes it come at once again.
    #[inline(always)]
    pub fn take(&mut self, key: Key) -> Option<Arc<L>> {
        let place = key.1 as usize % AT_HAND;
        if self.keys.get(place) != Some(&key) {
            self.take_in_hand(key);
        }
        let line = self.at_hand.get_mut(place)?.take();
        if let Some(key) = self.keys.get_mut(place) {
            *key = NOTHING;
        }
        line
    }

    /// Puts a line back to those at hand, unless another one has come there meanwhile.
    #[inline(always)]
    pub fn give_back(&mut self, key: Key, line: Arc<L>) {
        let place = key.1 as usize % AT_HAND;
        if let (Some(known), Some(slot)) = (self.keys.get_mut(place), self.at_hand.get_mut(place))
            && *known == NOTHING
        {
            (*known, *slot) = (key, Some(line));
        }
    }

    /// Looks for a line that another one has the place of.
    #[inline(never)]
    fn take_in_hand(&mut self, key: Key) {
        let place = key.1 as usize % AT_HAND;
        if let (Some(known), Some(slot)) = (self.keys.get_mut(place), self.at_hand.get_mut(place)) {
            (*known, *slot) = (key, self.lines.get(&key).map(Arc::clone));
        }
    }

    /// Keeps a line whose text has this many bytes.
    pub fn insert(&mut self, key: Key, line: &Arc<L>, text: usize) {
        let size = LINE + text * PER_BYTE;
        if self.bytes + size > MOST {
            self.clear();
        }
        if size <= MOST {
            self.bytes += size;
            self.lines.insert(key, Arc::clone(line));
            if let Some(known) = self.keys.get_mut(key.1 as usize % AT_HAND) {
                *known = NOTHING;
            }
        }
    }

    /// Forgets all lines.
    pub fn clear(&mut self) {
        // The room of a large table is given back, too.
        self.lines = FxHashMap::default();
        self.at_hand.fill_with(|| None);
        self.keys.fill(NOTHING);
        self.bytes = 0;
    }

    /// Bytes that the lines take, about.
    pub fn bytes(&self) -> usize {
        self.bytes
    }
}

/// Bytes of tables that are kept.
const MOST_OF_TABLES: usize = 64 << 20;

/// A table of the content of a program or file.
pub trait CachedTable {
    /// Bytes that it takes, about.
    fn bytes(&self) -> usize;
}

/// Tables by file, or by program.
#[derive(Debug)]
pub struct TableCache<K, T> {
    tables: FxHashMap<K, Arc<T>>,
    /// The table that was requested last.
    at_hand: Option<(K, Arc<T>)>,
    bytes: usize,
}

impl<K, T> Default for TableCache<K, T> {
    fn default() -> Self {
        Self { tables: FxHashMap::default(), at_hand: None, bytes: 0 }
    }
}

impl<K: Copy + Eq + Hash, T: CachedTable> TableCache<K, T> {
    /// The table of a file or program, made when it is wanted for the first time.
    #[inline]
    pub fn get(&mut self, key: K, make: impl FnOnce() -> T) -> Arc<T>
    where
        T: Default,
    {
        Arc::clone(self.look(key, make))
    }

    /// The same for a look at it.
    #[inline]
    pub fn look(&mut self, key: K, make: impl FnOnce() -> T) -> &Arc<T>
    where
        T: Default,
    {
        if self.at_hand.as_ref().is_none_or(|(of, _)| *of != key) {
            self.at_hand = Some((key, self.look_up(key, make)));
        }
        &self.at_hand.get_or_insert_with(|| (key, Arc::default())).1
    }

    /// The same for another key than the last one.
    #[inline(never)]
    fn look_up(&mut self, key: K, make: impl FnOnce() -> T) -> Arc<T> {
        if let Some(table) = self.tables.get(&key) {
            return Arc::clone(table);
        }
        let table = Arc::new(make());
        let size = table.bytes();
        if self.bytes + size > MOST_OF_TABLES {
            self.clear();
        }
        self.bytes += size;
        self.tables.insert(key, Arc::clone(&table));
        table
    }

    /// Forgets all tables.
    pub fn clear(&mut self) {
        self.tables = FxHashMap::default();
        self.at_hand = None;
        self.bytes = 0;
    }

    /// Bytes that they take, about.
    pub fn bytes(&self) -> usize {
        self.bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_million_lines_stay_within_the_bound() {
        let mut kept = LineCache::default();
        for line in 0..1_000_000 {
            kept.insert((0, line), &Arc::new(line), 20);
            assert!(kept.bytes() <= MOST && kept.lines.len() * LINE <= MOST);
        }
        assert_eq!(kept.get((0, 999_999)).map(|line| **line), Some(999_999));
        assert_eq!(kept.get((0, 0)), None);
        kept.insert((0, 5), &Arc::new(5), MOST);
        assert_eq!(kept.get((0, 5)), None, "larger than all that is kept");
    }

    #[test]
    fn a_line_at_hand_is_that_of_its_file_and_the_latest() {
        let mut kept = LineCache::default();
        let number = |kept: &mut LineCache<u32>, key| kept.get(key).map(|line| **line);
        let far = 5 + AT_HAND as u32;
        for (file, line) in [(0, 5), (1, 5), (0, far)] {
            kept.insert((file, line), &Arc::new(u32::from(file) * 1000 + line), 20);
        }
        for _ in 0..2 {
            assert_eq!(number(&mut kept, (0, 5)), Some(5));
            assert_eq!(number(&mut kept, (1, 5)), Some(1005));
            assert_eq!(number(&mut kept, (0, far)), Some(far));
            assert_eq!(number(&mut kept, (2, 5)), None);
        }
        kept.insert((0, far), &Arc::new(7), 20);
        assert_eq!(number(&mut kept, (0, far)), Some(7));
        kept.clear();
        assert_eq!(number(&mut kept, (0, far)), None);
    }

    impl CachedTable for usize {
        fn bytes(&self) -> usize {
            *self
        }
    }

    #[test]
    fn tables_stay_within_their_bound() {
        let mut tables = TableCache::default();
        for file in 0..100 {
            tables.get(file, || MOST_OF_TABLES / 8);
            assert!(tables.bytes() <= MOST_OF_TABLES);
        }
        assert_eq!(*tables.get(99, || 0), MOST_OF_TABLES / 8, "made once");
        assert_eq!(*tables.get(98, || 0), MOST_OF_TABLES / 8, "not the one that was asked for last");
    }
}
