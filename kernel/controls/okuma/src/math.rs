//! Functions of expressions.
//!
//! Facts: reference control-emulator.md 5.4. Angles are degrees. Decisions: truth is 1 and 0; AND, OR and EOR work on
//! the bits of whole numbers, NOT turns a truth round and the bits of any other number; ATAN2 has the height first. The
//! functions come from `libm`, so that every machine gives the same bits.

use counterpoint_control_api::numeric::{NAMED, NumericFunction, NumericOperator};

/// Why an expression has no value.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub(super) enum OkumaMathError {
    #[error("division by zero")]
    Division,
    #[error("{0} of {1} is not defined")]
    Domain(&'static str, f64),
    #[error("the value is out of range")]
    Overflow,
}

/// A function of the control.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum OkumaFunction {
    One(NumericFunction),
    Steps(StepRounding),
    Two(NumericOperator),
}

/// How a number is rounded to steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct StepRounding(NumericFunction);

impl StepRounding {
    /// Value; `unit` is how many of the smallest steps of the control a unit of length has.
    pub(super) fn value(self, v: f64, unit: f64) -> f64 {
        self.0.value(v * unit).map_or(v, |steps| steps / unit)
    }
}

/// Functions besides those of all controls.
const FUNCTIONS: &[(&str, OkumaFunction)] = &[
    ("ATAN", OkumaFunction::One(NumericFunction::Atan)),
    ("ATAN2", OkumaFunction::Two(NumericOperator::Atan2)),
    ("BIN", OkumaFunction::One(NumericFunction::Bin)),
    ("BCD", OkumaFunction::One(NumericFunction::Bcd)),
    ("ROUND", OkumaFunction::One(NumericFunction::Round)),
    ("FIX", OkumaFunction::One(NumericFunction::Fix)),
    ("FUP", OkumaFunction::One(NumericFunction::Fup)),
    ("DROUND", OkumaFunction::Steps(StepRounding(NumericFunction::Round))),
    ("DFIX", OkumaFunction::Steps(StepRounding(NumericFunction::Fix))),
    ("DFUP", OkumaFunction::Steps(StepRounding(NumericFunction::Fup))),
    ("MOD", OkumaFunction::Two(NumericOperator::Rem)),
];

/// The function of a name, as the control writes it, and that name.
pub(super) fn named(name: &str) -> Option<(&'static str, OkumaFunction)> {
    let common = NAMED.iter().map(|(name, function)| (*name, OkumaFunction::One(*function)));
    common.chain(FUNCTIONS.iter().copied()).find(|(known, _)| *known == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn functions_of_numbers() {
        let value = |name: &str, v: f64, second: f64| match named(name).unwrap().1 {
            OkumaFunction::One(function) => function.value(v),
            OkumaFunction::Steps(steps) => Some(steps.value(v, 1000.0)),
            OkumaFunction::Two(operator) => operator.value(v, second),
        };
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
            assert_eq!(value(name, v, second), Some(expected), "{name}");
        }
        for (name, v) in [("TAN", 90.0), ("ASIN", 1.1), ("ACOS", -1.1), ("SQRT", -1.0), ("LN", 0.0), ("MOD", 1.0)] {
            assert!(value(name, v, 0.0).is_none(), "{name}");
        }
        assert!(value("FIX", f64::NAN, 0.0).unwrap().is_nan());
    }
}
