//! Meeting of channels: waiting M codes of the Fanuc kind.
//!
//! Facts: reference channel-synchronisation.md 1.3. An illegal channel list alarms when the block is read; codes
//! that do not match alarm when two waits meet.

mod start;

use std::sync::Arc;

use crate::channel::Kernel;
use crate::control::State;
use crate::diag;
use crate::log::event::{Kind, Primitive, Release, Wait};
use crate::machine::ident::data;
use crate::machine::model::{CodeForm, CodeRow, PathsForm, SyncDialect};
use crate::multi::coordinator::turn::Met;
use crate::multi::order::Wake;
use crate::multi::order::arrive::After;
use crate::multi::tag::Tag;
use crate::multi::waits::{Finish, Set, Spec, Style, Terminal, Waiting};
use counterpoint_fault::{Acted, Halt};

/// Which marks a waiting code sets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Mark {
    /// Those of its word, for the channels that it names.
    Word,
    /// Of the two heads, with a word of its own on the main one.
    Main,
    /// With that of the side one.
    Side,
    /// Begin of a stretch that both heads cut together.
    Start,
    /// Its end.
    Stop,
    /// A start by this head.
    StartBy(u16),
}

/// A waiting code of the main and the side head: both meet at equal numbers, whatever their words.
fn meet_head(kernel: &mut Kernel<'_>, mark: Mark) -> Acted {
    let (id, letter) = match mark {
        Mark::Main => (data::SYNC_MAIN, 'S'),
        Mark::Side => (data::SYNC_SIDE, 'S'),
        Mark::Start => (data::SYNC_START, 'B'),
        Mark::StartBy(by) => return start::start(kernel, by),
        Mark::Stop | Mark::Word => (data::SYNC_STOP, 'E'),
    };
    let number = kernel.take(id).map_or(0.0, |d| d.value) as u32;
    let heads = heads(kernel);
    if passes(kernel) || !heads.has(kernel.channel.at.channel) || kernel.channel.env.machine.channels.len() < 2 {
        return pass(kernel);
    }
    let (primitive, named) = (Primitive::Barrier, Set::default());
    arrive(kernel, Spec { primitive, letter, number, named, parts: heads, style: Style::NoList })
}

/// The first two channels.
fn heads(kernel: &Kernel<'_>) -> Set {
    kernel.channel.env.machine.channels.iter().take(2).map(|channel| channel.number).collect()
}

/// The channel never waits.
fn passes(kernel: &Kernel<'_>) -> bool {
    kernel.channel.env.machine.sync.dialect == SyncDialect::None
        || kernel.channel.env.options.ignore_waits.contains(&kernel.channel.at.channel)
}

fn pass(kernel: &mut Kernel<'_>) -> Acted {
    kernel.emit(0, Kind::mode("sync passed without waiting"));
    Ok(())
}

