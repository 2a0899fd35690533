//! Signals of ISG and Beckhoff controls: `#SIGNAL [ID7 CH2]`, `#WAIT [ID7 CH1]`, `#SIGNAL REMOVE`, `#SIGNAL READ`.
//!
//! Facts: reference channel-synchronisation.md 1.7; the numbers in texts are those of the control's alarms. Decisions:
//! with a list a channel may name itself; a signal without a list and without a count is one for each other channel, or
//! stays until it is removed, as the row of the machine says; with a count it is for this many waits of whichever
//! channels. *Invariant:* all numbers count in one family.

use counterpoint_control_api::Signal;
use counterpoint_event::event::Primitive;
use counterpoint_machine::model::{Machine, WaitAct, WaitRow};
use counterpoint_sync::wait::{ChannelSet, Lasts, MarkSpace, RuleId, Send, SignalRules, Wait, WaitMark};

use super::all;
use super::statements::{find, known_channel};

/// Most waits that a signal is for.
const MOST_USES: f64 = 1_000_000.0;

/// A statement as programs write it.
pub(super) fn word(row: &WaitRow) -> Box<str> {
    format!("#{}", row.word).into()
}

/// The signal rules of a row.
pub(super) fn rule(machine: &Machine, row: &WaitRow) -> SignalRules {
    let sends = |other: &&WaitRow| other.signals.keys && other.act == WaitAct::Signal;
    let waits = row.signals.keys && row.primitive == Primitive::Signal && row.act == WaitAct::Wait;
    SignalRules {
        sent_by: machine.sync.waits.iter().find(sends).filter(|_| waits).map(word),
        to_itself: row.signals.keys,
        in_order: row.signals.in_order,
        most: machine.sync.signals,
    }
}

/// The number of a signal.
///
/// # Errors
/// The control has no such number.
pub fn signal_number(machine: &Machine, statement: &str, number: f64) -> Result<u32, String> {
    let highest = find(machine, statement).map_or(0, |(_, row)| row.highest);
    let possible = number.fract() == 0.0 && (0.0..=f64::from(highest)).contains(&number);
    if possible {
        Ok(number as u32)
    } else {
        Err(format!("20995 signal {number} is not possible, only 0 to {highest}"))
    }
}

/// Channels of a list.
fn channels(machine: &Machine, numbers: &[f64]) -> Result<Option<ChannelSet>, String> {
    let mut named = ChannelSet::default();
    for number in numbers {
        let whole = if number.fract() == 0.0 && number.abs() < 1e9 { *number as i64 } else { -1 };
        let channel =
            known_channel(machine, whole).map_err(|_| format!("250008 the machine has no channel {number}"))?;
        named = named.with(channel);
    }
    Ok((!numbers.is_empty()).then_some(named))
}

/// The row of a statement, the mark, and the list.
fn read<'m>(
    machine: &'m Machine,
    statement: &str,
    signal: &Signal,
) -> Result<(RuleId, &'m WaitRow, WaitMark, Option<ChannelSet>), String> {
    let (index, row) = find(machine, statement).ok_or_else(|| format!("{statement} is not known"))?;
    let key = WaitMark { space: MarkSpace::Statements, number: signal_number(machine, statement, signal.number)? };
    Ok((RuleId::Row(index), row, key, channels(machine, &signal.channels)?))
}

/// A signal that is sent, and the wait that it is shown as.
///
/// # Errors
/// Why its number, its list or its count is not possible.
pub fn signal(machine: &Machine, statement: &str, channel: u16, signal: &Signal) -> Result<(Send, Wait), String> {
    let (rule, row, key, named) = read(machine, statement, signal)?;
    let lasts = match signal.uses {
        Some(uses) if uses.fract() != 0.0 || !(1.0..=MOST_USES).contains(&uses) => {
            return Err(format!("COUNT is {uses}; it must be a whole number from 1 to {MOST_USES}"));
        }
        Some(uses) => Lasts::Times(uses as u32),
        None if row.signals.stays && named.is_none() => Lasts::Always,
        None => Lasts::Each,
    };
    let to = named.unwrap_or(if lasts == Lasts::Each { all(machine).without(channel) } else { all(machine) });
    let shown = Wait { primitive: Primitive::Signal, key, named, parts: to.with(channel), need: 0, rule };
    Ok((Send { key, to, broadcast: named.is_none(), lasts }, shown))
}

/// A wait for signals.
///
/// # Errors
/// Why its number or its list is not possible.
pub fn signal_wait(machine: &Machine, statement: &str, channel: u16, signal: &Signal) -> Result<Wait, String> {
    let (rule, _, key, named) = read(machine, statement, signal)?;
    let parts = named.unwrap_or(all(machine)).with(channel);
    let need = u16::from(named.is_none());
    Ok(Wait { primitive: Primitive::Signal, key, named, parts, need, rule })
}
