//! Straight moves.
//!
//! Facts: reference control-emulator.md 6.1. Feed is taken before the axes; axes in channel order.

use counterpoint_channel::axis_rates::{at_rates, feed_down};
use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::cutter::{MoveShape, ProgrammedMove};
use counterpoint_channel::frame_transforms::PartialPlane;
use counterpoint_channel::modal::{feed_of, group};
use counterpoint_channel::path_lengths::{feed_path, polar_axes, tool_path};
use counterpoint_channel::plane_points::{opens_line, polar_end};
use counterpoint_channel::rotary_words::turned_to;
use counterpoint_event::event::{FeedUnit, Motion, MotionKind, Position};
use counterpoint_fault as diag;
use counterpoint_fault::{Acted, Halt};
use counterpoint_machine::ident::{codes, data};
use counterpoint_machine::index::{AxisSlot, BySlot};
use counterpoint_program::block::RetrievedValue;

use crate::context::{ActionContext, StraightSteps};
use crate::cutter::angle::by_angle;
use crate::cutter::compensate;
use crate::entry::{ActionEntry, CompensationEffect};
use crate::polar_words::put_polar_words;
use crate::time::feed_seconds;
use crate::tip::{orient_words, straight_move};
use counterpoint_channel::timed_path::{TimedPath, rapid_seconds};

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] = &[
    ActionEntry::of(&[codes::RAPID], |act, _, _| rapid(act)).moves().contour(CompensationEffect::Follows),
    ActionEntry::of(&[codes::RAPID_ONE_WAY], |act, _, _| one_way(act)).contour(CompensationEffect::Leaves),
    ActionEntry::of(&[codes::INTERP_LINEAR], |act, _, _| linear(act)).moves().contour(CompensationEffect::Follows),
    ActionEntry::of(&[codes::INTERP_LINEAR_X10], |act, _, _| linear_times(act, 10.0))
        .moves()
        .contour(CompensationEffect::Follows),
    ActionEntry::of(&[codes::INTERP_LINEAR_X100], |act, _, _| linear_times(act, 100.0))
        .moves()
        .contour(CompensationEffect::Follows),
];

/// Positioning.
pub(crate) fn rapid(act: &mut ActionContext<'_, '_>) -> Acted {
    let feed = rapid_feed(act);
    let (coded, target) = straight_targets(act);
    if coded == 0 {
        return Ok(());
    }
    straight_move(act, (coded, target), |act, coded, target| act.rapid_within(coded, target, feed))
}

/// Positioning that approaches its end from a fixed direction: past the end and back, along axes with an overshoot
/// distance.
fn one_way(act: &mut ActionContext<'_, '_>) -> Acted {
    let (coded, target) = act.targets();
    if coded == 0 {
        return Ok(());
    }
    let mut past = target;
    for (slot, axis) in act.channel().state.place.layout.axes.entries().filter(|(slot, _)| coded & slot.bit() != 0) {
        *past.at_mut(slot) -= axis.one_way;
    }
    rapid_to(act, coded, past)?;
    rapid_to(act, coded, target)
}

/// Straight feed.
pub(crate) fn linear(act: &mut ActionContext<'_, '_>) -> Acted {
    if act.channel().block.flags.machine_frame && act.channel().env.machine.habits.machine_frame_rapid {
        return rapid(act);
    }
    let (feed, unit) = act.active_feed();
    if act.channel().state.place.frames.is_none() {
        let (coded, target) = plain_targets(act);
        return plain_feed(act, coded, &target, feed, unit);
    }
    let targets = straight_targets(act);
    straight_move(act, targets, |act, coded, target| act.feed_to(coded, target, feed, unit))
}

/// Straight feed over a multiple of the programmed distance.
pub(crate) fn linear_times(act: &mut ActionContext<'_, '_>, factor: f64) -> Acted {
    let (feed, unit) = act.active_feed();
    let (coded, mut target) = straight_targets(act);
    for (to, from) in target.iter_mut().zip(&act.channel().state.place.contour()) {
        let far = from + factor * (*to - from);
        if far.is_finite() {
            *to = far;
        }
    }
    act.feed_to(coded, target, feed, unit)
}

