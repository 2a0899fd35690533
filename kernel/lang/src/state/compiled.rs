//! Formats and regular expressions that were compiled, by their texts.
//!
//! *Invariant:* the remembered texts of either kind take at most [`MOST_REMEMBERED`] bytes and [`MOST`] texts.

use crate::format::StringFormat;
use crate::pattern::TextPattern;
use rustc_hash::FxHashMap;
use std::hash::Hash;
use std::sync::Arc;

/// Bytes of one kind.
const MOST_REMEMBERED: usize = 4 << 20;
/// Texts of one kind.
const MOST: usize = 1000;

/// One kind.
#[derive(Debug)]
struct Cache<K, V> {
    entries: FxHashMap<K, Arc<V>>,
    bytes: usize,
}

impl<K, V> Default for Cache<K, V> {
    fn default() -> Self {
        Cache { entries: FxHashMap::default(), bytes: 0 }
    }
}

impl<K: Eq + Hash, V> Cache<K, V> {
    fn remember(&mut self, key: K, value: &Arc<V>, size: usize) {
        if self.entries.len() >= MOST || self.bytes + size > MOST_REMEMBERED {
            self.entries.clear();
            self.bytes = 0;
        }
        if size <= MOST_REMEMBERED {
            self.bytes += size;
            self.entries.insert(key, Arc::clone(value));
        }
    }
}

/// Compiled formats and regular expressions.
#[derive(Debug, Default)]
pub struct Compiled {
    formats: Cache<(String, bool), StringFormat>,
    patterns: Cache<String, TextPattern>,
}

impl Compiled {
    pub(super) fn format(&self, text: &str, input: bool) -> Option<Arc<StringFormat>> {
        self.formats.entries.get(&(text.to_owned(), input)).cloned()
    }

    pub(super) fn remember_format(&mut self, text: &str, input: bool, format: &Arc<StringFormat>) {
        self.formats.remember((text.to_owned(), input), format, text.len() + format.size());
    }

    pub(super) fn pattern(&self, text: &str) -> Option<Arc<TextPattern>> {
        self.patterns.entries.get(text).cloned()
    }

    pub(super) fn remember_pattern(&mut self, text: &str, pattern: &Arc<TextPattern>) {
        self.patterns.remember(text.to_owned(), pattern, text.len() + pattern.size());
    }
}
