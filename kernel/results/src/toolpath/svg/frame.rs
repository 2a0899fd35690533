//! One view: its place in the picture, its border, scales and axis cross.

use std::f64::consts::FRAC_PI_2;
use std::fmt::Write as _;

use super::sight::{Projection, Sight};
use super::{INK, LEFT, RIGHT, SOFT};
use crate::svg::{round_step, text};
use crate::toolpath::store::{Curve, RecordedPath, Stroke};

/// Visible extent by coordinate; for a view, to the right and up.
#[derive(Debug, Clone, Copy)]
pub(super) struct PictureBounds {
    low: [f64; 3],
    high: [f64; 3],
}

impl PictureBounds {
    /// Extent of the cutting moves, or of all moves when nothing cuts, with a margin; each path with whether it is seen
    /// below the turning axis.
    pub(super) fn of<'a>(paths: impl Iterator<Item = (&'a RecordedPath, bool)> + Clone) -> Self {
        let none = Self { low: [f64::INFINITY; 3], high: [f64::NEG_INFINITY; 3] };
        let (mut cutting, mut all) = (none, Self { low: [f64::INFINITY; 3], high: [f64::NEG_INFINITY; 3] });
        for (path, mirrored) in paths {
            let mut from = [0.0; 3];
            for step in &path.moves {
                let to = seen(step.to(), mirrored);
                all.add(&to);
                if matches!(step.stroke(), Stroke::Feed | Stroke::Thread) {
                    cutting.add(&from);
                    cutting.add(&to);
                    if let Some(curve) = path.curve(step) {
                        cutting.add_curve(curve, mirrored);
                    }
                }
                from = to;
            }
        }
        let mut bounds = if cutting.low[0] <= cutting.high[0] { cutting } else { all };
        if bounds.low[0] > bounds.high[0] {
            bounds = Self { low: [0.0; 3], high: [0.0; 3] };
        }
        let largest = bounds.low.iter().zip(&bounds.high).map(|(l, h)| h - l).fold(0.0, f64::max);
        let margin = if largest > 0.0 { largest * 0.05 } else { 1.0 };
        bounds.low.iter_mut().for_each(|v| *v -= margin);
        bounds.high.iter_mut().for_each(|v| *v += margin);
        bounds
    }

    /// The extent in a view: that of its corners.
    pub(super) fn seen_by(&self, sight: Sight) -> Self {
        let mut seen = Self { low: [f64::INFINITY; 3], high: [f64::NEG_INFINITY; 3] };
        for corner in 0..8_usize {
            let side = |axis: usize| if corner >> axis & 1 == 0 { self.at(axis).0 } else { self.at(axis).1 };
            let [right, up] = sight.projection.of([side(0), side(1), side(2)]);
            seen.add(&[right, up, 0.0]);
        }
        seen
    }

    fn add(&mut self, point: &[f64; 3]) {
        for ((low, high), value) in self.low.iter_mut().zip(&mut self.high).zip(point) {
            (*low, *high) = (low.min(*value), high.max(*value));
        }
    }

    /// Quarter points that the arc passes.
    fn add_curve(&mut self, curve: &Curve, mirrored: bool) {
        let (low, high) = if curve.angle < 0.0 {
            (curve.start + curve.angle, curve.start)
        } else {
            (curve.start, curve.start + curve.angle)
        };
        let first = (low / FRAC_PI_2).ceil();
        for quarter in (0..4).map(|n| first + f64::from(n)).take_while(|q| q * FRAC_PI_2 <= high) {
            // Quarters 0 and 2 are on the first axis of the plane, 1 and 3 on the second.
            let side = quarter.rem_euclid(2.0) as usize;
            let offset = if quarter.rem_euclid(4.0) < 2.0 { curve.radius } else { -curve.radius };
            let (Some(axis), Some(center)) = (curve.plane.get(side), curve.center.get(side)) else { continue };
            let axis = usize::from(*axis);
            let value = if mirrored && axis == 1 { -center - offset } else { center + offset };
            if let (Some(low), Some(high)) = (self.low.get_mut(axis), self.high.get_mut(axis)) {
                (*low, *high) = (low.min(value), high.max(value));
            }
        }
    }

    /// Least and greatest value of a coordinate.
    fn at(&self, coordinate: usize) -> (f64, f64) {
        (self.low.get(coordinate).copied().unwrap_or(0.0), self.high.get(coordinate).copied().unwrap_or(1.0))
    }

    pub(super) fn span(&self, coordinate: usize) -> f64 {
        let (low, high) = self.at(coordinate);
        high - low
    }
}

