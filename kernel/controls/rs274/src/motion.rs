//! Motions: lines, circles, threads, probes, splines, and moves to stored positions.
//!
//! Facts: LinuxCNC documentation of G0 to G5.3, G28, G30, G33, G33.1, G38, G53. Decisions: a spline becomes lines that
//! deviate from it by at most 0.002 mm. A probing move touches at its end if the machine gives #5070 the value 1 at the
//! start (`[variables] initial`), otherwise it never touches. *Invariant:* a block with a motion has its code.

use counterpoint_fault as diag;
use counterpoint_machine::ident::codes as ids;

use super::block::{AXES, BlockWord, BlockWords};
use super::codes::{NO_MOTION, is_cycle};
use super::offsets::no_axis;
use super::polar::without_polar;
use super::run::{push_code, push_value, push_word};
use super::system::{PROBED, axis};
use super::text::Rs274Mistake;
use super::{Outcome, Rs274};
use counterpoint_control_api::host::{AxisPlace, InterpreterHost};
use counterpoint_control_api::words::Span;

/// Largest distance of the lines of a spline from the spline, mm.
pub(super) const SPLINE: f64 = 0.002;

/// Largest number of lines of a spline.
const LINES: f64 = 1000.0;

/// Letters of centres, by axis.
const CENTERS: &[u8] = b"ijk";

fn refused(error: u8, text: &str) -> Rs274Mistake {
    Rs274Mistake::new(&diag::REFUSED, error, text)
}

/// Program position along the axis of a letter.
pub(super) fn work(places: &[AxisPlace], at: usize) -> f64 {
    axis(places, at).map_or(0.0, |place| place.work)
}

impl Rs274 {
    /// Adds the words of a motion. Returns whether there are any.
    pub(super) fn push_motion(&mut self, host: &mut dyn InterpreterHost, words: &BlockWords) -> Outcome<bool> {
        let Some(motion) = words.motion else { return Ok(false) };
        let before = std::mem::replace(&mut self.modes.motion, motion);
        if !is_cycle(motion) {
            self.modes.cycle.end();
        }
        let (block, polar) = (words, without_polar(host, words, 0)?);
        let words = polar.as_ref().unwrap_or(words);
        let span = words.whole;
        let turns =
            host.is_active(ids::SPINDLE_CLW) || host.is_active(ids::SPINDLE_CCLW) || words.has_m(3) || words.has_m(4);
        match motion {
            330 if !turns => return Err(refused(20, "G33 needs a turning spindle: write M3 or M4 before").into()),
            NO_MOTION => push_code(host, b'G', 80.0, span),
            50 | 51 => self.spline(host, words, (motion, before))?,
            52 => {
                let begins = before != 52 || words.has_g(52) && self.modes.nurbs.is_empty();
                self.nurbs_point(host, words, begins)?;
                return Ok(false);
            }
            53 => self.nurbs_end(host, words, before == 52)?,
            331 => self.tap(host, words)?,
            760 => self.thread(host, words)?,
            motion if is_cycle(motion) => self.cycle(host, block, motion)?,
            0 | 10 if words.has_g(530) && !host.is_active(ids::POSITION_ABSOLUTE) => {
                self.machine_distance(host, words)?
            }
            _ => {
                push_code(host, b'G', f64::from(motion) / 10.0, span);
                push_feed(host, words)?;
                for word in &words.words {
                    match word.letter {
                        b'i' | b'j' | b'k' | b'r' | b'p' if matches!(motion, 20 | 30) => {
                            self.push_arc(host, words, word)?
                        }
                        b'k' if motion == 330 => push_word(host, word)?,
                        letter if AXES.contains(&letter) => push_word(host, word)?,
                        _ => {}
                    }
                }
            }
        }
        Ok(true)
    }

    /// Adds a word of a circle; converts an absolute centre into a distance.
    fn push_arc(&self, host: &mut dyn InterpreterHost, words: &BlockWords, word: &BlockWord) -> Outcome<()> {
        if matches!(word.letter, b'p') && !words.has_g(40) {
            return push_word(host, word);
        }
        let center = CENTERS.iter().position(|letter| *letter == word.letter).filter(|_| self.modes.absolute_centers);
        match center {
            Some(at) => {
                let here = work(&host.axes(), at);
                push_value(host, word.letter.to_ascii_uppercase(), word.value - here, word.span)
            }
            None => push_word(host, word),
        }
    }

    /// G53 in incremental mode: axis words are machine positions nevertheless.
    fn machine_distance(&mut self, host: &mut dyn InterpreterHost, words: &BlockWords) -> Outcome<()> {
        let span = words.whole;
        push_code(host, b'G', 90.0, span);
        push_code(host, b'G', 53.0, span);
        push_code(host, b'G', f64::from(self.modes.motion) / 10.0, span);
        push_feed(host, words)?;
        for word in words.words.iter().filter(|word| AXES.contains(&word.letter)) {
            push_word(host, word)?;
        }
        host.end_block();
        push_code(host, b'G', 91.0, span);
        Ok(())
    }

