//! What interpreters have read of programs, kept for the next time: lines, and tables of labels and blocks.
//!
//! *Invariant:* what is kept is bounded in bytes; when it would be too much all of it goes, so what is kept depends only on
//! what was read.

use std::hash::Hash;
use std::sync::Arc;

use rustc_hash::FxHashMap;

use counterpoint_event::FileId;

/// Bytes of lines that are kept.
const MOST: usize = 8 << 20;
/// Bytes that a line takes besides what stands in it.
const LINE: usize = 256;
/// Bytes that a byte of its text takes once it is read.
const PER_BYTE: usize = 16;

/// Lines by file and line number.
#[derive(Debug)]
pub(crate) struct Kept<L> {
    lines: FxHashMap<(FileId, u32), Arc<L>>,
    bytes: usize,
}

impl<L> Default for Kept<L> {
    fn default() -> Self {
        Self { lines: FxHashMap::default(), bytes: 0 }
    }
}

impl<L> Kept<L> {
    /// A line that was kept.
    #[inline]
    pub(crate) fn get(&self, key: (FileId, u32)) -> Option<&Arc<L>> {
        self.lines.get(&key)
    }

    /// Keeps a line whose text has so many bytes.
    pub(crate) fn insert(&mut self, key: (FileId, u32), line: &Arc<L>, text: usize) {
        let size = LINE + text * PER_BYTE;
        if self.bytes + size > MOST {
            self.clear();
        }
        if size <= MOST {
            self.bytes += size;
            self.lines.insert(key, Arc::clone(line));
        }
    }

    /// Forgets all lines.
    pub(crate) fn clear(&mut self) {
        // The room of a large table is given back, too.
        self.lines = FxHashMap::default();
        self.bytes = 0;
    }

    /// Bytes that the lines take, about.
    pub(crate) fn bytes(&self) -> usize {
        self.bytes
    }
}

/// Bytes of tables that are kept.
const MOST_OF_TABLES: usize = 64 << 20;

/// A table of what is in a program or file.
pub(super) trait Table {
    /// Bytes that it takes, about.
    fn bytes(&self) -> usize;
}

/// Tables by file, or by program.
#[derive(Debug)]
pub(super) struct Tables<K, T> {
    tables: FxHashMap<K, Arc<T>>,
    bytes: usize,
}

impl<K, T> Default for Tables<K, T> {
    fn default() -> Self {
        Self { tables: FxHashMap::default(), bytes: 0 }
    }
}

impl<K: Eq + Hash, T: Table> Tables<K, T> {
    /// The table of a file or program, made when it is wanted for the first time.
    pub(super) fn get(&mut self, key: K, make: impl FnOnce() -> T) -> Arc<T> {
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
    pub(super) fn clear(&mut self) {
        self.tables = FxHashMap::default();
        self.bytes = 0;
    }

    /// Bytes that they take, about.
    pub(super) fn bytes(&self) -> usize {
        self.bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_million_lines_stay_within_the_bound() {
        let mut kept = Kept::default();
        for line in 0..1_000_000 {
            kept.insert((0, line), &Arc::new(line), 20);
            assert!(kept.bytes() <= MOST && kept.lines.len() * LINE <= MOST);
        }
        assert_eq!(kept.get((0, 999_999)).map(|line| **line), Some(999_999));
        assert_eq!(kept.get((0, 0)), None);
        kept.insert((0, 5), &Arc::new(5), MOST);
        assert_eq!(kept.get((0, 5)), None, "larger than all that is kept");
    }

    impl Table for usize {
        fn bytes(&self) -> usize {
            *self
        }
    }

    #[test]
    fn tables_stay_within_their_bound() {
        let mut tables = Tables::default();
        for file in 0..100 {
            tables.get(file, || MOST_OF_TABLES / 8);
            assert!(tables.bytes() <= MOST_OF_TABLES);
        }
        assert_eq!(*tables.get(99, || 0), MOST_OF_TABLES / 8, "made once");
    }
}
