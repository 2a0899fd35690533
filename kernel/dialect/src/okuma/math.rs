//! Operators and functions of expressions.
//!
//! Facts: reference control-emulator.md 5.4. Angles are degrees. Decisions: truth is 1 and 0; AND, OR and EOR work on
//! the bits of whole numbers, NOT turns a truth round and the bits of any other number; ATAN2 has the height first. The
//! functions come from `libm`, so that every machine gives the same bits.

use crate::numeric::{self, DEGREES, away};

/// Why an expression has no value.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub(super) enum Fault {
    #[error("division by zero")]
    Division,
    #[error("{0} of {1} is not defined")]
    Domain(&'static str, f64),
    #[error("the value is too large")]
    Overflow,
}

/// Operators between two values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Binary {
    Add,
    Sub,
    Mul,
    Div,
    Mod,
    Eq,
    Ne,
    Gt,
    Ge,
    Lt,
    Le,
    And,
    Or,
    Eor,
}

/// Functions, with the operators before one value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Function {
    Minus,
    /// Bits of a number.
    Not,
    /// A truth turned round.
    NotTrue,
    /// One that other controls have, too.
    Common(numeric::Function),
    Atan2,
    Dround,
    Dfix,
    Dfup,
    Mod,
}

const FUNCTIONS: &[(&str, Function)] = &[
    ("SIN", Function::Common(numeric::Function::Sin)),
    ("COS", Function::Common(numeric::Function::Cos)),
    ("TAN", Function::Common(numeric::Function::Tan)),
    ("ASIN", Function::Common(numeric::Function::Asin)),
    ("ACOS", Function::Common(numeric::Function::Acos)),
    ("ATAN", Function::Common(numeric::Function::Atan)),
    ("ATAN2", Function::Atan2),
    ("SQRT", Function::Common(numeric::Function::Sqrt)),
    ("ABS", Function::Common(numeric::Function::Abs)),
    ("BIN", Function::Common(numeric::Function::Bin)),
    ("BCD", Function::Common(numeric::Function::Bcd)),
    ("ROUND", Function::Common(numeric::Function::Round)),
    ("FIX", Function::Common(numeric::Function::Fix)),
    ("FUP", Function::Common(numeric::Function::Fup)),
    ("DROUND", Function::Dround),
    ("DFIX", Function::Dfix),
    ("DFUP", Function::Dfup),
    ("EXP", Function::Common(numeric::Function::Exp)),
    ("LN", Function::Common(numeric::Function::Ln)),
    ("MOD", Function::Mod),
];

impl Function {
    /// The function of a name, as the control writes it.
    pub(super) fn named(name: &str) -> Option<(&'static str, Self)> {
        FUNCTIONS.iter().find(|(known, _)| *known == name).copied()
    }

    /// How many values it takes.
    pub(super) fn arguments(self) -> usize {
        if matches!(self, Function::Atan2 | Function::Mod) { 2 } else { 1 }
    }

    /// Value; `unit` is how many of the smallest steps of the control a unit of length has.
    pub(super) fn apply(self, v: f64, second: f64, unit: f64) -> Result<f64, Fault> {
        Ok(match self {
            Function::Minus => -v,
            Function::Not => !(v as i64) as f64,
            Function::NotTrue => truth(v == 0.0),
            Function::Common(function) => function.value(v).ok_or(Fault::Domain(function.name(), v))?,
            Function::Atan2 => libm::atan2(v, second) * DEGREES,
            Function::Dround => (v * unit).round() / unit,
            Function::Dfix => (v * unit).trunc() / unit,
            Function::Dfup => away(v * unit) / unit,
            Function::Mod => return Binary::Mod.apply(v, second),
        })
    }
}

impl Binary {
    /// Its value is a truth.
    pub(super) fn compares(self) -> bool {
        matches!(self, Binary::Eq | Binary::Ne | Binary::Gt | Binary::Ge | Binary::Lt | Binary::Le)
    }

    pub(super) fn apply(self, a: f64, b: f64) -> Result<f64, Fault> {
        Ok(match self {
            Binary::Add => a + b,
            Binary::Sub => a - b,
            Binary::Mul => a * b,
            Binary::Div | Binary::Mod if b == 0.0 => return Err(Fault::Division),
            Binary::Div => a / b,
            Binary::Mod => a % b,
            Binary::Eq => truth(a == b),
            Binary::Ne => truth(a != b),
            Binary::Gt => truth(a > b),
            Binary::Ge => truth(a >= b),
            Binary::Lt => truth(a < b),
            Binary::Le => truth(a <= b),
            Binary::And => (a as i64 & b as i64) as f64,
            Binary::Or => (a as i64 | b as i64) as f64,
            Binary::Eor => (a as i64 ^ b as i64) as f64,
        })
    }
}

/// A truth as a number.
pub(super) fn truth(is: bool) -> f64 {
    if is { 1.0 } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn functions_of_numbers() {
        let value = |name: &str, v: f64, second: f64| Function::named(name).unwrap().1.apply(v, second, 1000.0);
        for (name, v, second, expected) in [
            ("SIN", 180.0, 0.0, 0.0),
            ("COS", 270.0, 0.0, 0.0),
            ("ATAN2", 0.0, -1.0, 180.0),
            ("ROUND", -2.5, 0.0, -3.0),
            ("FIX", -2.9, 0.0, -2.0),
            ("FUP", 2.1, 0.0, 3.0),
            ("DROUND", -1.2345, 0.0, -1.235),
            ("DFIX", 1.2349, 0.0, 1.234),
            ("DFUP", 1.2341, 0.0, 1.235),
            ("BIN", 37.0, 0.0, 25.0),
            ("BCD", 25.0, 0.0, 37.0),
            ("MOD", 7.5, 2.0, 1.5),
        ] {
            assert_eq!(value(name, v, second), Ok(expected), "{name}");
        }
        for (name, v) in [("TAN", 90.0), ("ASIN", 1.1), ("ACOS", -1.1), ("SQRT", -1.0), ("LN", 0.0), ("MOD", 1.0)] {
            assert!(value(name, v, 0.0).is_err(), "{name}");
        }
        assert!(value("FIX", f64::NAN, 0.0).unwrap().is_nan());
    }
}