/// Moves these axes straight to a point of the work frame, without words: at rapid, or at the feed of the active mode.
pub(crate) fn go_straight(act: &mut ActionContext<'_, '_>, rapid: bool, coded: u8, to: &Position) -> Acted {
    if rapid {
        let most = act.channel().state.remembered.value(data::RAPID_FEED);
        return act.rapid_within(coded, *to, most);
    }
    let (id, unit) = feed_of(act.channel().state.modal.code(group::FEED));
    let feed = act.channel().state.remembered.value(id).filter(|_| unit != FeedUnit::InverseTime);
    plain_feed(act, coded, to, feed, unit)
}

impl StraightSteps for ActionContext<'_, '_> {
    #[inline(always)]
    fn targets(&mut self) -> (u8, Position) {
        if self.channel().state.place.frames.is_some() { targets_in_frames(self) } else { plain_targets(self) }
    }

    fn feed_to(&mut self, coded: u8, target: Position, feed: Option<f64>, unit: FeedUnit) -> Acted {
        if self.channel().state.place.frames.is_some() {
            return feed_in_frames(self, coded, target, feed, unit);
        }
        plain_feed(self, coded, &target, feed, unit)
    }

    fn rapid_within(&mut self, coded: u8, target: Position, feed: Option<f64>) -> Acted {
        if self.channel().state.place.is_compensated() {
            let step = ProgrammedMove { shape: MoveShape::Rapid, coded, to: target, feed, unit: FeedUnit::Rapid };
            return compensate(self, step);
        }
        let from = self.channel().state.place.position;
        if target == from {
            return Ok(());
        }
        let changes = self.channel().state.place.changes(&from, &target);
        let mut seconds = rapid_seconds(self.channel(), &from, &target);
        if let Some(feed) = feed {
            let length = changes.iter().map(|change| change * change).sum::<f64>().sqrt();
            seconds = seconds.max(length / feed * 60.0);
        }
        let length = tool_path(self.channel(), &changes);
        let moving = moved_axes(self.channel(), coded, &changes);
        let feed = (0.0, FeedUnit::Rapid);
        self.travel(seconds, &Motion::straight(MotionKind::Rapid, moving, [from, target], feed, length))
    }
}

/// Upper feed limit for rapid moves: the limit of the block, otherwise the remembered limit if the row is modal.
fn rapid_feed(act: &mut ActionContext<'_, '_>) -> Option<f64> {
    let Some(datum) = act.take(data::RAPID_FEED) else {
        return act.channel().state.remembered.value(data::RAPID_FEED);
    };
    if datum.value <= 0.0 {
        let text = format!(
            "the feed rate is zero or negative in '{}', the move is timed as rapid",
            act.channel().block_text()
        );
        act.diagnose(&diag::FEED_NOT_POSITIVE, text);
        return None;
    }
    if act.sources(data::RAPID_FEED).iter().any(|source| source.modal) {
        act.channel_mut().state.remembered.remember(data::RAPID_FEED, datum.value);
    }
    Some(datum.value)
}

/// Takes the axis words and the words that orient the tool: bits of coded axes, and the target in the work frame.
#[inline(always)]
pub(crate) fn straight_targets(act: &mut ActionContext<'_, '_>) -> (u8, Position) {
    if act.channel().state.place.frames.is_some() { oriented_targets(act) } else { plain_targets(act) }
}

/// Takes the axis words: bits of coded axes, and the target as programmed.
#[inline(always)]
pub(crate) fn programmed_targets(act: &mut ActionContext<'_, '_>) -> (u8, Position) {
    if act.channel().state.place.frames.is_some() { framed_targets(act) } else { plain_targets(act) }
}

/// Takes the axis words, if programmed points are points of the work frame.
#[inline(never)]
fn plain_targets(act: &mut ActionContext<'_, '_>) -> (u8, Position) {
    axis_words(
        act,
        act.channel().state.place.position,
        |act, axis| Some(act.channel().shift_in_machine_frame(axis)),
        take_axis,
    )
}

