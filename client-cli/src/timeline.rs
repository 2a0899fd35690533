//! The timeline as text: one bar of coloured cells per channel, scaled to the width of the terminal.
//!
//! Each cell shows the work with the largest share of its time span.

use std::fmt::Write as _;

use anstyle::{AnsiColor, Color, Style};
use serde::Deserialize;

use crate::say::styled;
use crate::text::time;

/// timeline.json as far as the drawing needs it.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct TextTimeline {
    makespan_ns: i64,
    channels: Vec<TimelineLane>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct TimelineLane {
    name: String,
    bars: Vec<LaneBar>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct LaneBar {
    kind: LaneBarKind,
    t_ns: i64,
    dur_ns: i64,
}

#[derive(Debug, Default, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum LaneBarKind {
    Rapid,
    Feed,
    Tool,
    Dwell,
    Wait,
    #[default]
    #[serde(other)]
    Misc,
}

const KINDS: [(LaneBarKind, char, AnsiColor, &str); 6] = [
    (LaneBarKind::Feed, '█', AnsiColor::Green, "feed"),
    (LaneBarKind::Rapid, '▒', AnsiColor::Yellow, "rapid"),
    (LaneBarKind::Tool, 'T', AnsiColor::Magenta, "tool"),
    (LaneBarKind::Dwell, 'd', AnsiColor::Cyan, "dwell"),
    (LaneBarKind::Wait, '·', AnsiColor::Red, "wait"),
    (LaneBarKind::Misc, '-', AnsiColor::Blue, "other"),
];

fn style(colour: AnsiColor) -> Style {
    Style::new().fg_color(Some(Color::Ansi(colour)))
}

/// Draws the timeline `width` columns wide.
pub(crate) fn draw(timeline: &TextTimeline, width: usize) -> String {
    if timeline.makespan_ns <= 0 {
        return String::new();
    }
    let label = timeline.channels.iter().map(|c| c.name.chars().count()).max().unwrap_or(0).min(16);
    let cells = width.saturating_sub(label + 4).clamp(10, 400);
    let mut out = String::from("\n");
    for channel in &timeline.channels {
        let name: String = channel.name.chars().take(label).collect();
        let _ = writeln!(out, "  {name:>label$} {}", row(channel, timeline.makespan_ns, cells));
    }
    let end = time(timeline.makespan_ns);
    let _ = writeln!(out, "  {:label$} 00:00.000{end:>rest$}", "", rest = cells.saturating_sub(9));
    let legend = KINDS.map(|(_, mark, colour, name)| format!("{} {name}", styled(style(colour), mark)));
    let _ = writeln!(out, "  {:label$} {}", "", legend.join("  "));
    out
}

fn row(channel: &TimelineLane, makespan: i64, cells: usize) -> String {
    let mut shares = vec![[0f64; KINDS.len()]; cells];
    let scale = cells as f64 / makespan as f64;
    for bar in &channel.bars {
        let Some(kind) = KINDS.iter().position(|k| k.0 == bar.kind) else { continue };
        let (start, end) = (bar.t_ns as f64 * scale, (bar.t_ns + bar.dur_ns) as f64 * scale);
        let (first, last) = (start as usize, (end as usize).min(cells.saturating_sub(1)));
        for (i, cell) in shares.iter_mut().enumerate().take(last + 1).skip(first) {
            let share = end.min(i as f64 + 1.0) - start.max(i as f64);
            if let Some(slot) = cell.get_mut(kind) {
                *slot += share.max(0.0);
            }
        }
    }
    let mut out = String::new();
    let mut run: Option<(usize, usize)> = None;
    for kind in shares.iter().map(largest).chain([usize::MAX]) {
        match &mut run {
            Some((of, length)) if *of == kind => *length += 1,
            _ => {
                if let Some((of, length)) = run.replace((kind, 1)) {
                    paint(&mut out, of, length);
                }
            }
        }
    }
    out
}

/// Index of the kind with the largest share; `KINDS.len()` for an empty cell.
fn largest(cell: &[f64; KINDS.len()]) -> usize {
    let best = cell.iter().enumerate().filter(|(_, share)| **share > 0.0).max_by(|a, b| a.1.total_cmp(b.1));
    best.map_or(KINDS.len(), |(kind, _)| kind)
}

fn paint(out: &mut String, kind: usize, length: usize) {
    match KINDS.get(kind) {
        Some((_, mark, colour, _)) => {
            out.push_str(&styled(style(*colour), mark.to_string().repeat(length)));
        }
        None => out.push_str(&" ".repeat(length)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_show_the_largest_share() {
        let text = r#"{"makespan_ns":100,"channels":[{"name":"A","bars":[{"kind":"rapid","t_ns":0,"dur_ns":50},
            {"kind":"feed","t_ns":50,"dur_ns":25},{"kind":"new","t_ns":75,"dur_ns":5}]},{"name":"B","bars":[]}]}"#;
        let drawn = draw(&serde_json::from_str(text).unwrap(), 25);
        let plain = anstream::adapter::strip_str(&drawn).to_string();
        let first = plain.lines().nth(1).unwrap();
        assert_eq!(first, format!("  A {}{}-{}", "▒".repeat(10), "█".repeat(5), " ".repeat(4)), "{plain}");
    }
}
