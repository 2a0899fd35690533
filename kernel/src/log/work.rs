//! What the time of an event was spent on.
//!
//! Invariant: an event with a duration belongs to one class and only one, so the classes of a channel and its waits
//! add up to its time. Facts: reference control-emulator.md 6.9 (feed, rapid, misc, idle).

use serde::Serialize;

use crate::log::event::{Kind, MotionKind};

/// Classes of working time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Work {
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
    /// Standing at a meeting point.
    Wait,
}

impl Work {
    /// Class of an event; `None` for kinds that never take time by themselves, and for waits, whose length is only
    /// known at their release.
    #[must_use]
    pub fn of(kind: &Kind) -> Option<Self> {
        match kind {
            Kind::Motion(motion) if motion.kind == MotionKind::Rapid => Some(Self::Rapid),
            Kind::Motion(_) => Some(Self::Feed),
            Kind::Tool { .. } => Some(Self::Tool),
            Kind::Dwell => Some(Self::Dwell),
            Kind::Spindle(_) | Kind::Function { .. } | Kind::Coolant(_) | Kind::Stop(_) => Some(Self::Misc),
            _ => None,
        }
    }
}
