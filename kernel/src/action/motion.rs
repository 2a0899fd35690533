//! Straight moves.
//!
//! Facts: reference control-emulator.md 6.1. Feed is taken before the axes; axes in channel order.

use super::time::Path;
use crate::channel::Kernel;
use crate::channel::data::Datum;
use crate::diag;
use crate::log::event::{FeedUnit, Kind, Motion, MotionKind, Position};
use crate::machine::ident::{codes, data};
use crate::state::cutter::{Shape, Step};
use crate::state::modal::{feed_of, group};
use counterpoint_fault::Acted;

/// Positioning.
pub(super) fn rapid(kernel: &mut Kernel<'_>) -> Acted {
    let feed = kernel.rapid_feed();
    let (coded, target) = kernel.straight_targets();
    if coded == 0 {
        return Ok(());
    }
    kernel.rapid_within(coded, target, feed)
}

/// Straight feed.
pub(super) fn linear(kernel: &mut Kernel<'_>) -> Acted {
    let (feed, unit) = kernel.feed();
    if kernel.channel.state.place.frames.is_none() {
        let (coded, target) = kernel.plain_targets();
        return kernel.plain_feed(coded, &target, feed, unit);
    }
    let (coded, target) = kernel.straight_targets();
    kernel.feed_to(coded, target, feed, unit)
}

/// Straight feed over a multiple of the programmed distance.
pub(super) fn linear_times(kernel: &mut Kernel<'_>, factor: f64) -> Acted {
    let (feed, unit) = kernel.feed();
    let (coded, mut target) = kernel.straight_targets();
    for (to, from) in target.iter_mut().zip(&kernel.channel.contour()) {
        let far = from + factor * (*to - from);
        if far.is_finite() {
            *to = far;
        }
    }
    kernel.feed_to(coded, target, feed, unit)
}

