//! Draws moves as the `d` of one path.
//!
//! Coordinates are hundredths of a pixel, relative to the last point. Points closer than the coarseness are left out,
//! and so are points on a straight line between their neighbours. An omitted point is never further from the drawn path
//! than the coarseness. In long paths, lines over lines are also left out.

use std::f64::consts::{PI, TAU};

use super::canvas::Canvas;
use super::frame::PictureView;
use super::sight::Projection;
use crate::svg::{hundredths, px};
use crate::toolpath::store::Curve;

/// Radii beyond this are drawn as chords: renderers lose precision.
const LARGEST: f64 = 20_000.0;

/// Maximum number of chords of one arc.
const MOST_CHORDS: f64 = 10_000.0;

pub(super) struct Pen {
    d: String,
    coarseness: f64,
    /// Last point in `d`, hundredths.
    written: Option<[i64; 2]>,
    /// Last point of the line so far that counts, px.
    anchor: [f64; 2],
    /// Point not yet written.
    pending: Option<[f64; 2]>,
    /// How far points left out since the anchor may be off the line.
    off: f64,
    /// The last command written is a line.
    lining: bool,
    /// The painted area, for long paths.
    canvas: Option<Canvas>,
    /// Way drawn since the last cut, px.
    way: f64,
    /// Dashed lines over dashed lines would look like a solid line, so only the new parts of a line are drawn.
    dashed: bool,
}

impl Pen {
    /// `long`: the path is so long that lines over lines are left out.
    pub(super) fn new(coarseness: f64, long: bool) -> Self {
        Self {
            d: String::new(),
            coarseness,
            written: None,
            anchor: [0.0; 2],
            pending: None,
            off: 0.0,
            lining: false,
            canvas: long.then(Canvas::new),
            way: 0.0,
            dashed: false,
        }
    }

    /// A pen for dashed lines.
    pub(super) fn dashed(coarseness: f64) -> Self {
        Self { dashed: true, canvas: Some(Canvas::tall()), ..Self::new(coarseness, false) }
    }

    /// Moves follow from here.
    pub(super) fn begin(&mut self, at: [f64; 2]) {
        self.flush();
        self.anchor = at;
        if self.written.is_some_and(|w| w != at.map(px)) {
            self.written = None;
        }
    }

    pub(super) fn line(&mut self, to: [f64; 2]) {
        self.way += distance(self.pending.unwrap_or(self.anchor), to);
        let Some(pending) = self.pending else {
            self.pending = Some(to);
            return;
        };
        let near = distance(self.anchor, pending) < self.coarseness;
        let off = if near { distance(self.anchor, pending) } else { off_line(self.anchor, pending, to) };
        if self.off + off < self.coarseness {
            self.off += if near { 0.0 } else { off };
            self.pending = Some(to);
            return;
        }
        self.write(pending);
        self.pending = Some(to);
    }

    pub(super) fn arc(&mut self, curve: &Curve, from: &[f64; 3], to: &[f64; 3], frame: &PictureView) {
        let radius = curve.radius * frame.scale;
        let plane = curve.plane.map(usize::from);
        let axes = match frame.sight.projection {
            Projection::Along(axes) => axes,
            Projection::Isometric => [usize::MAX; 2],
        };
        let seen = plane == axes || plane == [axes[1], axes[0]];
        if radius * curve.angle.abs() < self.coarseness.max(0.5) {
            return self.line(frame.pixel(to));
        }
        if !seen || radius > LARGEST {
            // A chord is half the coarseness off the circle at most; points on a line with others are left out.
            let turn = (4.0 * self.coarseness / radius.max(1.0)).sqrt().clamp(0.005, 0.4);
            let parts = (curve.angle.abs() / turn).ceil().clamp(1.0, MOST_CHORDS);
            (1..parts as u32).for_each(|n| self.line(frame.pixel(&curve.at(f64::from(n) / parts, from, to))));
            return self.line(frame.pixel(to));
        }
        self.flush();
        self.way += radius * curve.angle.abs();
        if self.painted(curve, from, to, frame) {
            self.anchor = frame.pixel(to);
            return;
        }
        self.move_to_anchor();
        // Seen with the plane's axes to the right and up, clockwise is clockwise on the screen.
        let sweep = ((curve.angle < 0.0) == (plane == axes)) != frame.mirrored;
        let whole = curve.angle.abs();
        let mut shares = Vec::with_capacity(5);
        if whole > TAU + 1e-9 {
            // Further turns lie on the first one.
            shares.extend([PI / whole, TAU / whole]);
        }
        let rest = if whole > TAU + 1e-9 { whole % TAU } else { whole };
        let parts = (rest / (0.95 * PI)).ceil().max(1.0);
        shares.extend((1..=parts as u32).map(|n| 1.0 - rest / whole * (1.0 - f64::from(n) / parts)));
        for share in shares {
            let end = if share > 1.0 - 1e-12 { *to } else { curve.at(share, from, to) };
            self.write_arc(radius, sweep, frame.pixel(&end));
        }
    }

