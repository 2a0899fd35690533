//! Lines of programs as a pre-processor has read them, kept for the next time they come.
//!
//! Invariant: what is kept is bounded in bytes; when it would be too much all of it goes, so what is kept depends only on
//! the lines that came.

use std::sync::Arc;

use rustc_hash::FxHashMap;

use crate::log::event::FileId;

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
}
