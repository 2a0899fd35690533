//! Limits of travel and of the working area: checks the ends of moves, and the extent of circles between their ends.
//!
//! *Invariant:* a block is reported once; a straight move is within the limits where both its ends are, except under
//! tool tip control, where places along it are checked. Circles in the face plane of polar interpolation are checked at
//! their ends only, those on a cylinder along its axis too.

use counterpoint_event::event::{Motion, MotionKind, Position};
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::index::{AxisId, AxisSlot, BySlot};
use counterpoint_motion::arc;
use counterpoint_motion::space::SpaceArc;
use counterpoint_program::block::Word;

use super::Kernel;
use counterpoint_channel::channel_axis::FIRST_AXES;
use counterpoint_channel::channel_context::ChannelContext;

/// An axis beyond its limits, where it is, and the limits.
type Over = (AxisId, f64, [f64; 2]);

/// A circle in a plane: its axes, the circle in radius values, and the factors to those.
type Round = ([AxisSlot; 2], arc::PlaneArc, [f64; 2]);

/// Which limits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum LimitKind {
    /// Those of the machine.
    Travel,
    /// Those of the program.
    Area,
}

/// Distance beyond the limits that counts as rounding.
const NOISE: f64 = 1e-9;

/// Fewest digits of a number that may count least increments: 1000 is 1 mm.
const FEWEST_DIGITS: usize = 4;

/// Places of a move under tool tip control that are looked at, for each degree of its rotary axes: 1 m from the centre
/// of rotation the axes get at most 0.01 mm further between two places.
const PLACES_PER_DEGREE: f64 = 2.0;
/// Fewest and most places of a move.
const MIN_PLACES: f64 = 16.0;
const MAX_PLACES: f64 = 20_000.0;

/// The place of a move, straight or on its circle, after this share of it.
fn place_along(motion: &Motion, round: &Option<Round>, share: f64) -> Position {
    let mut place = motion.from;
    for (slot, end) in place.iter_mut().zip(&motion.to) {
        *slot += (end - *slot) * share;
    }
    if let Some((axes, arc, scales)) = round {
        let angle = arc.start_angle + arc.sweep * share;
        *place.at_mut(axes[0]) = (arc.center[0] + arc.radius * libm::cos(angle)) / scales[0];
        *place.at_mut(axes[1]) = (arc.center[1] + arc.radius * libm::sin(angle)) / scales[1];
    }
    place
}

