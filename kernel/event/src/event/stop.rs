//! Stops and ends of programs.

pub use counterpoint_fault::StopCode;

use super::fields::{EventField, EventRecord, EventValue, FieldReader, FieldWriter};
use super::work::WorkClass;

/// Each with its word in JSON, in the order of their numbers on the wire, from 1.
const WORDS: [(StopCode, &str); 4] = [
    (StopCode::Program, "program"),
    (StopCode::Optional, "optional"),
    (StopCode::End, "end"),
    (StopCode::Rewind, "rewind"),
];

impl EventRecord for StopCode {
    fn fields(&self, out: &mut impl FieldWriter) {
        let known = (1..).zip(WORDS).find(|(_, (stop, _))| stop == self);
        let (number, word) = known.map_or((0, ""), |(number, (_, word))| (number, word));
        out.put(EventField::new(1, "stop"), EventValue::Word(number, word));
    }

    fn read(from: &impl FieldReader) -> Option<Self> {
        let number = usize::try_from(from.number(1)).ok()?;
        WORDS.get(number.checked_sub(1)?).map(|(stop, _)| *stop)
    }

    fn work(&self) -> Option<WorkClass> {
        Some(WorkClass::Misc)
    }

    fn action(&self, _: fn(f64) -> String) -> Option<String> {
        let words = match self {
            Self::Program => "stop",
            Self::Optional => "opstop",
            Self::End => "end",
            Self::Rewind => "rewind",
        };
        Some(words.to_owned())
    }
}
