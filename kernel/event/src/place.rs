//! Places in the programs of a job.

use crate::FileId;

/// A line of a file of the job.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct SourcePlace {
    /// Line in the file, from 1; 0: no place.
    pub line: u32,
    /// The file; meaningless when `line` is 0.
    pub file: FileId,
}

impl SourcePlace {
    /// No place.
    pub const NONE: Self = Self { line: 0, file: 0 };

    /// The line of a file.
    #[must_use]
    pub const fn new(file: FileId, line: u32) -> Self {
        Self { line, file }
    }

    /// Whether there is one.
    #[inline(always)]
    #[must_use]
    pub const fn is_some(self) -> bool {
        self.line != 0
    }

    /// This place if it is one, otherwise the other place.
    #[inline(always)]
    #[must_use]
    pub const fn or(self, other: Self) -> Self {
        if self.is_some() { self } else { other }
    }
}
