//! Words of rotary and parallel axes in codes of the local frame: shifts, factors and mirrors of axes other than X, Y
//! and Z.
//!
//! Decisions: docs/emulation.md, "Local coordinate system". *Invariant:* a word of the axis that such a code takes
//! never moves it.

use counterpoint_lang::format::wildcard_text;

use crate::act::Act;
use counterpoint_machine::ident::{DataId, data};
use counterpoint_machine::index::{AxisSlot, BySlot};
use counterpoint_motion::frame::beside::{Line, Lines, SAME};
use counterpoint_motion::frame::local::Part;
use counterpoint_program::block::Datum;

/// Axes of a channel other than its X, Y and Z, with the data of their words.
fn axes(act: &Act<'_, '_>) -> Vec<(AxisSlot, DataId)> {
    let layout = &act.channel().state.place.layout;
    let beside = layout.axes.entries().filter(|(slot, _)| layout.is_beside(*slot));
    beside.map(|(slot, axis)| (slot, axis.data)).collect()
}

/// Takes the words of these axes and returns the new linear maps; none without words.
fn taken(act: &mut Act<'_, '_>, before: Lines, line: impl Fn(Datum) -> Line) -> Option<Lines> {
    let mut lines = before;
    let mut any = false;
    for (axis, id) in axes(act) {
        let Some(datum) = act.take(id) else { continue };
        any = true;
        *lines.at_mut(axis) = line(datum);
    }
    any.then_some(lines)
}

/// The part that is active, to which words of other axes are added.
fn part(act: &Act<'_, '_>, part: Part) -> Lines {
    let frames = act.channel().state.place.frames.as_deref().and_then(|frames| frames.beside.as_deref());
    frames.and_then(|beside| beside.part(part)).copied().unwrap_or(SAME)
}

/// Shifts; axes without a word keep theirs if the part is set.
pub(super) fn translation(act: &mut Act<'_, '_>, adds: bool) -> Option<Lines> {
    let before = if adds { SAME } else { part(act, Part::Translate) };
    taken(act, before, |datum| Line::shift(datum.value))
}

/// The shifts of these axes end, bit by axis.
pub(super) fn end_shift(act: &mut Act<'_, '_>, coded: u8) {
    let Some(beside) = act.channel().state.place.frames.as_deref().and_then(|frames| frames.beside.as_deref()) else {
        return;
    };
    let mut lines = part(act, Part::Translate);
    for (axis, _) in axes(act).into_iter().filter(|(axis, _)| coded & axis.bit() != 0) {
        *lines.at_mut(axis) = Line::SAME;
    }
    if let Ok(changed) = beside.with(Part::Translate, Some(lines)) {
        act.channel_mut().state.place.frames().beside = Some(Box::new(changed)).filter(|beside| !beside.is_empty());
        act.channel_mut().state.place.frames_changed();
    }
}

/// Factors, where the words of X, Y and Z are factors too and not places of the centre.
pub(super) fn scale(act: &mut Act<'_, '_>) -> Option<Lines> {
    let are_factors = act.registers_of(data::LCS_SCALE_X) & act.registers_of(data::AXIS_X) != 0;
    if are_factors { taken(act, SAME, |datum| Line::scale(datum.raw, 0.0)) } else { None }
}

/// Mirrors at the programmed places; axes without a word keep theirs if the part is set.
pub(super) fn mirror(act: &mut Act<'_, '_>, adds: bool) -> Option<Lines> {
    let before = if adds { SAME } else { part(act, Part::Mirror) };
    taken(act, before, |datum| Line::scale(-1.0, datum.value))
}

/// The mirrors that remain when those of the block are removed; none without words.
pub(super) fn fewer_mirrors(act: &mut Act<'_, '_>) -> Option<Lines> {
    let before = part(act, Part::Mirror);
    taken(act, before, |_| Line::SAME)
}

/// The axes of a part for the listing, all parts of a kind taken together: `,C=30`.
pub(super) fn text(act: &Act<'_, '_>, part: Part) -> String {
    let frames = act.channel().state.place.frames.as_deref();
    let Some(beside) = frames.and_then(|frames| frames.beside.as_deref()) else { return String::new() };
    let mut text = String::new();
    for (axis, _) in axes(act) {
        let lines = beside.parts(part).map(|lines| lines.at(axis));
        let (value, nothing) = match part {
            Part::Translate => (lines.map(|line| line.shift).sum(), 0.0),
            Part::Scale => (lines.map(|line| line.factor).product(), 1.0),
            Part::Mirror => (f64::from(u8::from(lines.filter(|line| line.factor < 0.0).count() % 2 == 1)), 0.0),
            Part::Rotate => (0.0, 0.0),
        };
        if value != nothing {
            text += &format!(",{}={}", act.channel().axis_name(axis), wildcard_text(value));
        }
    }
    text
}
