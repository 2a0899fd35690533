//! Straight moves.
//!
//! Facts: reference control-emulator.md 6.1. Feed is taken before the axes; axes in channel order.

use super::time::TimedPath;
use crate::context::ActionContext;
use crate::entry::{ActionEntry, CompensationEffect};
use counterpoint_channel::cutter::{MoveShape, ProgrammedMove};
use counterpoint_channel::modal::{feed_of, group};
use counterpoint_event::event::{FeedUnit, Motion, MotionKind, Position};
use counterpoint_fault as diag;
use counterpoint_fault::{Acted, Halt};
use counterpoint_machine::ident::{codes, data};
use counterpoint_machine::index::{AxisSlot, BySlot};
use counterpoint_program::block::RetrievedValue;

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
    let feed = act.rapid_feed();
    let (coded, target) = act.straight_targets();
    if coded == 0 {
        return Ok(());
    }
    act.straight_move((coded, target), |act, coded, target| act.rapid_within(coded, target, feed))
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
    act.rapid_to(coded, past)?;
    act.rapid_to(coded, target)
}

/// Straight feed.
pub(crate) fn linear(act: &mut ActionContext<'_, '_>) -> Acted {
    if act.channel().block.flags.machine_frame && act.channel().env.machine.habits.machine_frame_rapid {
        return rapid(act);
    }
    let (feed, unit) = act.feed();
    if act.channel().state.place.frames.is_none() {
        let (coded, target) = act.plain_targets();
        return act.plain_feed(coded, &target, feed, unit);
    }
    let targets = act.straight_targets();
    act.straight_move(targets, |act, coded, target| act.feed_to(coded, target, feed, unit))
}

/// Straight feed over a multiple of the programmed distance.
pub(crate) fn linear_times(act: &mut ActionContext<'_, '_>, factor: f64) -> Acted {
    let (feed, unit) = act.feed();
    let (coded, mut target) = act.straight_targets();
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
    act.plain_feed(coded, to, feed, unit)
}

impl ActionContext<'_, '_> {
    /// Feed of the active mode: the word in the block, otherwise the remembered one.
    pub(crate) fn feed(&mut self) -> (Option<f64>, FeedUnit) {
        let (id, unit) = feed_of(self.channel().state.modal.code(group::FEED));
        match self.take(id) {
            Some(datum) => {
                self.channel_mut().state.remembered.remember(id, datum.value);
                (Some(datum.value), unit)
            }
            // Inverse time belongs to its block alone.
            None if unit == FeedUnit::InverseTime => (None, unit),
            None => (self.channel().state.remembered.value(id), unit),
        }
    }

    /// Feed that a rapid move must not pass: that of the block, otherwise the remembered one where the row is modal.
    fn rapid_feed(&mut self) -> Option<f64> {
        let Some(datum) = self.take(data::RAPID_FEED) else {
            return self.channel().state.remembered.value(data::RAPID_FEED);
        };
        if datum.value <= 0.0 {
            let text = format!(
                "the feed rate is zero or negative in '{}', the move is timed as rapid",
                self.channel().block_text()
            );
            self.diagnose(&diag::FEED_NOT_POSITIVE, text);
            return None;
        }
        if self.sources(data::RAPID_FEED).iter().any(|source| source.modal) {
            self.channel_mut().state.remembered.remember(data::RAPID_FEED, datum.value);
        }
        Some(datum.value)
    }

    /// Takes the axis words: bits of coded axes, and the target in the work frame.
    #[inline(always)]
    pub(crate) fn targets(&mut self) -> (u8, Position) {
        if self.channel().state.place.frames.is_some() { self.targets_in_frames() } else { self.plain_targets() }
    }

    /// The same, with the words that orient the tool.
    #[inline(always)]
    pub(crate) fn straight_targets(&mut self) -> (u8, Position) {
        if self.channel().state.place.frames.is_some() { self.oriented_targets() } else { self.plain_targets() }
    }

