//! Diagnostics.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::declare::record;

record! {
    /// A diagnostic of the program, the machine or a limit.
    #[derive(Debug, Clone, PartialEq, Eq, Default)]
    pub struct Diagnostic {
        /// Stable number with a page in `docs/diagnostics/`.
        pub number: u32 = 1,
        /// 0–3 message, 4–7 warning, 8–15 error, 16–99 fatal.
        pub severity: u8 = 2,
        /// Text for people, one line.
        pub text: Box<str> = 3,
        /// Name of the operation as macros have set it (`$OPNAME`), empty without one.
        pub operation: Box<str> = 4 [added],
        /// Name of the kernel as macros have set it (`$MCENAM`), empty while it is that of the channel.
        pub kernel: Box<str> = 5 [added],
        /// The statement of a macro that raised it, none if no macro did.
        pub origin: Option<Box<DiagnosticOrigin>> = 6 [added],
        /// The unrecognised text, if the diagnostic is about it.
        pub unrecognised: Option<Box<Unrecognised>> = 7 [wire],
        /// The access with which the block races, if the diagnostic reports a race.
        pub race: Option<Box<RaceWith>> = 8 [wire],
    }
}

record! {
    /// The earlier one of two accesses to a variable that race.
    #[derive(Debug, Clone, PartialEq, Eq, Default)]
    pub struct RaceWith {
        /// The variable by its name in programs.
        pub variable: Box<str> = 1,
        /// Channel of the earlier access.
        pub channel: u16 = 2,
        /// Line of the earlier access, from 1.
        pub line: u32 = 3,
    }
}

record! {
    /// Text of a block that no code takes.
    #[derive(Debug, Clone, PartialEq, Eq, Default)]
    pub struct Unrecognised {
        /// Its block in quotes, and possible mistakes in the block.
        pub text: Box<str> = 1,
        /// Its block in quotes, and possible mistakes in the block.
        pub place: Box<str> = 2,
    }
}

/// As the diagnostic says it.
impl fmt::Display for Unrecognised {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} not recognised in {}", self.text, self.place)
    }
}

record! {
    /// A statement of a macro, or a block of a resident program, that raised a diagnostic.
    #[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
    #[serde(default)]
    pub struct DiagnosticOrigin {
        /// Name of the macro as the trace shows it, or of the program as blocks call it.
        #[serde(rename = "macro")]
        pub name: Box<str> = 1 [as "macro"],
        /// Its file.
        pub file: Box<str> = 2,
        /// Line in that file, from 1.
        pub line: u32 = 3,
        /// The statement as the trace shows it.
        pub statement: Box<str> = 4,
    }
}
