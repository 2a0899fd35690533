//! Circular moves: centre by I J K from the start point, or radius R.
//!
//! Facts: reference control-emulator.md 6.1 (arc rules): centre offsets are radii even on a diameter axis; a block
//! with only a centre is a full circle; end-point tolerance 0.01 mm.

use counterpoint_motion::arc as geometry;

use super::cutter::{Shape, Step};
use super::time::Path;
use super::turned;
use crate::channel::state::{group, plane};
use crate::channel::{Acted, Kernel};
use crate::diag;
use crate::log::event::{FeedUnit, Motion, MotionKind, Position};
use crate::log::info::Unit;
use crate::machine::ident::data;

/// An arc in the active plane, helical when the third axis is coded.
pub(super) fn arc(kernel: &mut Kernel<'_>, clockwise: bool) -> Acted {
    if let Some(polar) = kernel.polar() {
        return super::polar::arc(kernel, polar, clockwise);
    }
    let (feed, unit) = kernel.feed();
    let (coded, target) = kernel.programmed_targets();
    let plane_code = kernel.modal.code(group::PLANE);
    let axes = plane_code.and_then(plane).and_then(|p| {
        let index = |role: usize| kernel.place.cartesian.get(role).copied().flatten().map(usize::from);
        Some((p, index(p.first)?, index(p.second)?))
    });
    let radius = kernel.take(data::ARC_RADIUS).map(|d| d.value);
    let Some((plane, first, second)) = axes else {
        for id in [data::ARC_CENTER_X, data::ARC_CENTER_Y, data::ARC_CENTER_Z] {
            kernel.take(id);
        }
        let text =
            format!("no plane with both axes in channel {} is active for '{}'", kernel.rank, kernel.block_text());
        kernel.diagnose(&diag::ARC_PLANE, text);
        return Ok(());
    };
    let offsets = plane.centers.map(|id| kernel.take(id).map(|d| d.value));
    let turns = kernel.take(data::ARC_TURNS).map_or(0.0, |d| d.value);
    let has_center = offsets.iter().any(Option::is_some);
    if coded == 0 && radius.is_none() && !has_center {
        return Ok(());
    }
    let from = kernel.programmed();
    let scales = [first, second].map(|axis| kernel.place.axes.get(axis).map_or(1.0, |a| a.scale));
    let in_plane = |p: &[f64]| {
        let at = |axis: usize, scale: f64| p.get(axis).copied().unwrap_or(0.0) * scale;
        [at(first, scales[0]), at(second, scales[1])]
    };
    let (start, end) = (in_plane(&from), in_plane(&target));
    let tolerance = match kernel.machine.unit {
        Unit::Mm => 0.01,
        Unit::Inch => 0.01 / 25.4,
    };
    let made = match radius {
        Some(radius) => geometry::by_radius(start, end, radius, clockwise, tolerance),
        None => {
            let [i, j] = offsets.map(|o| o.unwrap_or(0.0));
            geometry::by_center(start, end, [start[0] + i, start[1] + j], clockwise)
        }
    };
    let made = match made {
        Ok(made) => made,
        Err(error) => {
            let text =
                format!("the circle cannot be made: {error} in '{}', the end is reached straight", kernel.block_text());
            kernel.diagnose(&diag::ARC_RADIUS, text);
            return kernel.feed_to_point(coded, target, feed, unit);
        }
    };
    let off = made.end_error(end);
    if radius.is_none() && off > tolerance {
        let text = format!("the end is {off:.4} off the circle in '{}'", kernel.block_text());
        kernel.diagnose(&diag::ARC_END_OFF, text);
    }
    let turns = if (0.0..=999.0).contains(&turns) { turns as u16 } else { 0 };
    let made = made.with_turns(turns);
    let circle = Circle { made, coded, from, to: target, axes: [first, second], turns, feed, unit };
    if kernel.place.frames.is_some() { turned::circle(kernel, plane, &circle) } else { kernel.circle_to(&circle) }
}

/// A circle to be made, in the frame of its points.
#[derive(Debug, Clone, Copy)]
pub(super) struct Circle {
    /// Geometry, with full turns.
    pub(super) made: geometry::Arc,
    pub(super) coded: u8,
    pub(super) from: Position,
    pub(super) to: Position,
    /// Channel axes of its plane.
    pub(super) axes: [usize; 2],
    pub(super) turns: u16,
    pub(super) feed: Option<f64>,
    pub(super) unit: FeedUnit,
}

impl Kernel<'_> {
    /// A circle in the work frame.
    #[inline(always)]
    pub(super) fn circle_to(&mut self, circle: &Circle) -> Acted {
        if self.is_compensated() {
            let Circle { made, axes, turns, coded, to, feed, unit, .. } = *circle;
            return self.compensate(Step { shape: Shape::Circle { made, axes, turns }, coded, to, feed, unit });
        }
        let Circle { made, coded, from, to, axes: [first, second], turns, feed, unit } = *circle;
        let changes = self.changes(&from, &to);
        let rise = changes
            .iter()
            .enumerate()
            .filter(|&(i, _)| i != first && i != second && self.place.axes.get(i).is_some_and(|a| !a.rotary))
            .map(|(_, c)| c * c)
            .sum::<f64>();
        let length = (made.length() * made.length() + rise).sqrt();
        let x = self.place.cartesian.first().copied().flatten().map(usize::from);
        let radial = [first, second].iter().position(|&axis| Some(axis) == x);
        let scale = |axis: usize| self.place.axes.get(axis).map_or(1.0, |a| a.scale);
        let center = [made.center[0] / scale(first), made.center[1] / scale(second)];
        let path = Path { from: &from, to: &to, length: made.length(), arc: Some((&made, radial)) };
        let seconds = self.feed_seconds(&path, feed, unit)?;
        let moving = self.moving(coded, &changes) | 1 << first | 1 << second;
        self.travel(
            seconds,
            &Motion {
                kind: if made.sweep < 0.0 { MotionKind::ArcCw } else { MotionKind::ArcCcw },
                moving,
                from,
                to,
                center,
                plane_axes: [first as u8, second as u8],
                turns,
                feed: feed.unwrap_or(0.0),
                feed_unit: unit,
                length,
            },
        )
    }
}