impl Kernel<'_> {
    /// Reports a motion beyond the limits.
    #[inline(always)]
    pub(super) fn check_travel(&mut self, motion: &Motion) {
        if self.channel.state.place.layout.bounds.limited && !self.channel.state.place.layout.bounds.stop {
            self.check_limits_of_motion(motion);
        }
    }

    /// If the limit is an alarm, a motion beyond it stops the channel before it begins; a motion beyond a limit of the
    /// program always stops the channel.
    #[inline(always)]
    pub(super) fn check_travel_before(&mut self, motion: &Motion) -> Acted {
        if self.channel.state.place.layout.bounds.limited {
            if self.channel.state.place.stored.is_some() {
                self.check_stored_area(motion);
            }
            if self.channel.state.place.layout.bounds.stop {
                self.check_limits_of_motion(motion);
            }
            return self.channel.check_stop();
        }
        Ok(())
    }

    #[inline(always)]
    fn check_limits_of_motion(&mut self, motion: &Motion) {
        if !stays_within_travel(&self.channel, motion) {
            self.measure_travel(motion);
        }
    }

    #[cold]
    #[inline(never)]
    fn measure_travel(&mut self, motion: &Motion) {
        let over = self.leads_beyond(motion, LimitKind::Travel);
        self.report_over_travel(over);
    }

    /// Stops the channel before a motion that leads out of the working area.
    pub(super) fn check_area(&mut self, motion: &Motion) -> Acted {
        let Some((axis, at, [low, high])) = self.leads_beyond(motion, LimitKind::Area) else { return Ok(()) };
        let name = &self.channel.env.machine.axes[axis].name;
        let bound = if at > high { high } else { low };
        let text = format!(
            "axis {name} would be at {at:.3} in the basic coordinate system, beyond the limit {bound} of the working area, \
             in '{}'; no part of the block acts",
            self.channel.block_text()
        );
        self.diagnose(&diag::WORK_AREA, text);
        self.channel.check_stop()
    }

    fn leads_beyond(&self, motion: &Motion, limits: LimitKind) -> Option<Over> {
        let over = beyond(&self.channel, &motion.to, NOISE, limits).or_else(|| match motion.kind {
            MotionKind::ArcCw | MotionKind::ArcCcw => self.swings_beyond(motion, limits),
            MotionKind::ArcSpace => swings_beyond_in_space(&self.channel, motion, limits),
            MotionKind::Rapid | MotionKind::Linear | MotionKind::Thread => None,
        });
        if over.is_none() && self.channel.state.place.tip().is_some() {
            self.follows_beyond(motion, limits)
        } else {
            over
        }
    }

    /// The linear axes follow the rotary ones under tool tip control: looks at places along the move.
    #[cold]
    fn follows_beyond(&self, motion: &Motion, limits: LimitKind) -> Option<Over> {
        let chain = &self.channel.state.place.tip()?.chain;
        let joints = chain.tables.iter().chain(&chain.heads).map(|joint| joint.axis);
        let turned: f64 = joints.map(|axis| (motion.to.at(axis) - motion.from.at(axis)).abs()).sum();
        if turned == 0.0 {
            return None;
        }
        let round = match motion.kind {
            MotionKind::ArcCw | MotionKind::ArcCcw => self.round(motion),
            _ => None,
        };
        let places = (turned * PLACES_PER_DEGREE).clamp(MIN_PLACES, MAX_PLACES).ceil();
        (1..places as u32)
            .find_map(|at| beyond(&self.channel, &place_along(motion, &round, f64::from(at) / places), NOISE, limits))
    }

    /// Reports a motion that breaks the limit that the program has set.
    #[cold]
    fn check_stored_area(&mut self, motion: &Motion) {
        let Some(area) = self.channel.state.place.stored.as_deref().copied().filter(|area| area.on) else { return };
        let at = |place: &Position| {
            let machine = self.channel.state.place.machine_point(place);
            self.channel.state.place.layout.cartesian.map(|axis| axis.map(|axis| machine.at(axis)))
        };
        let round = match motion.kind {
            MotionKind::ArcCw | MotionKind::ArcCcw => self.round(motion),
            _ => None,
        };
        let broken = match round {
            Some(_) => area.breaks_round(|share| at(&place_along(motion, &round, share))),
            None => area.breaks(&at(&motion.from), &at(&motion.to)),
        };
        let Some(role) = broken else { return };
        let name = ["X", "Y", "Z"].get(role).copied().unwrap_or_default();
        let does = if area.keep_out { "enters the forbidden area" } else { "leaves the allowed area" };
        let text = format!("the tool {does} along {name} in '{}'", self.channel.block_text());
        self.diagnose(&diag::STORED_LIMIT, text);
    }

    /// A circle in a plane: its axes, the circle in radius values, and the factors to those.
    fn round(&self, motion: &Motion) -> Option<Round> {
        let layout = &self.channel.state.place.layout;
        let [first, second] = motion.plane_axes.map(|axis| layout.axes.id(usize::from(axis)));
        let axes = [first?, second?];
        let scales = axes.map(|axis| layout.axes[axis].scale);
        let point = |place: &Position| [place.at(axes[0]) * scales[0], place.at(axes[1]) * scales[1]];
        let center = [motion.center[0] * scales[0], motion.center[1] * scales[1]];
        let made = arc::by_center(point(&motion.from), point(&motion.to), center, motion.kind == MotionKind::ArcCw);
        Some((axes, made.ok()?.with_turns(motion.turns), scales))
    }

    /// Reports axes that stand beyond their limits.
    pub(super) fn check_limits_of_axes(&mut self, at: &Position) {
        let over = beyond(&self.channel, at, NOISE, LimitKind::Travel);
        self.report_over_travel(over);
    }

    /// Reports a circle that is straight for its axes and turns one of them back beyond its limits, at `values` in
    /// radius.
    #[cold]
    pub fn check_swing(&mut self, to: &Position, axis: AxisSlot, values: [Option<f64>; 2]) -> Acted {
        if self.channel.state.place.layout.bounds.limited
            && beyond(&self.channel, to, NOISE, LimitKind::Travel).is_none()
        {
            let over = turns_beyond(&self.channel, to, axis, values, (NOISE, LimitKind::Travel));
            self.report_over_travel(over);
            if self.channel.state.place.layout.bounds.stop {
                return self.channel.check_stop();
            }
        }
        Ok(())
    }

    /// A circle in a plane. Its end may be off the circle by the tolerance of the machine, so the places between may
    /// be, too.
    fn swings_beyond(&self, motion: &Motion, limits: LimitKind) -> Option<Over> {
        let (axes, made, scales) = self.round(motion)?;
        let to = [motion.to.at(axes[0]) * scales[0], motion.to.at(axes[1]) * scales[1]];
        let slack = made.end_error(to) + NOISE;
        (0..).zip(axes).find_map(|(side, axis)| {
            turns_beyond(&self.channel, &motion.to, axis, made.turning_points(side), (slack, limits))
        })
    }

    fn report_over_travel(&mut self, over: Option<Over>) {
        let Some((axis, at, [low, high])) = over else { return };
        let axis = &self.channel.env.machine.axes[axis];
        let hint = match self.channel.block.words.iter().find_map(|word| whole_number(self, word, &axis.letter)) {
            Some(word) => format!("; if {word} counts least increments, run with --set numbers=increments"),
            None => String::new(),
        };
        let text = format!(
            "axis {} at {at:.3} in the machine frame is beyond its limits {low} to {high} in '{}'{hint}",
            axis.name,
            self.channel.block_text()
        );
        self.diagnose(&diag::OVER_TRAVEL, text);
    }
}

