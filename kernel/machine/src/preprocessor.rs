//! Pre-processors that a machine definition can name.
//!
//! Facts: reference control-emulator.md 1.1, 5.4. The behaviour of a pre-processor is not known here: a
//! [`Preprocessor`] is a row of a table, and above this module another table has the pre-processors themselves by name.
//! *Invariant:* a [`Preprocessor`] is always a row of the table.

/// Properties of a pre-processor on which machine definitions depend.
#[derive(Debug)]
pub struct PreprocessorRow {
    /// Name in machine definitions.
    pub name: &'static str,
    /// Words may call programs (`[[subprograms.calls]]`).
    pub calls_by_word: bool,
    /// Incremental words after a change of frame travel the change too, unless the machine says otherwise.
    pub frame_increments: bool,
    /// Coordinates without a decimal point may count least increments.
    pub counts_increments: bool,
    /// A semicolon starts a comment, so it does not end a block.
    pub semicolon_comments: bool,
    /// Statements of its own may be rows of `[[waits]]`.
    pub wait_statements: bool,
    /// Such statements have keywords in brackets.
    pub wait_keys: bool,
    /// The rewind-stop begins or ends names of programs, so no other text is beside it.
    pub named_stops: bool,
    /// Its variables of the machine's PLC are rows of `[[external]]`.
    pub external_variables: bool,
}

/// A row for plain words only, and the defaults of the others.
const PLAIN: PreprocessorRow = PreprocessorRow {
    name: "none",
    calls_by_word: false,
    frame_increments: false,
    counts_increments: false,
    semicolon_comments: false,
    wait_statements: false,
    wait_keys: false,
    named_stops: false,
    external_variables: false,
};

static ROWS: [PreprocessorRow; 9] = [
    PreprocessorRow { counts_increments: true, ..PLAIN },
    PreprocessorRow { name: "fanuc", calls_by_word: true, counts_increments: true, ..PLAIN },
    PreprocessorRow { name: "okuma", counts_increments: true, named_stops: true, ..PLAIN },
    PreprocessorRow {
        name: "siemens",
        frame_increments: true,
        semicolon_comments: true,
        wait_statements: true,
        named_stops: true,
        ..PLAIN
    },
    PreprocessorRow { name: "heidenhain", semicolon_comments: true, named_stops: true, ..PLAIN },
    PreprocessorRow {
        name: "isg",
        semicolon_comments: true,
        wait_statements: true,
        wait_keys: true,
        named_stops: true,
        external_variables: true,
        ..PLAIN
    },
    PreprocessorRow { name: "linuxcnc", semicolon_comments: true, ..PLAIN },
    PreprocessorRow { name: "grbl", semicolon_comments: true, ..PLAIN },
    PreprocessorRow { name: "grblhal", semicolon_comments: true, ..PLAIN },
];

/// Pre-processor of a control.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Preprocessor(u8);

impl Preprocessor {
    /// No pre-processor: plain words only.
    pub const NONE: Self = Self(0);

    /// All of them, in the order of the table.
    pub fn all() -> impl ExactSizeIterator<Item = Self> {
        (0..ROWS.len() as u8).map(Self)
    }

    /// Its row of the table.
    #[must_use]
    pub fn row(self) -> &'static PreprocessorRow {
        ROWS.get(usize::from(self.0)).unwrap_or(&PLAIN)
    }
}
