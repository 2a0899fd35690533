//! The tools of one channel, above its bars.
//!
//! A tool with room for its number has a name, cut with an ellipsis; narrow ones show it under the mouse only.
//! Invariant: a row has no more marks than it has pixels.

use std::fmt::Write as _;

use super::scale::{TimeScale, time_text};
use super::{SOFT, STRIP};
use crate::spans::ToolSpan;
use crate::svg::{escape, fit, text, width};
use crate::timeline::ChannelTimeline;

/// Grounds of neighbours.
const GROUNDS: [&str; 2] = ["#e3e9f0", "#f3f5f8"];
/// Least width of a tool, px.
const LEAST: f64 = 1.5;

/// `T3 GROOVE`.
pub(super) fn name(span: &ToolSpan) -> String {
    if span.operation.is_empty() { format!("T{}", span.tool) } else { format!("T{} {}", span.tool, span.operation) }
}

pub(super) fn draw(out: &mut String, channel: &ChannelTimeline, top: f64, scale: &TimeScale) {
    let mut free = f64::NEG_INFINITY;
    let mut grounds = GROUNDS.into_iter().cycle();
    for span in channel.tools.iter().filter(|span| scale.sees(span.t_ns, span.end_ns)) {
        let (from, to) = scale.within(span.t_ns, span.end_ns);
        let (x, end) = (scale.x(from), scale.x(to));
        if end - x < LEAST && x < free {
            continue;
        }
        let wide = (end - x).max(LEAST);
        free = x + wide;
        let ground = grounds.next().unwrap_or(SOFT);
        let name = name(span);
        let time = time_text(span.end_ns - span.t_ns, 1_000_000);
        let hint = escape(&format!("{name}, {time}, {} line {}", span.file, span.line));
        let _ = writeln!(
            out,
            r#"<rect x="{x:.1}" y="{top:.0}" width="{wide:.1}" height="{:.0}" fill="{ground}"><title>{hint}</title></rect>"#,
            STRIP - 2.0
        );
        let number = format!("T{}", span.tool);
        let label = fit(&name, 10, wide - 6.0);
        let label = if label.chars().count() < number.chars().count() { String::new() } else { label };
        let label = match label {
            label if label.is_empty() && width(&number, 10) <= wide - 2.0 => number,
            label => label,
        };
        if !label.is_empty() {
            text(out, (x + 3.0, top + 10.5), 10, "start", "#3b4754", &label);
        }
    }
}
