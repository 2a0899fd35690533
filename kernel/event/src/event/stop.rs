//! Stops and ends of programs.

pub use counterpoint_fault::Stop;

use super::fields::{Field, Fields, Record, Source, Value};
use super::work::Work;

/// Each with its word in JSON, in the order of their numbers on the wire, from 1.
const WORDS: [(Stop, &str); 4] =
    [(Stop::Program, "program"), (Stop::Optional, "optional"), (Stop::End, "end"), (Stop::Rewind, "rewind")];

impl Record for Stop {
    fn fields(&self, out: &mut impl Fields) {
        let known = (1..).zip(WORDS).find(|(_, (stop, _))| stop == self);
        let (number, word) = known.map_or((0, ""), |(number, (_, word))| (number, word));
        out.put(Field::new(1, "stop"), Value::Word(number, word));
    }

    fn read(from: &impl Source) -> Option<Self> {
        let number = usize::try_from(from.number(1)).ok()?;
        WORDS.get(number.checked_sub(1)?).map(|(stop, _)| *stop)
    }

    fn work(&self) -> Option<Work> {
        Some(Work::Misc)
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
