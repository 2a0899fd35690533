//! Modal states.

use std::borrow::Cow;
use std::fmt;

use super::declare::{record, words};
use super::{Kind, Position};

words! {
    /// Quantity that a tool offset corrects.
    pub enum OffsetKind {
        /// The length of the tool.
        Length = 1 "length",
        /// Its diameter.
        Diameter = 2 "diameter",
    }
}

record! {
    /// A tool offset that is in effect from here on.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub struct OffsetSelection {
        /// The values that it corrects.
        pub kind: OffsetKind = 1,
        /// Its number.
        pub number: u32 = 2,
    }
}

record! {
    /// An axis of the channel that another channel has moved.
    #[derive(Debug, Clone, PartialEq)]
    pub struct CarriedMove {
        /// The previous position of the channel, in the work frame.
        pub from: Box<Position> = 1,
        /// The current position.
        pub to: Box<Position> = 2,
        /// The axis and its master: `Z2 with Z1`.
        pub axes: Box<str> = 3,
    }
}

record! {
    /// A modal state changed. *Invariant:* data that a result needs are fields; the text is for people only.
    #[derive(Debug, Clone, PartialEq)]
    pub struct ModalChange {
        /// The action in the words of the listing: `plane zx`, `comp diam left n=3`.
        pub text: Cow<'static, str> = 1,
        /// The tool offset that comes with it.
        pub offset: Option<OffsetSelection> = 2 [wire],
        /// The axis that a coupling has moved in the meantime.
        pub carried: Option<Box<CarriedMove>> = 3 [uncounted],
    }

    fn action(&self, _: fn(f64) -> String) -> Option<String> {
        Some(self.to_string())
    }
}

/// The words of the listing.
impl fmt::Display for ModalChange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl Kind {
    /// A modal state, in the words of the listing.
    pub fn mode(text: impl Into<Cow<'static, str>>) -> Self {
        Self::Mode(ModalChange { text: text.into(), offset: None, carried: None })
    }

    /// A coupling of axes, in the words of the listing, and the axis that it has moved.
    pub fn coupling(text: String, carried: Option<CarriedMove>) -> Self {
        Self::Mode(ModalChange { text: text.into(), offset: None, carried: carried.map(Box::new) })
    }

    /// Compensation by a tool offset, in the words of the listing. Numbers that no offset can have are left to the
    /// words.
    pub fn compensation(text: impl Into<Cow<'static, str>>, kind: OffsetKind, number: f64) -> Self {
        let whole = (0.0..=f64::from(u32::MAX)).contains(&number) && number.fract() == 0.0;
        let offset = whole.then_some(OffsetSelection { kind, number: number as u32 });
        Self::Mode(ModalChange { text: text.into(), offset, carried: None })
    }
}
