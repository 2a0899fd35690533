//! Lines where channels met.
//!
//! Of sync points closer together than a few pixels one line is drawn; of marks that would lie over each other the first
//! one is written. Many lines are drawn between the rows only and without marks, so that the bars stay readable.

use std::fmt::Write as _;

use super::scale::{Scale, time_text};
use super::{BAR, GAP, INK, LEFT, STRIP, WIDTH, row_top};
use crate::summary::SyncPoint;
use crate::svg::{escape, fit, text, width};
use crate::timeline::Timeline;

/// Least distance of two lines between the same rows, px.
const NEAR: f64 = 2.5;

/// More lines than this are thin and leave the bars free.
const MANY: usize = 150;

/// Width of a mark at most, px.
const LONGEST: f64 = 200.0;

/// A line to be drawn.
struct Line<'a> {
    x: f64,
    rows: Vec<usize>,
    point: &'a SyncPoint,
}

pub(super) fn draw(out: &mut String, timeline: &Timeline, scale: &Scale) {
    let lines = lines(timeline, scale);
    if lines.is_empty() {
        return;
    }
    let (mut path, mut dots, mut labels) = (String::new(), String::new(), String::new());
    let many = lines.len() > MANY;
    // Where the last mark below a row ends.
    let mut ends = vec![f64::NEG_INFINITY; timeline.channels.len()];
    for line in &lines {
        let (x, Some(&first), Some(&last)) = (line.x, line.rows.first(), line.rows.last()) else { continue };
        if many {
            for row in first..last {
                let _ = write!(path, "M{x:.1} {:.0}v{:.0}", row_top(row) + BAR, GAP + STRIP);
            }
        } else {
            let _ = write!(path, "M{x:.1} {:.0}V{:.0}", row_top(first), row_top(last) + BAR);
            let hint = escape(&hint(timeline, line.point));
            for row in &line.rows {
                let y = row_top(*row) + BAR / 2.0;
                let _ = writeln!(
                    dots,
                    r#"<circle cx="{x:.1}" cy="{y:.0}" r="3" fill="{INK}"><title>{hint}</title></circle>"#
                );
            }
        }
        if let (Some(end), false) = (ends.get_mut(first), many) {
            label(&mut labels, line, row_top(first) + BAR + GAP / 2.0, end);
        }
    }
    let (stroke, opacity) = if many { (0.7, 0.6) } else { (1.2, 1.0) };
    let _ = writeln!(
        out,
        r#"<path fill="none" stroke="{INK}" stroke-width="{stroke}" stroke-opacity="{opacity}" d="{path}"/>"#
    );
    out.push_str(&dots);
    out.push_str(&labels);
}

/// What is shown of a sync point: its mark, when it was, and who arrived from where.
fn hint(timeline: &Timeline, point: &SyncPoint) -> String {
    let mut hint = format!("{}, {}", point.key, time_text(point.release_ns.unwrap_or(0), 1_000_000));
    for arrival in &point.arrivals {
        let name = timeline.channels.iter().find(|c| c.channel == arrival.channel).map_or("", |c| &c.name);
        let _ = write!(hint, "; {name} {} line {}", arrival.file, arrival.line);
    }
    hint
}

/// Lines far enough from each other, from left to right.
fn lines<'a>(timeline: &'a Timeline, scale: &Scale) -> Vec<Line<'a>> {
    let count = timeline.channels.len();
    // By first and last row: the place of the last line.
    let mut drawn = vec![f64::NEG_INFINITY; count * count];
    let mut lines: Vec<Line<'a>> = Vec::new();
    for point in timeline.waits.iter() {
        let Some(release) = point.release_ns else { continue };
        let rows = rows_of(timeline, point);
        let (x, Some(&first), Some(&last)) = (scale.x(release), rows.first(), rows.last()) else { continue };
        let Some(latest) = drawn.get_mut(first * count + last) else { continue };
        if first == last || (x - *latest).abs() < NEAR {
            continue;
        }
        *latest = x;
        lines.push(Line { x, rows, point });
    }
    lines.sort_by(|a, b| a.x.total_cmp(&b.x));
    lines
}

/// The mark of a sync point inside the picture, unless it would lie over the one before, which ends at `end`.
fn label(out: &mut String, line: &Line<'_>, middle: f64, end: &mut f64) {
    let key = fit(&line.point.key, 11, LONGEST);
    let wide = width(&key, 11) + 6.0;
    let x = line.x.clamp(LEFT - 10.0 + wide / 2.0, WIDTH - 4.0 - wide / 2.0);
    let (left, upper) = (x - wide / 2.0, middle - 8.0);
    if left < *end + 3.0 {
        return;
    }
    *end = left + wide;
    let _ = writeln!(
        out,
        r##"<rect x="{left:.1}" y="{upper:.1}" width="{wide:.1}" height="16" rx="3" fill="#ffffff" stroke="#9aa5b1"/>"##
    );
    text(out, (x, middle + 4.0), 11, "middle", INK, &key);
}

fn rows_of(timeline: &Timeline, point: &SyncPoint) -> Vec<usize> {
    point.arrivals.iter().filter_map(|a| timeline.channels.iter().position(|c| c.channel == a.channel)).collect()
}
