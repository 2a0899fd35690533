//! Waiting M codes of Fanuc: which pairs are alarm PS0160, and which lists PS0161.
//!
//! Facts: reference channel-synchronisation.md 1.3. An illegal list alarms when the block is read; codes that do not
//! match alarm when two channels wait at the same time.

use counterpoint_event::event::Primitive;
use counterpoint_machine::model::PathsForm;
use counterpoint_sync::wait::{ChannelSet, MarkSpace, MismatchCheck, Reaction, Wait, WaitRule};

use super::{WaitArguments, channels};

/// Alarm PS0160.
pub(super) const MISMATCH: MismatchCheck =
    MismatchCheck { refuses, title: "PS0160 waiting codes do not match", reaction: Reaction::Alarm };

/// Words of alarm PS0161.
const ILLEGAL: &str = "PS0161 illegal P of a waiting code";

/// Waiting codes of a letter.
pub(super) fn rule(letter: &str) -> WaitRule {
    WaitRule { list: " P".into(), mismatch: Some(MISMATCH), ..WaitRule::plain(letter) }
}

/// Case of PS0160 when both stand at the same time.
fn refuses(wait: &Wait, other: &Wait) -> Option<&'static str> {
    // Codes that two channels execute together are not waiting codes.
    let joint = [wait, other]
        .iter()
        .any(|wait| matches!(wait.key.space, MarkSpace::Coupling(_) | MarkSpace::Lease | MarkSpace::Balance));
    if joint || wait.primitive != Primitive::Barrier || other.primitive != Primitive::Barrier {
        return None;
    }
    let same_code = wait.key == other.key;
    match (wait.named, other.named) {
        (None, None) if !same_code => Some("different codes without P"),
        (None, Some(_)) | (Some(_), None) => Some("one with P, one without"),
        (Some(named), Some(others)) if same_code && named != others => Some("the same code with different P"),
        (Some(named), Some(others)) if !same_code && named == others => Some("different codes with the same P"),
        _ => None,
    }
}

/// The channels of a P word, as written and in all. Only two channels can wait without one.
pub(super) fn participants(
    said: WaitArguments,
    form: PathsForm,
    all: ChannelSet,
) -> Result<(Option<ChannelSet>, ChannelSet), String> {
    match said.list {
        Some(list) => match channels::named(list, form, all) {
            Ok(named) => Ok((Some(named), named.with(said.channel))),
            Err(reason) => Err(format!("{ILLEGAL}: {reason}")),
        },
        None if all.count() == 2 => Ok((None, all)),
        None => {
            let count = all.count();
            let list: String = match form {
                PathsForm::Bits => (0..count.min(31)).map(|at| 1_u64 << at).sum::<u64>().to_string(),
                _ => (1..=count).map(|number| (number % 10).to_string()).collect(),
            };
            Err(format!(
                "{ILLEGAL}: a wait without P is possible with two channels only, this machine has {count}; P{list} waits for all \
                 of them"
            ))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use counterpoint_sync::wait::{RuleId, WaitMark};

    #[test]
    fn cases_of_the_alarm() {
        let wait = |number, named: &[u16]| {
            let named = (!named.is_empty()).then(|| named.iter().copied().collect::<ChannelSet>());
            let parts = named.unwrap_or(ChannelSet::up_to(2));
            let key = WaitMark { space: MarkSpace::Statements, number };
            Wait { primitive: Primitive::Barrier, key, named, parts, need: 0, rule: RuleId::Start }
        };
        for (first, second, alarm) in [
            (wait(101, &[]), wait(102, &[]), true),
            (wait(101, &[1, 2]), wait(102, &[1, 2]), true),
            (wait(101, &[1, 2, 3]), wait(101, &[1, 2]), true),
            (wait(101, &[]), wait(101, &[1, 2]), true),
            (wait(101, &[1, 2]), wait(102, &[2, 3]), false),
            (wait(101, &[1, 2]), wait(101, &[1, 2]), false),
            (wait(101, &[]), Wait { primitive: Primitive::Signal, ..wait(102, &[]) }, false),
        ] {
            assert_eq!(refuses(&first, &second).is_some(), alarm, "{first:?} {second:?}");
            assert_eq!(refuses(&second, &first).is_some(), alarm, "{first:?} {second:?}");
        }
    }

    #[test]
    fn only_two_channels_wait_without_a_list() {
        let said = WaitArguments { channel: 1, number: 101, list: None };
        assert_eq!(participants(said, PathsForm::Bits, ChannelSet::up_to(2)), Ok((None, ChannelSet::up_to(2))));
        assert!(participants(said, PathsForm::List, ChannelSet::up_to(3)).is_err());
        let listed = WaitArguments { list: Some(2.0), ..said };
        let two = ChannelSet::default().with(2);
        assert_eq!(participants(listed, PathsForm::List, ChannelSet::up_to(3)), Ok((Some(two), ChannelSet::up_to(2))));
    }
}