/// A point as it is seen: of a channel below the turning axis the radius counts downwards.
fn seen(point: [f64; 3], mirrored: bool) -> [f64; 3] {
    if mirrored { [point[0], -point[1], point[2]] } else { point }
}

/// A view in the picture.
#[derive(Debug, Clone)]
pub(super) struct PictureView {
    pub(super) sight: Sight,
    /// Pixels per unit.
    pub(super) scale: f64,
    /// Points are those of a channel below the turning axis.
    pub(super) mirrored: bool,
    low: [f64; 2],
    high: [f64; 2],
    left: f64,
    right: f64,
    top: f64,
    pub(super) bottom: f64,
}

impl PictureView {
    pub(super) fn new(sight: Sight, bounds: &PictureBounds, scale: f64, top: f64) -> Self {
        let ((low, high), (under, over)) = (bounds.at(0), bounds.at(1));
        // Sideways the view takes the whole width, its content in the middle.
        let spare = ((RIGHT - LEFT) / scale - (high - low)).max(0.0) / 2.0;
        let bottom = top + (over - under) * scale;
        let (low, high) = ([low - spare, under], [high + spare, over]);
        Self { sight, scale, mirrored: false, low, high, left: LEFT, right: RIGHT, top, bottom }
    }

    /// The view of a channel, which may be below the turning axis.
    pub(super) fn of(&self, mirrored: bool) -> Self {
        Self { mirrored, ..self.clone() }
    }

    /// Pixel of a point.
    pub(super) fn pixel(&self, point: &[f64; 3]) -> [f64; 2] {
        let point = seen(*point, self.mirrored);
        let [right, up] = self.sight.projection.of(point);
        [self.x(right), self.y(up)]
    }

    /// Pixel of a point, or the nearest one that is in the view with so much room around it.
    pub(super) fn pixel_inside(&self, point: &[f64; 3], room: f64) -> [f64; 2] {
        let [x, y] = self.pixel(point);
        let within = |value: f64, low: f64, high: f64| value.max(low + room).min(high - room);
        [within(x, self.left, self.right), within(y, self.top, self.bottom)]
    }

    /// A place in the right half of the view.
    pub(super) fn is_right_half(&self, x: f64) -> bool {
        x > f64::midpoint(self.left, self.right)
    }

    fn x(&self, value: f64) -> f64 {
        self.left + (value - self.low[0]) * self.scale
    }

    fn y(&self, value: f64) -> f64 {
        self.bottom - (value - self.low[1]) * self.scale
    }

