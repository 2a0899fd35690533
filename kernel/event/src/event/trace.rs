//! Lines of the trace, and the listing controls of macros.

use std::fmt;

use super::Kind;
use super::declare::record;
use super::fields::{EventField, EventRecord, EventValue, FieldReader, FieldType, FieldWriter};

/// Letter of the controls of the listing. It is not a letter that a job may ask for.
const LISTING: char = 'L';

record! {
    /// A line of the trace, or a control of the listing. *Invariant:* data that the listing needs are fields; the text
    /// is for people only.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct Trace {
        /// Its letter.
        pub letter: char = 1,
        /// The whole line.
        pub text: Box<str> = 2,
        /// Its effect on the listing; such a line is not shown.
        pub listing: Option<Listing> = 3 [wire],
        /// The line takes the place of the action of the event after it.
        pub instead: bool = 4 [wire],
    }
}

/// The effect of a macro on the listing.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Listing {
    /// Blocks and lines of the trace are shown from here on.
    On,
    /// They are not; diagnostics and summaries are all the same.
    Off,
    /// Empty lines.
    Lines(u32),
    /// The text of the next block, which is not the line of a file.
    Block(Box<str>),
}

impl Listing {
    /// Number on the wire, and its word in the contract.
    const fn word(&self) -> (u8, &'static str) {
        match self {
            Self::On => (1, "on"),
            Self::Off => (2, "off"),
            Self::Lines(_) => (3, "lines"),
            Self::Block(_) => (4, "block"),
        }
    }
}

/// As the log shows it.
impl fmt::Display for Listing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Lines(lines) => write!(f, "{lines}"),
            Self::Block(text) => write!(f, "block {text}"),
            Self::On | Self::Off => f.write_str(self.word().1),
        }
    }
}

impl EventRecord for Listing {
    fn fields(&self, out: &mut impl FieldWriter) {
        let (number, word) = self.word();
        out.put(EventField::wire(1), EventValue::Word(number, word));
        match self {
            Self::On | Self::Off => {}
            Self::Lines(lines) => lines.put(EventField::wire(2), out),
            Self::Block(text) => text.put(EventField::wire(3), out),
        }
    }

    fn read(from: &impl FieldReader) -> Option<Self> {
        Some(match from.number(1) {
            1 => Self::On,
            2 => Self::Off,
            3 => Self::Lines(FieldType::get(2, from)?),
            4 => Self::Block(FieldType::get(3, from)?),
            _ => return None,
        })
    }
}

impl Kind {
    /// A line of the trace.
    pub fn trace(letter: char, text: impl Into<Box<str>>) -> Self {
        Self::Trace(Trace { letter, text: text.into(), listing: None, instead: false })
    }

    /// A control of the listing.
    #[must_use]
    pub fn listing(listing: Listing) -> Self {
        let text = listing.to_string().into();
        Self::Trace(Trace { letter: LISTING, text, listing: Some(listing), instead: false })
    }
}
