//! Feeds that depend on the way of a move: down along the tool, of rotary axes, at the edge of the tool.
//!
//! Facts: reference heidenhain-cycles.md 6 (M103, M109 to M111, M116). *Invariant:* a share of the feed makes a move
//! down slower, never faster. Decision: arcs round corners outside keep the feed, since the edge stands there.

use crate::context::ActionContext;
use crate::entry::ActionEntry;
use counterpoint_channel::modal::group;
use counterpoint_event::event::{FeedUnit, Position};
use counterpoint_fault::Acted;
use counterpoint_machine::ident::{codes, data};
use counterpoint_machine::index::BySlot;

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] = &[
    ActionEntry::of(&[codes::FEED_DOWN], |act, _, _| down(act)),
    ActionEntry::of(&[codes::FEED_ROTARY_LENGTH], |act, _, _| rotary(act, true)),
    ActionEntry::of(&[codes::FEED_ROTARY_ANGLE], |act, _, _| rotary(act, false)),
];

/// Modal group of the edge.
const EDGE: u16 = 149;

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

impl ActionContext<'_, '_> {
    /// Feed of a move in the work frame, along which the feed counts a length: one that goes down keeps to its share.
    #[cold]
    pub(crate) fn feed_down(&self, feed: Option<f64>, unit: FeedUnit, changes: &Position, length: f64) -> Option<f64> {
        let share = self.channel().state.place.frames.as_deref().and_then(|frames| frames.feeds.down);
        let (Some(share), Some(full)) = (share, feed) else { return feed };
        let role = match self.channel().state.modal.code(group::PLANE) {
            Some(codes::PLANE_ZX) => 1,
            Some(codes::PLANE_YZ) => 0,
            _ => 2,
        };
        let tool = self.channel().state.place.layout.cartesian.get(role).copied().flatten();
        let way = tool.map_or(0.0, |axis| -changes.at(axis));
        if !matches!(unit, FeedUnit::PerMinute | FeedUnit::PerRevolution) || way <= 0.0 {
            return feed;
        }
        // Straight down the path is the length, except for rounding.
        let times = if length - way < way * 1e-12 { 1.0 } else { length / way };
        Some(full.min(full * share * times))
    }

    /// Feed of the middle of the tool beside an arc; `times`: how many times as large as that of the contour its radius
    /// is.
    pub(crate) fn edge_feed(&self, feed: Option<f64>, unit: FeedUnit, times: f64) -> Option<f64> {
        let counts = match self.channel().state.modal.code(EDGE) {
            Some(codes::FEED_AT_EDGE) => true,
            Some(codes::FEED_AT_EDGE_INSIDE) => times < 1.0,
            _ => false,
        };
        let counts = counts && matches!(unit, FeedUnit::PerMinute | FeedUnit::PerRevolution);
        feed.map(|feed| if counts { feed * times } else { feed })
    }
}
