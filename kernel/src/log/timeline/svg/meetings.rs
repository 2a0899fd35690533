//! Lines where channels met.
//!
//! Of meetings closer together than a few pixels one line is drawn; a mark is written only where its meeting stands
//! alone. Many lines are drawn between the rows only, so that the bars stay readable.

use std::fmt::Write as _;

use super::scale::Scale;
use super::{BAR, GAP, INK, LEFT, row_top};
use crate::log::summary::Meeting;
use crate::log::svg::text;
use crate::log::timeline::Timeline;

/// Least distance of two lines between the same rows, px.
const NEAR: f64 = 2.5;

/// More lines than this are thin and leave the bars free.
const MANY: usize = 150;

/// A line to be drawn.
struct Line<'a> {
    x: f64,
    rows: Vec<usize>,
    key: &'a str,
    /// Other meetings are at least this far away, px.
    room: f64,
}

pub(super) fn draw(out: &mut String, timeline: &Timeline, scale: &Scale) {
    let lines = lines(timeline, scale);
    if lines.is_empty() {
        return;
    }
    let (mut path, mut dots, mut labels) = (String::new(), String::new(), String::new());
    let many = lines.len() > MANY;
    for line in &lines {
        let (x, Some(&first), Some(&last)) = (line.x, line.rows.first(), line.rows.last()) else { continue };
        if many {
            for row in first..last {
                let _ = write!(path, "M{x:.1} {:.0}v{GAP:.0}", row_top(row) + BAR);
            }
        } else {
            let _ = write!(path, "M{x:.1} {:.0}V{:.0}", row_top(first), row_top(last) + BAR);
            for row in &line.rows {
                let _ = write!(dots, "M{x:.1} {:.0}h0", row_top(*row) + BAR / 2.0);
            }
        }
        label(&mut labels, line, row_top(first) + BAR + GAP / 2.0);
    }
    let (stroke, opacity) = if many { (0.7, 0.6) } else { (1.2, 1.0) };
    let _ = writeln!(
        out,
        r#"<path fill="none" stroke="{INK}" stroke-width="{stroke}" stroke-opacity="{opacity}" d="{path}"/>"#
    );
    if !many {
        let _ =
            writeln!(out, r#"<path fill="none" stroke="{INK}" stroke-width="6" stroke-linecap="round" d="{dots}"/>"#);
    }
    out.push_str(&labels);
}

/// Lines far enough from each other, and how much room each has.
fn lines<'a>(timeline: &'a Timeline, scale: &Scale) -> Vec<Line<'a>> {
    let count = timeline.channels.len();
    // By first and last row: where the last line stands. By the gap of the mark: the last line there.
    let mut stands = vec![f64::NEG_INFINITY; count * count];
    let mut gaps: Vec<Option<(usize, f64)>> = vec![None; count];
    let mut lines: Vec<Line<'a>> = Vec::new();
    for meeting in timeline.waits.iter() {
        let Some(release) = meeting.release_ns else { continue };
        let rows = rows_of(timeline, meeting);
        let (x, Some(&first), Some(&last)) = (scale.x(release), rows.first(), rows.last()) else { continue };
        let (Some(stand), Some(gap)) = (stands.get_mut(first * count + last), gaps.get_mut(first)) else { continue };
        if first == last {
            continue;
        }
        let mut room = f64::INFINITY;
        if let Some((index, before)) = gap {
            room = (x - *before).abs();
            if let Some(line) = lines.get_mut(*index) {
                line.room = line.room.min(room);
            }
            *before = x;
        }
        if (x - *stand).abs() < NEAR {
            continue;
        }
        *stand = x;
        *gap = Some((lines.len(), x));
        lines.push(Line { x, rows, key: &meeting.key, room });
    }
    lines
}

/// The mark of a meeting, if it fits between its neighbours.
fn label(out: &mut String, line: &Line<'_>, middle: f64) {
    let width = 6.6 * line.key.chars().count() as f64 + 8.0;
    if line.room < width + 4.0 || width > 300.0 {
        return;
    }
    let (x, upper) = (line.x.max(LEFT + width / 2.0 - 10.0), middle - 8.0);
    let left = x - width / 2.0;
    let _ = writeln!(
        out,
        r##"<rect x="{left:.1}" y="{upper:.1}" width="{width:.1}" height="16" rx="3" fill="#ffffff" stroke="#9aa5b1"/>"##
    );
    text(out, (x, middle + 4.0), 11, "middle", INK, line.key);
}

fn rows_of(timeline: &Timeline, meeting: &Meeting) -> Vec<usize> {
    meeting.arrivals.iter().filter_map(|a| timeline.channels.iter().position(|c| c.channel == a.channel)).collect()
}
