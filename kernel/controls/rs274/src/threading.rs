//! The threading cycle G76.
//!
//! Facts: LinuxCNC documentation, "G76 Threading Cycle": the drive line starts at the current X and runs along Z. I is
//! the peak offset (negative for outside threads), J the first depth, K the full depth, P the pitch. Q is the compound
//! angle, R the degression, H the spring passes, E the length of the taper, L the tapered ends. The depth of pass n is
//! J n^(1/R), at most K. *Invariant:* positions are in the units of the X and Z words.

use counterpoint_fault as diag;
use counterpoint_machine::ident::codes as ids;

use super::block::{AXES, BlockWords};
use super::motion::{push_axis, work};
use super::run::{push_code, push_value};
use super::text::Rs274Mistake;
use super::{Outcome, Rs274};
use counterpoint_control_api::host::InterpreterHost;
use counterpoint_control_api::numeric::{cosine, sine};
use counterpoint_control_api::words::Span;

/// Largest number of passes.
const PASSES: usize = 10_000;

fn refused(error: u8, text: &str) -> Rs274Mistake {
    Rs274Mistake::new(&diag::REFUSED, error, text)
}

/// The words of the cycle; depths are those of the X words.
#[derive(Debug)]
struct ThreadShape {
    /// X of the drive line.
    line: f64,
    start: f64,
    end: f64,
    /// 1 to cut towards larger X.
    side: f64,
    peak: f64,
    first: f64,
    full: f64,
    degression: f64,
    /// Z that belongs to a depth of 1 in X.
    slope: f64,
    pitch: f64,
    taper_pitch: f64,
    /// Length of the taper along Z, with the sign from the end to the start.
    taper: f64,
    ends: [bool; 2],
}

/// Adds moves; positions are absolute.
struct ThreadMoves<'h> {
    host: &'h mut dyn InterpreterHost,
    here: [f64; 2],
    relative: bool,
    span: Span,
    wrote: bool,
}

impl ThreadMoves<'_> {
    /// Moves at rapid, or with a pitch.
    fn go(&mut self, x: f64, z: f64, pitch: Option<f64>) -> Outcome<()> {
        let [before_x, before_z] = self.here;
        if (x, z) == (before_x, before_z) {
            return Ok(());
        }
        if std::mem::replace(&mut self.wrote, true) {
            self.host.end_block();
        }
        push_code(self.host, b'G', if pitch.is_some() { 33.0 } else { 0.0 }, self.span);
        for (at, to, from) in [(0, x, before_x), (2, z, before_z)] {
            if to != from {
                push_axis(self.host, at, if self.relative { to - from } else { to }, self.span)?;
            }
        }
        if let Some(pitch) = pitch {
            push_value(self.host, b'K', pitch, self.span)?;
        }
        self.here = [x, z];
        Ok(())
    }
}

impl ThreadShape {
    /// Depths of the passes below the drive line.
    fn depths(&self) -> Option<Vec<f64>> {
        let mut depths = Vec::new();
        // Adding the peak rounds the depths as on the control: K may be the exact depth of a pass.
        let mut depth = self.peak + self.first;
        while depth < self.full + self.peak {
            depths.push(depth);
            if depths.len() > PASSES {
                return None;
            }
            depth = self.peak + self.first * libm::pow((depths.len() + 1) as f64, 1.0 / self.degression);
        }
        Some(depths)
    }

    fn pass(&self, moves: &mut ThreadMoves<'_>, depth: f64) -> Outcome<()> {
        let shift = (depth - self.peak) * self.slope;
        let at = |below: f64| self.line + self.side * below;
        let (begin, end) = (self.start - shift, self.end + self.full * self.slope - shift);
        let [entry, exit] = self.ends;
        let back = depth - self.peak - self.full;
        moves.go(at(back), begin, None)?;
        if entry {
            moves.go(at(depth - self.full), begin, Some(self.taper_pitch))?;
            moves.go(at(depth), begin - self.taper, Some(self.taper_pitch))?;
        } else {
            moves.go(at(depth), begin, None)?;
        }
        if exit {
            moves.go(at(depth), end + self.taper, Some(self.pitch))?;
            moves.go(at(depth - self.full), end, Some(self.taper_pitch))?;
        } else {
            moves.go(at(depth), end, Some(self.pitch))?;
        }
        moves.go(at(back), end, None)
    }
}