/// A waiting code.
pub(super) fn meet(kernel: &mut Kernel<'_>, row: &CodeRow, mark: Mark) -> Acted {
    if mark != Mark::Word {
        return meet_head(kernel, mark);
    }
    let number = kernel.take(data::SYNC).map_or(0.0, |d| d.value);
    let paths = kernel.take(data::SYNC_PATHS).map(|d| d.raw);
    if passes(kernel) {
        return pass(kernel);
    }
    let letter = match row.form {
        CodeForm::Register { register, .. } | CodeForm::RegisterAsData { register, .. } => kernel
            .channel
            .env
            .machine
            .registers
            .get(usize::from(register))
            .and_then(|r| r.name.chars().next())
            .unwrap_or('M'),
        CodeForm::Text(_) | CodeForm::NotApplicable => 'M',
    };
    let all: Set = kernel.channel.env.machine.channels.iter().map(|channel| channel.number).collect();
    let spec = match participants(paths, kernel.channel.env.machine.sync.paths, all) {
        Ok(Some(named)) => Spec {
            primitive: Primitive::Barrier,
            letter,
            number: number as u32,
            named,
            parts: named.with(kernel.channel.at.channel),
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
            let text = format!("PS0161 illegal P of a waiting code: {reason} in '{}'", kernel.block_text());
            return Err(kernel.alarm(&diag::WAIT_ILLEGAL, text));
        }
    };
    arrive(kernel, spec)
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

/// Arrives, and waits until the others are there.
fn arrive(kernel: &mut Kernel<'_>, spec: Spec) -> Acted {
    let since_ns = kernel.channel.at.clock;
    let wait = kernel.channel.reports.waits.wait(&spec);
    kernel.channel.burden.result(crate::state::burden::RESULT);
    kernel.emit(0, Kind::Wait(wait.clone()));
    kernel.flow.pass.effects = true;
    let tag = kernel.tag();
    let (file, line, info) = (kernel.channel.at.file, kernel.channel.at.line, kernel.channel.env.info);
    let waiting = Waiting { spec, tag, file, line };
    let release = |meeting| Release { key: wait.key.clone(), primitive: wait.primitive, since_ns, meeting };
    kernel.ports.control.disturb(kernel.channel.at.channel);
    let met = kernel.ports.coordinator.meet(
        waiting.clone(),
        kernel,
        |kernel| {
            kernel.ports.emitter.flush(tag);
            kernel.ports.progress.stand(wait.clone());
        },
        |kernel, look| kernel.ports.emitter.work(look),
    );
    kernel.ports.control.disturb(kernel.channel.at.channel);
    let after = match met {
        Met::Woken(wake) => return woken(kernel, wake, release),
        Met::Turn(mut turn) => {
            let own = Finish { how: Terminal::Alarmed, file, line };
            turn.arrive(waiting, own, info)
        }
    };
    match after {
        After::Go { t, micro, meeting } => {
            kernel.ports.progress.set_state(State::Running);
            go_on(kernel, (t, micro), release(meeting));
            Ok(())
        }
        After::Alarm { text, verdict } => {
            let halt = kernel.fatal(&diag::WAIT_MISMATCH, text);
            if let Some(verdict) = verdict {
                kernel.emit_verdict(verdict);
            }
            Err(halt)
        }
        After::Stand(verdict) => {
            if let Some(verdict) = verdict {
                kernel.emit_verdict(verdict);
            }
            let wake = stand(kernel, tag, &wait);
            woken(kernel, wake, release)
        }
    }
}

/// Continues after a wait.
fn woken(kernel: &mut Kernel<'_>, wake: Wake, release: impl FnOnce(u64) -> Release) -> Acted {
    match wake {
        Wake::Released { tag, meeting, all } => {
            kernel.ports.progress.set_state(State::Running);
            if all {
                kernel.ports.emitter.all_reached(tag.t);
            }
            go_on(kernel, (tag.t, tag.micro), release(meeting));
            Ok(())
        }
        Wake::Alarm { tag, text } => {
            (kernel.channel.at.clock, kernel.channel.at.micro) = (tag.t, tag.micro);
            Err(kernel.fatal(&diag::WAIT_MISMATCH, text))
        }
        Wake::Over if kernel.ports.control.cancelled() => Err(Halt::Stopped),
        Wake::Over => Err(Halt::Blocked),
        Wake::Stopped | Wake::Turn => Err(Halt::Stopped),
    }
}

/// Waits until another channel ends the wait that this one is blocked at.
fn stand(kernel: &mut Kernel<'_>, tag: Tag, wait: &Arc<Wait>) -> Wake {
    let (coordinator, rank) = (kernel.ports.coordinator, kernel.channel.at.channel);
    let wake = coordinator.wait(rank, kernel, |kernel| {
        kernel.ports.emitter.flush(tag);
        kernel.ports.progress.stand(wait.clone());
    });
    kernel.ports.control.disturb(kernel.channel.at.channel);
    wake
}

/// Continues after a meeting.
fn go_on(kernel: &mut Kernel<'_>, (t, micro): (i64, u32), release: Release) {
    if t > kernel.channel.at.clock {
        kernel.channel.at.idle_blocks = 0;
        kernel.macros.variables.store.idle += t - kernel.channel.at.clock;
    }
    (kernel.channel.at.clock, kernel.channel.at.micro) = (t, micro);
    kernel.emit(0, Kind::Release(release));
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