    /// Paints the arc at four places; `true` when all were painted already.
    fn painted(&mut self, curve: &Curve, from: &[f64; 3], to: &[f64; 3], frame: &PictureView) -> bool {
        let Some(canvas) = &mut self.canvas else { return false };
        let mut fresh = false;
        for n in 1..5 {
            fresh |= canvas.paint(frame.pixel(&curve.at(f64::from(n) / 5.0, from, to)));
        }
        !fresh
    }

    fn write_arc(&mut self, radius: f64, sweep: bool, to: [f64; 2]) {
        let end = to.map(px);
        let Some(start) = self.written else { return };
        self.d.push('a');
        hundredths(&mut self.d, px(radius), true);
        hundredths(&mut self.d, px(radius), false);
        self.d.push_str(if sweep { " 0 0 1" } else { " 0 0 0" });
        hundredths(&mut self.d, end[0] - start[0], false);
        hundredths(&mut self.d, end[1] - start[1], false);
        (self.written, self.anchor, self.lining) = (Some(end), to, false);
    }

    fn move_to_anchor(&mut self) {
        let at = self.anchor.map(px);
        if self.written != Some(at) {
            self.d.push('M');
            hundredths(&mut self.d, at[0], true);
            hundredths(&mut self.d, at[1], false);
            (self.written, self.lining) = (Some(at), false);
        }
    }

    fn write(&mut self, to: [f64; 2]) {
        let from = self.anchor;
        if let Some(canvas) = self.canvas.as_mut().filter(|_| self.dashed) {
            for [start, end] in canvas.parts(from, to) {
                let at = |share: f64| [from[0] + (to[0] - from[0]) * share, from[1] + (to[1] - from[1]) * share];
                self.anchor = at(start);
                self.draw(at(end));
            }
            (self.anchor, self.off) = (to, 0.0);
            return;
        }
        if self.canvas.as_mut().is_some_and(|canvas| !canvas.line(from, to)) {
            (self.anchor, self.off) = (to, 0.0);
            return;
        }
        self.draw(to);
    }

    /// Draws a line from the anchor.
    fn draw(&mut self, to: [f64; 2]) {
        self.move_to_anchor();
        let end = to.map(px);
        if let Some(start) = self.written.filter(|s| *s != end) {
            if !self.lining {
                self.d.push('l');
            }
            hundredths(&mut self.d, end[0] - start[0], !self.lining);
            hundredths(&mut self.d, end[1] - start[1], false);
            (self.written, self.lining) = (Some(end), true);
        }
        (self.anchor, self.off) = (to, 0.0);
    }

    /// Writes the point not yet written, if it is far enough to be seen.
    fn flush(&mut self) {
        if let Some(pending) = self.pending.take() {
            if distance(self.anchor, pending) >= self.coarseness / 2.0 {
                self.write(pending);
            } else {
                self.anchor = pending;
            }
        }
        self.off = 0.0;
    }

    /// Way since the last cut, px.
    pub(super) fn way(&self) -> f64 {
        self.way
    }

    /// Returns the drawing so far; moves continue after [`begin`](Self::begin).
    pub(super) fn cut(&mut self) -> String {
        self.flush();
        (self.written, self.lining, self.way) = (None, false, 0.0);
        std::mem::take(&mut self.d)
    }
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    let way = [a[0] - b[0], a[1] - b[1]];
    (way[0] * way[0] + way[1] * way[1]).sqrt()
}

/// How far a point is from the path from `a` to `b`; infinite when the path turns back at it, also to where it came
/// from.
fn off_line(a: [f64; 2], point: [f64; 2], b: [f64; 2]) -> f64 {
    let (way, to) = ([b[0] - a[0], b[1] - a[1]], [point[0] - a[0], point[1] - a[1]]);
    let length = (way[0] * way[0] + way[1] * way[1]).sqrt();
    let along = way[0] * to[0] + way[1] * to[1];
    if length == 0.0 || along < 0.0 || along > length * length {
        return f64::INFINITY;
    }
    (way[0] * to[1] - way[1] * to[0]).abs() / length
}
