//! Lines where channels met.
//!
//! Of meetings closer together than a few pixels one line is drawn; a mark is written only where there is room.

use std::fmt::Write as _;

use super::scale::Scale;
use super::{BAR, GAP, INK, row_top};
use crate::log::summary::Meeting;
use crate::log::svg::text;
use crate::log::timeline::Timeline;

/// Least distance of two lines between the same rows, px.
const NEAR: f64 = 2.5;

pub(super) fn draw(out: &mut String, timeline: &Timeline, scale: &Scale) {
    let rows = timeline.channels.len();
    // By first and last row: where the last line stands.
    let mut lines = vec![f64::NEG_INFINITY; rows * rows];
    // By gap between rows: where the last mark ends.
    let mut marks = vec![f64::NEG_INFINITY; rows];
    let mut path = String::new();
    let mut dots = String::new();
    let mut labels = String::new();
    for meeting in &timeline.waits {
        let Some(release) = meeting.release_ns else { continue };
        let places = rows_of(timeline, meeting);
        let (Some(&first), Some(&last)) = (places.first(), places.last()) else { continue };
        let x = scale.x(release);
        let Some(line) = lines.get_mut(first * rows + last) else { continue };
        if first == last || (x - *line).abs() < NEAR {
            continue;
        }
        *line = x;
        let _ = write!(path, "M{x:.1} {:.0}V{:.0}", row_top(first), row_top(last) + BAR);
        for row in &places {
            let _ = write!(dots, "M{x:.1} {:.0}h0", row_top(*row) + BAR / 2.0);
        }
        let width = 6.6 * meeting.key.chars().count() as f64 + 8.0;
        let Some(mark) = marks.get_mut(first) else { continue };
        if x - width / 2.0 < *mark || meeting.key.chars().count() > 40 {
            continue;
        }
        *mark = x + width / 2.0 + 4.0;
        let middle = row_top(first) + BAR + GAP / 2.0;
        let (left, upper) = (x - width / 2.0, middle - 8.0);
        let _ = writeln!(
            labels,
            r##"<rect x="{left:.1}" y="{upper:.1}" width="{width:.1}" height="16" rx="3" fill="#ffffff" stroke="#9aa5b1"/>"##
        );
        text(&mut labels, (x, middle + 4.0), 11, "middle", INK, &meeting.key);
    }
    let count = path.matches('M').count();
    let (stroke, opacity) = if count > 150 { (0.6, 0.55) } else { (1.2, 1.0) };
    if count > 0 {
        let _ = writeln!(
            out,
            r#"<path fill="none" stroke="{INK}" stroke-width="{stroke}" stroke-opacity="{opacity}" d="{path}"/>"#
        );
        if count <= 150 {
            let _ = writeln!(
                out,
                r#"<path fill="none" stroke="{INK}" stroke-width="6" stroke-linecap="round" d="{dots}"/>"#
            );
        }
        out.push_str(&labels);
    }
}

fn rows_of(timeline: &Timeline, meeting: &Meeting) -> Vec<usize> {
    meeting.arrivals.iter().filter_map(|a| timeline.channels.iter().position(|c| c.channel == a.channel)).collect()
}