    /// Takes the axis words: bits of coded axes, and the target as programmed.
    #[inline(always)]
    pub(crate) fn programmed_targets(&mut self) -> (u8, Position) {
        if self.channel().state.place.frames.is_some() { self.framed_targets() } else { self.plain_targets() }
    }

    /// Where programmed points are points of the work frame.
    #[inline(never)]
    fn plain_targets(&mut self) -> (u8, Position) {
        self.axis_words(
            self.channel().state.place.position,
            |act, axis| Some(act.channel().shift_in_machine_frame(axis)),
            Self::take_axis,
        )
    }

    #[cold]
    fn targets_in_frames(&mut self) -> (u8, Position) {
        let (coded, target) = self.framed_targets();
        let (coded, target) = self.by_angle(coded, target);
        self.channel_mut().state.place.ways_travelled(coded);
        (coded, self.channel_mut().state.place.work_point(&target))
    }

    #[cold]
    fn oriented_targets(&mut self) -> (u8, Position) {
        let (coded, target) = self.targets_in_frames();
        self.orient_words(coded, target)
    }

    #[cold]
    fn framed_targets(&mut self) -> (u8, Position) {
        self.check_parts();
        if self.channel().block.flags.machine_frame {
            let tool = self.channel().tool_in_machine_frame();
            let add = |place: &mut Position, factor: f64| {
                place.iter_mut().zip(tool).for_each(|(slot, tool)| *slot += factor * tool);
            };
            let start = self.start_in_machine_frame();
            let mut stands = self.channel().state.place.machine_point(&start);
            add(&mut stands, -1.0);
            let (coded, mut target) = self.axis_words(stands, |_, _| None, Self::take_axis);
            add(&mut target, 1.0);
            self.channel_mut().state.place.ways_travelled(coded);
            return (
                coded,
                self.channel().state.place.program_point(&self.channel().state.place.point_of_machine(&target)),
            );
        }
        let from = self.channel().state.place.programmed();
        let counted = self.channel().state.place.counted();
        let shift = |act: &Self, axis: AxisSlot| Some(act.channel().state.place.shift.at(axis));
        let (coded, mut target) = match (self.channel().state.place.polar(), self.polar_axes()) {
            (Some(polar), _) => self.axis_words(counted, shift, |act, axis| act.take_polar(polar, axis)),
            (None, None) => self.axis_words(counted, shift, Self::take_axis),
            (None, Some(flat)) => {
                let take = |act: &mut Self, axis| if flat.contains(&axis) { None } else { act.take_axis(axis) };
                let (coded, mut target) = self.axis_words(counted, shift, take);
                (coded | self.take_polar_words(flat, &counted, &mut target), target)
            }
        };
        if counted != from {
            for (at, (slot, from)) in target.iter_mut().zip(from).enumerate() {
                if coded & 1 << at == 0 {
                    *slot = from;
                }
            }
        }
        let (coded, target) = self.polar_end(coded, target);
        self.channel_mut().state.place.ways_travelled(coded);
        (coded, target)
    }

    /// Where a move to positions of the machine frame starts: on the contour, unless it goes without compensation.
    fn start_in_machine_frame(&mut self) -> Position {
        if self.channel_mut().state.place.cutter().is_some_and(|cutter| !cutter.suspended) {
            self.channel().state.place.contour()
        } else {
            self.channel().state.place.position
        }
    }

    /// Takes the word of an axis.
    #[inline(always)]
    pub(crate) fn take_axis(&mut self, axis: AxisSlot) -> Option<RetrievedValue> {
        self.take(self.channel().state.place.layout.axes[axis].data)
    }

