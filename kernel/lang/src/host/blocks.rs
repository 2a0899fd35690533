//! Commands of macros for the NC program and its blocks.

use crate::fault::Outcome;
use crate::format::RegisterHost;
use crate::state::MacroState;
use crate::value::MacroValue;

/// A command for the host.
#[derive(Debug)]
pub enum HostCommand<'a> {
    /// MATCH/ON, OFF
    Match(bool),
    /// Switches MATCH on, at the start and after the end of a user function.
    MatchAgain,
    /// OUTPUT, with the arguments of the macro as they are now: number and value.
    Output(&'a [(u8, MacroValue)]),
    /// EXEC of a block; the flag is NOW.
    ExecBlock(bool, &'a str),
    /// EXEC of identifiers and values; the flag is NOW.
    ExecItems(bool, &'a [MacroValue]),
    /// TAPERD
    TapeRead,
    /// TAPEWT
    TapeWrite,
    /// SEARCH
    Search(i64),
    /// SAVMODAL
    SaveModal,
    /// RSTMODAL
    RestoreModal,
    /// LPRINT/ON, OFF
    Listing(bool),
    /// LPRINT/n
    Skip(i64),
    /// PPRINT
    Print(&'a str),
    /// SYSTEM; returns the status
    System(&'a str),
}

/// The control that executes the commands of macros.
pub trait CommandHost: RegisterHost {
    /// Executes a command; returns a status for `$ERRNO`.
    ///
    /// # Errors
    /// The command is not available here, or failed.
    fn command(&mut self, state: &mut MacroState, command: HostCommand<'_>) -> Outcome<i32>;
}
