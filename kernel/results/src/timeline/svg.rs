//! The timeline as a picture: a row for each channel with its tools above, the time below, lines where channels met.
//!
//! With more sync points than [`READABLE`], detail plots follow below the whole: the same rows, each for a part of the
//! time. *Invariant:* the size of the picture depends on its width in pixels, not on the length of the log.

mod critical;
mod layout;
mod marks;
mod rows;
mod scale;
mod sync_points;
mod tools;

use std::fmt::Write as _;

use super::Timeline;
use crate::summary::ChannelState;
use crate::svg::{fit, open, text, width};
use counterpoint_event::event::WorkClass;
use layout::{PlotLayout, windows};
use scale::{TimeScale, time_text};

const WIDTH: f64 = 1200.0;
/// Where the bars begin.
const LEFT: f64 = 150.0;
/// Where the picture's plot ends.
const RIGHT: f64 = WIDTH - 24.0;
/// Top of the first row.
const TOP: f64 = 84.0;
const BAR: f64 = 30.0;
/// Between the bars of a row and the tools of the next one at least.
const GAP: f64 = 26.0;
/// Sync points whose marks are readable in one plot.
const READABLE: usize = 40;
/// Height of the tools above the bars.
const STRIP: f64 = 16.0;
const INK: &str = "#1f2933";
const SOFT: &str = "#66727f";
const RED: &str = "#d62839";

const KINDS: [(WorkClass, &str, &str); 6] = [
    (WorkClass::Feed, "feed", "#2f7fc1"),
    (WorkClass::Rapid, "rapid", "#f2b134"),
    (WorkClass::Tool, "tool", "#8e5ea2"),
    (WorkClass::Dwell, "dwell", "#8593a0"),
    (WorkClass::Misc, "misc", "#3fa796"),
    (WorkClass::Wait, "wait", "url(#wait)"),
];

fn style(kind: WorkClass) -> (&'static str, &'static str) {
    KINDS.iter().find(|(k, ..)| *k == kind).map_or(("misc", "#3fa796"), |(_, name, color)| (name, color))
}

pub(super) fn draw(timeline: &Timeline) -> String {
    // Room for bars without an end, and for the word after a channel that did not end well.
    let open_ended = timeline
        .channels
        .iter()
        .any(|c| matches!(c.state, ChannelState::Blocked | ChannelState::Alarmed | ChannelState::Stopped));
    let right = if open_ended { RIGHT - 100.0 } else { RIGHT };
    let span = (0, timeline.makespan_ns);
    let windows = windows(timeline);
    let whole = PlotLayout::new(timeline, TimeScale::new(span, LEFT, right), TOP, windows.is_empty());
    let mut bottom = whole.bottom();
    let details: Vec<PlotLayout> = windows
        .into_iter()
        .map(|window| {
            let layout = PlotLayout::new(timeline, TimeScale::new(window, LEFT, RIGHT), bottom + 60.0, true);
            bottom = layout.bottom();
            layout
        })
        .collect();
    let mut out = String::with_capacity(64 * 1024);
    open(&mut out, WIDTH, bottom + 44.0);
    out.push_str(concat!(
        r#"<defs><pattern id="wait" width="6" height="6" patternUnits="userSpaceOnUse" patternTransform="rotate(45)">"#,
        r##"<rect width="6" height="6" fill="#edf0f3"/><rect width="2" height="6" fill="#a9b4bf"/></pattern></defs>"##,
        "\n"
    ));
    title(&mut out, timeline);
    legend(&mut out, open_ended, critical::is_shown(timeline));
    plot(&mut out, timeline, &whole, true);
    for (index, layout) in details.iter().enumerate() {
        let (from, to) = layout.scale.window();
        let heading = format!("{} to {}", time_text(from, 1_000_000), time_text(to, 1_000_000));
        text(&mut out, (16.0, layout.top - 4.0), 12, "start", SOFT, &heading);
        let (y, height) = (layout.top - 10.0, layout.bottom() - layout.top + 40.0);
        let _ = writeln!(
            out,
            r#"<clipPath id="part{index}"><rect x="0" y="{y:.0}" width="{:.0}" height="{height:.0}"/></clipPath><g clip-path="url(#part{index})">"#,
            RIGHT + 1.0
        );
        plot(&mut out, timeline, layout, false);
        out.push_str("</g>\n");
    }
    out.push_str("</svg>\n");
    out
}

/// The rows of all channels for the time of a layout; `whole`: their names have their times beside them.
fn plot(out: &mut String, timeline: &Timeline, layout: &PlotLayout, whole: bool) {
    layout.scale.draw(out, layout.top - 10.0, layout.bottom());
    for (index, channel) in timeline.channels.iter().enumerate() {
        rows::draw(out, timeline, channel, (layout, index), whole);
        tools::draw(out, channel, layout.row_top(index) - STRIP, &layout.scale);
    }
    critical::draw(out, timeline, layout);
    sync_points::draw(out, timeline, layout);
}

fn title(out: &mut String, timeline: &Timeline) {
    let mut programs: Vec<&str> =
        timeline.channels.iter().map(|c| c.program.as_str()).filter(|p| !p.is_empty()).collect();
    programs.dedup();
    // A job that has not reached its end has no cycle time.
    let until = if timeline.failed { "stopped after" } else { "cycle time" };
    let mut total = format!("{until} {}", time_text(timeline.makespan_ns, 1_000_000));
    let waits = timeline.waits.iter().filter(|w| w.release_ns.is_some()).count();
    if waits > 0 {
        let _ = write!(total, ", {waits} sync point{}", if waits == 1 { "" } else { "s" });
    }
    if timeline.failed {
        total = format!("FAILED, {total}");
    }
    let machine = format!("{}{}", if programs.is_empty() { "" } else { " on " }, timeline.machine);
    let machine = fit(&machine, 17, 360.0);
    let room = RIGHT - 16.0 - width(&total, 15) - 24.0 - width(&machine, 17);
    let line = format!("{}{machine}", fit(&programs.join(" + "), 17, room));
    text(out, (16.0, 27.0), 17, "start", INK, &line);
    text(out, (RIGHT, 27.0), 15, "end", if timeline.failed { RED } else { INK }, &total);
}

fn legend(out: &mut String, open_ended: bool, critical: bool) {
    let mut x = LEFT;
    let blocked = (open_ended).then_some(("blocked", RED));
    for (name, color) in KINDS.iter().map(|(_, name, color)| (*name, *color)).chain(blocked) {
        let _ = writeln!(out, r#"<rect x="{x:.0}" y="42" width="14" height="12" fill="{color}"/>"#);
        text(out, (x + 19.0, 52.5), 12, "start", SOFT, name);
        x += 34.0 + 7.0 * name.len() as f64;
    }
    if critical {
        critical::legend(out, x);
    }
}
