//! String formats: values as text and text as values.
//!
//! *Invariant:* a format is parsed once into pieces; writing it never fails half-way with a changed output. Facts:
//! reference macro-language.md 5.

mod number;
mod read;
mod spec;
mod write;

pub use number::{ColumnStyle, Numeric, PointStyle, ZeroStyle};
pub use read::read;
pub use spec::{FormatCode, FormatPiece, FormatRegister, StringFormat};
pub use write::{any, write};

/// Outside data that formats need: names of identifiers, and registers with their own formats.
pub trait RegisterHost {
    /// Name of a code identifier.
    fn code_name(&self, code: u32) -> String;
    /// Name of a data identifier.
    fn register_name(&self, register: u32) -> String;
    /// A register as text: the word (prefix, value, suffix) or the value only; the current value if none is given.
    /// None if there is no such register.
    fn register_text(&mut self, register: FormatRegister, value: Option<f64>, word: bool) -> Option<String>;
}

/// Appends `value` in the wildcard form `!(s9f9s)`: no leading or trailing zeros, point only with a fraction,
/// nine fraction digits at most: `12`, `8.5`, `-20`, `.5`, `0`.
pub fn wildcard(out: &mut String, value: f64) {
    Numeric::WILDCARD.write(out, value);
}

/// [`wildcard`] as an owned string.
#[must_use]
pub fn wildcard_text(value: f64) -> String {
    let mut out = String::new();
    wildcard(&mut out, value);
    out
}

#[cfg(test)]
mod tests;
