//! Names of variables and their meanings.
//!
//! Decisions: a local variable has letters and then digits, two to four characters, and begins with none of O, N and V,
//! which begin the names of programs, sequences and the control's own variables. Common variables are VC1 to VC200 on
//! machining centres and V1 to V200 on lathes; both are understood, and they are different ones. Facts: reference
//! control-emulator.md 5.4.

use std::fmt::Write as _;
use std::sync::LazyLock;

use arrayvec::ArrayString;

/// Number of common variables of each kind.
const COMMON: f64 = 200.0;

/// Words that are not names.
const RESERVED: &[&str] = &[
    "EQ", "NE", "GT", "GE", "LT", "LE", "AND", "OR", "EOR", "NOT", "MOD", "IF", "GOTO", "CALL", "RTS", "NOEX", "MSG",
    "NMSG", "SIN", "COS", "TAN", "ASIN", "ACOS", "ATAN", "SQRT", "ABS", "BIN", "BCD", "FIX", "FUP", "DFIX", "DFUP",
    "EXP", "LN",
];

/// Words of two letters that the control has on machines with the equipment: tools of a changer and of turrets, tool
/// groups, live tools, the B axis, spindle orientation, home positions.
const WORDS: [&str; 8] = ["TD", "TL", "TG", "OG", "SB", "BA", "RS", "HP"];

/// A word of the control, whether the machine has it or not.
pub(super) fn is_word_of_control(name: &str) -> bool {
    WORDS.contains(&name)
}

/// An offset of the tool in the spindle: its first to third length or radius.
pub(super) fn is_offset(name: &str) -> bool {
    matches!(name, "HA" | "HB" | "HC" | "DA" | "DB" | "DC")
}

/// Whether a word only looks like the name of a block or program. OMIT leaves points of a figure out, unless nothing
/// follows it.
pub(super) fn is_statement(word: &[u8], continues: bool) -> bool {
    let statements = [b"NOEX".as_slice(), b"NCYL", b"NMSG"].into_iter();
    statements.chain(continues.then_some(b"OMIT".as_slice())).any(|known| word.eq_ignore_ascii_case(known))
}

/// A local variable: its name, filled up with zeros.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct LocalVariableName([u8; 4]);

impl std::fmt::Display for LocalVariableName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.iter().filter(|byte| **byte != 0).try_for_each(|byte| write!(f, "{}", char::from(*byte)))
    }
}

/// The two kinds of common variables.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Family {
    /// VC1 and so on.
    Vc,
    /// V1 and so on.
    V,
}

impl Family {
    pub(super) fn prefix(self) -> &'static str {
        match self {
            Family::Vc => "VC",
            Family::V => "V",
        }
    }

    /// A common variable by its number; none if it does not exist.
    pub(super) fn common(self, index: f64) -> Option<Common> {
        let exists = (1.0..=COMMON).contains(&index) && index.fract() == 0.0;
        if exists { COMMON_NAMES.get(self as usize)?.get(index as usize).copied() } else { None }
    }
}

/// Common variables by family and number; the first of each family, number 0, does not exist.
static COMMON_NAMES: LazyLock<[[Common; COMMON as usize + 1]; 2]> =
    LazyLock::new(|| [Family::Vc, Family::V].map(|family| std::array::from_fn(|number| Common::new(family, number))));

/// A common variable by its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Common(ArrayString<8>);

impl Common {
    fn new(family: Family, number: usize) -> Self {
        let mut name = ArrayString::new();
        // Two letters and three digits fit.
        _ = write!(name, "{}{number}", family.prefix());
        Self(name)
    }

    /// Its name.
    #[inline]
    pub(super) fn name(&self) -> &str {
        self.0.as_str()
    }
}

/// The local variable of a name.
pub(super) fn local(name: &str) -> Option<LocalVariableName> {
    let letters = name.bytes().take_while(u8::is_ascii_uppercase).count();
    let digits = name.bytes().skip(letters).take_while(u8::is_ascii_digit).count();
    let fits = letters > 0 && letters + digits == name.len() && (2..=4).contains(&name.len());
    if !fits || name.starts_with(['O', 'N', 'V']) || RESERVED.contains(&name) {
        return None;
    }
    let mut bytes = [0; 4];
    bytes.iter_mut().zip(name.bytes()).for_each(|(slot, byte)| *slot = byte);
    Some(LocalVariableName(bytes))
}

/// The kind of common variable that a name with or without its number means, and the number.
pub(super) fn common(name: &str) -> Option<(Family, Option<f64>)> {
    let (family, number) = match name.strip_prefix("VC") {
        Some(number) => (Family::Vc, number),
        None => (Family::V, name.strip_prefix('V')?),
    };
    if number.is_empty() {
        return Some((family, None));
    }
    let digits = number.len() <= 9 && number.bytes().all(|byte| byte.is_ascii_digit());
    digits.then(|| (family, number.parse().ok()))
}

/// A sequence number or program name in the form in which names are compared: leading zeros of a number are ignored.
pub(super) fn normal(name: &str) -> String {
    let name = name.to_ascii_uppercase();
    if name.bytes().all(|byte| byte.is_ascii_digit()) {
        let number = name.trim_start_matches('0');
        return if number.is_empty() { "0".to_owned() } else { number.to_owned() };
    }
    name
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_variables() {
        for name in ["LA1", "LA", "A1", "DIA1", "PX", "XYZ", "ABCD"] {
            assert_eq!(local(name).unwrap().to_string(), name);
        }
        for name in ["A", "OA", "N1", "VA", "SIN", "A1B", "ABCDE", "LA123", "1A", "", "EQ"] {
            assert!(local(name).is_none(), "{name}");
        }
        assert_eq!(common("VC12"), Some((Family::Vc, Some(12.0))));
        assert_eq!(common("V7"), Some((Family::V, Some(7.0))));
        assert_eq!(common("V"), Some((Family::V, None)));
        assert_eq!(common("VSIOX"), None);
        assert_eq!(common("VCX"), None);
        for (family, number, name) in [(Family::Vc, 200.0, "VC200"), (Family::V, 7.0, "V7"), (Family::Vc, 10.0, "VC10")]
        {
            assert_eq!(family.common(number).unwrap().name(), name);
        }
        assert_eq!((Family::V.common(0.0), Family::V.common(201.0), Family::V.common(1.5)), (None, None, None));
    }
}
