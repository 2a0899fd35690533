//! A programmed dwell.

use super::fields::{Fields, Record, Source};
use super::work::Work;

/// Programmed dwell; the duration of the event is its time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Dwell;

impl Record for Dwell {
    fn fields(&self, _: &mut impl Fields) {}

    fn read(_: &impl Source) -> Option<Self> {
        Some(Self)
    }

    fn work(&self) -> Option<Work> {
        Some(Work::Dwell)
    }
}
