//! Units of length of a table of tools.

use std::fmt;

/// Millimetres in an inch.
const INCH: f64 = 25.4;

/// A unit of length.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum LengthUnit {
    #[default]
    Millimetre,
    Inch,
}

impl LengthUnit {
    /// The unit that a word names.
    pub(super) fn of(word: &str) -> Option<Self> {
        match word.to_ascii_lowercase().as_str() {
            "mm" | "millimeter" | "millimeters" | "millimetre" | "millimetres" => Some(Self::Millimetre),
            "in" | "inch" | "inches" => Some(Self::Inch),
            _ => None,
        }
    }

    /// Inches for millimetres, millimetres for inches.
    pub(super) fn other(self) -> Self {
        match self {
            Self::Millimetre => Self::Inch,
            Self::Inch => Self::Millimetre,
        }
    }

    /// The length of this unit in another one.
    pub(super) fn in_unit(self, unit: Self) -> f64 {
        match (self, unit) {
            (Self::Inch, Self::Millimetre) => INCH,
            (Self::Millimetre, Self::Inch) => 1.0 / INCH,
            _ => 1.0,
        }
    }
}

impl fmt::Display for LengthUnit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Millimetre => "mm",
            Self::Inch => "inch",
        })
    }
}
