//! Marks of Siemens: lists of channels that are not mutual are warning 16949.
//!
//! Facts: reference channel-synchronisation.md 1.4. The alarm is for display only; the waits continue.

use counterpoint_event::event::Primitive;
use counterpoint_sync::wait::{MismatchCheck, Reaction, Wait};

/// Alarm 16949.
pub(super) const MISMATCH: MismatchCheck =
    MismatchCheck { refuses, title: "16949 marks of channels do not correspond", reaction: Reaction::Warning };

/// Channels that wait at the same mark with different lists, of which one concerns the other.
fn refuses(wait: &Wait, other: &Wait) -> Option<&'static str> {
    let flags = wait.primitive == Primitive::Flag && other.primitive == Primitive::Flag;
    let meet = wait.parts != other.parts && !wait.parts.and(other.parts).is_empty();
    (flags && wait.key == other.key && meet).then_some("different channels at one mark")
}

#[cfg(test)]
mod tests {
    use super::*;
    use counterpoint_sync::wait::{ChannelSet, WaitMark};
    use counterpoint_sync::wait::{MarkSpace, RuleId};

    #[test]
    fn lists_correspond_when_they_are_equal_or_have_nobody_in_common() {
        let wait = |number, channels: &[u16]| {
            let parts: ChannelSet = channels.iter().copied().collect();
            let key = WaitMark { space: MarkSpace::Statements, number };
            Wait { primitive: Primitive::Flag, key, named: Some(parts), parts, need: 0, rule: RuleId::Start }
        };
        for (one, other, warns) in [
            (wait(40, &[1, 2]), wait(40, &[1, 2]), false),
            (wait(40, &[1, 2]), wait(40, &[2, 4]), true),
            (wait(40, &[1, 2]), wait(40, &[1, 2, 3]), true),
            (wait(40, &[1, 2]), wait(40, &[3, 4]), false),
            (wait(40, &[1, 2]), wait(41, &[2, 4]), false),
        ] {
            assert_eq!(refuses(&one, &other).is_some(), warns, "{one:?} {other:?}");
        }
    }
}
