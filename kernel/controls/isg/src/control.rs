//! The ISG kernel as a dialect.

use super::Isg;
use counterpoint_control_api::definition::{Dialect, Unknown};
use counterpoint_control_api::interpreter::Interpreter;
use counterpoint_control_api::outline::OutlineReader;
use counterpoint_machine::Machine;
use counterpoint_program::syntax::{PLAIN, Syntax};

static SYNTAX: Syntax = Syntax {
    numbered_programs: false,
    named_programs: Some(super::places::PROGRAMS),
    needs_interpreter: Some(needs_interpreter),
    keeps_names: true,
    ..PLAIN
};

/// Controls with an ISG kernel.
pub struct IsgDialect;

impl Dialect for IsgDialect {
    fn name(&self) -> &'static str {
        "isg"
    }

    fn title(&self) -> &'static str {
        "ISG"
    }

    fn syntax(&self) -> &'static Syntax {
        &SYNTAX
    }

    fn unknown_text(&self, text: &str, _: Unknown) -> String {
        format!("{text} is not known to this control")
    }

    fn reader(&self, machine: &Machine) -> Option<Box<dyn OutlineReader>> {
        Some(Box::new(Isg::new(&machine.variables.external)))
    }

    fn interpreter(&self, machine: &Machine) -> Option<Box<dyn Interpreter>> {
        Some(Box::new(Isg::new(&machine.variables.external)))
    }
}

/// Whether a block is more than plain words: a quick look at the text. A dwell may have a number without an address.
fn needs_interpreter(text: &[u8]) -> bool {
    let (mut before, mut depth) = (b' ', 0_u32);
    for (at, &byte) in text.iter().enumerate() {
        let rest = || text.get(at + 1..).unwrap_or_default();
        match byte {
            b'(' if depth > 0 => return true,
            b'(' => depth += 1,
            b')' => depth = depth.saturating_sub(1),
            _ if depth > 0 => {}
            b'=' | b'[' | b'$' | b'#' | b'%' | b':' | b'"' | b';' => return true,
            b'P' | b'p' | b'L' | b'l' | b'V' | b'v' => return true,
            b'G' | b'g' if is_number(rest(), b"4") => return true,
            b'M' | b'm' if is_number(rest(), b"17") || is_number(rest(), b"29") => return true,
            _ if byte.is_ascii_alphabetic() && before.is_ascii_alphabetic() => return true,
            _ => {}
        }
        before = byte;
    }
    false
}

/// Whether a text begins with this number.
fn is_number(text: &[u8], number: &[u8]) -> bool {
    let zeros = text.iter().take_while(|byte| **byte == b'0').count();
    let digits = text.get(zeros..).unwrap_or_default();
    digits.starts_with(number) && !digits.get(number.len()).is_some_and(|byte| byte.is_ascii_digit() || *byte == b'.')
}

#[cfg(test)]
mod tests {
    use super::needs_interpreter;

    #[test]
    fn plain_words_are_left_alone() {
        for text in ["", "N100 G01 X10.5 Z-3 (P1=5 [X])", "/1 G0 X1", "G1X5Z3F.2", "M30", "G40 M3 S500", "M170 M0"] {
            assert!(!needs_interpreter(text.as_bytes()), "{text}");
        }
        for text in [
            "P1=5",
            "X[P1]",
            "M17",
            "M029",
            "N10 $IF P1>3",
            "%MAIN",
            "G04 X1",
            "G4 2",
            "X1 ; a",
            "XV.E.A",
            "LL UP",
            "(a(b))",
        ] {
            assert!(needs_interpreter(text.as_bytes()), "{text}");
        }
    }
}