#[cold]
fn targets_in_frames(act: &mut ActionContext<'_, '_>) -> (u8, Position) {
    let (coded, target) = framed_targets(act);
    let (coded, target) = by_angle(act, coded, target);
    act.channel_mut().state.place.ways_travelled(coded);
    (coded, act.channel_mut().state.place.work_point(&target))
}

#[cold]
fn oriented_targets(act: &mut ActionContext<'_, '_>) -> (u8, Position) {
    let (coded, target) = targets_in_frames(act);
    orient_words(act, coded, target)
}

#[cold]
fn framed_targets(act: &mut ActionContext<'_, '_>) -> (u8, Position) {
    check_parts(act);
    if act.channel().block.flags.machine_frame {
        let tool = act.channel().tool_in_machine_frame();
        let add = |place: &mut Position, factor: f64| {
            place.iter_mut().zip(tool).for_each(|(slot, tool)| *slot += factor * tool);
        };
        let start = start_in_machine_frame(act.channel_mut());
        let mut stands = act.channel().state.place.machine_point(&start);
        add(&mut stands, -1.0);
        let (coded, mut target) = axis_words(act, stands, |_, _| None, take_axis);
        add(&mut target, 1.0);
        act.channel_mut().state.place.ways_travelled(coded);
        return (coded, act.channel().state.place.program_point(&act.channel().state.place.point_of_machine(&target)));
    }
    let from = act.channel().state.place.programmed();
    let counted = act.channel().state.place.counted();
    let shift = |act: &ActionContext<'_, '_>, axis: AxisSlot| Some(act.channel().state.place.shift.at(axis));
    let (coded, mut target) = match (act.channel().state.place.polar(), polar_axes(act.channel())) {
        (Some(polar), _) => axis_words(act, counted, shift, |act, axis| act.take_polar(polar, axis)),
        (None, None) => axis_words(act, counted, shift, take_axis),
        (None, Some(flat)) => {
            let take =
                |act: &mut ActionContext<'_, '_>, axis| if flat.contains(&axis) { None } else { take_axis(act, axis) };
            let (coded, mut target) = axis_words(act, counted, shift, take);
            let words = flat.map(|axis| take_axis(act, axis));
            (coded | put_polar_words(act, words, flat, &counted, &mut target), target)
        }
    };
    if counted != from {
        for (at, (slot, from)) in target.iter_mut().zip(from).enumerate() {
            if coded & 1 << at == 0 {
                *slot = from;
            }
        }
    }
    let (coded, target) = polar_end(act.channel_mut(), coded, target);
    act.channel_mut().state.place.ways_travelled(coded);
    (coded, target)
}

/// Start of a move to positions of the machine frame: on the contour, unless the move has no compensation.
fn start_in_machine_frame(channel: &mut ChannelContext<'_>) -> Position {
    if channel.state.place.cutter().is_some_and(|cutter| !cutter.suspended) {
        channel.state.place.contour()
    } else {
        channel.state.place.position
    }
}

/// Takes the word of an axis.
#[inline(always)]
pub(crate) fn take_axis(act: &mut ActionContext<'_, '_>, axis: AxisSlot) -> Option<RetrievedValue> {
    act.take(act.channel().state.place.layout.axes[axis].data)
}

