//! Words of rotary and parallel axes in codes of the local frame: shifts, factors and mirrors of axes other than X, Y
//! and Z.
//!
//! Decisions: docs/emulation.md, "Local coordinate system". *Invariant:* a word of the axis that such a code takes
//! never moves it.

use counterpoint_lang::format::wildcard_text;

use crate::context::ActionContext;
use counterpoint_machine::ident::{DataId, data};
use counterpoint_machine::index::{AxisSlot, BySlot};
use counterpoint_motion::frame::beside::{AxisMap, Lines, SAME};
use counterpoint_motion::frame::local::LocalFramePart;
use counterpoint_program::block::RetrievedValue;

/// Axes of a channel other than its X, Y and Z, with the data of their words.
fn axes(act: &ActionContext<'_, '_>) -> Vec<(AxisSlot, DataId)> {
    let layout = &act.channel().state.place.layout;
    let beside = layout.axes.entries().filter(|(slot, _)| layout.is_beside(*slot));
    beside.map(|(slot, axis)| (slot, axis.data)).collect()
}

/// Takes the words of these axes and returns the new linear maps; none without words.
fn taken(act: &mut ActionContext<'_, '_>, before: Lines, line: impl Fn(RetrievedValue) -> AxisMap) -> Option<Lines> {
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
fn part(act: &ActionContext<'_, '_>, part: LocalFramePart) -> Lines {
    let frames = act.channel().state.place.frames.as_deref().and_then(|frames| frames.beside.as_deref());
    frames.and_then(|beside| beside.part(part)).copied().unwrap_or(SAME)
}

/// Shifts; axes without a word keep theirs if the part is set.
pub(crate) fn translation(act: &mut ActionContext<'_, '_>, adds: bool) -> Option<Lines> {
    let before = if adds { SAME } else { part(act, LocalFramePart::Translate) };
    taken(act, before, |datum| AxisMap::shift(datum.value))
}

/// The shifts of these axes end, bit by axis.
pub(crate) fn end_shift(act: &mut ActionContext<'_, '_>, coded: u8) {
    let Some(beside) = act.channel().state.place.frames.as_deref().and_then(|frames| frames.beside.as_deref()) else {
        return;
    };
    let mut lines = part(act, LocalFramePart::Translate);
    for (axis, _) in axes(act).into_iter().filter(|(axis, _)| coded & axis.bit() != 0) {
        *lines.at_mut(axis) = AxisMap::SAME;
    }
    if let Ok(changed) = beside.with(LocalFramePart::Translate, Some(lines)) {
        act.channel_mut().state.place.frames().beside = Some(Box::new(changed)).filter(|beside| !beside.is_empty());
        act.channel_mut().state.place.frames_changed();
    }
}

/// Factors, where the words of X, Y and Z are factors too and not places of the centre.
pub(crate) fn scale(act: &mut ActionContext<'_, '_>) -> Option<Lines> {
    let are_factors = act.registers_of(data::LCS_SCALE_X) & act.registers_of(data::AXIS_X) != 0;
    if are_factors { taken(act, SAME, |datum| AxisMap::scale(datum.raw, 0.0)) } else { None }
}

/// Mirrors at the programmed places; axes without a word keep theirs if the part is set.
pub(crate) fn mirror(act: &mut ActionContext<'_, '_>, adds: bool) -> Option<Lines> {
    let before = if adds { SAME } else { part(act, LocalFramePart::Mirror) };
    taken(act, before, |datum| AxisMap::scale(-1.0, datum.value))
}

/// The mirrors that remain when those of the block are removed; none without words.
pub(crate) fn fewer_mirrors(act: &mut ActionContext<'_, '_>) -> Option<Lines> {
    let before = part(act, LocalFramePart::Mirror);
    taken(act, before, |_| AxisMap::SAME)
}

/// The axes of a part for the listing, all parts of a kind taken together: `,C=30`.
pub(crate) fn text(act: &ActionContext<'_, '_>, part: LocalFramePart) -> String {
    let frames = act.channel().state.place.frames.as_deref();
    let Some(beside) = frames.and_then(|frames| frames.beside.as_deref()) else { return String::new() };
    let mut text = String::new();
    for (axis, _) in axes(act) {
        let lines = beside.parts(part).map(|lines| lines.at(axis));
        let (value, nothing) = match part {
            LocalFramePart::Translate => (lines.map(|line| line.shift).sum(), 0.0),
            LocalFramePart::Scale => (lines.map(|line| line.factor).product(), 1.0),
            LocalFramePart::Mirror => {
                (f64::from(u8::from(lines.filter(|line| line.factor < 0.0).count() % 2 == 1)), 0.0)
            }
            LocalFramePart::Rotate => (0.0, 0.0),
        };
        if value != nothing {
            text += &format!(",{}={}", act.channel().axis_name(axis), wildcard_text(value));
        }
    }
    text
}
