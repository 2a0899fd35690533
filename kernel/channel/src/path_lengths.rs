//! Axes of polar words, and path lengths that feeds apply to.
//!
//! *Invariant:* nothing here moves.

use counterpoint_event::event::Position;
use counterpoint_machine::index::AxisSlot;

use crate::channel_context::ChannelContext;
use crate::modal::{group, plane};

/// Axes whose words are a radius and an angle.
pub fn polar_axes(channel: &ChannelContext<'_>) -> Option<[AxisSlot; 2]> {
    let frames = channel.state.place.frames.as_deref()?;
    frames.words.filter(|_| frames.polar.is_none())?;
    let plane = plane(channel.state.modal.code(group::PLANE)?)?;
    let axis = |role: usize| channel.state.place.layout.cartesian.get(role).copied().flatten();
    Some([axis(plane.first)?, axis(plane.second)?])
}

/// Applies the polar words of the block once more, from the current position of the tool.
pub fn polar_words_again(channel: &ChannelContext<'_>, target: &mut Position) {
    let words = channel.state.place.frames.as_deref().and_then(|frames| frames.words);
    let words = words.filter(|words| words.radius.is_some() || words.angle.is_some());
    if let (Some(words), Some(axes)) = (words, polar_axes(channel)) {
        words.put(&channel.state.place, axes, &channel.state.place.programmed(), target);
    }
}

/// Length of a feed move on the part, or of its tool path.
#[inline(always)]
pub fn feed_path(channel: &ChannelContext<'_>, changes: &Position, feed_length: f64) -> f64 {
    if channel.state.place.frames.is_some() && channel.state.place.polar().is_some() {
        feed_length
    } else {
        tool_path(channel, changes)
    }
}

/// Length of the tool path: linear axes, or the rotary ones when nothing else moves.
pub fn tool_path(channel: &ChannelContext<'_>, changes: &Position) -> f64 {
    let sum = |rotary: bool| {
        channel
            .state
            .place
            .layout
            .axes
            .iter()
            .zip(changes)
            .filter(|(a, _)| a.rotary == rotary)
            .map(|(_, c)| c * c)
            .sum::<f64>()
    };
    let linear = sum(false);
    if linear > 0.0 { linear.sqrt() } else { sum(true).sqrt() }
}
