//! Alarms of a channel, and their effect in a block.

/// Alarms of a channel.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Alarms {
    /// A diagnostic of this block stops the channel before the next code acts.
    pub stopping: bool,
    /// Diagnostics of severity 8 or more in the log.
    pub errors: u32,
    /// Alarms gone on from that are not among them.
    pub softened: u32,
}

impl Alarms {
    /// Counts an entry of the log if it is an error.
    pub fn count(&mut self, severity: u8) {
        if severity >= ERROR {
            self.errors = self.errors.saturating_add(1);
        }
    }
}

/// Severity from which a diagnostic is an error.
const ERROR: u8 = 8;
