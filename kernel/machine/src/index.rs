//! Positions in the tables of a machine, and tables that such a position cannot miss.
//!
//! Invariant: an id is made by the table that it is a position of, or by the list of built-in identifiers, and tables
//! are never shortened. So every table made for the same rows has an entry for it, and indexing with it cannot fail. A
//! plain number (of the program, or of a macro) becomes an id through [`IdTable::id`], which may return none.

use std::marker::PhantomData;
use std::ops::{Index, IndexMut};

use counterpoint_event::MAX_AXES;

mod sealed {
    /// Making ids is a matter of this module.
    pub trait Make: Copy {
        /// How many ids there are.
        const MOST: usize;
        /// The id of a position below `MOST`.
        fn nth(at: usize) -> Self;
        /// The id of a position, none if there can be no such.
        fn make(at: usize) -> Option<Self> {
            (at < Self::MOST).then(|| Self::nth(at))
        }
        /// The position.
        fn at(self) -> usize;
    }
}

/// A position in tables of one kind.
pub trait Id: sealed::Make + PartialEq {}

macro_rules! ids {
    ($($(#[$doc:meta])* $name:ident($number:ty) < $most:expr;)*) => { $(
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub struct $name($number);

        impl $name {
            /// The position.
            #[must_use]
            #[inline]
            pub const fn index(self) -> usize {
                self.0 as usize
            }
        }

        impl sealed::Make for $name {
            const MOST: usize = $most;

            #[inline]
            fn nth(at: usize) -> Self {
                Self(at as $number)
            }

            #[inline]
            fn at(self) -> usize {
                self.index()
            }
        }

        impl Id for $name {}
    )* };
}

/// Largest number of registers.
pub const REGISTERS: usize = 100;

/// Ids of 16 bits.
const WORD: usize = 1 << u16::BITS;

ids! {
    /// A code identifier, which fires an action.
    CodeId(u16) < WORD;
    /// A data identifier, which supplies a value to an action.
    DataId(u16) < WORD;
    /// A row of the code table.
    CodeRowId(u16) < WORD;
    /// A row of the data table.
    DataRowId(u16) < WORD;
    /// A macro of codes.
    CodeMacroId(u16) < WORD;
    /// A macro of data.
    DataMacroId(u16) < WORD;
    /// A register: a letter of the program, or a text.
    RegisterId(u8) < REGISTERS;
    /// An axis of the machine.
    AxisId(u16) < WORD;
    /// A spindle of the machine.
    SpindleId(u16) < WORD;
    /// An axis of a channel: its place in the channel's list.
    AxisSlot(u8) < MAX_AXES;
}

impl CodeId {
    /// The built-in code at a position of the list.
    pub(crate) const fn built_in(at: u16) -> Self {
        Self(at)
    }
}

impl DataId {
    /// The built-in data at a position of the list.
    pub(crate) const fn built_in(at: u16) -> Self {
        Self(at)
    }
}

/// A list with an entry for every id of its kind.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct IdTable<I, T> {
    entries: Vec<T>,
    ids: PhantomData<fn(I)>,
}

impl<I, T> Default for IdTable<I, T> {
    fn default() -> Self {
        Self { entries: Vec::new(), ids: PhantomData }
    }
}

impl<I: Id, T> IdTable<I, T> {
    /// Adds an entry; none if the table has as many as there are ids, and the entry is dropped.
    pub fn push(&mut self, entry: T) -> Option<I> {
        let id = I::make(self.entries.len())?;
        self.entries.push(entry);
        Some(id)
    }

    /// The id of a position that may not exist.
    #[must_use]
    pub fn id(&self, at: usize) -> Option<I> {
        I::make(at).filter(|_| at < self.entries.len())
    }

    /// All ids.
    pub fn ids(&self) -> impl DoubleEndedIterator<Item = I> + Clone + use<I, T> {
        (0..self.entries.len()).map(I::nth)
    }

    /// All entries with their ids.
    pub fn entries(&self) -> impl DoubleEndedIterator<Item = (I, &T)> + Clone {
        self.entries.iter().enumerate().map(|(at, entry)| (I::nth(at), entry))
    }

    /// The first entry that is meant.
    pub fn find(&self, is: impl FnMut(&T) -> bool) -> Option<I> {
        self.entries.iter().position(is).map(I::nth)
    }

    /// A table for the same ids.
    pub fn map<U>(&self, mut of: impl FnMut(I, &T) -> U) -> IdTable<I, U> {
        self.entries().map(|(id, entry)| of(id, entry)).collect()
    }
}

/// Entries beyond the last id are dropped.
impl<I: Id, T> FromIterator<T> for IdTable<I, T> {
    fn from_iter<L: IntoIterator<Item = T>>(list: L) -> Self {
        let entries = list.into_iter().take(I::MOST).collect();
        Self { entries, ids: PhantomData }
    }
}

impl<I: Id, T> Index<I> for IdTable<I, T> {
    type Output = T;

    #[inline]
    #[expect(
        clippy::indexing_slicing,
        reason = "the invariant of the module: the id was made by a table of the same rows"
    )]
    fn index(&self, id: I) -> &T {
        &self.entries[id.at()]
    }
}

