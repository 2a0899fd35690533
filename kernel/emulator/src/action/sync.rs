//! Meeting of channels: waiting M codes of the Fanuc kind.
//!
//! Facts: reference channel-synchronisation.md 1.3. An illegal channel list alarms when the block is read; codes
//! that do not match alarm when two waits meet.

use crate::act::Act;
use crate::action::entry::Entry;
use counterpoint_event::event::{Kind, Primitive};
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::DataId;
use counterpoint_machine::ident::codes;
use counterpoint_machine::ident::data;
use counterpoint_machine::model::{PathsForm, SyncDialect};
use counterpoint_machine::rows::{CodeForm, CodeRow};
use counterpoint_sync::waits::{Set, Spec, Style};

/// Codes and what they do.
pub(crate) const ENTRIES: &[Entry] = &[
    Entry::of(&[codes::SYNC_REG], |act, row, _| meet(act, row)),
    Entry::of(&[codes::SYNC_REG_MAIN], |act, _, _| meet_head(act, data::SYNC_MAIN, 'S')),
    Entry::of(&[codes::SYNC_REG_SIDE], |act, _, _| meet_head(act, data::SYNC_SIDE, 'S')),
    // The begin of a stretch that both heads cut together, and its end.
    Entry::of(&[codes::SYNC_REG_START], |act, _, _| meet_head(act, data::SYNC_START, 'B')),
    Entry::of(&[codes::SYNC_REG_STOP], |act, _, _| meet_head(act, data::SYNC_STOP, 'E')),
    Entry::of(&[codes::SYNC_START_MAIN], |act, _, _| start(act, 1)),
    Entry::of(&[codes::SYNC_START_SIDE], |act, _, _| start(act, 2)),
];

/// A waiting code of the main and the side head: both meet at equal numbers, whatever their words.
fn meet_head(act: &mut Act<'_, '_>, id: DataId, letter: char) -> Acted {
    let number = act.take(id).map_or(0.0, |d| d.value) as u32;
    let heads = heads(act);
    if passes(act) || !heads.has(act.at.channel) || act.env.machine.channels.len() < 2 {
        return pass(act);
    }
    let (primitive, named) = (Primitive::Barrier, Set::default());
    act.arrive(Spec { primitive, letter, number, named, parts: heads, style: Style::NoList })
}

/// The first two channels.
fn heads(act: &Act<'_, '_>) -> Set {
    act.env.machine.channels.iter().take(2).map(|channel| channel.number).collect()
}

/// The channel never waits.
fn passes(act: &Act<'_, '_>) -> bool {
    act.env.machine.sync.dialect == SyncDialect::None || act.env.options.ignore_waits.contains(&act.at.channel)
}

fn pass(act: &mut Act<'_, '_>) -> Acted {
    act.emit(0, Kind::mode("sync passed without waiting"));
    Ok(())
}

/// A waiting code.
fn meet(act: &mut Act<'_, '_>, row: &CodeRow) -> Acted {
    let number = act.take(data::SYNC).map_or(0.0, |d| d.value);
    let paths = act.take(data::SYNC_PATHS).map(|d| d.raw);
    if passes(act) {
        return pass(act);
    }
    let letter = match row.form {
        CodeForm::Register { register, .. } | CodeForm::RegisterAsData { register, .. } => {
            act.env.machine.registers.get(usize::from(register)).and_then(|r| r.name.chars().next()).unwrap_or('M')
        }
        CodeForm::Text(_) | CodeForm::NotApplicable => 'M',
    };
    let all: Set = act.env.machine.channels.iter().map(|channel| channel.number).collect();
    let spec = match participants(paths, act.env.machine.sync.paths, all) {
        Ok(Some(named)) => Spec {
            primitive: Primitive::Barrier,
            letter,
            number: number as u32,
            named,
            parts: named.with(act.at.channel),
            style: Style::Listed,
        },
        Ok(None) => Spec {
            primitive: Primitive::Barrier,
            letter,
            number: number as u32,
            named: Set::default(),
            parts: all,
            style: Style::NoList,
        },
        Err(reason) => {
            let text = format!("PS0161 illegal P of a waiting code: {reason} in '{}'", act.block_text());
            return Err(act.alarm(&diag::WAIT_ILLEGAL, text));
        }
    };
    act.arrive(spec)
}

/// Channels of a P word: `None` without P, which only two channels may do.
fn participants(paths: Option<f64>, form: PathsForm, all: Set) -> Result<Option<Set>, String> {
    let Some(value) = paths else {
        let count = all.iter().count();
        return if count == 2 {
            Ok(None)
        } else {
            Err(format!("a wait without P is possible with two channels only, this machine has {count}"))
        };
    };
    if value < 0.0 || value.fract() != 0.0 || value > 9_999_999_999.0 {
        return Err(format!("P{value} is not a positive whole number"));
    }
    let value = value as u64;
    let bits = || {
        let set = Set(value.into());
        (value > 0 && set.iter().all(|channel| all.has(channel))).then_some(set)
    };
    let list = || {
        let mut set = Set::default();
        for digit in value.to_string().bytes() {
            let channel = if digit == b'0' { 10 } else { u16::from(digit - b'0') };
            if !all.has(channel) {
                return None;
            }
            set = set.with(channel);
        }
        Some(set)
    };
    let set = match form {
        PathsForm::Bits => bits(),
        PathsForm::List => list(),
        PathsForm::Either => bits().or_else(list),
    };
    match set {
        Some(set) => Ok(Some(set)),
        None => Err(format!("P{value} names a channel that this machine does not have")),
    }
}

/// Carries out the start by a head.
fn start(act: &mut Act<'_, '_>, by: u16) -> Acted {
    let heads = heads(act);
    // The code names a head by its place: the first or the second channel.
    let by = heads.iter().nth(usize::from(by).saturating_sub(1)).unwrap_or(by);
    let gives = act.at.channel == by && act.env.machine.sync.dialect != SyncDialect::None;
    if !heads.has(act.at.channel) || act.env.machine.channels.len() < 2 || !gives && passes(act) {
        return pass(act);
    }
    act.start_by_head(by, heads)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set(paths: &[u16]) -> Option<Set> {
        Some(paths.iter().fold(Set::default(), |s, &c| s.with(c)))
    }

    #[test]
    fn channel_lists_in_both_forms() {
        for (value, form, count, expected) in [
            (3.0, PathsForm::Bits, 3, Ok(set(&[1, 2]))),
            (7.0, PathsForm::Bits, 3, Ok(set(&[1, 2, 3]))),
            (321.0, PathsForm::List, 3, Ok(set(&[1, 2, 3]))),
            (12.0, PathsForm::Either, 2, Ok(set(&[1, 2]))),
            (3.0, PathsForm::Either, 2, Ok(set(&[1, 2]))),
            (12.0, PathsForm::Bits, 3, Err(())),
            (14.0, PathsForm::List, 3, Err(())),
            (-3.0, PathsForm::List, 3, Err(())),
            (1.5, PathsForm::List, 3, Err(())),
            (0.0, PathsForm::Bits, 3, Err(())),
        ] {
            assert_eq!(
                participants(Some(value), form, Set::up_to(count)).map_err(|_| ()),
                expected,
                "{value} {form:?}"
            );
        }
        assert_eq!(participants(None, PathsForm::Bits, Set::up_to(2)), Ok(None));
        assert!(participants(None, PathsForm::List, Set::up_to(3)).is_err());
    }
}
