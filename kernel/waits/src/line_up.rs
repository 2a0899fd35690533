//! Words at which the systems of a Mitsubishi or Citizen control line up.
//!
//! Facts: reference channel-synchronisation.md 1.6. Decision: the named systems and the own system take part. If that
//! is the own system alone, the systems whose programs have the label take part, and all systems if no other system has
//! it.

use counterpoint_event::info::Info;
use counterpoint_machine::model::Machine;
use counterpoint_machine::rows::{CodeForm, CodeRow};
use counterpoint_program::line_up::LineUp;
use counterpoint_program::sources::SeenSources;
use counterpoint_sync::wait::{ChannelSet, MarkSpace, WaitMark};

use super::{Meaning, all, of_row};

/// The meaning of such a word in this channel; none for other codes.
///
/// # Errors
/// Why its list of systems is not possible.
pub fn of_systems(
    machine: &Machine,
    (info, sources): (&Info, SeenSources<'_>),
    code: &CodeRow,
    (channel, word): (u16, LineUp),
) -> Option<Result<Meaning, String>> {
    let index = machine.sync.waits.iter().position(|row| row.line_up && row.is_of(&code.form))?;
    let row = machine.sync.waits.get(index)?;
    let CodeForm::Text(text) = &code.form else { return None };
    let mark = *text.as_bytes().first()?;
    let everybody = all(machine);
    let systems = everybody.0 as u32;
    let (named, label) = word.resolve(systems);
    if named & !systems != 0 {
        return Some(Err(format!(
            "the word names a system that this machine does not have, only {}",
            everybody.count()
        )));
    }
    let mut parts = ChannelSet(named.into()).with(channel);
    if parts.count() == 1 {
        let others = info.channels.iter().filter(|other| !other.program.is_empty());
        let users = others.filter(|other| {
            sources.whole(other.file).is_some_and(|file| file.seen_by(other.number).lines_up(mark, label, systems))
        });
        parts = users.map(|user| user.number).collect::<ChannelSet>().with(channel);
    }
    if parts.count() == 1 {
        parts = everybody;
    }
    let key = WaitMark { space: MarkSpace::Row(index as u16), number: label };
    Some(Ok(of_row((index as u16, row), key, (None, parts), channel)))
}
