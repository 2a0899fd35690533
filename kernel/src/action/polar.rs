//! Polar interpolation: its codes, its words, and circles on the part.
//!
//! Facts: reference control-emulator.md 6.8. Decisions: docs/emulation.md, "Polar interpolation". Invariant: events name
//! the real axes; length and time are those on the part.

use std::f64::consts::TAU;

use counterpoint_motion::arc as geometry;

use super::arc::Circle;
use super::time::Path;
use crate::channel::Kernel;
use crate::channel::data::Datum;
use crate::diag;
use crate::log::event::{Kind, Motion, MotionKind, Position};
use crate::log::info::Unit;
use crate::machine::ident::{DataId, data};
use crate::state::alarms::STRAIGHT;
use crate::state::frames::polar::{Polar, round_the_centre};
use counterpoint_fault::Acted;

/// Degrees of a circle that one step goes round its own centre.
const STEP: f64 = 2.0;

/// Switches it on: words are coordinates, or radius and angle.
pub(super) fn on(kernel: &mut Kernel<'_>, cartesian: bool) -> Acted {
    if kernel.channel.polar().is_some_and(|polar| polar.cartesian == cartesian) {
        return Ok(());
    }
    let Some((linear, rotary)) = axes(kernel) else {
        let text = format!(
            "channel {} has no linear and rotary axis for polar interpolation of '{}'",
            kernel.channel.at.channel,
            kernel.block_text()
        );
        kernel.diagnose(&diag::NO_POLAR_AXES, text);
        return Ok(());
    };
    kernel.channel.frames().polar = Some(Polar::new(&kernel.channel.state.place, linear, rotary, cartesian));
    kernel.channel.frames_changed();
    super::cutter::plane_changed(kernel);
    kernel.emit(0, Kind::mode(format!("c2p {} on", form(cartesian))));
    Ok(())
}

/// Switches it off; the axes stay where they are.
pub(super) fn off(kernel: &mut Kernel<'_>) -> Acted {
    let Some(polar) = kernel.channel.state.place.frames.as_deref_mut().and_then(|frames| frames.polar.take()) else {
        return Ok(());
    };
    kernel.channel.frames_changed();
    super::cutter::plane_changed(kernel);
    kernel.emit(0, Kind::mode(format!("c2p {} off", form(polar.cartesian))));
    Ok(())
}

fn form(cartesian: bool) -> &'static str {
    if cartesian { "cart" } else { "polar" }
}

/// The axes that the machine names for it, else X and the first rotary axis of the workpiece.
fn axes(kernel: &Kernel<'_>) -> Option<(usize, usize)> {
    let channel =
        kernel.channel.env.machine.channels.iter().find(|channel| channel.number == kernel.channel.at.channel)?;
    let own = |machine: usize| kernel.channel.state.place.axes.iter().position(|axis| axis.machine == machine);
    if let Some([linear, rotary]) = channel.polar {
        return own(linear).zip(own(rotary));
    }
    let tables = [data::AXIS_CT, data::AXIS_CT2, data::AXIS_BT, data::AXIS_AT];
    let rotary = tables.into_iter().find_map(|id| kernel.channel.axis_of_data(id))?;
    Some((usize::from(kernel.channel.state.place.cartesian.first().copied().flatten()?), rotary))
}

/// A circle on the part. Its plane is that of the part, whatever plane is active.
pub(super) fn arc(kernel: &mut Kernel<'_>, polar: Polar, clockwise: bool) -> Acted {
    let (feed, unit) = kernel.feed();
    let (coded, target) = kernel.programmed_targets();
    let radius = kernel.take(data::ARC_RADIUS).map(|d| d.value);
    let offsets = [data::ARC_CENTER_X, data::ARC_CENTER_Y].map(|id| kernel.take(id).map(|d| d.value));
    let turns = kernel.take(data::ARC_TURNS).map_or(0.0, |d| d.value);
    if coded == 0 && radius.is_none() && offsets.iter().all(Option::is_none) {
        return Ok(());
    }
    let (from, programmed) = (kernel.channel.contour(), kernel.channel.programmed());
    let mut to = kernel.channel.work_point(&target);
    // Words that are coordinates tell a circle of the local frame.
    let spots = if polar.cartesian {
        [&programmed, &target].map(|point| kernel.channel.seen(point)).map(|[x, y, _]| [x, y])
    } else {
        [&from, &to].map(|point| polar.part(&kernel.channel.state.place, point))
    };
    let [start, end] = spots;
    let tolerance = if kernel.channel.env.machine.unit == Unit::Inch { 0.01 / 25.4 } else { 0.01 };
    let made = match radius {
        Some(radius) => geometry::by_radius(start, end, radius, clockwise, tolerance),
        None => {
            let [i, j] = offsets.map(|offset| offset.unwrap_or(0.0));
            geometry::by_center(start, end, [start[0] + i, start[1] + j], clockwise)
        }
    };
    let made = match made {
        Ok(made) => made,
        Err(error) => {
            super::arc::not_made(kernel, error);
            return kernel.feed_to(coded, to, feed, unit);
        }
    };
    let off = made.end_error(end);
    if radius.is_none() && off > tolerance {
        let text = format!("the end is {off:.4} off the circle in '{}'", kernel.block_text());
        kernel.diagnose(&diag::ARC_END_OFF, text);
    }
    let local =
        kernel.channel.state.place.frames.as_deref().filter(|_| polar.cartesian).map(|frames| *frames.local.map());
    let level = kernel.channel.seen(&programmed)[2];
    let Some(made) = local.map_or(Some(made), |map| super::turned::on_part(&map, made, level)) else {
        let done = kernel.channel.becomes(&diag::ARC_SCALED, STRAIGHT);
        let text = format!("the frame makes no circle of the part of '{}', {done}", kernel.block_text());
        kernel.diagnose(&diag::ARC_SCALED, text);
        return kernel.feed_to(coded, to, feed, unit);
    };
    let turns = if (0.0..=999.0).contains(&turns) { turns as u16 } else { 0 };
    let made = made.with_turns(turns);
    let spot = polar.part(&kernel.channel.state.place, &to);
    polar.reach(&kernel.channel.state.place, &mut to, spot, way_round(&made));
    kernel.circle_to(&Circle { made, coded, from, to, axes: [polar.linear, polar.rotary], turns, feed, unit })
}

