//! Commands of macros for the NC program and its blocks.

use crate::fault::Outcome;
use crate::format::Registers;
use crate::state::State;
use crate::value::Value;

/// A command for the host.
#[derive(Debug)]
pub enum Command<'a> {
    /// MATCH/ON, OFF
    Match(bool),
    /// Switches MATCH on, at the start and after the end of a user function.
    MatchAgain,
    /// OUTPUT, with the arguments of the macro as they are now: number and value.
    Output(&'a [(u8, Value)]),
    /// EXEC of a block; the flag is NOW.
    ExecBlock(bool, &'a str),
    /// EXEC of identifiers and values; the flag is NOW.
    ExecItems(bool, &'a [Value]),
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
pub trait Blocks: Registers {
    /// Executes a command; returns a status for `$ERRNO`.
    ///
    /// # Errors
    /// The command is not available here, or failed.
    fn command(&mut self, state: &mut State, command: Command<'_>) -> Outcome<i32>;
}
