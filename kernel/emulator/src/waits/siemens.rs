//! Marks of Siemens: lists of channels that are not mutual are warning 16949.
//!
//! Facts: reference channel-synchronisation.md 1.4. The alarm is for display only; the waits continue.

use counterpoint_event::event::Primitive;
use counterpoint_sync::wait::{Mismatch, Reaction, Wait};

/// Alarm 16949.
pub(super) const MISMATCH: Mismatch =
    Mismatch { refuses, title: "16949 marks of channels do not correspond", reaction: Reaction::Warning };

/// Channels that wait at the same mark with different lists.
fn refuses(wait: &Wait, other: &Wait) -> Option<&'static str> {
    let flags = wait.primitive == Primitive::Flag && other.primitive == Primitive::Flag;
    (flags && wait.key == other.key && wait.parts != other.parts).then_some("different channels at one mark")
}
