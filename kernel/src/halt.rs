//! Why a kernel leaves its program.

use crate::log::event::Stop;

/// Why a kernel leaves its program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Halt {
    /// An end code or the end of the text.
    End(Option<Stop>),
    /// An alarm of the control.
    Alarm,
    /// An alarm after which the machine continues: the rest of the block is dropped. It never leaves the block loop.
    Dropped,
    /// The job was stopped.
    Stopped,
    /// It waits for something that never comes.
    Blocked,
}

/// What an action returns.
pub(crate) type Acted = Result<(), Halt>;
