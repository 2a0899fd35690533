//! The three travel tables: feed motions, rapid motions, both.
//!
//! Layout: reference listing-and-trace.md 7.3. *Invariant:* positions are those of the machine base frame, in axis
//! units (diameters on a diameter axis), arcs with their extremes.

use std::io::{Result, Write};

use crate::geometry::ArcGeometry;
use counterpoint_event::event::{MAX_AXES, Motion, MotionKind, Position};
use counterpoint_event::info::JobAxis;

#[derive(Debug, Clone, Copy)]
struct Extent {
    low: f64,
    high: f64,
    way: f64,
}

impl Extent {
    const NONE: Self = Self { low: f64::INFINITY, high: f64::NEG_INFINITY, way: 0.0 };

    fn add(&mut self, place: f64, way: f64) {
        self.low = self.low.min(place);
        self.high = self.high.max(place);
        self.way += way.abs();
    }

    fn join(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high), way: self.way + other.way }
    }
}

/// Collects the travel of a channel.
#[derive(Debug)]
pub(super) struct TravelTables<'a> {
    axes: &'a [JobAxis],
    shift: Position,
    feed: [Extent; MAX_AXES],
    rapid: [Extent; MAX_AXES],
}

impl<'a> TravelTables<'a> {
    pub(super) fn new(axes: &'a [JobAxis]) -> Self {
        Self { axes, shift: [0.0; MAX_AXES], feed: [Extent::NONE; MAX_AXES], rapid: [Extent::NONE; MAX_AXES] }
    }

    pub(super) fn frame(&mut self, shift: &Position) {
        self.shift = *shift;
    }

    pub(super) fn motion(&mut self, motion: &Motion) {
        let table = if motion.kind == MotionKind::Rapid { &mut self.rapid } else { &mut self.feed };
        let round = ArcGeometry::of(motion, self.axes);
        let ends = motion.from.iter().zip(&motion.to).zip(&self.shift);
        for (index, (extent, ((from, to), shift))) in table.iter_mut().zip(ends).enumerate().take(self.axes.len()) {
            extent.add(from + shift, 0.0);
            let mut last = *from;
            if let Some(round) = round {
                for at in round.reversals(self.axes, index) {
                    extent.add(at + shift, at - last);
                    last = at;
                }
            }
            extent.add(to + shift, to - last);
        }
    }

    pub(super) fn write(&self, out: &mut dyn Write) -> Result<()> {
        let mut both = self.feed;
        for (sum, rapid) in both.iter_mut().zip(self.rapid) {
            *sum = sum.join(rapid);
        }
        self.table("TRAVEL SUMMARY (FEED):", &self.feed, out)?;
        self.table("TRAVEL SUMMARY (RAPID):", &self.rapid, out)?;
        self.table("TRAVEL SUMMARY (TOTAL):", &both, out)
    }

    fn table(&self, caption: &str, extents: &[Extent], out: &mut dyn Write) -> Result<()> {
        write!(out, "\n{caption}\n\n")?;
        write!(out, "{:<6}{:>13}{:>13}{:>13}{:>13}\n\n", "AXIS", "MINIMUM", "MAXIMUM", "TOTAL", "ACCUM")?;
        for (axis, extent) in self.axes.iter().zip(extents).filter(|(_, e)| e.way > 0.0) {
            let [low, high, total, way] = [extent.low, extent.high, extent.high - extent.low, extent.way].map(tidy);
            if axis.rotary {
                writeln!(out, "{:<6}{low:>12.3}{high:>13.3}{total:>13.3}{way:>13.3}", axis.name)?;
            } else {
                writeln!(out, "{:<6}{low:>13.4}{high:>13.4}{total:>13.4}{way:>13.4}", axis.name)?;
            }
        }
        Ok(())
    }
}

/// No `-0.0000`.
fn tidy(value: f64) -> f64 {
    if value.abs() < 0.000_05 { 0.0 } else { value }
}