/// Takes the axis words onto a point; `shift` is the distance of its machine coordinates.
#[inline(always)]
fn axis_words(
    act: &mut ActionContext<'_, '_>,
    from: Position,
    shift: impl Fn(&ActionContext<'_, '_>, AxisSlot) -> Option<f64>,
    take: impl Fn(&mut ActionContext<'_, '_>, AxisSlot) -> Option<RetrievedValue>,
) -> (u8, Position) {
    let relative = match act.channel().state.modal.code(group::POSITION) {
        Some(codes::POSITION_RELATIVE) => Some(true),
        Some(_) => Some(false),
        None => None,
    };
    let mut target = from;
    let mut coded = 0_u8;
    let as_written = act.channel().state.place.layout.angles == 0 && !act.channel().block.flags.machine_frame;
    for axis in act.channel().state.place.layout.axes.ids() {
        let Some(datum) = take(act, axis) else { continue };
        if relative.is_none() && !datum.incremental {
            let text = format!(
                "neither absolute nor incremental is active in '{}', absolute is assumed",
                act.channel().block_text()
            );
            act.diagnose(&diag::POSITION_MODE_UNKNOWN, text);
        }
        let slot = target.at_mut(axis);
        *slot = if datum.incremental || relative == Some(true) && !datum.absolute {
            *slot + datum.value
        } else if as_written {
            datum.value
        } else {
            let away = if act.channel().block.flags.machine_frame { shift(act, axis).unwrap_or(0.0) } else { 0.0 };
            match act.channel().state.place.layout.angles & axis.bit() {
                0 => datum.value - away,
                _ => turned_to(act.channel(), axis, *slot, datum.value, away),
            }
        };
        coded |= axis.bit();
    }
    (coded, target)
}

/// A rapid move to a programmed point.
pub(crate) fn rapid_to_point(act: &mut ActionContext<'_, '_>, coded: u8, target: Position) -> Acted {
    let target = act.channel_mut().state.place.work_point(&target);
    rapid_to(act, coded, target)
}

/// A straight feed move to a programmed point.
pub(crate) fn feed_to_point(
    act: &mut ActionContext<'_, '_>,
    coded: u8,
    target: Position,
    feed: Option<f64>,
    unit: FeedUnit,
) -> Acted {
    let target = act.channel_mut().state.place.work_point(&target);
    act.feed_to(coded, target, feed, unit)
}

/// Axes that a move concerns: a rotated frame moves axes other than the coded axes.
#[inline(always)]
pub(crate) fn moved_axes(channel: &ChannelContext<'_>, coded: u8, changes: &Position) -> u8 {
    if channel.state.place.frames.is_none() {
        return coded;
    }
    changes.iter().enumerate().filter(|(_, c)| **c != 0.0).fold(coded, |bits, (axis, _)| bits | 1 << axis)
}

/// A rapid move to a target in the work frame.
pub(crate) fn rapid_to(act: &mut ActionContext<'_, '_>, coded: u8, target: Position) -> Acted {
    act.rapid_within(coded, target, None)
}

/// Makes a feed move, if programmed points are points of the work frame.
fn plain_feed(
    act: &mut ActionContext<'_, '_>,
    coded: u8,
    target: &Position,
    feed: Option<f64>,
    unit: FeedUnit,
) -> Acted {
    let from = act.channel().state.place.position;
    if *target == from {
        return Ok(());
    }
    let changes = act.channel().state.place.changes(&from, target);
    let weighs = act.channel().state.place.weighs;
    let square = |ways: &Position| ways.iter().map(|c| c * c).sum::<f64>();
    let feed_length = if weighs { square(&act.channel().feed_ways(&changes)) } else { square(&changes) }.sqrt();
    let path = TimedPath { from: &from, to: target, length: feed_length, arc: None };
    let mut seconds = feed_seconds(act, &path, feed, unit)?;
    if weighs {
        seconds = act.channel().state.place.seconds_of_group(seconds, &changes);
    }
    let length = if weighs { tool_path(act.channel(), &changes) } else { feed_length };
    let feed = (if weighs { act.channel().feed_of_axes(feed, unit, &changes) } else { feed.unwrap_or(0.0) }, unit);
    act.travel(seconds, &Motion::straight(MotionKind::Linear, coded, [from, *target], feed, length))
}

