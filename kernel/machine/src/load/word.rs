//! The written form of a code: `G1`, `G54.1`, `G54-G59`.
//!
//! Invariant: a range runs upwards, has at most one decimal, and decimals only below 1000. Facts: reference
//! control-emulator.md 1.2.

use crate::index::{IdTable, RegisterId};
use crate::rows::Register;

/// Largest code number.
const LARGEST: f64 = 99_999_999.0;

/// A code word.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct CodeWord {
    /// Its register.
    pub(super) register: RegisterId,
    /// Smallest value.
    pub(super) min: f64,
    /// Largest value.
    pub(super) max: f64,
}

/// Why a text is not a code word.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum CodeWordError {
    /// It starts with no register; the letters are given.
    Register(String),
    /// Something else.
    Form(String),
}

/// Reads a code word.
pub(super) fn parse(word: &str, registers: &IdTable<RegisterId, Register>) -> Result<CodeWord, CodeWordError> {
    let (register, rest) = split(word, registers)?;
    let (first, second) = match rest.split_once('-') {
        None => (rest, rest),
        Some((first, last)) => {
            let (other, second) = split(last, registers)?;
            if other != register {
                return Err(form(word, "both ends of a range must have the same letter"));
            }
            (first, second)
        }
    };
    let (min, max) = (value(word, first)?, value(word, second)?);
    if min > max {
        return Err(form(word, "the range must run upwards"));
    }
    Ok(CodeWord { register, min, max })
}

fn split<'w>(word: &'w str, registers: &IdTable<RegisterId, Register>) -> Result<(RegisterId, &'w str), CodeWordError> {
    let longest = registers
        .entries()
        .filter_map(|(id, register)| Some((register.name.len(), id, word.strip_prefix(register.name.as_str())?)))
        .max_by_key(|(length, _, _)| *length);
    longest.map(|(_, id, rest)| (id, rest)).ok_or_else(|| {
        let letters: String = word.chars().take_while(|c| !c.is_ascii_digit() && *c != '-').collect();
        CodeWordError::Register(letters)
    })
}

fn value(word: &str, digits: &str) -> Result<f64, CodeWordError> {
    let (whole, decimal) = digits.split_once('.').unwrap_or((digits, "0"));
    let plain = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    if !plain(whole) || !plain(decimal) {
        return Err(form(word, "it must be a letter and a number (G54.1), or a range (G54-G59)"));
    }
    if decimal.len() > 1 {
        return Err(form(word, "a code number has at most one decimal"));
    }
    let value: f64 = digits.parse().unwrap_or(f64::INFINITY);
    if value > LARGEST {
        return Err(form(word, "a code number has at most eight digits"));
    }
    if decimal != "0" && value >= 1000.0 {
        return Err(form(word, "only code numbers below 1000 have a decimal"));
    }
    Ok(value)
}

fn form(word: &str, why: &str) -> CodeWordError {
    CodeWordError::Form(format!("\"{}\" is not a code word: {why}", word.escape_debug()))
}
