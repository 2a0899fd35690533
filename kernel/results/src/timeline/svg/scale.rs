//! The time axis.

use std::fmt::Write as _;

use super::{SOFT, WIDTH};
use crate::svg::{round_step, text, width};

const S: i64 = 1_000_000_000;

/// From simulated time to pixels.
#[derive(Debug)]
pub(super) struct TimeScale {
    from_ns: i64,
    span_ns: i64,
    pub(super) left: f64,
    pub(super) right: f64,
}

impl TimeScale {
    /// From one time to another; a job without any length is drawn as one of a second.
    pub(super) fn new((from_ns, to_ns): (i64, i64), left: f64, right: f64) -> Self {
        Self { from_ns, span_ns: if to_ns > from_ns { to_ns - from_ns } else { S }, left, right }
    }

    pub(super) fn x(&self, ns: i64) -> f64 {
        self.left + (ns - self.from_ns) as f64 / self.span_ns as f64 * (self.right - self.left)
    }

    /// First and last time, ns.
    pub(super) fn window(&self) -> (i64, i64) {
        (self.from_ns, self.from_ns.saturating_add(self.span_ns))
    }

    /// Whether something between two times is seen.
    pub(super) fn sees(&self, from_ns: i64, to_ns: i64) -> bool {
        to_ns >= self.from_ns && from_ns <= self.window().1
    }

    /// The part of a stretch of time that is seen.
    pub(super) fn within(&self, from_ns: i64, to_ns: i64) -> (i64, i64) {
        let (first, last) = self.window();
        (from_ns.clamp(first, last), to_ns.clamp(first, last))
    }

    /// The times of the grid lines.
    fn ticks(&self, step: i64) -> impl Iterator<Item = i64> {
        let (from, to) = self.window();
        (from.div_euclid(step) + i64::from(from.rem_euclid(step) > 0)..=to / step).map(move |n| n * step)
    }

    /// Ticks, grid lines and their times between two heights.
    pub(super) fn draw(&self, out: &mut String, top: f64, bottom: f64) {
        let step = step(self.span_ns);
        let _ = write!(out, r##"<path stroke="#dde2e7" stroke-width="1" d=""##);
        for tick in self.ticks(step) {
            let _ = write!(out, "M{:.1} {top:.0}V{:.0}", self.x(tick), bottom + 5.0);
        }
        out.push_str("\"/>\n");
        let _ = writeln!(
            out,
            r##"<path stroke="#66727f" stroke-width="1" d="M{:.1} {bottom:.0}H{:.1}"/>"##,
            self.left,
            WIDTH - 24.0
        );
        for tick in self.ticks(step) {
            let label = form(tick, step, self.window().1);
            let half = width(&label, 12) / 2.0;
            let x = self.x(tick).min(WIDTH - 4.0 - half);
            text(out, (x, bottom + 20.0), 12, "middle", SOFT, &label);
        }
    }
}

/// A round step that gives about ten ticks.
fn step(span_ns: i64) -> i64 {
    let seconds = [1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 10_800, 21_600, 43_200, 86_400];
    if span_ns > 10 * S {
        let found = seconds.into_iter().map(|s| s * S).find(|s| span_ns / s <= 12);
        return found
            .unwrap_or_else(|| (round_step(span_ns as f64 / S as f64 / 86_400.0, 10.0) * 86_400.0).ceil() as i64 * S);
    }
    (round_step(span_ns as f64, 10.0) as i64).max(1)
}

/// `2.5 s`, `12:30`, `1:02:03`, with the decimals that `precision_ns` asks for.
pub(super) fn time_text(ns: i64, precision_ns: i64) -> String {
    form(ns, precision_ns, ns)
}

/// A time in the form that fits a length.
fn form(ns: i64, precision_ns: i64, length_ns: i64) -> String {
    let decimals = (0..9_u32).find(|d| precision_ns % (S / 10_i64.pow(*d)) == 0).unwrap_or(9) as usize;
    if length_ns < 120 * S {
        return format!("{:.decimals$} s", ns as f64 / S as f64);
    }
    let total = ns / S;
    let fraction = if decimals > 0 {
        let text = format!("{:.decimals$}", (ns % S) as f64 / S as f64);
        text.get(1..).unwrap_or_default().to_owned()
    } else {
        String::new()
    };
    let (hours, minutes, seconds) = (total / 3600, total / 60 % 60, total % 60);
    if length_ns >= 3600 * S {
        format!("{hours}:{minutes:02}:{seconds:02}{fraction}")
    } else {
        format!("{minutes}:{seconds:02}{fraction}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_and_steps_are_readable() {
        assert_eq!(time_text(2_500_000_000, 500_000_000), "2.5 s");
        assert_eq!(time_text(119 * S, S), "119 s");
        assert_eq!(time_text(754 * S, S), "12:34");
        assert_eq!(time_text(3723 * S + S / 2, 1_000_000), "1:02:03.500");
        assert_eq!([step(5 * S), step(100 * S), step(754 * S), step(7200 * S)], [S / 2, 10 * S, 60 * S, 600 * S]);
    }
}
