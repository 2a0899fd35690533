//! Feeds that depend on the way of a move: down along the tool, of rotary axes, at the edge of the tool.
//!
//! Facts: reference heidenhain-cycles.md 6 (M103, M109 to M111, M116). *Invariant:* a share of the feed makes a move
//! down slower, never faster. Decision: arcs round corners outside keep the feed, since the edge stands there.

use counterpoint_fault::Acted;
use counterpoint_machine::ident::{codes, data};

use crate::context::ActionContext;
use crate::entry::ActionEntry;

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] = &[
    ActionEntry::of(&[codes::FEED_DOWN], |act, _, _| down(act)),
    ActionEntry::of(&[codes::FEED_ROTARY_LENGTH], |act, _, _| rotary(act, true)),
    ActionEntry::of(&[codes::FEED_ROTARY_ANGLE], |act, _, _| rotary(act, false)),
];

/// The share of the feed that moves down keep to; without one they have the feed.
fn down(act: &mut ActionContext<'_, '_>) -> Acted {
    let share = act.take(data::DOWN_FEED).map(|datum| datum.value / 100.0).filter(|share| *share > 0.0);
    act.channel_mut().state.place.frames().feeds.down = share;
    act.channel_mut().state.place.frames_changed();
    let text = match share {
        Some(share) => format!("feed down {}%", counterpoint_lang::format::wildcard_text(share * 100.0)),
        None => "feed down off".to_owned(),
    };
    act.channel_mut().emit(0, counterpoint_event::event::Kind::mode(text));
    Ok(())
}

/// The feed of rotary axes is a length or an angle.
fn rotary(act: &mut ActionContext<'_, '_>, length: bool) -> Acted {
    act.channel_mut().state.place.frames().feeds.rotary_length = length;
    act.channel_mut().state.place.frames_changed();
    super::mode::mode(act, if length { "feed rotary length" } else { "feed rotary angle" })
}
