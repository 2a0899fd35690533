//! Circular moves in a plane: by centre, radius or angle.
//!
//! Facts: reference control-emulator.md 6.1 (arc rules): centre offsets are radii even on a diameter axis; a block with
//! only a centre is a full circle. Separate codes define the properties that a code leaves open (direction, centre,
//! radius). *Invariant:* a circle that cannot be made is reported and its end reached straight. Decisions:
//! docs/emulation.md, "Circles".

mod define;
pub(crate) mod space;
mod tangent;

pub(crate) use define::{define_center, define_direction, define_radius};

use counterpoint_channel::alarm_effect::STRAIGHT;
use counterpoint_channel::cutter::MoveShape;
use counterpoint_channel::cutter::ProgrammedMove;
use counterpoint_channel::modal::Plane;
use counterpoint_channel::modal::group;
use counterpoint_channel::modal::plane;
use counterpoint_channel::thread::Screw;
use counterpoint_event::event::FeedUnit;
use counterpoint_event::event::Motion;
use counterpoint_event::event::MotionKind;
use counterpoint_event::event::Position;
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::codes;
use counterpoint_machine::ident::data;
use counterpoint_machine::ident::kind::CodeKind;
use counterpoint_machine::ident::kind::arc::ArcDefinition;
use counterpoint_machine::ident::kind::arc::ArcForm;
use counterpoint_machine::index::AxisSlot;
use counterpoint_machine::index::BySlot;
use counterpoint_machine::model::paths::Helix;
use counterpoint_machine::model::paths::MultiTurnCircles;
use counterpoint_motion::arc as geometry;
use counterpoint_program::block::PendingCode;

use super::circular_move::not_made;
use super::turned;
use crate::context::{ActionContext, CircleSteps, ThreadSteps};
use crate::cutter::compensate;
use crate::entry::ActionEntry;
use crate::entry::CompensationEffect;
use crate::entry::entry_of_kind;
use crate::motion::feed_to_point;
use crate::motion::moved_axes;
use crate::motion::programmed_targets;
use crate::polar::circle_of_part;
use crate::time::feed_seconds;
use counterpoint_channel::axis_rates::at_rates;
use counterpoint_channel::axis_rates::feed_down;
use counterpoint_channel::circular_move::CircularMove;
use counterpoint_channel::plane_points::ends_by_pole;
use counterpoint_channel::timed_path::TimedPath;

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] = &[
    entry_of_kind!(CodeKind::Arc(form) => |act, _row, code| arc(act, form, code))
        .moves()
        .contour(CompensationEffect::Follows),
    ActionEntry::of(&[codes::INTERP_ARC_TANGENT], |act, _, _| tangent::tangent(act))
        .moves()
        .contour(CompensationEffect::Follows),
    ActionEntry::of(&[codes::INTERP_ARC_3D], |act, _, _| space::through(act))
        .moves()
        .contour(CompensationEffect::Leaves),
    ActionEntry::of(&[codes::INTERP_DEF_CENTER], |act, _, _| define_center(act)).contour(CompensationEffect::Waits),
    ActionEntry::of(&[codes::INTERP_DEF_RADIUS], |act, _, _| define_radius(act)).contour(CompensationEffect::Waits),
    ActionEntry::of(&[codes::INTERP_DEF_CLW], |act, _, _| define_direction(act, true))
        .contour(CompensationEffect::Waits),
    ActionEntry::of(&[codes::INTERP_DEF_CCLW], |act, _, _| define_direction(act, false))
        .contour(CompensationEffect::Waits),
];

/// The plane of a circle by its axes in the channel, with their factors to radius values.
#[derive(Clone, Copy)]
struct Flat {
    axes: [AxisSlot; 2],
    scales: [f64; 2],
}

impl Flat {
    fn point(&self, position: &Position) -> [f64; 2] {
        let ([first, second], [a, b]) = (self.axes, self.scales);
        [position.at(first) * a, position.at(second) * b]
    }

    /// Moves a position to a point of the plane.
    fn set(&self, position: &mut Position, point: [f64; 2]) {
        for ((axis, scale), value) in self.axes.iter().zip(self.scales).zip(point) {
            *position.at_mut(*axis) = value / scale;
        }
    }
}

/// The data of a block about its circle.
struct CircleWords {
    radius: Option<f64>,
    /// Centre in the plane, radius values.
    center: Option<[f64; 2]>,
    /// Degrees.
    angle: Option<f64>,
}

/// A thread along a circle in the active plane.
pub(crate) fn threaded(act: &mut ActionContext<'_, '_>, clockwise: bool, code: &PendingCode, screw: Screw) -> Acted {
    along(act, ArcForm::new(Some(clockwise), ArcDefinition::Any, false), code, Some(screw))
}