impl Rs274 {
    /// G76.
    pub(super) fn thread(&mut self, host: &mut dyn InterpreterHost, words: &BlockWords) -> Outcome<()> {
        if host.keeps_moves_back() {
            return Err(refused(20, "G76 is not possible under cutter compensation: write G40 before").into());
        }
        if !host.is_active(ids::PLANE_ZX) {
            return Err(refused(20, "G76 needs the plane of G18: write G18 before").into());
        }
        if !host.is_active(ids::SPINDLE_CLW) && !host.is_active(ids::SPINDLE_CCLW) {
            return Err(refused(20, "G76 needs a turning spindle: write M3 or M4 before").into());
        }
        if words.words.iter().any(|word| AXES.contains(&word.letter) && word.letter != b'z') {
            return Err(refused(20, "G76 has Z as its only axis word: remove the others").into());
        }
        let (places, relative) = (host.axes(), host.relative());
        let (line, start) = (work(&places, 0), work(&places, 2));
        let word = |letter| words.get(letter).unwrap_or(0.0);
        let (peak, first, full) = (word(b'i'), word(b'j'), word(b'k'));
        if peak == 0.0 {
            return Err(refused(20, "I of G76, the offset of the thread peak, is 0").into());
        }
        if first <= 0.0 || full <= first {
            return Err(refused(20, "G76 needs J, the first depth, above 0, and K, the full depth, above J").into());
        }
        let degression = words.get(b'r').unwrap_or(1.0);
        if word(b'p') <= 0.0 || word(b'h') < 0.0 || degression < 1.0 {
            return Err(refused(20, "G76 needs P above 0, H of 0 or more, and R of 1 or more").into());
        }
        let end = if relative { start + word(b'z') } else { word(b'z') };
        // Under G7, depths are those of the diameter.
        let radius = if host.is_active(ids::XAXIS_DIAMETER) { 0.5 } else { 1.0 };
        let compound = word(b'q');
        let slope = sine(compound) / cosine(compound) * radius * if end > start { -1.0 } else { 1.0 };
        let length = word(b'e').max(0.0);
        if length * 2.0 > (end - start).abs() {
            return Err(refused(20, "E of G76, the length of the taper, is more than half the thread").into());
        }
        let flags = word(b'l').max(0.0) as u32;
        let shape = ThreadShape {
            line,
            start,
            end,
            side: if peak > 0.0 { 1.0 } else { -1.0 },
            peak: peak.abs(),
            first,
            full,
            degression,
            slope,
            pitch: word(b'p'),
            taper_pitch: if length > 0.0 {
                word(b'p') * libm::hypot(length, full * radius) / length
            } else {
                word(b'p')
            },
            taper: if end > start { -length } else { length },
            ends: [flags & 1 != 0 && length > 0.0, flags & 2 != 0 && length > 0.0],
        };
        let Some(mut depths) = shape.depths() else {
            return Err(refused(20, "G76 has too many passes: write a larger J or a smaller R").into());
        };
        let spring = word(b'h').min(PASSES as f64) as usize;
        depths.extend(std::iter::repeat_n(shape.peak + shape.full, spring + 1));
        host.work(depths.len())?;
        let mut moves = ThreadMoves { host, here: [line, start], relative, span: words.whole, wrote: false };
        for depth in depths {
            shape.pass(&mut moves, depth)?;
        }
        moves.go(line, end, None)
    }
}
