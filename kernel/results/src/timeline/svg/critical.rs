//! The critical path: a line below the bars of the channel that decides, and from one channel to the next.
//!
//! *Invariant:* stretches narrower than half a pixel leave no line of their own, so the picture stays small.

use std::fmt::Write as _;

use super::layout::PlotLayout;
use super::{BAR, SOFT};
use crate::analysis::Analysis;
use crate::summary::ChannelState;
use crate::svg::text;
use crate::timeline::Timeline;

/// Colour of the line.
const COLOR: &str = "#c2185b";
/// Distance of the line from the bars, px.
const BELOW: f64 = 3.0;
/// Least length of a part, px.
const SHORTEST: f64 = 0.5;

/// Whether channels wait for each other, so there is a path to show.
pub(super) fn is_shown(timeline: &Timeline) -> bool {
    timeline.waits.iter().any(|point| point.release_ns.is_some() && point.arrivals.len() > 1 || point.by != 0)
}

/// Entry of the legend at a place.
pub(super) fn legend(out: &mut String, x: f64) {
    let _ = writeln!(out, r#"<path stroke="{COLOR}" stroke-width="2.5" d="M{x:.0} 48h14"/>"#);
    text(out, (x + 19.0, 52.5), 12, "start", SOFT, "critical path");
}

pub(super) fn draw(out: &mut String, timeline: &Timeline, layout: &PlotLayout) {
    let scale = &layout.scale;
    if !is_shown(timeline) {
        return;
    }
    let ran = timeline.channels.iter().filter(|channel| channel.state != ChannelState::NotStarted);
    let ends: Vec<(u16, i64)> = ran.map(|channel| (channel.channel, channel.end_ns)).collect();
    let row = |channel: u16| timeline.channels.iter().position(|known| known.channel == channel);
    let mut path = String::new();
    let mut at: Option<(f64, f64)> = None;
    for (channel, from, to) in Analysis::of(&ends, &timeline.waits).critical {
        let Some(y) = row(channel).map(|row| layout.row_top(row) + BAR + BELOW) else { continue };
        if !scale.sees(from, to) {
            continue;
        }
        // A plot of details shows a part of the time only.
        let (first, last) = scale.window();
        let (from, to) = (scale.x(from.max(first)), scale.x(to.min(last)));
        if to - from < SHORTEST {
            continue;
        }
        match at {
            Some((_, level)) if level == y => {}
            Some(_) => {
                let _ = write!(path, "H{from:.1}V{y:.0}");
            }
            None => {
                let _ = write!(path, "M{from:.1} {y:.0}");
            }
        }
        let _ = write!(path, "H{to:.1}");
        at = Some((to, y));
    }
    let _ = writeln!(
        out,
        r#"<path fill="none" stroke="{COLOR}" stroke-width="2.5" d="{path}"><title>critical path: the job ends earlier only if work above this line takes less time</title></path>"#
    );
}