/// An arc in the active plane, helical when a further axis is coded.
pub(crate) fn arc(act: &mut ActionContext<'_, '_>, form: ArcForm, code: &PendingCode) -> Acted {
    if act.channel().block.flags.machine_frame && act.channel().env.machine.habits.machine_frame_rapid {
        return super::motion::rapid(act);
    }
    if let Some(polar) = act.channel().state.place.polar()
        && let Some(clockwise) = define::direction(act, form)
    {
        return super::polar::arc(act, polar, clockwise);
    }
    along(act, form, code, None)
}

/// A circle at a feed, or at the lead of a thread.
fn along(act: &mut ActionContext<'_, '_>, form: ArcForm, code: &PendingCode, screw: Option<Screw>) -> Acted {
    let (feed, unit) = match screw {
        Some(screw) => (Some(screw.lead), FeedUnit::PerRevolution),
        None => act.active_feed(),
    };
    let about_pole = ends_by_pole(act.channel_mut());
    let (coded, target) = programmed_targets(act);
    let Some((plane, flat)) = active_plane(act) else {
        for id in [data::ARC_RADIUS, data::ARC_CENTER_X, data::ARC_CENTER_Y, data::ARC_CENTER_Z] {
            act.take(id);
        }
        let text = format!(
            "no plane with both axes in channel {} is active for '{}'",
            act.channel().at.channel,
            act.channel().block_text()
        );
        act.diagnose(&diag::ARC_PLANE, text);
        return Ok(());
    };
    let mut words = take_words(act, form, &plane, &flat, (coded, code.modal));
    if about_pole && words.radius.is_none() && words.center.is_none() && words.angle.is_none() {
        words.center = Some(flat.point(&act.channel().state.arcs.pole));
    }
    if coded == 0 && words.radius.is_none() && words.center.is_none() && words.angle.is_none() {
        return Ok(());
    }
    let Some(clockwise) = define::direction(act, form) else {
        let done = act.channel().becomes(&diag::ARC_DIRECTION, STRAIGHT);
        let text = format!("the circle of '{}' has no direction, {done}", act.channel().block_text());
        act.diagnose(&diag::ARC_DIRECTION, text);
        return feed_to_point(act, coded, target, feed, unit);
    };
    let incomplete = words.radius.is_none() && words.center.is_none() && words.angle.is_none();
    if incomplete {
        let forms = [data::ARC_RADIUS, data::ARC_CENTER_X, data::ARC_CENTER_Y, data::ARC_CENTER_Z, data::ARC_ANGLE];
        act.report_switched_off(&forms);
    }
    if incomplete && act.channel().env.machine.arcs.straight {
        let text = format!(
            "the circle has neither a centre nor a radius in '{}', it is a straight line",
            act.channel().block_text()
        );
        act.diagnose(&diag::ARC_STRAIGHT, text);
        return feed_to_point(act, coded, target, feed, unit);
    }
    if incomplete && act.channel().env.machine.stops_at(&diag::ARC_INCOMPLETE) {
        let text = format!(
            "the circle has neither a centre nor a radius in '{}', nothing is moved",
            act.channel().block_text()
        );
        return Err(act.alarm(&diag::ARC_INCOMPLETE, text));
    }
    cut(act, &words, (form, clockwise), (plane, &flat), (coded, target), (feed, unit, screw))
}

/// The active plane, if the channel has its axes.
fn active_plane(act: &ActionContext<'_, '_>) -> Option<(Plane, Flat)> {
    let plane = plane(act.channel().state.modal.code(group::PLANE)?)?;
    let index = |role: usize| act.channel().state.place.layout.cartesian.get(role).copied().flatten();
    let axes = [index(plane.first)?, index(plane.second)?];
    let scales = axes.map(|axis| act.channel().state.place.layout.axes[axis].scale);
    Some((plane, Flat { axes, scales }))
}