#[cold]
fn feed_in_frames(
    act: &mut ActionContext<'_, '_>,
    coded: u8,
    target: Position,
    feed: Option<f64>,
    unit: FeedUnit,
) -> Acted {
    if act.channel().state.place.is_compensated() {
        // Without a coordinate nothing moves, though the tool is not where the program is.
        let step = ProgrammedMove { shape: MoveShape::Linear, coded, to: target, feed, unit };
        return if coded == 0 && !opens_line(act.channel_mut()) { Ok(()) } else { compensate(act, step) };
    }
    let from = act.channel().state.place.position;
    if target == from {
        return Ok(());
    }
    let changes = act.channel().feed_changes(&from, &target);
    let ways = act.channel().feed_ways(&changes);
    let feed_length = ways.iter().map(|c| c * c).sum::<f64>().sqrt();
    let feed = feed_down(act.channel(), feed, unit, &ways, feed_length);
    let path = TimedPath { from: &from, to: &target, length: feed_length, arc: None };
    let seconds = feed_seconds(act, &path, feed, unit)?;
    let seconds =
        act.channel().state.place.seconds_of_group(at_rates(act.channel(), seconds, &from, &target, None), &changes);
    let length = feed_path(act.channel(), &changes, feed_length);
    let moving = moved_axes(act.channel(), coded, &act.channel().state.place.changes(&from, &target));
    let feed = (act.channel().feed_of_axes(feed, unit, &changes), unit);
    act.travel(seconds, &Motion::straight(MotionKind::Linear, moving, [from, target], feed, length))
}

/// Makes a straight move that a macro has changed, again from its start.
pub(crate) fn straight_again(act: &mut ActionContext<'_, '_>, motion: &Motion, rapid: bool, to: Position) -> Acted {
    let (seconds, motion) = straight_to(act, motion, rapid, to)?;
    act.move_to(seconds, &motion)
}

/// Gives a straight move a new end, at rapid or at feed; returns its time in seconds, and the move.
pub(super) fn straight_to(
    act: &mut ActionContext<'_, '_>,
    motion: &Motion,
    rapid: bool,
    to: Position,
) -> Result<(f64, Motion), Halt> {
    let from = act.channel().state.place.position;
    let changes = act.channel().state.place.changes(&from, &to);
    let length = tool_path(act.channel(), &changes);
    let moved = changes.iter().enumerate().filter(|(_, change)| **change != 0.0);
    let coded = moved.fold(motion.moving, |bits, (axis, _)| bits | 1 << axis);
    if rapid {
        let seconds = rapid_seconds(act.channel(), &from, &to);
        let feed = (0.0, FeedUnit::Rapid);
        return Ok((seconds, Motion::straight(MotionKind::Rapid, coded, [from, to], feed, length)));
    }
    let (feed, unit) = match motion.kind {
        MotionKind::Linear => (Some(motion.feed), motion.feed_unit),
        _ => act.active_feed(),
    };
    let changes = act.channel().feed_changes(&from, &to);
    let feed_length = act.channel().feed_ways(&changes).iter().map(|c| c * c).sum::<f64>().sqrt();
    let path = TimedPath { from: &from, to: &to, length: feed_length, arc: None };
    let mut seconds = feed_seconds(act, &path, feed, unit)?;
    if act.channel().state.place.frames.is_some() {
        seconds = at_rates(act.channel(), seconds, &from, &to, None);
    }
    seconds = act.channel().state.place.seconds_of_group(seconds, &changes);
    let length = feed_path(act.channel(), &changes, feed_length);
    let feed = (feed.unwrap_or(0.0), unit);
    Ok((seconds, Motion::straight(MotionKind::Linear, coded, [from, to], feed, length)))
}

/// A move in the middle of a definition is an alarm: it would be made in the wrong plane.
#[cold]
fn check_parts(act: &mut ActionContext<'_, '_>) {
    if forget_parts(act).is_some() {
        let text = format!("a definition by several blocks is not complete before '{}'", act.channel().block_text());
        act.diagnose(&diag::PLANE_UNDEFINED, text);
    }
}

/// Takes away the blocks of a definition that is not complete.
pub(crate) fn forget_parts(act: &mut ActionContext<'_, '_>) -> Option<Box<PartialPlane>> {
    let parts = act.channel_mut().state.place.frames.as_deref_mut()?.parts.take()?;
    act.channel_mut().state.place.frames_changed();
    Some(parts)
}
