//! Why a channel leaves its program, or stops in it.

use serde::Serialize;

/// The code that stops or ends a program.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum StopCode {
    /// M0.
    Program,
    /// M1 with the switch on.
    Optional,
    /// M2.
    End,
    /// M30.
    Rewind,
}

/// Why a kernel leaves its program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Halt {
    /// An end code or the end of the text.
    ProgramEnd(Option<StopCode>),
    /// An alarm of the control.
    Alarm,
    /// An alarm after which the machine continues: the rest of the block is dropped. It never leaves the block loop.
    Dropped,
    /// The job was stopped.
    Stopped,
    /// The channel waits for something that will never come.
    Blocked,
}

/// Result of an action.
pub type Acted = Result<(), Halt>;