/// Takes radius or centre, then the angle; earlier blocks may have defined values that this block omits.
fn take_words(
    act: &mut ActionContext<'_, '_>,
    form: ArcForm,
    plane: &Plane,
    flat: &Flat,
    (coded, implied): (u8, bool),
) -> CircleWords {
    let here = act.channel().state.arcs.block == act.channel().at.blocks;
    let by = match form.by {
        ArcDefinition::Any if here => act.channel().state.arcs.by,
        by => by,
    };
    let mut radius = if by == ArcDefinition::Center { None } else { act.take(data::ARC_RADIUS).map(|d| d.value) };
    let start = flat.point(&act.channel().state.place.programmed());
    let mut center = None;
    if by != ArcDefinition::Radius {
        let roles = [plane.first, plane.second];
        let sides = plane.centers.into_iter().zip(roles).zip(flat.axes);
        let mut said = [None; 2];
        for (slot, ((id, _), axis)) in said.iter_mut().zip(sides) {
            *slot = define::coordinate(act, id, axis);
        }
        // The missing one of an absolute centre is that of the definition.
        let known = roles.map(|role| act.channel().state.arcs.center.get(role).copied().flatten());
        let fill = |a: Option<f64>, b: Option<f64>, or: f64| a.or(b).unwrap_or(or);
        if said.iter().any(Option::is_some) {
            let offsets =
                act.channel().env.machine.arcs.center == counterpoint_machine::model::DistanceMode::Incremental;
            let known = if offsets { [None; 2] } else { known };
            center = Some([fill(said[0], known[0], start[0]), fill(said[1], known[1], start[1])]);
        } else if known.iter().any(Option::is_some) && radius.is_none() {
            let angle = act.block_has(data::ARC_ANGLE);
            if coded != 0 || angle || here && !implied {
                center = Some([fill(None, known[0], start[0]), fill(None, known[1], start[1])]);
            }
        }
    }
    if radius.is_none() && center.is_none() && coded != 0 && !act.block_has(data::ARC_ANGLE) {
        radius = act.channel().state.arcs.radius.filter(|_| by != ArcDefinition::Center);
    }
    let angle = if radius.is_none() { act.take(data::ARC_ANGLE).map(|d| d.value.abs()) } else { None };
    CircleWords { radius, center, angle }
}

/// Makes the circle and travels along it.
fn cut(
    act: &mut ActionContext<'_, '_>,
    words: &CircleWords,
    (form, clockwise): (ArcForm, bool),
    (plane, flat): (Plane, &Flat),
    (coded, mut target): (u8, Position),
    (feed, unit, screw): (Option<f64>, FeedUnit, Option<Screw>),
) -> Acted {
    let from = act.channel().state.place.programmed();
    let (start, end) = (flat.point(&from), flat.point(&target));
    let tolerance = act.channel().env.machine.arcs.tolerance;
    // Many machines do not ask.
    let asks = act.channel().env.machine.arcs.helix != Helix::Any
        || act.channel().env.machine.arcs.turns == MultiTurnCircles::Helical;
    let rises = asks && rises(act, flat, &from, &target);
    let made = match (words.radius, words.angle, words.center) {
        (Some(radius), ..) => geometry::by_radius(start, end, radius, clockwise, tolerance).map(|arc| (arc, end)),
        (None, Some(angle), Some(center)) => geometry::by_center_and_angle(start, center, angle, clockwise),
        (None, Some(angle), None) => geometry::by_end_and_angle(start, end, angle, clockwise).map(|arc| (arc, end)),
        (None, None, center) => {
            geometry::by_center(start, end, center.unwrap_or(start), clockwise).map(|arc| (arc, end))
        }
    };
    let (mut made, reached) = match made {
        Ok(made) => made,
        Err(error) => {
            not_made(act, error);
            return feed_to_point(act, coded, target, feed, unit);
        }
    };
    let by_angle = words.angle.is_some() && words.center.is_some();
    let flat_coded = coded & (flat.axes[0].bit() | flat.axes[1].bit()) != 0;
    if words.radius.is_none() && (!by_angle || flat_coded) {
        let off = made.end_error(end).max(if by_angle { distance(reached, end) } else { 0.0 });
        check_end(act, off, made.radius);
    }
    let turns = if by_angle {
        // Digits of an angle after the ninth were not programmed.
        let tidy = |value: f64| (value * 1e9).round() / 1e9 + 0.0;
        flat.set(&mut target, if reached == start { start } else { reached.map(tidy) });
        made.full_turns()
    } else {
        take_turns(act, rises)
    };
    if !by_angle {
        made = made.with_turns(turns);
    }
    check_machine(act, form, &made, rises);
    let circle = CircularMove { made, coded, from, to: target, axes: flat.axes, turns, feed, unit, screw };
    if act.channel().state.place.frames.is_some() {
        turned::circle(act, plane, &circle)
    } else {
        act.circle_to(&circle)
    }
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    ((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1])).sqrt()
}

/// Whether a linear axis out of the plane moves too.
fn rises(act: &ActionContext<'_, '_>, flat: &Flat, from: &Position, to: &Position) -> bool {
    let axes = act.channel().state.place.layout.axes.entries();
    axes.filter(|(slot, axis)| !flat.axes.contains(slot) && !axis.rotary).any(|(slot, _)| from.at(slot) != to.at(slot))
}

fn check_end(act: &mut ActionContext<'_, '_>, off: f64, radius: f64) {
    if off > act.channel().env.machine.arcs.end_tolerance(radius) {
        let text = format!("the end is {off:.4} off the circle in '{}'", act.channel().block_text());
        act.diagnose(&diag::ARC_END_OFF, text);
    }
}

