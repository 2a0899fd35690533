//! The diagnostics of the macro language: numbers, words, severities.
//!
//! *Invariant:* every number has a page in `docs/diagnostics`. Facts: reference macro-language.md 10 (the number of an
//! inhibited SYSTEM); every other number is this project's own.

use std::fmt;

/// A diagnostic number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct DiagnosticNumber(pub u32);

/// Facts of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LanguageDiagnostic {
    /// The number.
    pub number: DiagnosticNumber,
    /// Stable word that people use for the number.
    pub name: &'static str,
    /// 0–3 message, 4–7 warning, 8–15 error, 16–99 fatal.
    pub severity: u8,
    /// Its subject.
    pub about: &'static str,
}

macro_rules! numbers {
    ($($constant:ident = $number:literal, $name:literal, $severity:literal, $about:literal;)*) => {
        impl DiagnosticNumber {
            $(#[doc = $about] pub const $constant: DiagnosticNumber = DiagnosticNumber($number);)*
        }
        /// Every number with its facts.
        pub const TABLE: &[LanguageDiagnostic] =
            &[$(LanguageDiagnostic { number: DiagnosticNumber($number), name: $name, severity: $severity, about: $about }),*];
    };
}

numbers! {
    SYSTEM_INHIBITED = 1118001, "system-command-inhibited", 8, "operating system command not allowed";
    LINE_TOO_LONG = 2910001, "line-too-long", 8, "line longer than 512 characters";
    OPEN_TEXT = 2910002, "text-not-closed", 8, "text without a closing quote";
    STRANGE_CHARACTER = 2910003, "illegal-character", 8, "illegal character in a macro";
    BAD_NAME = 2910004, "malformed-name", 8, "name too long or malformed";
    BAD_NUMBER = 2910005, "malformed-number", 8, "malformed number or code";
    SYNTAX = 2910010, "macro-syntax", 8, "syntax error in a statement or expression";
    UNKNOWN_COMMAND = 2910011, "unknown-command", 8, "unknown command";
    TOO_DEEP = 2910012, "nested-too-deeply", 8, "expression or blocks nested too deeply";
    UNBALANCED = 2910013, "block-not-paired", 8, "block without its end, or end without its block";
    BARE_CALL = 2910014, "call-as-statement", 8, "function call used as a statement";
    BAD_TARGET = 2910015, "not-assignable", 8, "left side of an assignment not assignable";
    BAD_EXIT = 2910016, "exit-outside-loop", 8, "EXIT from more loops than enclose it";
    BAD_LABEL = 2910017, "illegal-label", 8, "label missing, repeated or malformed";
    BAD_WHEN = 2910018, "when-not-constant", 8, "WHEN list with values that are not constants";
    RESERVED_WORD = 2910019, "reserved-word", 8, "reserved word used as a name";
    UNKNOWN_VARIABLE = 2910020, "unknown-system-variable", 8, "unknown system variable";
    UNKNOWN_FUNCTION = 2910021, "unknown-function", 8, "unknown function";
    WRONG_COUNT = 2910022, "wrong-argument-count", 8, "wrong number of arguments or indices";
    WRONG_TYPE = 2910023, "wrong-operand-type", 8, "operand or argument of the wrong type";
    READ_ONLY = 2910024, "read-only-variable", 8, "assignment to a read-only variable";
    REDECLARED = 2910025, "declared-twice", 8, "name declared twice or not declarable";
    UNDECLARED = 2910026, "undeclared-name", 8, "undeclared name under strong declaration";
    UNINITIALISED = 2910027, "never-assigned", 4, "variable read but never assigned";
    BAD_ARRAY = 2910028, "illegal-array-use", 8, "array used as a single value, or illegal dimension";
    BAD_FORMAT = 2910029, "malformed-format", 8, "malformed string format";
    BAD_PATTERN = 2910030, "malformed-pattern", 8, "malformed regular expression";
    NOT_HERE = 2910031, "not-available-here", 8, "statement or function not available here";
    UNKNOWN_IDENTIFIER = 2910032, "unknown-identifier", 8, "unknown code or data identifier";
    TOO_LARGE = 2910033, "macro-too-large", 8, "macro with too many statements or variables";
    NO_FILE = 2910034, "include-unreadable", 8, "INCLUD file not readable";
    TOO_MANY = 2910035, "too-many-macro-diagnostics", 8, "diagnostic limit of a file reached";
    DUPLICATE_FUNCTION = 2910036, "function-defined-twice", 8, "function defined twice, or a malformed MACRO header";
    RECORD_IGNORED = 2910037, "post-record-ignored", 4, "post-processor record in a control emulator macro";
    TYPE_MISMATCH = 2910050, "wrong-value-type", 8, "wrong type of value at run time";
    OUT_OF_RANGE = 2910051, "index-out-of-range", 8, "index out of range";
    BAD_ARITHMETIC = 2910052, "arithmetic-without-result", 8, "arithmetic without a result";
    FORMAT_MISMATCH = 2910053, "format-mismatch", 8, "string format does not match its arguments";
    RE_ENTERED = 2910054, "function-re-entered", 8, "function called while it is running";
    TICKS = 2910055, "macro-steps-limit", 8, "macro exceeded its budget of steps";
    DEPTH = 2910056, "macro-depth-limit", 8, "macros nested too deeply";
    SIZE = 2910057, "value-size-limit", 8, "text, sequence or array too large";
    UNITS = 2910058, "file-units-limit", 8, "unit number out of range or too many units open";
    BACKTRACKING = 2910059, "pattern-steps-limit", 8, "regular expression needs too many steps";
    UNIT_NOT_OPEN = 2910060, "file-unit-not-open", 8, "end-of-file test on a unit that is not open";
    STEP_ZERO = 2910061, "loop-step-zero", 8, "DO loop with step zero";
    UNKNOWN_DIAGNOSTIC = 2910062, "unknown-diagnostic", 8, "ERROR with an unknown number";
    NO_HOST = 2910063, "not-offered-by-host", 8, "command or function not offered by the host";
    BAD_VECTOR = 2910064, "illegal-vector-size", 8, "illegal size of a vector or matrix";
    TERMAC_GENERATED = 2910065, "macro-ended-by-error", 0, "macro ended because of an error";
    TYPED_STORE = 2910066, "declared-type-mismatch", 8, "wrong type of value for a declared variable";
    OUTSIDE = 2910067, "file-outside-folder", 4, "file name outside the folder of the run";
    NO_DIALOG = 2910068, "dialog-without-answer", 8, "dialog without an answer";
    PROGRAM_END = 2910069, "past-program-end", 4, "block requested after the end of the NC program";
    NO_MODEL = 2910070, "no-machine-model", 0, "machine model function without a model";
    NO_SETTING = 2910071, "no-such-setting", 4, "unknown pre-processor setting";
    BAD_VALUE = 2910072, "value-not-accepted", 8, "value not accepted by a system variable";
    NOT_ANSWERED = 2910073, "dialog-not-answered", 8, "dialog declined or not answered in time";
    MEMORY = 2900310, "macro-memory-limit", 16, "macros exceed the memory of the job";
    AUTHOR = 2910090, "macro-message", 0, "diagnostic issued by a macro itself";
}

impl DiagnosticNumber {
    /// The word of the number, `None` for numbers of other tables.
    #[must_use]
    pub fn name(self) -> Option<&'static str> {
        TABLE.iter().find(|row| row.number == self).map(|row| row.name)
    }

    /// Severity from the table, 8 for numbers of other tables.
    #[must_use]
    pub fn severity(self) -> u8 {
        TABLE.iter().find(|row| row.number == self).map_or(8, |row| row.severity)
    }
}

impl fmt::Display for DiagnosticNumber {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:08}", self.0)
    }
}
