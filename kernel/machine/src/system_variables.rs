//! Numbered system variables of the pre-processor: the meaning of each number, as rows of the machine.
//!
//! Facts: reference fanuc-variables-and-alarms.md 1. *Invariant:* a number has one row at most, and finding it takes
//! the same time for all numbers up to 20,000; above them the rows are few and searched by halves.

use crate::ident::CodeId;

/// First number of a system variable.
pub const FIRST: u32 = 1000;

/// Marks the modal macro calls among the groups of a row.
pub const MODAL_CALLS: u16 = 1000;

/// Numbers up to this one are looked up directly.
const DENSE: u32 = 20_000;

/// The meaning of variables.
#[derive(Debug, Clone, PartialEq)]
pub enum Means {
    /// A value that is kept; this one until a program sets it.
    Kept(f64),
    /// The same, which can only be 0 or 1.
    Bit(f64),
    /// 32 variables, from this number on, as the bits of a whole number.
    Bits(u32),
    /// Another numbered variable: this one for the first number of the row.
    Alias(u32),
    /// Milliseconds since the start of the job.
    Milliseconds,
    /// Hours since the start of the job.
    Hours,
    /// Date as yyyymmdd.
    Date,
    /// Time of day as hhmmss.
    TimeOfDay,
    /// Switches of the control; bit 2 is the inch system.
    Settings,
    /// Mirrored axes as bits.
    Mirrors,
    /// Number of the main program.
    MainProgram,
    /// G number that is active in a group: the kernel's group, and the number while none is active.
    Modal(Vec<(u16, f64)>),
    /// Last value of an address.
    Address(Vec<u8>),
    /// A position or a value for each axis of the channel, or for these of X, Y and Z.
    Position(PositionReference, Option<Vec<u8>>),
    /// Work offsets from this number on, with this many numbers each.
    WorkOffset {
        /// Number of the first one, 0 for the external one.
        from: u32,
        /// Numbers of one offset.
        stride: u32,
    },
    /// One axis of work offsets from this number on.
    WorkOffsetAxis {
        /// Number of the first one, 0 for the external one.
        from: u32,
        /// Axis of the channel, from 0.
        axis: u8,
    },
    /// A column of the tool offsets, from offset 1 on.
    ToolOffset(OffsetColumn, bool),
}

/// The reference point of a position.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PositionReference {
    /// Shift of the local coordinate system.
    Local,
    /// End of the previous block, in the frame of the program.
    BlockEnd,
    /// The machine.
    Machine,
    /// Position of the machine, in the work frame without the tool.
    Work,
    /// End of the last probing move, likewise.
    Skip,
    /// Active tool compensation.
    Tool,
    /// Active wear.
    Wear,
    /// Active geometry.
    Geometry,
    /// Always 0: following error, handle, distance to go.
    Zero,
}

/// A column of the tool offsets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OffsetColumn {
    /// Value along X, Y or Z (0 to 2).
    Axis(u8),
    /// Radius.
    Radius,
    /// Twice the radius.
    Diameter,
    /// Direction of the imaginary tip.
    Tip,
}

/// A row.
#[derive(Debug, Clone, PartialEq)]
pub struct SystemRow {
    /// First number.
    pub first: u32,
    /// Last number.
    pub last: u32,
    /// First numbers of further ranges with the same meaning.
    pub also: Vec<u32>,
    /// The meaning of the numbers.
    pub means: Means,
    /// Programs may set them.
    pub writable: bool,
}

/// All rows of a machine.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SystemVariables {
    /// The rows.
    pub rows: Vec<SystemRow>,
    /// Number of an alarm that a program raises with 0.
    pub alarm: u32,
    /// Date and time at the start of a job: yyyymmdd, hhmmss.
    pub start: (u32, u32),
    /// Values that variables have at the start, by number.
    pub initial: Vec<(u32, f64)>,
    /// G number of each code that has one, for codes that are active from the start.
    pub words: Vec<(CodeId, f64)>,
    /// Where the numbers are.
    pub lookup: Lookup,
}

/// Finds the row of a number.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Lookup {
    /// Place of the row plus one by number.
    dense: Vec<u8>,
    /// First and last number and row of the numbers above, ascending.
    far: Vec<(u32, u32, u8)>,
}