    /// Takes the axis words onto a point; `shift` is the distance of its machine coordinates.
    #[inline(always)]
    fn axis_words(
        &mut self,
        from: Position,
        shift: impl Fn(&Self, AxisSlot) -> Option<f64>,
        take: impl Fn(&mut Self, AxisSlot) -> Option<RetrievedValue>,
    ) -> (u8, Position) {
        let relative = match self.channel().state.modal.code(group::POSITION) {
            Some(codes::POSITION_RELATIVE) => Some(true),
            Some(_) => Some(false),
            None => None,
        };
        let mut target = from;
        let mut coded = 0_u8;
        let as_written = self.channel().state.place.layout.angles == 0 && !self.channel().block.flags.machine_frame;
        for axis in self.channel().state.place.layout.axes.ids() {
            let Some(datum) = take(self, axis) else { continue };
            if relative.is_none() && !datum.incremental {
                let text = format!(
                    "neither absolute nor incremental is active in '{}', absolute is assumed",
                    self.channel().block_text()
                );
                self.diagnose(&diag::POSITION_MODE_UNKNOWN, text);
            }
            let slot = target.at_mut(axis);
            *slot = if datum.incremental || relative == Some(true) && !datum.absolute {
                *slot + datum.value
            } else if as_written {
                datum.value
            } else {
                let away =
                    if self.channel().block.flags.machine_frame { shift(self, axis).unwrap_or(0.0) } else { 0.0 };
                match self.channel().state.place.layout.angles & axis.bit() {
                    0 => datum.value - away,
                    _ => self.turned_to(axis, *slot, datum.value, away),
                }
            };
            coded |= axis.bit();
        }
        (coded, target)
    }

