//! Lists of channels as programs write them.
//!
//! Facts: reference channel-synchronisation.md 1.3 (parameter 8103 bit 1).

use counterpoint_machine::model::PathsForm;
use counterpoint_sync::wait::ChannelSet;

/// Largest value of a list.
const LARGEST: f64 = 9_999_999_999.0;

/// The channels of a list.
pub(super) fn named(value: f64, form: PathsForm, all: ChannelSet) -> Result<ChannelSet, String> {
    if value < 0.0 || value.fract() != 0.0 || value > LARGEST {
        return Err(format!("P{value} is not a positive whole number"));
    }
    let value = value as u64;
    let set = match form {
        PathsForm::Bits => bits(value, all),
        PathsForm::List => digits(value, all),
        PathsForm::Either => bits(value, all).or_else(|| digits(value, all)),
    };
    set.ok_or_else(|| format!("P{value} names a channel that this machine does not have"))
}

/// A sum of 2^(n−1).
fn bits(value: u64, all: ChannelSet) -> Option<ChannelSet> {
    let set = ChannelSet(value.into());
    (value > 0 && set.and(all) == set).then_some(set)
}

/// Numbers side by side; 0 is channel 10.
fn digits(value: u64, all: ChannelSet) -> Option<ChannelSet> {
    let channel = |digit: u8| if digit == b'0' { 10 } else { u16::from(digit - b'0') };
    let set: ChannelSet = value.to_string().bytes().map(channel).collect();
    (set.and(all) == set).then_some(set)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channel_lists_in_both_forms() {
        let set = |channels: &[u16]| Some(channels.iter().copied().collect::<ChannelSet>());
        for (value, form, count, expected) in [
            (3.0, PathsForm::Bits, 3, set(&[1, 2])),
            (7.0, PathsForm::Bits, 3, set(&[1, 2, 3])),
            (321.0, PathsForm::List, 3, set(&[1, 2, 3])),
            (12.0, PathsForm::Either, 2, set(&[1, 2])),
            (3.0, PathsForm::Either, 2, set(&[1, 2])),
            (12.0, PathsForm::Bits, 3, None),
            (14.0, PathsForm::List, 3, None),
            (-3.0, PathsForm::List, 3, None),
            (1.5, PathsForm::List, 3, None),
            (0.0, PathsForm::Bits, 3, None),
        ] {
            assert_eq!(named(value, form, ChannelSet::up_to(count)).ok(), expected, "{value} {form:?}");
        }
    }
}
