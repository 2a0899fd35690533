//! Positions of the rows of a plot: as far apart as the marks between them need.
//!
//! *Invariant:* plots of details follow each other without a gap in time, and there are [`MOST`] at most.

use super::marks::PlotMarks;
use super::scale::TimeScale;
use super::{BAR, GAP, READABLE, STRIP};
use crate::timeline::Timeline;

/// Plots of details at most.
const MOST: usize = 16;

/// Height of a row of marks, px.
const MARK: f64 = 17.0;

/// A plot: its time, its place and its marks.
#[derive(Debug)]
pub(super) struct PlotLayout {
    pub(super) scale: TimeScale,
    pub(super) top: f64,
    pub(super) marks: PlotMarks,
    gap: f64,
    rows: usize,
}

impl PlotLayout {
    /// A plot from `top` on; `readable`: no mark may lie over another one.
    pub(super) fn new(timeline: &Timeline, scale: TimeScale, top: f64, readable: bool) -> Self {
        let marks = PlotMarks::new(timeline, &scale, readable);
        let gap = GAP.max(9.0 + MARK * marks.levels() as f64);
        Self { scale, top, marks, gap, rows: timeline.channels.len() }
    }

    /// Top of the bar of a row.
    pub(super) fn row_top(&self, index: usize) -> f64 {
        self.top + STRIP + index as f64 * (BAR + self.gap + STRIP)
    }

    /// Middle of a mark below a row.
    pub(super) fn mark_middle(&self, row: usize, level: usize) -> f64 {
        self.row_top(row) + BAR + 4.5 + MARK * (level as f64 + 0.5)
    }

    /// Height of the space between two rows.
    pub(super) fn between(&self) -> f64 {
        self.gap + STRIP
    }

    /// Where the time axis is.
    pub(super) fn bottom(&self) -> f64 {
        self.row_top(self.rows) - self.gap - STRIP + 12.0
    }
}

/// The times of the plots of details, ns; none where the marks are readable in one plot.
pub(super) fn windows(timeline: &Timeline) -> Vec<(i64, i64)> {
    let mut times: Vec<i64> = timeline.waits.iter().filter_map(|point| point.release_ns).collect();
    times.sort_unstable();
    times.dedup();
    if times.len() <= READABLE || timeline.makespan_ns <= 0 {
        return Vec::new();
    }
    let plots = times.len().div_ceil(READABLE).min(MOST);
    let each = times.len().div_ceil(plots);
    // Between the last sync point of a plot and the first one of the next.
    let inner = times.chunks(each).zip(times.chunks(each).skip(1)).filter_map(|(one, next)| {
        let (last, first) = (one.last()?, next.first()?);
        Some(last + (first - last) / 2)
    });
    let borders: Vec<i64> = [0].into_iter().chain(inner).chain([timeline.makespan_ns]).collect();
    borders.windows(2).filter_map(|pair| Some((*pair.first()?, *pair.last()?))).collect()
}