    /// G28 and G30: moves to the stored position through the point of the block.
    pub(super) fn go_home(
        &mut self,
        host: &mut dyn InterpreterHost,
        words: &BlockWords,
        which: usize,
    ) -> Outcome<bool> {
        if host.keeps_moves_back() {
            return Err(refused(20, "G28 is not possible under cutter compensation: write G40 before").into());
        }
        let (places, factor, span) = (host.axes(), host.length_factor(), words.whole);
        let relative = host.relative();
        let axes: Vec<&BlockWord> = words.words.iter().filter(|word| AXES.contains(&word.letter)).collect();
        if let Some(word) = axes.iter().find(|word| letter_of(&places, word.letter).is_none()) {
            return Err(no_axis(word.letter).into());
        }
        if !axes.is_empty() {
            push_code(host, b'G', 0.0, span);
            for word in &axes {
                push_word(host, word)?;
            }
            host.end_block();
        }
        let stored = self.offsets.stored.get(which).copied().unwrap_or_default();
        let stored = self.point_of_machine(host, stored);
        push_code(host, b'G', 0.0, span);
        for (at, letter) in AXES.iter().enumerate() {
            let Some(place) = axis(&places, at) else { continue };
            let word = axes.iter().find(|word| word.letter == *letter);
            if axes.is_empty() || word.is_some() {
                let to = stored.get(at).copied().unwrap_or(0.0) / if place.turns { 1.0 } else { factor };
                // The move from the point of the block.
                let from = place.work + word.map_or(0.0, |word| word.value);
                push_axis(host, at, if relative { to - from } else { to }, span)?;
            }
        }
        Ok(true)
    }

    /// G33.1: a thread along the line and back.
    fn tap(&mut self, host: &mut dyn InterpreterHost, words: &BlockWords) -> Outcome<()> {
        let (places, relative, span) = (host.axes(), host.relative(), words.whole);
        let clockwise = host.is_active(ids::SPINDLE_CLW);
        if !clockwise && !host.is_active(ids::SPINDLE_CCLW) {
            return Err(refused(20, "G33.1 needs a turning spindle: write M3 or M4 before").into());
        }
        let pitch = words.get(b'k').unwrap_or(0.0);
        let axes: Vec<&BlockWord> = words.words.iter().filter(|word| AXES.contains(&word.letter)).collect();
        push_code(host, b'G', 33.0, span);
        for word in &axes {
            push_word(host, word)?;
        }
        push_value(host, b'K', pitch, span)?;
        host.end_block();
        push_code(host, b'M', if clockwise { 4.0 } else { 3.0 }, span);
        host.end_block();
        push_code(host, b'G', 33.0, span);
        for word in &axes {
            let Some(place) = letter_of(&places, word.letter) else { return Err(no_axis(word.letter).into()) };
            push_value(host, word.letter.to_ascii_uppercase(), if relative { -word.value } else { place.work }, span)?;
        }
        push_value(host, b'K', pitch, span)?;
        host.end_block();
        push_code(host, b'M', if clockwise { 3.0 } else { 4.0 }, span);
        Ok(())
    }

    /// Converts G5 and G5.1 into lines.
    fn spline(
        &mut self,
        host: &mut dyn InterpreterHost,
        words: &BlockWords,
        (motion, before): (u16, u16),
    ) -> Outcome<()> {
        if !host.is_active(ids::PLANE_XY) {
            return Err(refused(20, "splines are possible in the plane of G17 only").into());
        }
        if words.words.iter().any(|word| AXES.contains(&word.letter) && !matches!(word.letter, b'x' | b'y')) {
            return Err(refused(20, "a spline moves X and Y only: write other axes in another block").into());
        }
        let (places, relative, span) = (host.axes(), host.relative(), words.whole);
        let start = [work(&places, 0), work(&places, 1)];
        let word = |letter| words.get(letter);
        let coordinate = |at: usize, letter| {
            let base = start.get(at).copied().unwrap_or(0.0);
            word(letter).map_or(base, |value| if relative { base + value } else { value })
        };
        let end = [coordinate(0, b'x'), coordinate(1, b'y')];
        let first = match (word(b'i'), word(b'j')) {
            (None, None) if motion == 50 && before == 50 => self.modes.cycle.spline.map(|[x, y]| [-x, -y]),
            (Some(i), Some(j)) => Some([i, j]),
            (i, j) if motion == 51 && (i.is_some() || j.is_some()) => Some([i.unwrap_or(0.0), j.unwrap_or(0.0)]),
            _ => None,
        };
        let Some(first) = first else { return Err(refused(28, "the spline needs I and J").into()) };
        let last = [word(b'p').unwrap_or(0.0), word(b'q').unwrap_or(0.0)];
        self.modes.cycle.spline = (motion == 50).then_some(last);
        let add = |a: [f64; 2], b: [f64; 2]| [a[0] + b[0], a[1] + b[1]];
        let control = add(start, first);
        let points = if motion == 50 {
            [start, control, add(end, last), end]
        } else {
            // A parabola as a cubic curve.
            let near = |from: [f64; 2]| {
                [from[0] + 2.0 / 3.0 * (control[0] - from[0]), from[1] + 2.0 / 3.0 * (control[1] - from[1])]
            };
            [start, near(start), near(end), end]
        };
        let mut here = start;
        let lines = lines_of(&points, SPLINE / host.length_factor());
        for line in 1..=lines {
            let to = if line == lines { end } else { curve(&points, f64::from(line) / f64::from(lines)) };
            push_code(host, b'G', 1.0, span);
            if line == 1 {
                push_feed(host, words)?;
            } else if host.is_active(ids::FEED_1T) {
                return Err(refused(20, "a spline is not possible under G93: write G94 before it").into());
            }
            let value = |at: usize| {
                let (to, here) = (to.get(at).copied().unwrap_or(0.0), here.get(at).copied().unwrap_or(0.0));
                if relative { to - here } else { to }
            };
            push_value(host, b'X', value(0), span)?;
            push_value(host, b'Y', value(1), span)?;
            here = to;
            if line < lines {
                host.end_block();
            }
        }
        host.work(lines as usize)?;
        Ok(())
    }

