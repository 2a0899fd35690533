//! A programmed dwell.

use super::fields::{EventRecord, FieldReader, FieldWriter};
use super::work::WorkClass;

/// Programmed dwell; the duration of the event is its time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Dwell;

impl EventRecord for Dwell {
    fn fields(&self, _: &mut impl FieldWriter) {}

    fn read(_: &impl FieldReader) -> Option<Self> {
        Some(Self)
    }

    fn work(&self) -> Option<WorkClass> {
        Some(WorkClass::Dwell)
    }
}
