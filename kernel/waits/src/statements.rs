//! Statements of a pre-processor at which channels wait for each other: rows of `[[waits]]` by the name of the
//! statement.
//!
//! *Invariant:* which arguments a statement takes follows from its row, so the pre-processor needs to know none of
//! them. Facts: reference channel-synchronisation.md 1.4.

use counterpoint_control_api::Operands;
use counterpoint_event::event::Primitive;
use counterpoint_machine::model::{Machine, WaitAct, WaitRow};
use counterpoint_sync::wait::{ChannelSet, MarkSpace, WaitMark};

use super::{Meaning, all, of_row};

/// The effect of a statement.
pub enum WaitStatement {
    /// It waits, or lets others continue.
    Meaning(Meaning),
    /// It starts these channels.
    Start(ChannelSet),
}

/// Waits of this primitive have a mark.
pub(super) fn has_mark(primitive: Primitive) -> bool {
    !matches!(primitive, Primitive::Join)
}

pub(super) fn find<'m>(machine: &'m Machine, name: &str) -> Option<(u16, &'m WaitRow)> {
    let rows = (0..).zip(&machine.sync.waits);
    rows.into_iter().find(|(_, row)| row.form.is_none() && row.word.eq_ignore_ascii_case(name))
}

/// Whether a statement of this row is about axes and spindles.
pub(super) fn takes_axes(row: &WaitRow) -> bool {
    row.primitive == Primitive::Lease && row.form.is_none()
}

/// Operands of a statement; `None` if it is not one of `[[waits]]`.
pub fn operands(machine: &Machine, name: &str) -> Option<Operands> {
    let (_, row) = find(machine, name)?;
    Some(match (row.primitive, row.act) {
        (Primitive::Lease, WaitAct::Give) => Operands::AxesAndChannels,
        (Primitive::Lease, _) => Operands::Axes,
        (_, WaitAct::Select) => Operands::Program,
        (Primitive::Join, _) => Operands::Channels,
        (_, WaitAct::Wait | WaitAct::Signal | WaitAct::Start) => Operands::MarkAndChannels,
        (_, WaitAct::Set | WaitAct::Clear | WaitAct::Release | WaitAct::Take | WaitAct::Give) => Operands::Marks,
    })
}

/// Meaning of a statement of `[[waits]]` in this channel; `mark` is 0 where there is none.
///
/// # Errors
/// Why its arguments are not possible.
pub fn by_statement(
    machine: &Machine,
    name: &str,
    channel: u16,
    mark: i64,
    channels: &[i64],
) -> Result<WaitStatement, String> {
    let (index, row) = find(machine, name).ok_or_else(|| format!("{name} is not known"))?;
    let number = u32::try_from(mark).ok().filter(|mark| *mark <= row.highest);
    let number = number.ok_or_else(|| format!("mark {mark} is not possible, only 0 to {}", row.highest))?;
    let everybody = all(machine);
    let mut named = ChannelSet::default();
    for &number in channels {
        named = named.with(known_channel(machine, number)?);
    }
    if row.act == WaitAct::Start {
        return Ok(WaitStatement::Start(named));
    }
    let parts = if channels.is_empty() { everybody } else { named.with(channel) };
    let named = (!channels.is_empty()).then_some(named);
    Ok(WaitStatement::Meaning(of_row(
        (index, row),
        WaitMark { space: MarkSpace::Statements, number },
        (named, parts),
        channel,
    )))
}

/// A channel of the machine by its number.
///
/// # Errors
/// There is no such channel.
pub fn known_channel(machine: &Machine, number: i64) -> Result<u16, String> {
    let known = u16::try_from(number).ok().filter(|number| all(machine).has(*number));
    known.ok_or_else(|| format!("the machine has no channel {number}"))
}
