//! The diagnostics of the macro language: numbers, words, severities.
//!
//! *Invariant:* every number has a page in `docs/diagnostics`. Facts: reference macro-language.md 10 (the number of an
//! inhibited SYSTEM); every other number is this project's own.

use std::fmt;

/// A diagnostic number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Number(pub u32);

/// Facts of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Row {
    /// The number.
    pub number: Number,
    /// Stable word that people use for the number.
    pub name: &'static str,
    /// 0–3 message, 4–7 warning, 8–15 error, 16–99 fatal.
    pub severity: u8,
    /// What it is about.
    pub about: &'static str,
}

macro_rules! numbers {
    ($($constant:ident = $number:literal, $name:literal, $severity:literal, $about:literal;)*) => {
        impl Number {
            $(#[doc = $about] pub const $constant: Number = Number($number);)*
        }
        /// Every number with its facts.
        pub const TABLE: &[Row] =
            &[$(Row { number: Number($number), name: $name, severity: $severity, about: $about }),*];
    };
}

numbers! {
    SYSTEM_INHIBITED = 1118001, "system-command-inhibited", 8, "operating system command that is not allowed";
    LINE_TOO_LONG = 2910001, "line-too-long", 8, "line longer than 512 characters";
    OPEN_TEXT = 2910002, "text-not-closed", 8, "text without its closing quote";
    STRANGE_CHARACTER = 2910003, "illegal-character", 8, "character that the macro language does not have";
    BAD_NAME = 2910004, "malformed-name", 8, "name that is too long or malformed";
    BAD_NUMBER = 2910005, "malformed-number", 8, "malformed number or code";
    SYNTAX = 2910010, "macro-syntax", 8, "statement or expression that cannot be read";
    UNKNOWN_COMMAND = 2910011, "unknown-command", 8, "command that the macro language does not have";
    TOO_DEEP = 2910012, "nested-too-deeply", 8, "expression or blocks nested too deeply";
    UNBALANCED = 2910013, "block-not-paired", 8, "block without its end, or end without its block";
    BARE_CALL = 2910014, "call-as-statement", 8, "function call standing alone as a statement";
    BAD_TARGET = 2910015, "not-assignable", 8, "left side that cannot be assigned to";
    BAD_EXIT = 2910016, "exit-outside-loop", 8, "EXIT outside of enough loops";
    BAD_LABEL = 2910017, "illegal-label", 8, "label that is missing, repeated or malformed";
    BAD_WHEN = 2910018, "when-not-constant", 8, "WHEN list with something else than constants";
    RESERVED_WORD = 2910019, "reserved-word", 8, "reserved word in a place where it means nothing";
    UNKNOWN_VARIABLE = 2910020, "unknown-system-variable", 8, "system variable that does not exist";
    UNKNOWN_FUNCTION = 2910021, "unknown-function", 8, "function that does not exist";
    WRONG_COUNT = 2910022, "wrong-argument-count", 8, "wrong number of arguments or indices";
    WRONG_TYPE = 2910023, "wrong-operand-type", 8, "operand or argument of the wrong type";
    READ_ONLY = 2910024, "read-only-variable", 8, "assignment to a read-only variable";
    REDECLARED = 2910025, "declared-twice", 8, "name that is declared twice or may not be declared";
    UNDECLARED = 2910026, "undeclared-name", 8, "undeclared name under strong declaration";
    UNINITIALISED = 2910027, "never-assigned", 4, "variable that is read but never assigned";
    BAD_ARRAY = 2910028, "illegal-array-use", 8, "array used as a single value, or a bad dimension";
    BAD_FORMAT = 2910029, "malformed-format", 8, "malformed string format";
    BAD_PATTERN = 2910030, "malformed-pattern", 8, "malformed regular expression";
    NOT_HERE = 2910031, "not-available-here", 8, "statement or function that is not available here";
    UNKNOWN_IDENTIFIER = 2910032, "unknown-identifier", 8, "code or data identifier that does not exist";
    TOO_LARGE = 2910033, "macro-too-large", 8, "macro with too many statements or variables";
    NO_FILE = 2910034, "include-unreadable", 8, "file of an INCLUD that cannot be read";
    TOO_MANY = 2910035, "too-many-macro-diagnostics", 8, "further diagnostics of a file are not listed";
    DUPLICATE_FUNCTION = 2910036, "function-defined-twice", 8, "function defined twice, or a malformed MACRO header";
    RECORD_IGNORED = 2910037, "post-record-ignored", 4, "record of the post product in a macro of the control emulator";
    TYPE_MISMATCH = 2910050, "wrong-value-type", 8, "value of the wrong type at run time";
    OUT_OF_RANGE = 2910051, "index-out-of-range", 8, "index outside of a text, sequence or array";
    BAD_ARITHMETIC = 2910052, "arithmetic-without-result", 8, "arithmetic without a result";
    FORMAT_MISMATCH = 2910053, "format-mismatch", 8, "string format that does not fit its arguments";
    RE_ENTERED = 2910054, "function-re-entered", 8, "function entered while it is running";
    TICKS = 2910055, "macro-steps-limit", 8, "macro that ran longer than its budget";
    DEPTH = 2910056, "macro-depth-limit", 8, "macros nested deeper than the budget";
    SIZE = 2910057, "value-size-limit", 8, "text, sequence or array larger than the budget";
    UNITS = 2910058, "file-units-limit", 8, "unit number out of range or too many units open";
    BACKTRACKING = 2910059, "pattern-steps-limit", 8, "regular expression that needs too many steps";
    UNIT_NOT_OPEN = 2910060, "file-unit-not-open", 8, "end-of-file test on a unit that is not open";
    STEP_ZERO = 2910061, "loop-step-zero", 8, "DO loop with step zero";
    UNKNOWN_DIAGNOSTIC = 2910062, "unknown-diagnostic", 8, "ERROR with a number that no table has";
    NO_HOST = 2910063, "not-offered-by-host", 8, "command or function that the host does not offer";
    BAD_VECTOR = 2910064, "illegal-vector-size", 8, "vector or matrix of an impossible size";
    TERMAC_GENERATED = 2910065, "macro-ended-by-error", 0, "macro ended because of an error";
    TYPED_STORE = 2910066, "declared-type-mismatch", 8, "value of the wrong type for a declared variable";
    OUTSIDE = 2910067, "file-outside-folder", 4, "file name that leads out of the folder of the run";
    NO_DIALOG = 2910068, "dialog-without-answer", 8, "dialog without answers";
    PROGRAM_END = 2910069, "past-program-end", 4, "block asked for behind the end of the NC program";
    NO_MODEL = 2910070, "no-machine-model", 0, "function of a machine model where there is none";
    NO_SETTING = 2910071, "no-such-setting", 4, "setting of the pre-processor that does not exist";
    BAD_VALUE = 2910072, "value-not-accepted", 8, "value that a system variable does not take";
    MEMORY = 2900310, "macro-memory-limit", 16, "macros that keep more values than the memory of the job holds";
    AUTHOR = 2910090, "macro-message", 0, "diagnostic issued by a macro itself";
}

impl Number {
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

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:08}", self.0)
    }
}
