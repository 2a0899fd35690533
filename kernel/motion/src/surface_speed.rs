//! Time of a cut under constant surface speed, integrated along the radius.
//!
//! `n(r) = clamp(v / (2π·|r|), n_min, n_max)`; the time is the integral of `ds / (f · n)` (reference
//! channel-synchronisation.md 3). Both integrals are exact: pieces between the clamp radii are closed forms.

use crate::arc::PlaneArc;
use std::f64::consts::TAU;

/// Spindle under constant surface speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceSpeed {
    /// Surface speed in length units per minute (m/min · 1000 for mm).
    pub surface: f64,
    /// Largest rev/min, may be infinite.
    pub max: f64,
    /// Smallest rev/min, may be 0.
    pub min: f64,
}

impl SurfaceSpeed {
    /// Revolutions per minute at radius `r`.
    #[must_use]
    pub fn rpm(&self, r: f64) -> f64 {
        (self.surface / (TAU * r.abs())).min(self.max).max(self.min)
    }

    /// Minutes per revolution at radius `r`.
    #[must_use]
    pub fn per_rev(&self, r: f64) -> f64 {
        1.0 / self.rpm(r)
    }

    /// Radii where the clamps begin: `(largest speed, smallest speed)`.
    fn clamps(&self) -> [f64; 2] {
        let at = |n: f64| if n > 0.0 && n.is_finite() { self.surface / (TAU * n) } else { f64::INFINITY };
        let inner = if self.max.is_finite() { at(self.max) } else { 0.0 };
        [inner, at(self.min)]
    }

    /// Shares of a straight cut from radius `r0` to `r1` between which the minutes per revolution change evenly:
    /// ascending, from 0 to 1.
    #[must_use]
    pub fn line_cuts(&self, r0: f64, r1: f64) -> [f64; 7] {
        let [inner, outer] = self.clamps();
        let mut cuts = [0.0_f64, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0];
        for (cut, r) in cuts.iter_mut().skip(1).zip([0.0, inner, -inner, outer, -outer]) {
            let s = (r - r0) / (r1 - r0);
            *cut = if s > 0.0 && s < 1.0 { s } else { 1.0 };
        }
        cuts.sort_by(f64::total_cmp);
        cuts
    }

    /// Minutes for a straight cut of `length` at `feed` per revolution while the radius goes from `r0` to `r1`.
    #[must_use]
    pub fn line_minutes(&self, r0: f64, r1: f64, length: f64, feed: f64) -> f64 {
        let change = r1 - r0;
        if change.abs() < 1e-12 {
            return length / feed * self.per_rev(r0);
        }
        let cuts = self.line_cuts(r0, r1);
        // Between cuts 1/n is linear in the path, so the trapezoid rule is exact.
        let sum: f64 = cuts
            .windows(2)
            .map(|w| match w {
                [a, b] if b > a => (b - a) * (self.per_rev(r0 + change * a) + self.per_rev(r0 + change * b)) / 2.0,
                _ => 0.0,
            })
            .sum();
        sum * length / feed
    }

    /// Minutes for an arc at `feed` per revolution. `radial`: the plane coordinate that is the radius (0 or 1).
    #[must_use]
    pub fn arc_minutes(&self, arc: &PlaneArc, radial: usize, feed: f64) -> f64 {
        let offset = arc.center.get(radial).copied().unwrap_or(0.0);
        // r(θ) = offset + R·cos(θ − phase)
        let phase = if radial == 0 { 0.0 } else { TAU / 4.0 };
        let start = arc.start_angle - phase;
        let (from, to) = if arc.sweep >= 0.0 { (start, start + arc.sweep) } else { (start + arc.sweep, start) };
        let [inner, outer] = self.clamps();
        let mut cuts = vec![from, to];
        for r in [0.0, inner, -inner, outer, -outer] {
            let cosine = (r - offset) / arc.radius;
            if cosine.abs() < 1.0 {
                let angle = libm::acos(cosine);
                for base in [angle, -angle] {
                    let mut at = base + TAU * ((from - base) / TAU).ceil();
                    while at < to {
                        cuts.push(at);
                        at += TAU;
                    }
                }
            }
        }
        cuts.sort_by(f64::total_cmp);
        let radius_at = |theta: f64| offset + arc.radius * libm::cos(theta);
        let integral = |a: f64, b: f64| offset * (b - a) + arc.radius * (libm::sin(b) - libm::sin(a));
        let sum: f64 = cuts
            .windows(2)
            .map(|w| match *w {
                [a, b] if b > a => {
                    let middle = radius_at(f64::midpoint(a, b)).abs();
                    if middle <= inner {
                        (b - a) / self.max
                    } else if middle >= outer {
                        (b - a) / self.min
                    } else {
                        integral(a, b).abs() * TAU / self.surface
                    }
                }
                _ => 0.0,
            })
            .sum();
        sum * arc.radius / feed
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arc;

    #[test]
    fn facing_check_value_of_the_reference() {
        // Vc 200 m/min, 0.2 mm/rev, D50 → 0, n_max 3000: 2.415 s + 1.061 s = 3.476 s
        let speed = SurfaceSpeed { surface: 200_000.0, max: 3000.0, min: 0.0 };
        let seconds = speed.line_minutes(25.0, 0.0, 25.0, 0.2) * 60.0;
        assert!((seconds - 3.476).abs() < 0.001, "{seconds}");
        let clamp = 200_000.0 / (TAU * 3000.0);
        let cut = speed.line_minutes(25.0, clamp, 25.0 - clamp, 0.2) * 60.0;
        assert!((cut - 2.415).abs() < 0.001, "{cut}");
    }

    #[test]
    fn across_the_centre_counts_both_sides() {
        let speed = SurfaceSpeed { surface: 200_000.0, max: 3000.0, min: 0.0 };
        let one = speed.line_minutes(25.0, 0.0, 25.0, 0.2);
        let both = speed.line_minutes(25.0, -25.0, 50.0, 0.2);
        assert!((both - 2.0 * one).abs() < 1e-12);
    }

    #[test]
    fn arc_agrees_with_many_chords() {
        let speed = SurfaceSpeed { surface: 150_000.0, max: 2500.0, min: 60.0 };
        let arc = arc::by_center([0.0, 3.0], [20.0, 3.0], [10.0, 6.0], false).unwrap();
        for radial in [0, 1] {
            let exact = speed.arc_minutes(&arc, radial, 0.15);
            let steps = 20_000;
            let mut sum = 0.0;
            for k in 0..steps {
                let a = arc.start_angle + arc.sweep * f64::from(k) / f64::from(steps);
                let b = arc.start_angle + arc.sweep * f64::from(k + 1) / f64::from(steps);
                let at = |angle: f64| {
                    [arc.center[0] + arc.radius * angle.cos(), arc.center[1] + arc.radius * angle.sin()][radial]
                };
                sum += speed.line_minutes(at(a), at(b), arc.length() / f64::from(steps), 0.15);
            }
            assert!((exact - sum).abs() / sum < 1e-6, "{radial}: {exact} {sum}");
        }
    }
}