impl Kernel<'_> {
    /// Feed of the active mode: the word on the block, else the remembered one.
    pub(super) fn feed(&mut self) -> (Option<f64>, FeedUnit) {
        let (id, unit) = feed_of(self.channel.state.modal.code(group::FEED));
        match self.take(id) {
            Some(datum) => {
                self.channel.state.modal.remember(id, datum.value);
                (Some(datum.value), unit)
            }
            // Inverse time belongs to its block alone.
            None if unit == FeedUnit::InverseTime => (None, unit),
            None => (self.channel.state.modal.value(id), unit),
        }
    }

    /// Feed that a rapid move must not pass: that of the block, else the remembered one where the row is modal.
    fn rapid_feed(&mut self) -> Option<f64> {
        let Some(datum) = self.take(data::RAPID_FEED) else { return self.channel.state.modal.value(data::RAPID_FEED) };
        if datum.value <= 0.0 {
            let text = format!("the feed is zero or less in '{}', the move is timed as rapid", self.block_text());
            self.diagnose(&diag::FEED_NOT_POSITIVE, text);
            return None;
        }
        let mut sources = self.plan.data.sources.get(usize::from(data::RAPID_FEED.0)).into_iter().flatten();
        if sources.any(|source| source.modal) {
            self.channel.state.modal.remember(data::RAPID_FEED, datum.value);
        }
        Some(datum.value)
    }

    /// Takes the axis words: bits of coded axes, and the target in the work frame.
    #[inline(always)]
    pub(super) fn targets(&mut self) -> (u8, Position) {
        if self.channel.state.place.frames.is_some() { self.targets_in_frames() } else { self.plain_targets() }
    }

    /// The same, with the words that orient the tool.
    #[inline(always)]
    pub(super) fn straight_targets(&mut self) -> (u8, Position) {
        if self.channel.state.place.frames.is_some() { self.oriented_targets() } else { self.plain_targets() }
    }

    /// Takes the axis words: bits of coded axes, and the target as programmed.
    #[inline(always)]
    pub(super) fn programmed_targets(&mut self) -> (u8, Position) {
        if self.channel.state.place.frames.is_some() { self.framed_targets() } else { self.plain_targets() }
    }

    /// Where programmed points are points of the work frame.
    #[inline(never)]
    fn plain_targets(&mut self) -> (u8, Position) {
        self.axis_words(
            self.channel.state.place.position,
            |kernel, axis| kernel.channel.state.place.shift.get(axis).copied(),
            Self::take_axis,
        )
    }

    #[cold]
    fn targets_in_frames(&mut self) -> (u8, Position) {
        let (coded, target) = self.framed_targets();
        (coded, self.channel.work_point(&target))
    }

    #[cold]
    fn oriented_targets(&mut self) -> (u8, Position) {
        let (coded, target) = self.targets_in_frames();
        self.orient_words(coded, target)
    }

    #[cold]
    fn framed_targets(&mut self) -> (u8, Position) {
        if self.channel.block.machine_frame {
            let machine = self.channel.machine_point(&self.channel.state.place.position);
            let (coded, target) = self.axis_words(machine, |_, _| None, Self::take_axis);
            self.channel.ways_travelled(coded);
            return (coded, self.channel.program_point(&self.channel.point_of_machine(&target)));
        }
        let from = self.channel.programmed();
        let counted = self.channel.counted();
        let shift = |kernel: &Self, axis: usize| kernel.channel.state.place.shift.get(axis).copied();
        let (coded, mut target) = match self.channel.polar() {
            Some(polar) => self.axis_words(counted, shift, |kernel, axis| kernel.take_polar(polar, axis)),
            None => self.axis_words(counted, shift, Self::take_axis),
        };
        if counted != from {
            for (at, (slot, from)) in target.iter_mut().zip(from).enumerate() {
                if coded & 1 << at == 0 {
                    *slot = from;
                }
            }
        }
        self.channel.ways_travelled(coded);
        (coded, target)
    }

    /// Takes the word of an axis.
    #[inline(always)]
    fn take_axis(&mut self, axis: usize) -> Option<Datum> {
        let id = self.channel.state.place.axes.get(axis).map(|a| a.data)?;
        self.take(id)
    }

    /// Takes the axis words onto a point; `shift` tells how far away its machine coordinates are.
    #[inline(always)]
    fn axis_words(
        &mut self,
        from: Position,
        shift: impl Fn(&Self, usize) -> Option<f64>,
        take: impl Fn(&mut Self, usize) -> Option<Datum>,
    ) -> (u8, Position) {
        let relative = match self.channel.state.modal.code(group::POSITION) {
            Some(codes::POSITION_RELATIVE) => Some(true),
            Some(_) => Some(false),
            None => None,
        };
        let mut target = from;
        let mut coded = 0_u8;
        let as_written = self.channel.state.place.angles == 0 && !self.channel.block.machine_frame;
        for index in 0..self.channel.state.place.axes.len() {
            let Some(datum) = take(self, index) else { continue };
            if relative.is_none() && !datum.incremental {
                let text = format!(
                    "neither absolute nor incremental is active in '{}', absolute is assumed",
                    self.block_text()
                );
                self.diagnose(&diag::POSITION_MODE_UNKNOWN, text);
            }
            let Some(slot) = target.get_mut(index) else { break };
            *slot = if datum.incremental || relative == Some(true) && !datum.absolute {
                *slot + datum.value
            } else if as_written {
                datum.value
            } else {
                let away = if self.channel.block.machine_frame { shift(self, index).unwrap_or(0.0) } else { 0.0 };
                match self.channel.state.place.angles & 1 << index {
                    0 => datum.value - away,
                    _ => self.turned_to(index, *slot, datum.value, away),
                }
            };
            coded |= 1 << index;
        }
        (coded, target)
    }

    /// Length of the tool path: linear axes, or the rotary ones when nothing else moves.
    pub(super) fn tool_path(&self, changes: &Position) -> f64 {
        let sum = |rotary: bool| {
            self.channel
                .state
                .place
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
    pub(super) fn rapid_to_point(&mut self, coded: u8, target: Position) -> Acted {
        let target = self.channel.work_point(&target);
        self.rapid_to(coded, target)
    }

    /// A straight feed move to a programmed point.
    pub(super) fn feed_to_point(&mut self, coded: u8, target: Position, feed: Option<f64>, unit: FeedUnit) -> Acted {
        let target = self.channel.work_point(&target);
        self.feed_to(coded, target, feed, unit)
    }

    /// Axes that a move concerns: a turned frame moves others than the coded ones.
    #[inline(always)]
    pub(super) fn moving(&self, coded: u8, changes: &Position) -> u8 {
        if self.channel.state.place.frames.is_none() {
            return coded;
        }
        changes.iter().enumerate().filter(|(_, c)| **c != 0.0).fold(coded, |bits, (axis, _)| bits | 1 << axis)
    }

    /// A rapid move to a target in the work frame.
    pub(super) fn rapid_to(&mut self, coded: u8, target: Position) -> Acted {
        self.rapid_within(coded, target, None)
    }

    /// The same, along its path not faster than a feed per minute.
    pub(super) fn rapid_within(&mut self, coded: u8, target: Position, feed: Option<f64>) -> Acted {
        if self.channel.is_compensated() {
            let step = Step { shape: Shape::Rapid, coded, to: target, feed, unit: FeedUnit::Rapid };
            return self.compensate(step);
        }
        let from = self.channel.state.place.position;
        if target == from {
            return Ok(());
        }
        let changes = self.channel.changes(&from, &target);
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
    pub(super) fn feed_to(&mut self, coded: u8, target: Position, feed: Option<f64>, unit: FeedUnit) -> Acted {
        if self.channel.state.place.frames.is_some() {
            return self.feed_in_frames(coded, target, feed, unit);
        }
        self.plain_feed(coded, &target, feed, unit)
    }

    /// Where programmed points are points of the work frame.
    fn plain_feed(&mut self, coded: u8, target: &Position, feed: Option<f64>, unit: FeedUnit) -> Acted {
        let from = self.channel.state.place.position;
        if *target == from {
            return Ok(());
        }
        let changes = self.channel.changes(&from, target);
        let feed_length = changes.iter().map(|c| c * c).sum::<f64>().sqrt();
        let path = Path { from: &from, to: target, length: feed_length, arc: None };
        let seconds = self.feed_seconds(&path, feed, unit)?;
        let length = if self.channel.state.place.rotary { self.tool_path(&changes) } else { feed_length };
        let feed = (feed.unwrap_or(0.0), unit);
        self.travel(seconds, &Motion::straight(MotionKind::Linear, coded, [from, *target], feed, length))
    }

    #[cold]
    fn feed_in_frames(&mut self, coded: u8, target: Position, feed: Option<f64>, unit: FeedUnit) -> Acted {
        if self.channel.is_compensated() {
            // Without a coordinate nothing moves, though the tool is not where the program is.
            let step = Step { shape: Shape::Linear, coded, to: target, feed, unit };
            return if coded == 0 { Ok(()) } else { self.compensate(step) };
        }
        let from = self.channel.state.place.position;
        if target == from {
            return Ok(());
        }
        let changes = self.channel.feed_changes(&from, &target);
        let feed_length = changes.iter().map(|c| c * c).sum::<f64>().sqrt();
        let path = Path { from: &from, to: &target, length: feed_length, arc: None };
        let seconds = self.feed_seconds(&path, feed, unit)?;
        let seconds = self.at_rates(seconds, &from, &target, None);
        let length = self.feed_path(&changes, feed_length);
        let moving = self.moving(coded, &self.channel.changes(&from, &target));
        let feed = (feed.unwrap_or(0.0), unit);
        self.travel(seconds, &Motion::straight(MotionKind::Linear, moving, [from, target], feed, length))
    }

    /// Carries out a motion: limits, event, clock, position. After an alarm of its block nothing moves.
    #[inline]
    pub(super) fn travel(&mut self, seconds: f64, motion: &Motion) -> Acted {
        self.channel.check_stop()?;
        self.check_travel_before(motion)?;
        if let Some(hooks) = self.plan.hooks {
            return (hooks.motion)(self, seconds, motion);
        }
        self.move_to(seconds, motion)
    }

    /// A straight move that a macro has changed: made again from its start.
    pub(crate) fn straight_again(&mut self, motion: &Motion, rapid: bool, to: Position) -> Acted {
        let from = self.channel.state.place.position;
        let changes = self.channel.changes(&from, &to);
        let length = self.tool_path(&changes);
        let moved = changes.iter().enumerate().filter(|(_, change)| **change != 0.0);
        let coded = moved.fold(motion.moving, |bits, (axis, _)| bits | 1 << axis);
        if rapid {
            let seconds = self.rapid_seconds(&from, &to);
            let feed = (0.0, FeedUnit::Rapid);
            return self.move_to(seconds, &Motion::straight(MotionKind::Rapid, coded, [from, to], feed, length));
        }
        let (feed, unit) = match motion.kind {
            MotionKind::Linear => (Some(motion.feed), motion.feed_unit),
            _ => self.feed(),
        };
        let changes = self.channel.feed_changes(&from, &to);
        let feed_length = changes.iter().map(|c| c * c).sum::<f64>().sqrt();
        let path = Path { from: &from, to: &to, length: feed_length, arc: None };
        let mut seconds = self.feed_seconds(&path, feed, unit)?;
        if self.channel.state.place.frames.is_some() {
            seconds = self.at_rates(seconds, &from, &to, None);
        }
        let length = self.feed_path(&changes, feed_length);
        let feed = (feed.unwrap_or(0.0), unit);
        self.move_to(seconds, &Motion::straight(MotionKind::Linear, coded, [from, to], feed, length))
    }

    /// The motion itself.
    #[inline(always)]
    pub(crate) fn move_to(&mut self, seconds: f64, motion: &Motion) -> Acted {
        if let Some(hooks) = self.plan.hooks {
            (hooks.moved)(self, seconds, motion);
        }
        if self.channel.state.place.clamped != 0 {
            self.check_clamps(motion);
        }
        self.channel.block.moved = true;
        self.flow.pass.effects = true;
        self.channel.state.place.position = motion.to;
        let ns = crate::state::channel::nanoseconds(seconds);
        self.emit_as(ns, |kind| match kind {
            Kind::Motion(place) => *place = *motion,
            other => *other = Kind::Motion(*motion),
        });
        self.advance(ns);
        self.check_travel(&motion.to);
        self.follow_radius()
    }

    #[inline(always)]
    fn check_travel(&mut self, to: &Position) {
        if self.channel.state.place.bounds.limited && !self.channel.state.place.bounds.stop {
            self.check_limits_of_axes(to);
        }
    }

    /// Where it is an alarm, an end beyond the limits stops the channel before the move.
    #[inline(always)]
    fn check_travel_before(&mut self, motion: &Motion) -> Acted {
        if self.channel.state.place.bounds.limited && self.channel.state.place.bounds.stop {
            self.check_limits_of_axes(&motion.to);
            return self.channel.check_stop();
        }
        Ok(())
    }

    #[inline(never)]
    fn check_limits_of_axes(&mut self, to: &Position) {
        let mut over = None;
        let machine = self.channel.machine_point(to);
        for (axis, at) in self.channel.state.place.axes.iter().zip(machine) {
            if let Some((low, high)) = axis.limits
                && (at < low - 1e-9 || at > high + 1e-9)
            {
                over = Some((axis.machine, at, low, high));
            }
        }
        if let Some((axis, at, low, high)) = over {
            let name = self.channel.env.machine.axes.get(axis).map_or("?", |a| a.name.as_str());
            let text = format!(
                "axis {name} at {at:.3} in the machine frame is beyond its limits {low} to {high} in '{}'",
                self.block_text()
            );
            self.diagnose(&diag::OVER_TRAVEL, text);
        }
    }
}