/// The text of an axis word with many digits and no decimal point; `None` if the control never counts least increments,
/// or already counts them.
fn whole_number(kernel: &Kernel<'_>, word: &Word, axis: &str) -> Option<String> {
    let machine = kernel.channel.env.machine;
    let register = &machine.registers[word.register];
    if register.before != axis || register.counts || word.made || !machine.preprocessor.row().counts_increments {
        return None;
    }
    let text = String::from_utf8_lossy(&kernel.channel.word_bytes(word)).into_owned();
    let digits = text.trim_start_matches(|c: char| !c.is_ascii_digit());
    (digits.len() >= FEWEST_DIGITS && digits.bytes().all(|byte| byte.is_ascii_digit())).then_some(text)
}

/// Whether a straight move or a circle in a plane certainly stays within the travel limits; `false` leaves that
/// open.
#[inline(always)]
fn stays_within_travel(channel: &ChannelContext<'_>, motion: &Motion) -> bool {
    let swing = match motion.kind {
        MotionKind::Rapid | MotionKind::Linear | MotionKind::Thread => 0.0,
        MotionKind::ArcCw | MotionKind::ArcCcw => {
            let [first, second] = motion.plane_axes.map(|axis| motion.to.get(usize::from(axis)));
            let (Some(first), Some(second)) = (first, second) else { return false };
            // More than four radii: a circle is two radii wide, and a diameter axis counts twice. A radius is at
            // most the sum of its parts.
            5.0 * ((first - motion.center[0]).abs() + (second - motion.center[1]).abs())
        }
        MotionKind::ArcSpace => return false,
    };
    let place = &channel.state.place;
    let (Some(to), Some(shift)) = (motion.to.first_chunk::<FIRST_AXES>(), place.shift.first_chunk::<FIRST_AXES>())
    else {
        return false;
    };
    let mut within = !channel.state.place.couples();
    for ((to, shift), nearness) in to.iter().zip(shift).zip(&place.layout.bounds.nearness) {
        within &= ((to + shift).abs() + swing) * nearness <= 1.0;
    }
    within
}

/// The last axis of the channel that is beyond its limits at a place.
fn beyond(channel: &ChannelContext<'_>, place: &Position, slack: f64, limits: LimitKind) -> Option<Over> {
    let point = match limits {
        LimitKind::Travel => channel.state.place.machine_point(place),
        LimitKind::Area => channel.basic_point(place)?,
    };
    let layout = &channel.state.place.layout;
    layout.axes.entries().rev().find_map(|(slot, axis)| {
        let at = point.at(slot);
        let (low, high) = match limits {
            LimitKind::Travel => axis.limits?,
            LimitKind::Area => channel.area_of(slot)?,
        };
        (at < low - slack || at > high + slack).then_some((axis.machine, at, [low, high]))
    })
}

/// The same for places where one axis turns back, in radius values.
fn turns_beyond(
    channel: &ChannelContext<'_>,
    to: &Position,
    axis: AxisSlot,
    values: [Option<f64>; 2],
    (slack, limits): (f64, LimitKind),
) -> Option<Over> {
    let scale = channel.state.place.layout.axes[axis].scale;
    values.into_iter().flatten().find_map(|value| {
        let mut place = *to;
        *place.at_mut(axis) = value / scale;
        beyond(channel, &place, slack / scale, limits)
    })
}

fn swings_beyond_in_space(channel: &ChannelContext<'_>, motion: &Motion, limits: LimitKind) -> Option<Over> {
    let layout = &channel.state.place.layout;
    let scale = |axis: AxisSlot| layout.axes[axis].scale;
    let point = |place: &Position| layout.cartesian.map(|axis| axis.map_or(0.0, |axis| place.at(axis) * scale(axis)));
    let circle = SpaceArc::bulging(point(&motion.from), point(&motion.to), motion.center).ok()?;
    (0..).zip(layout.cartesian).find_map(|(side, axis)| {
        let values =
            circle.turning_points(side).map(|share| share.and_then(|share| circle.at(share).get(side).copied()));
        turns_beyond(channel, &motion.to, axis?, values, (NOISE, limits))
    })
}
