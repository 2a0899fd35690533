//! Registers, and the rows of the code and data tables.
//!
//! Facts: reference control-emulator.md 1.2 to 1.4.

use crate::ident::dimension::Dimension;
use crate::ident::{CodeId, DataId};
use crate::index::RegisterId;

/// A register: a letter (or text) with a number.
#[derive(Debug, Clone, PartialEq)]
pub struct Register {
    /// Index of the definition, 1–99.
    pub index: u8,
    /// Name: one capital letter for a regular register.
    pub name: String,
    /// Second name: incremental form.
    pub second: Option<String>,
    /// Text before the number; the name itself for a regular register.
    pub before: String,
    /// Text after the number, empty for a regular register.
    pub after: String,
    /// Number format in primary units.
    pub format: NumberFormat,
    /// Number format in secondary units.
    pub secondary: NumberFormat,
    /// Least increment of values of expressions; none: one in the last digit of the format.
    pub increment: Option<f64>,
    /// Values may be negative.
    pub signed: bool,
    /// Numbers may have a decimal point.
    pub pointed: bool,
    /// The text between `before` and `after` may be a tool's name.
    pub names: bool,
    /// It is a coordinate whose numbers without a point count least increments because the control says so.
    pub counts: bool,
}

impl Register {
    /// One capital letter and nothing after the number; everything else is a special register.
    #[must_use]
    pub fn is_regular(&self) -> bool {
        self.after.is_empty() && matches!(self.before.as_bytes(), [letter] if letter.is_ascii_uppercase())
    }
}

/// Format of a register's number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NumberFormat {
    /// Digits before the point.
    pub whole: u8,
    /// Digits after the point.
    pub frac: u8,
    /// Decimal point.
    pub point: DecimalPointRule,
    /// Leading zeros.
    pub lead: ZeroRule,
    /// Trailing zeros.
    pub trail: ZeroRule,
    /// Plus sign is shown.
    pub plus: bool,
    /// Digits of a program after the last one of `frac`.
    pub excess: Excess,
}

/// A number with more digits after the point than its register.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Excess {
    /// All of them count.
    #[default]
    Kept,
    /// They are cut off.
    Cut,
    /// The number is rounded to the nearest one with the digits of the register, halves away from zero.
    Rounded,
}

/// Decimal point of a register.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DecimalPointRule {
    /// Always written if fractional digits exist.
    Keep,
    /// Written only if needed.
    Fractional,
    /// Implied: never written.
    Omit,
}

/// Zeros of a register.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ZeroRule {
    /// All are written.
    Keep,
    /// One is written.
    One,
    /// None is written.
    Omit,
}

/// The actions that the seconds of a code or a spindle run in parallel with.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum TimeOverlap {
    /// Nothing: the following blocks wait.
    #[default]
    None,
    /// The rest of their block.
    Block,
    /// All that follows up to the next move at feed.
    Rapids,
}

impl TimeOverlap {
    /// The words of machine files.
    pub(crate) const WORDS: [(&'static str, Self); 3] =
        [("none", Self::None), ("block", Self::Block), ("rapids", Self::Rapids)];
}

/// A row of the code table.
#[derive(Debug, Clone, PartialEq)]
pub struct CodeRow {
    /// The trigger.
    pub id: CodeId,
    /// How it is written.
    pub form: CodeForm,
    /// `false` = the row does not exist for the scanner.
    pub enable: bool,
    /// `false` = recognised and swallowed.
    pub process: bool,
    /// 1–999, small first.
    pub order: u16,
    /// 0–999, 0 = none.
    pub group: u16,
    /// Modality.
    pub modality: Modality,
    /// value' = value · mul + add.
    pub mul: f64,
    /// See `mul`.
    pub add: f64,
    /// Row matches only if one of these registers is in the block; empty = always.
    pub with: Vec<RegisterId>,
    /// Row matches only if none of these registers is in the block.
    pub without: Vec<RegisterId>,
    /// Registers whose words the control ignores on a block of this code.
    pub ignores: Vec<RegisterId>,
    /// All axis words of a block with this code are the code's: those that it does not take are reported and move
    /// nothing.
    pub owns_axes: bool,
    /// The function turns no spindle: a speed word beside it is that of the active spindle.
    pub turns_no_spindle: bool,
    /// It acts beside an earlier row of its word whose conditions are met.
    pub also: bool,
    /// The block is examined as a whole before its codes act: the row is swallowed, or changes the length of the tool.
    pub special: bool,
    /// Seconds this code takes (machine's time table), 0 = none.
    pub seconds: f64,
    /// The actions that its seconds run in parallel with.
    pub overlap: TimeOverlap,
    /// Axis role along which a canned cycle works (0 X, 1 Y, 2 Z), none = the axis normal to the plane.
    pub axis: Option<u8>,
    /// Line in `file` where the row is defined.
    pub line: u32,
    /// File where the row is defined (relative to the machines folder).
    pub file: String,
}

impl CodeRow {
    /// Whether the other row has the same code, written alike, and not by other registers along another axis.
    pub(crate) fn is_twin_of(&self, other: &Self) -> bool {
        self.id == other.id && self.form == other.form && self.choice() == other.choice()
    }

    /// The axis of the cycle if other registers in the block choose this row.
    fn choice(&self) -> Option<u8> {
        self.axis.filter(|_| !self.with.is_empty() || !self.without.is_empty())
    }
}

/// Written form of a code.
#[derive(Debug, Clone, PartialEq)]
pub enum CodeForm {
    /// No form in the program; only macros fire it.
    NotApplicable,
    /// Literal text.
    Text(String),
    /// Register with a value range, inclusive.
    Register {
        /// Index into `Machine::registers`.
        register: RegisterId,
        /// Smallest value.
        min: f64,
        /// Largest value.
        max: f64,
    },
    /// The same, and the value is handed over as data.
    RegisterAsData {
        /// Index into `Machine::registers`.
        register: RegisterId,
        /// Smallest value.
        min: f64,
        /// Largest value.
        max: f64,
        /// Data identifier that receives value · mul + add.
        data: DataId,
    },
}

/// Modality of a code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Modality {
    /// Acts in its block.
    NonModal,
    /// Active until another code of its group.
    Modal,
    /// Modal, and fires again in every block.
    Persistent,
}

/// A row of the data table.
#[derive(Debug, Clone, PartialEq)]
pub struct DataRow {
    /// The data that it supplies.
    pub id: DataId,
    /// Register, `None` = not in the program text.
    pub register: Option<RegisterId>,
    /// `false` = the word is not recognised through this row.
    pub enable: bool,
    /// `false` = recognised and dropped.
    pub process: bool,
    /// The last value is remembered.
    pub modal: bool,
    /// Smallest value accepted, before `mul` and `add`.
    pub min: Option<f64>,
    /// Largest value accepted.
    pub max: Option<f64>,
    /// value' = value · mul + add.
    pub mul: f64,
    /// See `mul`.
    pub add: f64,
    /// Dimension, for the change of units.
    pub dimension: Dimension,
    /// Value of one unit of a number without a point, in primary and in secondary units, if such numbers count
    /// increments.
    pub increment: Option<[f64; 2]>,
    /// Line where the row is defined.
    pub line: u32,
    /// File where the row is defined.
    pub file: String,
}