/// Two rows have a number in common.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DuplicateNumber {
    /// Which row.
    pub row: usize,
    /// The number.
    pub number: u32,
}

impl SystemVariables {
    /// Compiles the lookups of the rows; at most 255 of them.
    ///
    /// # Errors
    /// Rows have a number in common.
    pub fn compile(&mut self) -> Result<(), DuplicateNumber> {
        let Lookup { mut dense, mut far } = Lookup::default();
        let rows = self.rows.iter().zip(0_u8..);
        let ranges = rows.flat_map(|(row, place)| {
            let starts = std::iter::once(row.first).chain(row.also.iter().copied());
            starts.map(move |first| (first, first.saturating_add(row.last - row.first), place))
        });
        for (first, last, place) in ranges {
            let row = usize::from(place);
            if last > DENSE {
                far.push((first.max(DENSE + 1), last, place));
            }
            if first > DENSE {
                continue;
            }
            let end = (last.min(DENSE) - FIRST) as usize + 1;
            if dense.len() < end {
                dense.resize(end, 0);
            }
            for number in first..=last.min(DENSE) {
                let Some(slot) = dense.get_mut((number - FIRST) as usize) else { continue };
                if *slot != 0 {
                    return Err(DuplicateNumber { row, number });
                }
                *slot = place + 1;
            }
        }
        far.sort_unstable();
        let overlap = far.windows(2).find_map(|pair| match pair {
            [(_, last, _), (first, _, row)] if first <= last => {
                Some(DuplicateNumber { row: usize::from(*row), number: *first })
            }
            _ => None,
        });
        self.lookup = Lookup { dense, far };
        overlap.map_or(Ok(()), Err)
    }

    /// The row of a number, and which number of its range it is, from 0.
    #[must_use]
    pub fn find(&self, number: u32) -> Option<(&SystemRow, u32)> {
        let at = number.checked_sub(FIRST)?;
        let place = match self.lookup.dense.get(at as usize) {
            Some(&place) => place.checked_sub(1)?,
            None => {
                let after = self.lookup.far.partition_point(|&(first, ..)| first <= number);
                let &(_, last, place) = self.lookup.far.get(after.checked_sub(1)?)?;
                (number <= last).then_some(place)?
            }
        };
        let row = self.rows.get(usize::from(place))?;
        let starts = std::iter::once(row.first).chain(row.also.iter().copied());
        let span = row.last - row.first;
        let start = starts.into_iter().find(|&start| start <= number && number - start <= span)?;
        Some((row, number - start))
    }

    /// G number of a code.
    #[must_use]
    pub fn word(&self, code: CodeId) -> Option<f64> {
        let at = self.words.binary_search_by(|(id, _)| id.cmp(&code)).ok()?;
        self.words.get(at).map(|(_, value)| *value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(first: u32, last: u32, also: &[u32]) -> SystemRow {
        SystemRow { first, last, also: also.to_vec(), means: Means::Kept(0.0), writable: true }
    }

    #[test]
    fn finds_the_row_and_the_place_in_it() {
        let rows = vec![row(1000, 1031, &[]), row(5001, 5020, &[100_001]), row(5021, 5040, &[100_051])];
        let mut variables = SystemVariables { rows, ..SystemVariables::default() };
        assert_eq!(variables.compile(), Ok(()));
        let found = |number| variables.find(number).map(|(row, at)| (row.first, at));
        assert_eq!(found(1031), Some((1000, 31)));
        assert_eq!(found(5022), Some((5021, 1)));
        assert_eq!(found(100_001), Some((5001, 0)));
        assert_eq!(found(100_020), Some((5001, 19)));
        assert_eq!(found(100_070), Some((5021, 19)));
        for missing in [0, 999, 1032, 5041, 100_000, 100_021, 100_071, u32::MAX] {
            assert_eq!(found(missing), None, "{missing}");
        }
    }

    #[test]
    fn two_rows_of_a_number_are_refused() {
        for (rows, number) in [
            (vec![row(1000, 1010, &[]), row(1010, 1020, &[])], 1010),
            (vec![row(1000, 1001, &[30_000]), row(1500, 1510, &[30_001])], 30_001),
        ] {
            let mut variables = SystemVariables { rows, ..SystemVariables::default() };
            assert_eq!(variables.compile(), Err(DuplicateNumber { row: 1, number }));
        }
    }
}