    /// Sets the parameters of a probing move.
    pub(super) fn probed(&mut self, host: &mut dyn InterpreterHost) -> Outcome<()> {
        let places = host.axes();
        for (number, at) in (PROBED..).zip(0..AXES.len()) {
            self.parameters.set_number(number, work(&places, at))?;
        }
        if self.touches {
            host.log_message("the probe is assumed to touch at the end of its move");
        }
        self.parameters.set_number(5070, f64::from(u8::from(self.touches)))?;
        if !self.touches && matches!(self.modes.motion, 382 | 384) {
            let alarm = if self.kind.is_firmware() { "ALARM:5 " } else { "" };
            let text = format!("{alarm}the probe made no contact in '{}'", host.block_text());
            return Err(host.alarm(&diag::PROBE_MISSED, text).into());
        }
        self.record_probe(host, &places)
    }
}

fn letter_of(places: &[AxisPlace], letter: u8) -> Option<&AxisPlace> {
    axis(places, AXES.iter().position(|known| *known == letter)?)
}

/// Adds the feed word of a block that moves.
pub(super) fn push_feed(host: &mut dyn InterpreterHost, words: &BlockWords) -> Outcome<()> {
    match words.word(b'f') {
        Some(feed) if words.has_axes() => push_word(host, feed),
        _ => Ok(()),
    }
}

/// Number of lines that stay within `near` of a cubic curve.
fn lines_of(points: &[[f64; 2]; 4], near: f64) -> u32 {
    let [a, b, c, d] = points;
    let bend =
        |p: &[f64; 2], q: &[f64; 2], r: &[f64; 2]| libm::hypot(p[0] - 2.0 * q[0] + r[0], p[1] - 2.0 * q[1] + r[1]);
    let most = bend(a, b, c).max(bend(b, c, d));
    (0.75 * most / near).sqrt().ceil().clamp(1.0, LINES) as u32
}

/// A point of a cubic curve.
fn curve(points: &[[f64; 2]; 4], t: f64) -> [f64; 2] {
    let s = 1.0 - t;
    let [a, b, c, d] = points;
    let value =
        |a: f64, b: f64, c: f64, d: f64| s * s * s * a + 3.0 * s * s * t * b + 3.0 * s * t * t * c + t * t * t * d;
    [value(a[0], b[0], c[0], d[0]), value(a[1], b[1], c[1], d[1])]
}

/// Adds an axis word.
pub(super) fn push_axis(host: &mut dyn InterpreterHost, at: usize, value: f64, span: Span) -> Outcome<()> {
    let letter = AXES.get(at).copied().unwrap_or(b'x').to_ascii_uppercase();
    push_value(host, letter, value, span)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_keep_near_to_their_curve() {
        let points = [[0.0, 0.0], [0.0, 10.0], [10.0, 10.0], [10.0, 0.0]];
        let lines = lines_of(&points, 0.01);
        let at = |line: u32| curve(&points, f64::from(line) / f64::from(lines));
        for line in 0..lines {
            let ([x, y], [u, v]) = (at(line), at(line + 1));
            let [p, q] = curve(&points, (f64::from(line) + 0.5) / f64::from(lines));
            let beside = ((u - x) * (q - y) - (v - y) * (p - x)).abs() / libm::hypot(u - x, v - y);
            assert!(beside < 0.01, "{line} of {lines}: {beside}");
        }
        assert_eq!((at(0), at(lines)), ([0.0, 0.0], [10.0, 0.0]));
    }
}
