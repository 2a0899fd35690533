//! Stops and ends of programs.

use super::declare::words;
use super::fields::{Datum, Field, Fields, Record, Source};
use super::work::Work;

words! {
    /// Why the program stops.
    pub enum Stop {
        /// M0.
        Program = 1 "program",
        /// M1 with the switch on.
        Optional = 2 "optional",
        /// M2.
        End = 3 "end",
        /// M30.
        Rewind = 4 "rewind",
    }
}

impl Record for Stop {
    fn fields(&self, out: &mut impl Fields) {
        self.put(Field::new(1, "stop"), out);
    }

    fn read(from: &impl Source) -> Option<Self> {
        Self::get(1, from)
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
