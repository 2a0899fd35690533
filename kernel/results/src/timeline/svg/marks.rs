//! Sync points as lines, and their marks in as many rows as they need.
//!
//! Of sync points closer together than a few pixels one line is drawn, whose mark names all of them. *Invariant:* marks
//! of one row do not lie over each other; a mark that finds no place is still named by the hint of its line.

use super::scale::TimeScale;
use super::{LEFT, RIGHT};
use crate::summary::SyncPoint;
use crate::svg::{fit, width};
use crate::timeline::Timeline;

/// Least distance of two lines between the same rows, px.
const NEAR: f64 = 2.5;

/// More lines than this are thin, leave the bars free and have no marks.
pub(super) const MANY: usize = 150;

/// Width of a mark at most, px.
const LONGEST: f64 = 200.0;

/// Rows of marks between two channels at most.
const LEVELS: usize = 8;

/// Rows of marks in a plot that has details below it.
const FEW_LEVELS: usize = 1;

/// A line with the sync points at its place.
#[derive(Debug)]
pub(super) struct PlotLine {
    pub(super) x: f64,
    /// Rows of the channels that arrive and release.
    pub(super) rows: Vec<usize>,
    /// Indices of its sync points.
    pub(super) points: Vec<usize>,
}

/// A mark below a row.
#[derive(Debug)]
pub(super) struct PlotMark {
    pub(super) text: String,
    pub(super) row: usize,
    pub(super) level: usize,
    /// Left border and width, px.
    pub(super) left: f64,
    pub(super) wide: f64,
}

/// The lines of a plot and their marks.
#[derive(Debug)]
pub(super) struct PlotMarks {
    pub(super) lines: Vec<PlotLine>,
    pub(super) marks: Vec<PlotMark>,
}

impl PlotMarks {
    /// All sync points in the time of a scale.
    pub(super) fn new(timeline: &Timeline, scale: &TimeScale, readable: bool) -> Self {
        let lines = lines(timeline, scale);
        let levels = if readable { LEVELS } else { FEW_LEVELS };
        let marks = if lines.len() > MANY { Vec::new() } else { place(timeline, &lines, levels) };
        Self { lines, marks }
    }

    /// Rows of marks that the gaps between channels must hold.
    pub(super) fn levels(&self) -> usize {
        self.marks.iter().map(|mark| mark.level + 1).max().unwrap_or(0)
    }
}

/// Lines far enough from each other, from left to right.
fn lines(timeline: &Timeline, scale: &TimeScale) -> Vec<PlotLine> {
    let (from, to) = scale.window();
    let mut lines: Vec<PlotLine> = Vec::new();
    let mut last: Vec<Option<usize>> = vec![None; timeline.channels.len() * timeline.channels.len()];
    for (index, point) in timeline.waits.iter().enumerate() {
        let Some(release) = point.release_ns.filter(|release| (from..=to).contains(release)) else { continue };
        let rows = rows_of(timeline, point);
        let (x, Some(&first), Some(&bottom)) = (scale.x(release), rows.first(), rows.last()) else { continue };
        let Some(latest) = last.get_mut(first * timeline.channels.len() + bottom) else { continue };
        let near = latest.and_then(|at| lines.get_mut(at)).filter(|line| (x - line.x).abs() < NEAR);
        match near {
            Some(line) => line.points.push(index),
            None => {
                *latest = Some(lines.len());
                lines.push(PlotLine { x, rows, points: vec![index] });
            }
        }
    }
    lines.sort_by(|a, b| a.x.total_cmp(&b.x));
    lines
}

/// A place for the mark of every line, in the first row where it has room.
fn place(timeline: &Timeline, lines: &[PlotLine], levels: usize) -> Vec<PlotMark> {
    // Where the last mark of each row and level ends.
    let mut ends = vec![[f64::NEG_INFINITY; LEVELS]; timeline.channels.len()];
    let mut marks = Vec::new();
    for line in lines {
        let Some((&row, ends)) = line.rows.first().and_then(|row| Some((row, ends.get_mut(*row)?))) else { continue };
        for text in texts(timeline, line) {
            let wide = width(&text, 11) + 6.0;
            let left = (line.x - wide / 2.0).clamp(LEFT - 10.0, RIGHT - wide);
            let free = ends.iter_mut().take(levels).enumerate().find(|(_, end)| left >= **end + 3.0);
            if let Some((level, end)) = free {
                *end = left + wide;
                marks.push(PlotMark { text, row, level, left, wide });
            }
        }
    }
    marks
}

/// The names of the sync points of a line, in as many texts as they need; neighbours of one name are counted.
fn texts(timeline: &Timeline, line: &PlotLine) -> Vec<String> {
    let mut names: Vec<(&str, usize)> = Vec::new();
    for point in line.points.iter().filter_map(|index| timeline.waits.get(*index)) {
        match names.last_mut() {
            Some((name, count)) if *name == &*point.key => *count += 1,
            _ => names.push((&point.key, 1)),
        }
    }
    let mut texts: Vec<String> = Vec::new();
    for (name, count) in names {
        let name = if count > 1 { format!("{name} ×{count}") } else { name.to_owned() };
        match texts.last_mut() {
            Some(text) if width(text, 11) + width(&name, 11) < LONGEST - 20.0 => {
                text.push_str(", ");
                text.push_str(&name);
            }
            _ => texts.push(fit(&name, 11, LONGEST)),
        }
    }
    texts
}

/// Rows of the channels that arrive and of the one that releases them, from the top.
fn rows_of(timeline: &Timeline, point: &SyncPoint) -> Vec<usize> {
    let row = |channel: u16| timeline.channels.iter().position(|known| known.channel == channel);
    let arrived = point.arrivals.iter().map(|arrival| arrival.channel);
    let mut rows: Vec<usize> = arrived.chain([point.by]).filter_map(row).collect();
    rows.sort_unstable();
    rows.dedup();
    rows
}
