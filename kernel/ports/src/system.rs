//! Commands of the operating system that macros start, where the owner of the server allows it.
//!
//! The kernel starts nothing itself: it hands out the files of the job and takes them back as the command has changed
//! them. The effect of a command is outside the promise that the same job gives the same log.

use bytes::Bytes;

/// A command.
#[derive(Debug)]
pub struct SystemCommand<'a> {
    /// The output of the macro.
    pub command: &'a str,
    /// Current folder below the folder of the run, empty for that one.
    pub folder: &'a str,
    /// All files that macros can read, by path, also those that they have written.
    pub files: Vec<(String, Bytes)>,
    /// Files stored with the machine, by path below `//ICAMFS/`.
    pub storage: Vec<(String, Bytes)>,
}

/// Its outcome.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct CommandOutcome {
    /// Status for `$ERRNO`: that of the command, or one above 0 that tells why there is none.
    pub status: i32,
    /// Its output.
    pub output: String,
    /// Files that are new or changed.
    pub written: Vec<(String, String)>,
    /// Files that are gone.
    pub removed: Vec<String>,
}

/// Starts commands.
pub trait System: Send + Sync {
    /// Runs a command to its end, or until `cancelled` is true.
    fn run(&self, call: &SystemCommand<'_>, cancelled: &dyn Fn() -> bool) -> CommandOutcome;
}