    /// Length of the tool path: linear axes, or the rotary ones when nothing else moves.
    pub(crate) fn tool_path(&self, changes: &Position) -> f64 {
        let sum = |rotary: bool| {
            self.channel()
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

    /// A rapid move to a programmed point.
    pub(crate) fn rapid_to_point(&mut self, coded: u8, target: Position) -> Acted {
        let target = self.channel_mut().state.place.work_point(&target);
        self.rapid_to(coded, target)
    }

    /// A straight feed move to a programmed point.
    pub(crate) fn feed_to_point(&mut self, coded: u8, target: Position, feed: Option<f64>, unit: FeedUnit) -> Acted {
        let target = self.channel_mut().state.place.work_point(&target);
        self.feed_to(coded, target, feed, unit)
    }

    /// Axes that a move concerns: a turned frame moves others than the coded ones.
    #[inline(always)]
    pub(crate) fn moving(&self, coded: u8, changes: &Position) -> u8 {
        if self.channel().state.place.frames.is_none() {
            return coded;
        }
        changes.iter().enumerate().filter(|(_, c)| **c != 0.0).fold(coded, |bits, (axis, _)| bits | 1 << axis)
    }

    /// A rapid move to a target in the work frame.
    pub(crate) fn rapid_to(&mut self, coded: u8, target: Position) -> Acted {
        self.rapid_within(coded, target, None)
    }

    /// The same, along its path not faster than a feed per minute.
    pub(crate) fn rapid_within(&mut self, coded: u8, target: Position, feed: Option<f64>) -> Acted {
        if self.channel().state.place.is_compensated() {
            let step = ProgrammedMove { shape: MoveShape::Rapid, coded, to: target, feed, unit: FeedUnit::Rapid };
            return self.compensate(step);
        }
        let from = self.channel().state.place.position;
        if target == from {
            return Ok(());
        }
        let changes = self.channel().state.place.changes(&from, &target);
        let mut seconds = self.rapid_seconds(&from, &target);
        if let Some(feed) = feed {
            let length = changes.iter().map(|change| change * change).sum::<f64>().sqrt();
            seconds = seconds.max(length / feed * 60.0);
        }
        let length = self.tool_path(&changes);
        let moving = self.moving(coded, &changes);
        let feed = (0.0, FeedUnit::Rapid);
        self.travel(seconds, &Motion::straight(MotionKind::Rapid, moving, [from, target], feed, length))
    }

    /// A straight feed move to a target in the work frame.
    pub(crate) fn feed_to(&mut self, coded: u8, target: Position, feed: Option<f64>, unit: FeedUnit) -> Acted {
        if self.channel().state.place.frames.is_some() {
            return self.feed_in_frames(coded, target, feed, unit);
        }
        self.plain_feed(coded, &target, feed, unit)
    }

    /// Where programmed points are points of the work frame.
    fn plain_feed(&mut self, coded: u8, target: &Position, feed: Option<f64>, unit: FeedUnit) -> Acted {
        let from = self.channel().state.place.position;
        if *target == from {
            return Ok(());
        }
        let changes = self.channel().state.place.changes(&from, target);
        let weighs = self.channel().state.place.weighs;
        let square = |ways: &Position| ways.iter().map(|c| c * c).sum::<f64>();
        let feed_length = if weighs { square(&self.channel().feed_ways(&changes)) } else { square(&changes) }.sqrt();
        let path = TimedPath { from: &from, to: target, length: feed_length, arc: None };
        let mut seconds = self.feed_seconds(&path, feed, unit)?;
        if weighs {
            seconds = self.channel().seconds_of_group(seconds, &changes);
        }
        let length = if weighs { self.tool_path(&changes) } else { feed_length };
        let feed = (if weighs { self.channel().feed_of_axes(feed, unit, &changes) } else { feed.unwrap_or(0.0) }, unit);
        self.travel(seconds, &Motion::straight(MotionKind::Linear, coded, [from, *target], feed, length))
    }

    #[cold]
    fn feed_in_frames(&mut self, coded: u8, target: Position, feed: Option<f64>, unit: FeedUnit) -> Acted {
        if self.channel().state.place.is_compensated() {
            // Without a coordinate nothing moves, though the tool is not where the program is.
            let step = ProgrammedMove { shape: MoveShape::Linear, coded, to: target, feed, unit };
            return if coded == 0 && !self.opens_line() { Ok(()) } else { self.compensate(step) };
        }
        let from = self.channel().state.place.position;
        if target == from {
            return Ok(());
        }
        let changes = self.channel().feed_changes(&from, &target);
        let ways = self.channel().feed_ways(&changes);
        let feed_length = ways.iter().map(|c| c * c).sum::<f64>().sqrt();
        let feed = self.feed_down(feed, unit, &ways, feed_length);
        let path = TimedPath { from: &from, to: &target, length: feed_length, arc: None };
        let seconds = self.feed_seconds(&path, feed, unit)?;
        let seconds = self.channel().seconds_of_group(self.at_rates(seconds, &from, &target, None), &changes);
        let length = self.feed_path(&changes, feed_length);
        let moving = self.moving(coded, &self.channel().state.place.changes(&from, &target));
        let feed = (self.channel().feed_of_axes(feed, unit, &changes), unit);
        self.travel(seconds, &Motion::straight(MotionKind::Linear, moving, [from, target], feed, length))
    }

    /// A straight move that a macro has changed: made again from its start.
    pub(crate) fn straight_again(&mut self, motion: &Motion, rapid: bool, to: Position) -> Acted {
        let (seconds, motion) = straight_to(self, motion, rapid, to)?;
        self.move_to(seconds, &motion)
    }
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
    let length = act.tool_path(&changes);
    let moved = changes.iter().enumerate().filter(|(_, change)| **change != 0.0);
    let coded = moved.fold(motion.moving, |bits, (axis, _)| bits | 1 << axis);
    if rapid {
        let seconds = act.rapid_seconds(&from, &to);
        let feed = (0.0, FeedUnit::Rapid);
        return Ok((seconds, Motion::straight(MotionKind::Rapid, coded, [from, to], feed, length)));
    }
    let (feed, unit) = match motion.kind {
        MotionKind::Linear => (Some(motion.feed), motion.feed_unit),
        _ => act.feed(),
    };
    let changes = act.channel().feed_changes(&from, &to);
    let feed_length = act.channel().feed_ways(&changes).iter().map(|c| c * c).sum::<f64>().sqrt();
    let path = TimedPath { from: &from, to: &to, length: feed_length, arc: None };
    let mut seconds = act.feed_seconds(&path, feed, unit)?;
    if act.channel().state.place.frames.is_some() {
        seconds = act.at_rates(seconds, &from, &to, None);
    }
    seconds = act.channel().seconds_of_group(seconds, &changes);
    let length = act.feed_path(&changes, feed_length);
    let feed = (feed.unwrap_or(0.0), unit);
    Ok((seconds, Motion::straight(MotionKind::Linear, coded, [from, to], feed, length)))
}
