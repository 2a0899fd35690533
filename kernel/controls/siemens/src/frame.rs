//! Frames: translation, fine translation, rotation, scale and mirror of X, Y and Z, and chains of them.
//!
//! Facts: the control's frame operators CTRANS, CFINE, CROT, CSCALE, CMIRROR and the chain `:`, whose left side acts
//! outside of its right side. A frame is given as translation, then rotations about Z, the turned Y and the turned X,
//! then scale and mirror. Invariant: all numbers are finite.

use super::beside::AxisFrames;
use super::frame_component::FrameComponent;
use counterpoint_control_api::numeric::is_multiple;

/// Places of X, Y and Z.
pub(super) const SPACE: usize = 3;

/// Largest number of a frame.
const BOUND: f64 = 1e12;
/// Values below this count as zero.
const NOTHING: f64 = 1e-9;

/// A frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SiemensFrame {
    linear: [[f64; 3]; 3],
    shift: [f64; 3],
    fine: [f64; 3],
    mirrored: [bool; 3],
    beside: AxisFrames,
}

/// The parts of a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FrameComponents {
    pub(super) shift: [f64; 3],
    pub(super) fine: [f64; 3],
    /// About X, Y, Z; Z turns first.
    pub(super) angles: [f64; 3],
    pub(super) scale: [f64; 3],
    pub(super) mirror: [bool; 3],
    /// Along other axes.
    pub(super) beside: AxisFrames,
}

impl Default for SiemensFrame {
    fn default() -> Self {
        Self {
            linear: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            shift: [0.0; 3],
            fine: [0.0; 3],
            mirrored: [false; 3],
            beside: AxisFrames::default(),
        }
    }
}

impl Default for FrameComponents {
    fn default() -> Self {
        Self {
            shift: [0.0; 3],
            fine: [0.0; 3],
            angles: [0.0; 3],
            scale: [1.0; 3],
            mirror: [false; 3],
            beside: AxisFrames::default(),
        }
    }
}

/// Sine and cosine of degrees, exact at multiples of 90.
pub(super) fn turn(degrees: f64) -> (f64, f64) {
    (sine(degrees), cosine(degrees))
}

/// Sine of degrees, exact at multiples of 90.
pub(super) fn sine(degrees: f64) -> f64 {
    if is_multiple(degrees, 90.0) { exact(degrees).0 } else { libm::sin(degrees.to_radians()) }
}

/// Cosine of degrees, exact at multiples of 90.
pub(super) fn cosine(degrees: f64) -> f64 {
    if is_multiple(degrees, 90.0) { exact(degrees).1 } else { libm::cos(degrees.to_radians()) }
}

/// Sine and cosine of a multiple of 90 degrees.
fn exact(degrees: f64) -> (f64, f64) {
    match degrees.rem_euclid(360.0) {
        0.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        _ => (-1.0, 0.0),
    }
}

fn product(a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let column = |at: usize| b.map(|row| row.get(at).copied().unwrap_or(0.0));
    let dot = |row: &[f64; 3], column: [f64; 3]| row.iter().zip(column).map(|(x, y)| x * y).sum();
    a.map(|row| [dot(&row, column(0)), dot(&row, column(1)), dot(&row, column(2))])
}

fn apply(a: &[[f64; 3]; 3], point: [f64; 3]) -> [f64; 3] {
    a.map(|row| row.iter().zip(point).map(|(x, y)| x * y).sum())
}

fn about(axis: usize, degrees: f64) -> [[f64; 3]; 3] {
    let (s, c) = turn(degrees);
    match axis {
        0 => [[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]],
        1 => [[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]],
        _ => [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]],
    }
}

impl FrameComponents {
    /// The frame that they make; none if it is out of all bounds.
    pub(super) fn frame(&self) -> Option<SiemensFrame> {
        let [x, y, z] = self.angles;
        let mut linear = product(&product(&about(2, z), &about(1, y)), &about(0, x));
        for row in &mut linear {
            for ((slot, scale), mirror) in row.iter_mut().zip(self.scale).zip(self.mirror) {
                *slot *= if mirror { -scale } else { scale };
            }
        }
        SiemensFrame { linear, shift: self.shift, fine: self.fine, mirrored: self.mirror, beside: self.beside }
            .checked()
    }

    /// Number of a part along an axis: 0 to 2 are X, Y and Z, from 3 on the axes of the channel follow.
    pub(super) fn get(&self, axis: usize, part: FrameComponent) -> f64 {
        if let Some(other) = axis.checked_sub(SPACE) {
            return self.beside.get(other, part);
        }
        let of = |numbers: [f64; 3]| numbers.get(axis).copied().unwrap_or(0.0);
        match part {
            FrameComponent::Translation => of(self.shift),
            FrameComponent::Fine => of(self.fine),
            FrameComponent::Rotation => of(self.angles),
            FrameComponent::Scale => of(self.scale),
            FrameComponent::Mirror => of(self.mirror.map(|on| f64::from(u8::from(on)))),
        }
    }

    /// Sets a part along an axis.
    pub(super) fn set(&mut self, axis: usize, part: FrameComponent, value: f64) {
        if let Some(other) = axis.checked_sub(SPACE) {
            return self.beside.set(other, part, value);
        }
        let numbers = match part {
            FrameComponent::Translation => &mut self.shift,
            FrameComponent::Fine => &mut self.fine,
            FrameComponent::Rotation => &mut self.angles,
            FrameComponent::Scale => &mut self.scale,
            FrameComponent::Mirror => {
                if let Some(slot) = self.mirror.get_mut(axis) {
                    *slot = value != 0.0;
                }
                return;
            }
        };
        if let Some(slot) = numbers.get_mut(axis) {
            *slot = value;
        }
    }
}

