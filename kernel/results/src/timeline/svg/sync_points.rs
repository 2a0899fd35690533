//! Lines where channels met.
//!
//! Many lines are drawn between the rows only and without marks, so that the bars stay readable.

use std::fmt::Write as _;

use super::layout::PlotLayout;
use super::marks::{MANY, PlotLine};
use super::scale::time_text;
use super::{BAR, INK};
use crate::svg::{escape, text};
use crate::timeline::Timeline;

/// Sync points that a hint names at most.
const NAMED: usize = 12;

pub(super) fn draw(out: &mut String, timeline: &Timeline, layout: &PlotLayout) {
    let lines = &layout.marks.lines;
    if lines.is_empty() {
        return;
    }
    let (mut path, mut dots) = (String::new(), String::new());
    let many = lines.len() > MANY;
    for line in lines {
        let (x, Some(&first), Some(&last)) = (line.x, line.rows.first(), line.rows.last()) else { continue };
        if many {
            for row in first..last {
                let _ = write!(path, "M{x:.1} {:.0}v{:.0}", layout.row_top(row) + BAR, layout.between());
            }
            continue;
        }
        let _ = write!(path, "M{x:.1} {:.0}V{:.0}", layout.row_top(first), layout.row_top(last) + BAR);
        let hint = escape(&hint(timeline, line));
        for row in &line.rows {
            let y = layout.row_top(*row) + BAR / 2.0;
            let _ =
                writeln!(dots, r#"<circle cx="{x:.1}" cy="{y:.1}" r="3" fill="{INK}"><title>{hint}</title></circle>"#);
        }
    }
    let (stroke, opacity) = if many { (0.7, 0.6) } else { (1.2, 1.0) };
    let _ = writeln!(
        out,
        r#"<path fill="none" stroke="{INK}" stroke-width="{stroke}" stroke-opacity="{opacity}" d="{path}"/>"#
    );
    out.push_str(&dots);
    for mark in &layout.marks.marks {
        let middle = layout.mark_middle(mark.row, mark.level);
        let _ = writeln!(
            out,
            r##"<rect x="{:.1}" y="{:.1}" width="{:.1}" height="16" rx="3" fill="#ffffff" stroke="#9aa5b1"/>"##,
            mark.left,
            middle - 8.0,
            mark.wide
        );
        text(out, (mark.left + mark.wide / 2.0, middle + 4.0), 11, "middle", INK, &mark.text);
    }
}

/// The hint of a line: for each sync point its mark, its time, and the place of each arrival.
fn hint(timeline: &Timeline, line: &PlotLine) -> String {
    let mut hint = String::new();
    for point in line.points.iter().take(NAMED).filter_map(|index| timeline.waits.get(*index)) {
        let separator = if hint.is_empty() { "" } else { " | " };
        let _ = write!(hint, "{separator}{}, {}", point.key, time_text(point.release_ns.unwrap_or(0), 1_000_000));
        for arrival in &point.arrivals {
            let name = timeline.channels.iter().find(|c| c.channel == arrival.channel).map_or("", |c| &c.name);
            let _ = write!(hint, "; {name} {} line {}", arrival.file, arrival.line);
        }
    }
    if line.points.len() > NAMED {
        let _ = write!(hint, " | and {} more", line.points.len() - NAMED);
    }
    hint
}