/// Full turns in addition, where the machine has them.
fn take_turns(act: &mut ActionContext<'_, '_>, rises: bool) -> u16 {
    let may = match act.channel().env.machine.arcs.turns {
        MultiTurnCircles::Always => true,
        MultiTurnCircles::Helical => rises,
        MultiTurnCircles::Never => false,
    };
    let turns = if may { act.take(data::ARC_TURNS).map_or(0.0, |d| d.value) } else { 0.0 };
    if (0.0..=geometry::MOST_TURNS).contains(&turns) {
        return turns as u16;
    }
    let text = format!("a circle has 0 to 999 further turns, not {turns} as in '{}'", act.channel().block_text());
    act.diagnose(&diag::DATA_OUT_OF_RANGE, text);
    0
}

/// The limit of the machine; the circle is made nevertheless.
fn check_machine(act: &mut ActionContext<'_, '_>, form: ArcForm, made: &geometry::PlaneArc, rises: bool) {
    check_radius(act, made.radius);
    let allowed = match act.channel().env.machine.arcs.helix {
        Helix::Any => true,
        Helix::Codes => form.helix,
        Helix::Off => false,
    };
    if rises && !allowed {
        let text = format!("this control has no helix for '{}'", act.channel().block_text());
        act.diagnose(&diag::ARC_HELIX, text);
    }
}

/// A radius above the largest of the machine.
fn check_radius(act: &mut ActionContext<'_, '_>, radius: f64) {
    let most = act.channel().env.machine.arcs.max_radius;
    if radius > most {
        let text = format!("the radius {radius:.3} is above the maximum {most} in '{}'", act.channel().block_text());
        act.diagnose(&diag::ARC_RADIUS, text);
    }
}

impl CircleSteps for ActionContext<'_, '_> {
    #[inline(always)]
    fn circle_to(&mut self, circle: &CircularMove) -> Acted {
        if self.channel().state.place.is_compensated() && circle.screw.is_none() {
            let CircularMove { made, axes, turns, coded, to, feed, unit, .. } = *circle;
            return compensate(
                self,
                ProgrammedMove { shape: MoveShape::Circle { made, axes, turns }, coded, to, feed, unit },
            );
        }
        if let Some(polar) = self.channel().state.place.polar() {
            return circle_of_part(self, polar, circle);
        }
        let CircularMove { made, coded, from, to, axes: [first, second], turns, feed, unit, screw } = *circle;
        let changes = self.channel().state.place.changes(&from, &to);
        let axes = self.channel().state.place.layout.axes.entries();
        let rise = axes
            .filter(|(slot, axis)| *slot != first && *slot != second && !axis.rotary)
            .map(|(slot, _)| changes.at(slot) * changes.at(slot))
            .sum::<f64>();
        let length = (made.length() * made.length() + rise).sqrt();
        let x = self.channel().state.place.layout.cartesian.first().copied().flatten();
        let radial = [first, second].iter().position(|&axis| Some(axis) == x);
        let scale = |axis: AxisSlot| self.channel().state.place.layout.axes[axis].scale;
        let center = [made.center[0] / scale(first), made.center[1] / scale(second)];
        let feed = match self.channel().state.place.frames {
            Some(_) => feed_down(self.channel(), feed, unit, &changes, made.length()),
            None => feed,
        };
        let along = match &self.channel().state.place.feed_group {
            Some(group) => {
                let axes = &self.channel().state.place.layout.axes;
                (made.length() * made.length() + group.rise(axes, &changes, [first, second])).sqrt()
            }
            None => made.length(),
        };
        let path = TimedPath { from: &from, to: &to, length: along, arc: Some((&made, radial)) };
        let mut seconds = match &screw {
            Some(screw) => self.arc_thread_seconds(&to, (&made, [first, second]), screw)?,
            None => feed_seconds(self, &path, feed, unit)?,
        };
        if screw.is_none() && self.channel().state.place.frames.is_some() {
            seconds = at_rates(self.channel(), seconds, &from, &to, None);
        }
        if screw.is_none() && self.channel().state.place.weighs {
            seconds = self.channel().state.place.seconds_of_group(seconds, &changes);
        }
        let moving = moved_axes(self.channel(), coded, &changes) | first.bit() | second.bit();
        self.channel_mut().state.threads.rounds = screw.is_some();
        let done = self.travel(
            seconds,
            &Motion {
                kind: if made.sweep < 0.0 { MotionKind::ArcCw } else { MotionKind::ArcCcw },
                moving,
                from,
                to,
                center,
                plane_axes: [first, second].map(|slot| slot.index() as u8),
                turns,
                feed: feed.unwrap_or(0.0),
                feed_unit: unit,
                length,
            },
        );
        self.channel_mut().state.threads.rounds = false;
        done
    }
}