    /// The view with its scales around the paths; values are shown in a unit, `shown` of them for one of the machine.
    pub(super) fn draw(&self, out: &mut String, index: usize, (unit, shown): (&str, f64), paths: &str) {
        let (left, right, top, bottom) = (self.left, self.right, self.top, self.bottom);
        let (width, height) = (right - left, bottom - top);
        let border = format!(r#"<rect x="{left:.1}" y="{top:.1}" width="{width:.1}" height="{height:.1}""#);
        let _ = writeln!(out, r#"<clipPath id="view{index}">{border}/></clipPath>"#);
        let mut labels = String::new();
        if self.sight.has_scales() {
            let grid = self.grid(&mut labels, shown);
            let _ = writeln!(out, r##"<path fill="none" stroke="#e6eaee" d="{grid}"/>"##);
            self.cross(out);
            let up = self.sight.upwards;
            text(&mut labels, (right, bottom + 34.0), 12, "end", INK, &format!("{} / {unit}", self.sight.across));
            text(&mut labels, (left, top - 6.0), 12, "start", INK, &format!("{} / {unit}{}", up.name, up.note()));
        } else {
            self.axes_in_space(&mut labels);
        }
        let _ = writeln!(out, r##"{border} fill="none" stroke="#b6c0ca"/>"##);
        let _ = writeln!(out, r#"<g clip-path="url(#view{index})" fill="none" stroke-linejoin="round">"#);
        out.push_str(paths);
        out.push_str("</g>\n");
        out.push_str(&labels);
    }

    /// Lines at round values, which become labels.
    fn grid(&self, labels: &mut String, shown: f64) -> String {
        let (left, right, top, bottom) = (self.left, self.right, self.top, self.bottom);
        let places = |step: f64| (-step.log10().floor()).clamp(0.0, 6.0) as usize;
        let step = round_step(64.0 / self.scale * shown, 1.0);
        let decimals = places(step);
        let mut grid = String::new();
        for value in ticks(self.low[0] * shown, self.high[0] * shown, step) {
            let x = self.x(value / shown);
            let _ = write!(grid, "M{x:.1} {top:.1}V{:.1}", bottom + 4.0);
            text(labels, (x, bottom + 18.0), 11, "middle", SOFT, &format!("{value:.decimals$}"));
        }
        let up = self.sight.upwards;
        let factor = up.factor * shown;
        let step = round_step(28.0 / self.scale * factor, 1.0);
        let decimals = places(step);
        for value in ticks(self.low[1] * factor, self.high[1] * factor, step) {
            let y = self.y(value / factor);
            let value = if up.both_ways { value.abs() } else { value };
            let _ = write!(grid, "M{:.1} {y:.1}H{right:.1}", left - 4.0);
            text(labels, (left - 7.0, y + 4.0), 11, "end", SOFT, &format!("{value:.decimals$}"));
        }
        grid
    }

    /// The directions of X, Y and Z in a corner of a view in space.
    fn axes_in_space(&self, out: &mut String) {
        let origin = [self.left + 44.0, self.bottom - 24.0];
        for (name, axis) in [("X", [1.0, 0.0, 0.0]), ("Y", [0.0, 1.0, 0.0]), ("Z", [0.0, 0.0, 1.0])] {
            let [right, up] = Projection::Isometric.of(axis).map(|part| part * 30.0);
            let (x, y) = (origin[0] + right, origin[1] - up);
            let _ = writeln!(out, r#"<path stroke="{SOFT}" d="M{:.1} {:.1}L{x:.1} {y:.1}"/>"#, origin[0], origin[1]);
            text(out, (x + right * 0.25, y - up * 0.25 + 4.0), 11, "middle", SOFT, name);
        }
    }

    /// The axes through zero, as far as they are in view.
    fn cross(&self, out: &mut String) {
        let (x, y) = (self.x(0.0), self.y(0.0));
        let mut d = String::new();
        if x >= self.left && x <= self.right {
            let _ = write!(d, "M{x:.1} {:.1}V{:.1}", self.top, self.bottom);
        }
        if y >= self.top && y <= self.bottom {
            let _ = write!(d, "M{:.1} {y:.1}H{:.1}", self.left, self.right);
        }
        if !d.is_empty() {
            let _ = writeln!(out, r##"<path fill="none" stroke="#7b8794" stroke-dasharray="14 3 3 3" d="{d}"/>"##);
        }
    }
}

/// Multiples of a step in a range, 200 at most.
fn ticks(low: f64, high: f64, step: f64) -> impl Iterator<Item = f64> {
    let first = (low / step).ceil();
    // Adding zero keeps minus zero out of the texts.
    (0..200_u32).map(move |n| (first + f64::from(n)) * step + 0.0).take_while(move |value| *value <= high)
}
