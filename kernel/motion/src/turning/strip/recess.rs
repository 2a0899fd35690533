//! Grooves of any shape by a tool with a flat end, which plunges beside itself, then goes along both flanks (Siemens
//! CYCLE952).
//!
//! Facts: operating manual of the control: plunges are 80 per cent of the width of the tool apart at most. Decisions:
//! they follow each other in the direction of the contour, beside each other over the base and then on the flanks, each
//! as deep as the whole width fits in, in steps of the depth of a level, between which the tool goes back by its lift;
//! finishing goes down each flank with the edge on its side to the middle of the base. *Invariant:* no part of the end
//! of the tool comes below the contour.

use super::{EqualLevels, Removal, StripError, ToolCursor};
use crate::contour::element::Spot;
use crate::turning::parts::{ContourPart, ContourParts};
use crate::turning::{MoveSink, NOISE};

/// How far apart plunges are, in widths of the tool.
const SHARE: f64 = 0.8;

/// Most plunges of a part of a groove.
const MOST: f64 = 100_000.0;

/// A tool as seen: its width, and where its end begins beside its place.
#[derive(Debug, Clone, Copy)]
pub(super) struct FlatToolEnd {
    width: f64,
    begins: f64,
}

impl FlatToolEnd {
    /// Of the distance of its other edge along the contour, as seen.
    pub(super) fn new(other: f64) -> Self {
        Self { width: other.abs(), begins: other.min(0.0) }
    }
}

/// Height of a part at a place along it.
fn height_at(part: &ContourPart, along: f64) -> f64 {
    let ([from, low], [to, high]) = (part.from, part.to);
    if (to - from).abs() < NOISE {
        return low.max(high);
    }
    let Some(([center, middle], _)) = part.arc else {
        return low + (high - low) * ((along - from) / (to - from)).clamp(0.0, 1.0);
    };
    let radius = libm::hypot(from - center, low - middle);
    let half = (radius * radius - (along - center) * (along - center)).max(0.0).sqrt();
    let side = if (low + high) / 2.0 >= middle { half } else { -half };
    (middle + side).clamp(low.min(high), low.max(high))
}

/// The highest place of a contour between two places.
fn highest(parts: &ContourParts, from: f64, to: f64) -> f64 {
    let inside = parts.all.iter().filter(|part| part.to[0] > from + NOISE && part.from[0] < to - NOISE);
    let heights = inside.flat_map(|part| {
        let (begin, end) = (part.from[0].max(from), part.to[0].min(to));
        [height_at(part, begin), height_at(part, end)]
    });
    heights.fold(f64::NEG_INFINITY, f64::max)
}

