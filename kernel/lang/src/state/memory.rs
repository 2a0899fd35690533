//! How much memory the values of macros keep.
//!
//! Values are counted as they are created. When that count could exceed the budget, all values that macros can still
//! reach are weighed. Invariants: a run is refused before its values take more than the budget. Whether that happens
//! depends on the actions of the macros, never on other owners of a value, nor on time.

use super::MacroState;
use crate::fault::Outcome;
use crate::value::{Elements, MacroValue};
use rustc_hash::FxHashSet;
use std::sync::Arc;

/// Bytes that an element of a sequence takes, with the room that sequences keep to grow.
pub(crate) const ELEMENT: usize = 32;
/// Bytes of an element of an array.
const CELL: usize = 16;
/// Bytes that a text or a sequence takes in addition to its content.
const HEAD: usize = 80;
/// Values that are weighed for a tick.
pub(crate) const PER_TICK: usize = 4;
/// Bytes made after which values are weighed before other macros run within a macro.
const WORTH_WEIGHING: u64 = 1 << 20;

/// Bytes of a text of this length.
pub(crate) const fn text(length: usize) -> usize {
    HEAD + length
}

/// Bytes of a sequence of this length, without those of its texts.
pub(crate) const fn sequence(length: usize) -> usize {
    HEAD + length * ELEMENT
}

/// Bytes of an array of this size, without those of its texts.
pub(crate) const fn array(size: usize) -> usize {
    HEAD + size * CELL
}

/// Adds up the memory of values; memory that several of them share counts once.
#[derive(Debug, Default)]
pub struct MemoryTally {
    shared: FxHashSet<usize>,
    /// Bytes so far.
    pub bytes: u64,
    pub(crate) visited: usize,
    pub(crate) largest: (u64, String),
}

impl MemoryTally {
    /// Adds a value.
    pub fn add(&mut self, value: &MacroValue) {
        self.visited += 1;
        match value {
            MacroValue::Text(held) if self.is_new_text(held) => self.weigh(text(held.len())),
            MacroValue::Sequence(held)
                if self.is_new(Elements::strong_count(held), Elements::as_ptr(held) as usize) =>
            {
                self.weigh(sequence(held.len()));
                held.iter().for_each(|element| self.element(element));
            }
            MacroValue::Array(held) => {
                self.weigh(array(held.elements.len()));
                held.elements.iter().for_each(|element| self.element(element));
            }
            _ => {}
        }
    }

    /// Adds an element: it is a single value.
    fn element(&mut self, value: &MacroValue) {
        self.visited += 1;
        if let MacroValue::Text(held) = value
            && self.is_new_text(held)
        {
            self.weigh(text(held.len()));
        }
    }

    /// Adds bytes that belong to no value.
    pub fn weigh(&mut self, bytes: usize) {
        self.bytes += bytes as u64;
    }

    /// Ends the part of a holder that began at `from` bytes; the largest part is remembered with its name.
    pub fn held_by(&mut self, from: u64, name: impl FnOnce() -> String) {
        let bytes = self.bytes - from;
        if bytes > self.largest.0 {
            self.largest = (bytes, name());
        }
    }

    fn is_new_text(&mut self, held: &Arc<String>) -> bool {
        self.is_new(Arc::strong_count(held), Arc::as_ptr(held) as usize)
    }

    fn is_new(&mut self, owners: usize, place: usize) -> bool {
        // A value with one owner is met once.
        owners == 1 || self.shared.insert(place)
    }
}

/// The memory of macros and its limits.
#[derive(Debug, Default)]
pub(crate) struct MacroMemory {
    /// Bytes that may be kept.
    pub(crate) limit: u64,
    /// Weighed last: values that outlive a run, and the macros that run.
    pub(crate) kept: u64,
    pub(crate) running: u64,
    /// Macros that wait while the host works for them.
    pub(crate) outer: u64,
    /// Made since.
    pub(crate) fresh: u64,
    /// May be made before values are weighed again.
    pub(crate) room: u64,
    /// The largest holder, once the budget is used up.
    pub(crate) over: Option<String>,
}

impl MacroMemory {
    pub(crate) fn new(limit: usize) -> MacroMemory {
        MacroMemory { limit: limit as u64, room: limit as u64, ..MacroMemory::default() }
    }
}

impl MacroState {
    /// Counts bytes that are made.
    #[inline]
    pub fn grow(&mut self, bytes: usize) {
        self.memory.fresh += bytes as u64;
    }

    /// Counts bytes that are made if there is room for them without weighing.
    #[inline]
    pub(crate) fn grows(&mut self, bytes: usize) -> bool {
        let fresh = self.memory.fresh + bytes as u64;
        let room = fresh <= self.memory.room;
        if room {
            self.memory.fresh = fresh;
        }
        room
    }

    /// More was made than can be without weighing.
    #[inline]
    pub(crate) fn is_full(&self) -> bool {
        self.memory.fresh > self.memory.room
    }

    /// Whether other macros may run within this one, so the size of its values should be known.
    pub(crate) fn is_vague(&self) -> bool {
        self.memory.fresh > (self.memory.kept / 4).max(WORTH_WEIGHING)
    }

    /// Whether the budget of memory is used up.
    #[must_use]
    pub fn is_over_memory(&self) -> bool {
        self.memory.over.is_some()
    }

    /// The largest user of memory, once the budget of memory is used up.
    pub fn over_memory(&mut self) -> Option<String> {
        self.memory.over.take()
    }

    /// Counts a value that was made just now: pays for it and for its memory.
    pub(crate) fn made(&mut self, value: &MacroValue) -> Outcome<()> {
        match value {
            MacroValue::Text(held) if Arc::strong_count(held) == 1 => {
                self.grow(text(held.len()));
                if held.len() >= 64 { self.spend(held.len() / 64) } else { Ok(()) }
            }
            MacroValue::Sequence(held) if Elements::strong_count(held) == 1 => {
                self.spend(held.len() / PER_TICK)?;
                self.grow(sequence(held.len()));
                for element in held.iter() {
                    if let MacroValue::Text(held) = element
                        && Arc::strong_count(held) == 1
                    {
                        self.grow(text(held.len()));
                    }
                }
                Ok(())
            }
            MacroValue::Array(held) => {
                self.grow(array(held.elements.len()));
                self.spend(held.elements.len() / PER_TICK)
            }
            _ => Ok(()),
        }
    }

    /// Begins a run within the macros that run already; to be ended with [`inner_ended`](Self::inner_ended).
    pub(crate) fn inner_begins(&mut self) -> (u64, u64, u64) {
        let memory = &mut self.memory;
        let before = (memory.outer, memory.running, memory.fresh);
        memory.outer += memory.running + memory.fresh;
        memory.room = memory.room.saturating_sub(memory.fresh);
        (memory.running, memory.fresh) = (0, 0);
        before
    }

    pub(crate) fn inner_ended(&mut self, (outer, running, fresh): (u64, u64, u64)) {
        let memory = &mut self.memory;
        (memory.outer, memory.running) = (outer, running);
        memory.fresh += fresh;
        memory.room = memory.limit.saturating_sub(memory.outer + memory.running + memory.kept);
    }
}