/// Degrees that a circle goes round the centre of the part; every full turn goes as far as the others.
pub(super) fn way_round(made: &geometry::Arc) -> f64 {
    let turns = (made.sweep.abs() / TAU).floor();
    let rest = made.sweep - turns * TAU.copysign(made.sweep);
    let once = if turns > 0.0 { part_round(made, TAU.copysign(made.sweep)) } else { 0.0 };
    turns * once + part_round(made, rest)
}

/// The same for a part of at most one turn from its start, radians.
pub(super) fn part_round(made: &geometry::Arc, sweep: f64) -> f64 {
    let steps = (sweep.abs().to_degrees() / STEP).ceil().clamp(1.0, 360.0 / STEP);
    let point = |at: u32| {
        let angle = made.start_angle + sweep * (f64::from(at) / steps);
        [made.center[0] + made.radius * libm::cos(angle), made.center[1] + made.radius * libm::sin(angle)]
    };
    round_the_centre((0..=steps as u32).map(point))
}

impl Kernel<'_> {
    /// A circle of the part from where the axes stand, which `circle.to` has gone round already.
    #[cold]
    pub(super) fn circle_of_part(&mut self, polar: Polar, circle: &Circle) -> Acted {
        let Circle { made, coded, from, to, feed, unit, .. } = *circle;
        let changes = self.channel.feed_changes(&from, &to);
        let others = changes.iter().enumerate().filter(|(axis, _)| *axis != polar.linear && *axis != polar.rotary);
        let rise = others.map(|(_, change)| change * change).sum::<f64>();
        let length = (made.length() * made.length() + rise).sqrt();
        let path = Path { from: &from, to: &to, length: made.length(), arc: None };
        let seconds = self.feed_seconds(&path, feed, unit)?;
        let seconds = self.at_rates(seconds, &from, &to, Some(&made));
        let moving = self.moving(coded, &self.channel.changes(&from, &to)) | 1 << polar.linear | 1 << polar.rotary;
        let feed = (feed.unwrap_or(0.0), unit);
        self.travel(seconds, &Motion::straight(MotionKind::Linear, moving, [from, to], feed, length))
    }

    /// Takes the word of an axis of the interpolation, in the axis's own unit.
    pub(super) fn take_polar(&mut self, polar: Polar, axis: usize) -> Option<Datum> {
        let (id, scale) = self.channel.state.place.axes.get(axis).map(|axis| (axis.data, axis.scale))?;
        let registers = |id: DataId| self.plan.data.registers_of.get(usize::from(id.0)).copied().unwrap_or(0);
        if polar.cartesian && axis != polar.rotary && registers(id) & registers(data::C2P_INTERP_Y) != 0 {
            // A word across is none of the axis that has its letter.
            return None;
        }
        let own = match (axis == polar.linear, axis == polar.rotary, polar.cartesian) {
            (true, _, true) => Some(data::C2P_INTERP_X),
            (true, _, false) => Some(data::C2P_INTERP_PLRX),
            (_, true, true) => Some(data::C2P_INTERP_Y),
            _ => None,
        };
        // The words of the interpolation are radii.
        let radius = own.and_then(|own| self.take(own)).map(|datum| Datum { value: datum.value / scale, ..datum });
        let spare = axis == polar.rotary && polar.cartesian && self.channel.axis_of_data(data::AXIS_Y).is_none();
        let across = radius.or_else(|| if spare { self.take(data::AXIS_Y) } else { None });
        across.or_else(|| self.take(id))
    }

    /// Length of a feed move on the part, or of its tool path.
    #[inline(always)]
    pub(super) fn feed_path(&self, changes: &Position, feed_length: f64) -> f64 {
        if self.channel.state.place.frames.is_some() && self.channel.polar().is_some() {
            feed_length
        } else {
            self.tool_path(changes)
        }
    }
}