impl Removal<'_> {
    /// Whether the tool fits into the groove, and may finish it.
    pub(super) fn check_recess(&self, end: FlatToolEnd) -> Result<(), StripError> {
        let (begin, last) = self.ends();
        if last - begin < end.width - NOISE || end.width < NOISE {
            return Err(StripError::Narrow);
        }
        let Some((falls, base)) = self.base() else { return Err(StripError::TurnsBack) };
        let falling = self.parts.all.iter().take(falls).all(|part| part.to[1] <= part.from[1] + NOISE);
        let rising = self.parts.all.iter().skip(falls).all(|part| part.to[1] >= part.from[1] - NOISE);
        if self.strip.finish && !(falling && rising) {
            return Err(StripError::TurnsBack);
        }
        if self.strip.finish && base[1] - base[0] < end.width - NOISE { Err(StripError::Narrow) } else { Ok(()) }
    }

    /// Where the contour first comes below its highest place, and where it last does.
    fn ends(&self) -> (f64, f64) {
        let top = self.high - NOISE;
        let first = self.parts.all.iter().find(|part| part.to[1] < top).map_or(0.0, |part| part.from[0]);
        let last = self.parts.all.iter().rfind(|part| part.from[1] < top).map_or(first, |part| part.to[0]);
        (first, last)
    }

    /// The number of parts down to the base, and where that begins and ends.
    fn base(&self) -> Option<(usize, [f64; 2])> {
        let low = self.parts.lowest();
        let flat = |part: &ContourPart| part.from[1] < low + NOISE && part.to[1] < low + NOISE;
        let first = self.parts.all.iter().position(|part| part.to[1] < low + NOISE)?;
        let begin = self.parts.all.get(first).map(|part| if flat(part) { part.from[0] } else { part.to[0] })?;
        let last = self.parts.all.iter().rposition(|part| part.from[1] < low + NOISE);
        let end = last
            .and_then(|at| self.parts.all.get(at))
            .map_or(begin, |part| if flat(part) { part.to[0] } else { part.from[0] });
        let falls = self.parts.all.iter().position(flat).unwrap_or(first + 1);
        Some((falls, [begin, end]))
    }

    /// Where the end of the tool begins in its plunges: beside each other over the base, then on both flanks as far as
    /// it fits.
    fn plunges(&self, end: FlatToolEnd) -> Vec<f64> {
        let (begin, last) = self.ends();
        let Some((_, base)) = self.base() else { return Vec::new() };
        let (room, step) = (base[1] - base[0] - end.width, SHARE * end.width);
        let count = if room > NOISE { 1.0 + (room / step - 1e-6).ceil().min(MOST) } else { 1.0 };
        let [first, over] = if room > 0.0 { [base[0], room] } else { [base[0] + room / 2.0, 0.0] };
        let within = |from: &f64| *from > begin - NOISE && *from < last - end.width + NOISE;
        let numbers = |most: f64| (0..most as u32).map(f64::from);
        let beside = ((last - begin) / step).min(MOST);
        let mut places: Vec<f64> = numbers(beside).map(|number| first - (number + 1.0) * step).collect();
        places.reverse();
        places.extend(numbers(count).map(|number| first + over * number / (count - 1.0).max(1.0)));
        places.extend(numbers(beside).map(|number| first + over + (number + 1.0) * step));
        places.retain(within);
        places
    }

    /// Plunges, and both flanks.
    pub(super) fn recess<S: MoveSink>(&self, cut: &mut ToolCursor<'_, S>, end: FlatToolEnd) -> Result<(), S::Stop> {
        let above = self.start[1];
        if self.strip.rough {
            for from in self.plunges(end) {
                let bottom = highest(&self.parts, from, from + end.width);
                if bottom > self.high - NOISE {
                    continue;
                }
                cut.sink.pass()?;
                cut.sink.use_feed(0);
                cut.rapid([from - end.begins, above])?;
                let levels = EqualLevels::new(self.high, bottom, self.strip.depth);
                for level in 1..=levels.count {
                    cut.sink.pass()?;
                    cut.feed([from - end.begins, levels.height(level)])?;
                    let back = if level < levels.count { levels.height(level) + self.strip.lift } else { above };
                    cut.rapid([from - end.begins, back])?;
                }
            }
        }
        if self.strip.finish
            && let Some((falls, base)) = self.base()
        {
            let middle = [f64::midpoint(base[0], base[1] - end.width) - end.begins, self.parts.lowest()];
            cut.sink.use_feed(2);
            let down: Vec<ContourPart> = self.parts.all.iter().take(falls).copied().collect();
            self.flank(cut, &down, (-end.begins, middle))?;
            let is_up = |part: &&ContourPart| part.from[1].max(part.to[1]) > middle[1] + NOISE;
            let back = |part: &ContourPart| {
                let arc = part.arc.map(|(center, clockwise)| (center, !clockwise));
                ContourPart { from: part.to, to: part.from, arc }
            };
            let up: Vec<ContourPart> = self.parts.all.iter().skip(falls).filter(is_up).rev().map(back).collect();
            self.flank(cut, &up, (-end.width - end.begins, middle))?;
        }
        cut.rapid(self.start)
    }

    /// Down a flank, moved along, to a place on the base, and up.
    fn flank<S: MoveSink>(
        &self,
        cut: &mut ToolCursor<'_, S>,
        parts: &[ContourPart],
        (by, to): (f64, Spot),
    ) -> Result<(), S::Stop> {
        cut.sink.pass()?;
        let moved = |[along, height]: Spot| [along + by, height];
        let Some(first) = parts.first() else { return Ok(()) };
        cut.rapid([moved(first.from)[0], self.start[1]])?;
        cut.feed(moved(first.from))?;
        for part in parts {
            let arc = part.arc.map(|(center, clockwise)| (moved(center), clockwise));
            let part = ContourPart { from: moved(part.from), to: moved(part.to), arc };
            cut.part(&part, part.to)?;
        }
        cut.feed(to)?;
        cut.rapid([cut.at[0], self.start[1]])
    }
}
