//! Where the double's lines go and where its files are.
//!
//! Invariant: the double itself touches nothing but memory; whoever runs macros for real gives it an [`Outside`].

use crate::diag::Diagnostic;

/// Kinds of lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stream {
    /// What PPRINT prints.
    Printed,
    /// The macro trace.
    Traced,
    /// What is written to the console.
    Console,
}

/// Facts of a file or folder.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Facts {
    /// Bytes.
    pub size: u64,
    /// Seconds since 1970 of the last access, change of the entry, and change of the content.
    pub times: [f64; 3],
    /// Bits: type and permissions as the system has them.
    pub mode: u32,
    /// Number of the owner.
    pub owner: u32,
    /// Number of the group.
    pub group: u32,
    /// Bits: 4 may be read, 2 may be written, 1 may be run.
    pub allowed: u8,
    /// It is a folder.
    pub folder: bool,
}

/// Status of a file that does not exist.
pub const NOT_FOUND: i32 = 2;
/// Status of a file that cannot be read or written.
pub const FAILED: i32 = 5;
/// Status of a file name that leads out of the folder of the run, or of a file that may not be used.
pub const FORBIDDEN: i32 = 13;
/// Status of arguments that make no sense.
pub const INVALID: i32 = 22;

/// A console, and files below one folder. Paths use `/`; a failure is a status for `$ERRNO`.
pub trait Outside: std::fmt::Debug {
    /// Takes a line; false if nobody takes lines any more, which ends the run.
    fn line(&mut self, stream: Stream, text: &str) -> bool;

    /// Takes a diagnostic.
    fn report(&mut self, diagnostic: &Diagnostic);

    /// One line from the console.
    fn console(&mut self) -> Option<String>;

    /// Text of a file.
    ///
    /// # Errors
    /// The status.
    fn read(&mut self, path: &str) -> Result<String, i32>;

    /// Replaces a file.
    ///
    /// # Errors
    /// The status.
    fn write(&mut self, path: &str, text: &str) -> Result<(), i32>;

    /// Facts of a file.
    ///
    /// # Errors
    /// The status.
    fn facts(&mut self, path: &str) -> Result<Facts, i32>;

    /// Removes a file.
    fn remove(&mut self, path: &str);

    /// Now: seconds since 1970-01-01 00:00, offset of the local zone in seconds, its name.
    fn now(&self) -> (f64, i32, String);

    /// Value of an environment variable.
    fn environment(&self, name: &str) -> Option<String>;
}
