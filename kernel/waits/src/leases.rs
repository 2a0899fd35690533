//! Axes and spindles that channels exchange: rows of `[[waits]]` with the primitive `lease` by the name of a statement.
//!
//! *Invariant:* each axis and each spindle of the machine has one number, which is that of its lease. Facts: reference
//! channel-synchronisation.md 1.4, 1.9.

use std::sync::Arc;

use counterpoint_event::event::Primitive;
use counterpoint_machine::index::AxisId;
use counterpoint_machine::model::{Machine, WaitAct};
use counterpoint_sync::wait::{ChannelSet, MarkSpace, Wait, WaitMark, WaitOp};

use super::statements::{find, known_channel};
use super::{Meaning, all, of_row};

/// The kind of object that a statement exchanges.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Leased {
    /// An axis that channels exchange.
    Axis(AxisId),
    /// An axis that the channel always has.
    Own,
    /// A spindle.
    Spindle,
}

/// The lease of an axis.
#[must_use]
pub fn of_axis(axis: AxisId) -> WaitMark {
    WaitMark { space: MarkSpace::Lease, number: axis.index() as u32 }
}

/// The lease of a spindle, by its position.
fn of_spindle(machine: &Machine, at: usize) -> WaitMark {
    WaitMark { space: MarkSpace::Lease, number: (machine.axes.len() + at) as u32 }
}

/// Names of all that has a lease, by number.
pub(super) fn names(machine: &Machine) -> Arc<[Box<str>]> {
    let axes = machine.axes.iter().map(|axis| axis.name.as_str().into());
    axes.chain(machine.spindles.iter().map(|spindle| format!("S{}", spindle.number).into())).collect()
}

/// Meaning of a statement for an axis or a spindle.
///
/// # Errors
/// The channel has no such axis, or the machine no such channel.
pub fn by_name(
    machine: &Machine,
    (statement, name): (&str, &str),
    channel: u16,
    to: Option<i64>,
) -> Result<(Leased, Meaning), String> {
    let (index, row) = find(machine, statement).ok_or_else(|| format!("{statement} is not known"))?;
    let own = machine.channels.iter().find(|own| own.number == channel);
    let axis = own.and_then(|own| {
        let has = |axis: &&AxisId| machine.axes[**axis].name.eq_ignore_ascii_case(name);
        own.axes.iter().find(has).copied()
    });
    let (leased, key) = match (axis, spindle(machine, name)) {
        (Some(axis), _) if machine.axes[axis].master.is_some() => (Leased::Axis(axis), of_axis(axis)),
        (Some(axis), _) => (Leased::Own, of_axis(axis)),
        (None, Some(at)) => (Leased::Spindle, of_spindle(machine, at)),
        (None, None) => return Err(format!("channel {channel} has no axis {name} in its list of axes")),
    };
    let meaning = of_row((index, row), key, (None, all(machine)), channel);
    let Some(to) = to.filter(|_| row.act == WaitAct::Give) else { return Ok((leased, meaning)) };
    let to = known_channel(machine, to)?;
    let lists = |channel: u16| {
        let row = machine.channels.iter().find(|row| row.number == channel);
        row.is_some_and(|row| axis.is_none_or(|axis| row.axes.as_slice().contains(&axis)))
    };
    if !lists(to) {
        return Err(format!("channel {to} has no axis {name} in its list of axes"));
    }
    let shown = Wait { named: Some(ChannelSet::default().with(to)), ..shown(meaning) };
    Ok((leased, if to == channel { Meaning::Wait(shown) } else { Meaning::Act(WaitOp::Give { key, to }, shown) }))
}

fn shown(meaning: Meaning) -> Wait {
    match meaning {
        Meaning::Wait(wait) | Meaning::Act(_, wait) => wait,
    }
}

/// Position of a spindle that a program names: `S2`, or its number.
fn spindle(machine: &Machine, name: &str) -> Option<usize> {
    let number: u16 = name.trim_start_matches(['S', 's']).parse().ok()?;
    machine.spindles.iter().position(|spindle| spindle.number == number)
}

/// The wait with which a machine asks for an axis by itself.
pub fn automatic(machine: &Machine, axis: AxisId, channel: u16) -> Option<Wait> {
    let asks = |row: &counterpoint_machine::model::WaitRow| {
        row.primitive == Primitive::Lease && row.act == WaitAct::Wait && row.form.is_none()
    };
    let (index, row) = (0..).zip(&machine.sync.waits).find(|(_, row)| asks(row))?;
    Some(shown(of_row((index, row), of_axis(axis), (None, all(machine)), channel)))
}
