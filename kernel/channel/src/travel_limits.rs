//! Whether a motion leaves the travel of an axis or the working area.
//!
//! *Invariant:* nothing here reports or moves.

use counterpoint_event::event::{Motion, MotionKind, Position};
use counterpoint_machine::index::{AxisId, AxisSlot, BySlot};
use counterpoint_motion::arc;
use counterpoint_motion::space::SpaceArc;

use crate::channel_axis::FIRST_AXES;
use crate::channel_context::ChannelContext;

/// An axis beyond its limits, its position, and the limits.
pub type Over = (AxisId, f64, [f64; 2]);

/// A circle in a plane: its axes, the circle in radius values, and the factors to those.
type Round = ([AxisSlot; 2], arc::PlaneArc, [f64; 2]);

/// The kind of limits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LimitKind {
    /// Limits of the machine.
    Travel,
    /// Limits of the program.
    Area,
}

/// Distance beyond the limits that counts as rounding.
pub const NOISE: f64 = 1e-9;

/// Fewest digits of a number that may count least increments: 1000 is 1 mm.
pub const FEWEST_DIGITS: usize = 4;

/// Places of a move under tool tip control that are looked at, for each degree of its rotary axes: 1 m from the centre
/// of rotation the axes get at most 0.01 mm further between two places.
const PLACES_PER_DEGREE: f64 = 2.0;

/// Fewest and most checked positions of a move.
const MIN_PLACES: f64 = 16.0;

const MAX_PLACES: f64 = 20_000.0;

/// The position after this fraction of a move, straight or on its circle.
pub fn place_along(motion: &Motion, round: &Option<Round>, share: f64) -> Position {
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

/// The first axis that a motion moves beyond its limits, with its position and its range.
pub fn leads_beyond(channel: &ChannelContext<'_>, motion: &Motion, limits: LimitKind) -> Option<Over> {
    let over = beyond(channel, &motion.to, NOISE, limits).or_else(|| match motion.kind {
        MotionKind::ArcCw | MotionKind::ArcCcw => swings_beyond(channel, motion, limits),
        MotionKind::ArcSpace => swings_beyond_in_space(channel, motion, limits),
        MotionKind::Rapid | MotionKind::Linear | MotionKind::Thread => None,
    });
    if over.is_none() && channel.state.place.tip().is_some() { follows_beyond(channel, motion, limits) } else { over }
}

/// The linear axes follow the rotary axes under tool tip control: checks positions along the move.
#[cold]
fn follows_beyond(channel: &ChannelContext<'_>, motion: &Motion, limits: LimitKind) -> Option<Over> {
    let chain = &channel.state.place.tip()?.chain;
    let joints = chain.tables.iter().chain(&chain.heads).map(|joint| joint.axis);
    let turned: f64 = joints.map(|axis| (motion.to.at(axis) - motion.from.at(axis)).abs()).sum();
    if turned == 0.0 {
        return None;
    }
    let round = match motion.kind {
        MotionKind::ArcCw | MotionKind::ArcCcw => circle_of(channel, motion),
        _ => None,
    };
    let places = (turned * PLACES_PER_DEGREE).clamp(MIN_PLACES, MAX_PLACES).ceil();
    (1..places as u32)
        .find_map(|at| beyond(channel, &place_along(motion, &round, f64::from(at) / places), NOISE, limits))
}

/// A circle in a plane: its axes, the circle in radius values, and the factors to those.
pub fn circle_of(channel: &ChannelContext<'_>, motion: &Motion) -> Option<Round> {
    let layout = &channel.state.place.layout;
    let [first, second] = motion.plane_axes.map(|axis| layout.axes.id(usize::from(axis)));
    let axes = [first?, second?];
    let scales = axes.map(|axis| layout.axes[axis].scale);
    let point = |place: &Position| [place.at(axes[0]) * scales[0], place.at(axes[1]) * scales[1]];
    let center = [motion.center[0] * scales[0], motion.center[1] * scales[1]];
    let made = arc::by_center(point(&motion.from), point(&motion.to), center, motion.kind == MotionKind::ArcCw);
    Some((axes, made.ok()?.with_turns(motion.turns), scales))
}

/// A circle in a plane. Its end may be off the circle by the tolerance of the machine, so the places between may
/// be, too.
fn swings_beyond(channel: &ChannelContext<'_>, motion: &Motion, limits: LimitKind) -> Option<Over> {
    let (axes, made, scales) = circle_of(channel, motion)?;
    let to = [motion.to.at(axes[0]) * scales[0], motion.to.at(axes[1]) * scales[1]];
    let slack = made.end_error(to) + NOISE;
    (0..)
        .zip(axes)
        .find_map(|(side, axis)| turns_beyond(channel, &motion.to, axis, made.turning_points(side), (slack, limits)))
}

/// Whether a straight move or a circle in a plane certainly stays within the travel limits; `false` means that this is
/// not certain.
#[inline(always)]
pub fn stays_within_travel(channel: &ChannelContext<'_>, motion: &Motion) -> bool {
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

/// The last axis of the channel that is beyond its limits at a position.
pub fn beyond(channel: &ChannelContext<'_>, place: &Position, slack: f64, limits: LimitKind) -> Option<Over> {
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
pub fn turns_beyond(
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