impl SiemensFrame {
    fn checked(self) -> Option<Self> {
        let sound = |value: &f64| value.abs() <= BOUND;
        let all = self.linear.iter().flatten().chain(&self.shift).chain(&self.fine);
        let volume = self.volume().abs();
        (all.into_iter().all(sound) && volume > 1e-12 && self.beside.is_sound()).then_some(self)
    }

    fn volume(&self) -> f64 {
        let [[a, b, c], [d, e, f], [g, h, i]] = self.linear;
        a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    }

    /// `self : inner`; none if it is out of all bounds.
    pub(super) fn chain(&self, inner: &Self) -> Option<Self> {
        let outer = [self.shift, self.fine];
        let [shift, fine] = outer;
        let moved = apply(&self.linear, inner.shift);
        let moved_fine = apply(&self.linear, inner.fine);
        let sum = |a: [f64; 3], b: [f64; 3]| {
            let mut sum = a;
            for (slot, by) in sum.iter_mut().zip(b) {
                *slot += by;
            }
            sum
        };
        let mut mirrored = self.mirrored;
        for (slot, other) in mirrored.iter_mut().zip(inner.mirrored) {
            *slot ^= other;
        }
        let linear = product(&self.linear, &inner.linear);
        let beside = self.beside.after(&inner.beside);
        Self { linear, shift: sum(shift, moved), fine: sum(fine, moved_fine), mirrored, beside }.checked()
    }

    /// Its parts; none for a frame that is not a rotation of a scaled and mirrored one.
    pub(super) fn parts(&self) -> Option<FrameComponents> {
        let column = |at: usize| self.linear.map(|row| row.get(at).copied().unwrap_or(0.0));
        let columns = [column(0), column(1), column(2)];
        let length = |column: [f64; 3]| column.iter().map(|part| part * part).sum::<f64>().sqrt();
        let dot = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        let scale = columns.map(length);
        let [a, b, c] = columns;
        let [la, lb, lc] = scale;
        let skew = [dot(a, b) / (la * lb), dot(b, c) / (lb * lc), dot(c, a) / (lc * la)];
        if !skew.iter().all(|part| part.abs() < NOTHING) {
            return None;
        }
        let mut mirror = self.mirrored;
        let odd = mirror.iter().filter(|on| **on).count() % 2 == 1;
        if odd != (self.volume() < 0.0)
            && let Some(first) = mirror.first_mut()
        {
            // A matrix that came from elsewhere does not tell its axis.
            *first = !*first;
        }
        let mut turned = self.linear;
        for row in &mut turned {
            for ((slot, scale), mirror) in row.iter_mut().zip(scale).zip(mirror) {
                *slot /= if mirror { -scale } else { scale };
            }
        }
        let [[r00, r01, _], [r10, r11, _], [r20, r21, r22]] = turned;
        let degrees = |y: f64, x: f64| clean(libm::atan2(y, x).to_degrees());
        let angles = if r20.abs() > 1.0 - 1e-12 {
            // The turned Y is along Z: all of the rest is a rotation about Z.
            [0.0, if r20 < 0.0 { 90.0 } else { -90.0 }, degrees(-r01, r11)]
        } else {
            [degrees(r21, r22), degrees(-r20, libm::sqrt(r21 * r21 + r22 * r22)), degrees(r10, r00)]
        };
        Some(FrameComponents {
            shift: self.shift.map(clean),
            fine: self.fine.map(clean),
            angles,
            scale: scale.map(clean),
            mirror,
            beside: self.beside,
        })
    }

    /// The same frame with other parts along axes beside X, Y and Z.
    pub(super) fn with_beside(self, beside: AxisFrames) -> Self {
        Self { beside, ..self }
    }

    /// Three rows of the linear part with the whole translation.
    pub(super) fn numbers(&self) -> [f64; 12] {
        let mut numbers = [0.0; 12];
        let shift = self.shift.iter().zip(self.fine).map(|(shift, fine)| shift + fine);
        let rows = self.linear.iter().zip(shift).flat_map(|([a, b, c], d)| [*a, *b, *c, d]);
        for (slot, number) in numbers.iter_mut().zip(rows) {
            *slot = number;
        }
        numbers
    }

    /// The frame of such numbers.
    pub(super) fn from_numbers(numbers: &[f64]) -> Option<Self> {
        let [a, b, c, x, d, e, f, y, g, h, i, z] = <[f64; 12]>::try_from(numbers).ok()?;
        let linear = [[a, b, c], [d, e, f], [g, h, i]];
        Self { linear, shift: [x, y, z], ..Self::default() }.checked()
    }

    /// Three rows of the linear part.
    pub(super) fn linear(&self) -> [f64; 9] {
        let [[a, b, c], [d, e, f], [g, h, i]] = self.linear;
        [a, b, c, d, e, f, g, h, i]
    }

    /// A frame that turns only.
    pub(super) fn turned([a, b, c, d, e, f, g, h, i]: [f64; 9]) -> Option<Self> {
        Self { linear: [[a, b, c], [d, e, f], [g, h, i]], ..Self::default() }.checked()
    }

    /// For messages.
    pub(super) fn text(&self) -> String {
        self.numbers().map(super::number_text::shown).join(",")
    }
}

/// The value without rounding residue.
fn clean(value: f64) -> f64 {
    let near = (value * 1e9).round() / 1e9;
    if near.is_finite() && (near - value).abs() < 1e-9 { near + 0.0 } else { value }
}
