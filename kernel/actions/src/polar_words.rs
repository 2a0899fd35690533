//! Polar coordinate command: the words of the plane are a radius and an angle until it is cancelled.
//!
//! *Invariant:* only words of target positions are read so; words of presets, offsets, frames and centres keep their
//! meaning. Decisions: docs/emulation.md, "Polar coordinate command".

use counterpoint_channel::frame_transforms::PolarWords;
use counterpoint_channel::modal::group;
use counterpoint_event::event::Position;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::codes;
use counterpoint_machine::index::AxisSlot;
use counterpoint_program::block::RetrievedValue;

use crate::context::ActionContext;
use crate::entry::{ActionEntry, CompensationEffect};

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] = &[
    ActionEntry::of(&[codes::POLAR_WORDS_ON], |act, _, _| switch(act, true)).contour(CompensationEffect::Waits),
    ActionEntry::of(&[codes::POLAR_WORDS_OFF], |act, _, _| switch(act, false)).contour(CompensationEffect::Waits),
];

fn switch(act: &mut ActionContext<'_, '_>, on: bool) -> Acted {
    if on || act.channel().state.place.frames.is_some() {
        act.channel_mut().state.place.frames().words = on.then(PolarWords::default);
        act.channel_mut().state.place.frames_changed();
    }
    super::mode::mode(act, if on { "polar words on" } else { "polar words off" })
}

/// Puts the words of axes into force, and the point into a target; returns the bits of the axes that it sets.
pub(crate) fn put_polar_words(
    act: &mut ActionContext<'_, '_>,
    [radius, angle]: [Option<RetrievedValue>; 2],
    axes: [AxisSlot; 2],
    from: &Position,
    target: &mut Position,
) -> u8 {
    let relative = act.channel().state.modal.code(group::POSITION) == Some(codes::POSITION_RELATIVE);
    let is_distance = |word: &RetrievedValue| word.incremental || relative && !word.absolute;
    let words = PolarWords {
        radius: radius.map(|word| (word.value, is_distance(&word))),
        // An angle has no unit of length.
        angle: angle.map(|word| (word.raw, is_distance(&word))),
    };
    act.channel_mut().state.place.frames().words = Some(words);
    if radius.is_none() && angle.is_none() {
        return 0;
    }
    words.put(&act.channel().state.place, axes, from, target);
    axes[0].bit() | axes[1].bit()
}

/// Reads words as positions of axes for once.
pub(crate) fn without_polar_words<T>(
    act: &mut ActionContext<'_, '_>,
    read: impl FnOnce(&mut ActionContext<'_, '_>) -> T,
) -> T {
    let words = act.channel_mut().state.place.frames.as_deref_mut().and_then(|frames| frames.words.take());
    let done = read(act);
    if words.is_some() {
        act.channel_mut().state.place.frames().words = words;
    }
    done
}