impl<I: Id, T> IndexMut<I> for IdTable<I, T> {
    #[inline]
    #[expect(
        clippy::indexing_slicing,
        reason = "the invariant of the module: the id was made by a table of the same rows"
    )]
    fn index_mut(&mut self, id: I) -> &mut T {
        &mut self.entries[id.at()]
    }
}

/// Data that a channel has for each of its axes, with places for the maximum number of axes. A position is one; it is a
/// plain array because events carry it.
pub trait BySlot<T> {
    /// The value of an axis.
    fn at(&self, slot: AxisSlot) -> T;
    /// The value of an axis, to be changed.
    fn at_mut(&mut self, slot: AxisSlot) -> &mut T;
}

impl<T: Copy> BySlot<T> for [T; MAX_AXES] {
    #[inline]
    #[expect(clippy::indexing_slicing, reason = "a slot is below MAX_AXES")]
    fn at(&self, slot: AxisSlot) -> T {
        self[slot.index() & (MAX_AXES - 1)]
    }

    #[inline]
    #[expect(clippy::indexing_slicing, reason = "a slot is below MAX_AXES")]
    fn at_mut(&mut self, slot: AxisSlot) -> &mut T {
        &mut self[slot.index() & (MAX_AXES - 1)]
    }
}

const _: () = assert!(MAX_AXES.is_power_of_two(), "slots are masked, so that the compiler leaves out the check");

/// The bit of each register. A load is cheaper than a shift of 128 bits for every word of a block.
#[expect(
    clippy::indexing_slicing,
    reason = "the indices are within the array, as its computation at compile time shows"
)]
static REGISTER_BITS: [u128; u128::BITS as usize] = {
    let mut bits = [1; u128::BITS as usize];
    let mut register = 1;
    while register < bits.len() {
        bits[register] = bits[register - 1] << 1;
        register += 1;
    }
    bits
};

impl RegisterId {
    /// Its bit in a set of registers.
    #[must_use]
    #[inline]
    #[expect(clippy::indexing_slicing, reason = "the index is masked")]
    pub fn bit(self) -> u128 {
        REGISTER_BITS[self.index() % REGISTER_BITS.len()]
    }
}

impl AxisSlot {
    /// Its bit in a set of axes.
    #[must_use]
    #[inline]
    pub const fn bit(self) -> u8 {
        1 << self.0
    }
}

impl<I, T> IdTable<I, T> {
    /// The entries, to be changed.
    pub fn iter_mut(&mut self) -> std::slice::IterMut<'_, T> {
        self.entries.iter_mut()
    }

    /// All entries, in order.
    pub fn iter(&self) -> std::slice::Iter<'_, T> {
        self.entries.iter()
    }

    /// All entries, in order.
    #[must_use]
    pub fn as_slice(&self) -> &[T] {
        &self.entries
    }

    /// How many entries there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Whether there is no entry.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }
}

impl<'t, I, T> IntoIterator for &'t IdTable<I, T> {
    type Item = &'t T;
    type IntoIter = std::slice::Iter<'t, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.entries.iter()
    }
}

/// The id of a position.
#[cfg(test)]
pub(crate) fn nth<I: Id>(at: usize) -> I {
    I::nth(at)
}

/// Positions of ids, for comparing.
#[cfg(test)]
pub(crate) fn places<I: Id>(ids: &[I]) -> Vec<usize> {
    ids.iter().map(|id| id.at()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_come_from_tables_and_find_their_entries() {
        let mut rows: IdTable<CodeRowId, &str> = IdTable::default();
        let first = rows.push("a").unwrap();
        let second = rows.push("b").unwrap();
        assert_eq!((rows[first], rows[second]), ("a", "b"));
        assert_eq!(rows.find(|row| *row == "b"), Some(second));
        assert_eq!(rows.ids().collect::<Vec<_>>(), [first, second]);
        let lengths = rows.map(|id, row| (id, row.len()));
        assert_eq!(lengths[second], (second, 1));
        assert_eq!((rows.id(1), rows.id(2)), (Some(second), None));
        assert_eq!(rows.iter().copied().collect::<IdTable<CodeRowId, _>>(), rows);
    }

    #[test]
    fn a_channel_has_no_more_axes_than_a_position_has_places() {
        let axes: IdTable<AxisSlot, ()> = std::iter::repeat_n((), MAX_AXES + 1).collect();
        assert_eq!(axes.len(), MAX_AXES);
        let mut position = [0.0; MAX_AXES];
        for slot in axes.ids() {
            *position.at_mut(slot) = f64::from(slot.bit());
        }
        assert_eq!(position, [1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 128.0]);
    }

    #[test]
    fn a_table_has_no_more_entries_than_ids() {
        let mut full: IdTable<CodeRowId, ()> = std::iter::repeat_n((), 70_000).collect();
        assert_eq!(full.len(), 65_536);
        assert_eq!(full.push(()), None);
        assert_eq!(full.ids().count(), 65_536);
    }
}
