//! The kind of work of the time of an event.
//!
//! *Invariant:* an event with a duration belongs to one class and only one, so the classes of a channel and its waits
//! add up to its time. Facts: reference control-emulator.md 6.9 (feed, rapid, misc, idle).

use serde::Serialize;

/// Classes of working time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum WorkClass {
    /// Positioning.
    Rapid,
    /// Straight feed, arcs, threads.
    Feed,
    /// Tool change.
    Tool,
    /// Programmed dwell.
    Dwell,
    /// Spindle run-up and functions that take time.
    Misc,
    /// Waiting for other channels.
    Wait,
}
