//! Where channels stopped before the end of their programs.
//!
//! *Invariant:* a job that has not succeeded says so in the title, even if no channel has a place.

use std::fmt::Write as _;

use super::RED;
use super::frame::PictureView;
use crate::summary::ChannelState;
use crate::svg::{escape, text};
use crate::toolpath::store::RecordedPath;
use crate::toolpath::{ChannelToolpath, StopPlace, Toolpath};

/// Half the size of a mark, px.
const SIZE: f64 = 6.0;

/// `FAILED: alarm at upper.nc line 12`; none for a job that has succeeded.
pub(super) fn sentence(toolpath: &Toolpath) -> Option<String> {
    if !toolpath.failed {
        return None;
    }
    let stops: Vec<&StopPlace> = toolpath.channels.iter().filter_map(|channel| channel.stop.as_ref()).collect();
    let first = stops.iter().find(|stop| stop.state == ChannelState::Alarmed).or(stops.first());
    Some(first.map_or_else(|| "FAILED".to_owned(), |stop| format!("FAILED: {}", phrase(stop))))
}

/// `alarm at upper.nc line 12`.
fn phrase(stop: &StopPlace) -> String {
    let what = match stop.state {
        ChannelState::Alarmed => "alarm",
        ChannelState::Blocked => "endless wait",
        _ => "stopped",
    };
    if stop.line == 0 { what.to_owned() } else { format!("{what} at {} line {}", stop.file, stop.line) }
}

/// A cross at the end of the path. The outline of its label is a separate text below it: a renderer that does not know
/// `paint-order` would draw the outline over the letters.
pub(super) fn draw(
    out: &mut String,
    channel: &ChannelToolpath,
    stop: &StopPlace,
    path: &RecordedPath,
    frame: &PictureView,
) {
    let Some(last) = path.moves.last() else { return };
    let [x, y] = frame.pixel_inside(&last.to(), SIZE);
    let hint = escape(&format!("{}: {}", channel.name, phrase(stop)));
    let _ = writeln!(
        out,
        r#"<path stroke="{RED}" stroke-width="3" d="M{:.1} {:.1}l{w:.1} {w:.1}m0-{w:.1}l-{w:.1} {w:.1}"><title>{hint}</title></path>"#,
        x - SIZE,
        y - SIZE,
        w = SIZE * 2.0
    );
    let (anchor, beside) = if frame.is_right_half(x) { ("end", -SIZE - 4.0) } else { ("start", SIZE + 4.0) };
    let (at, label) = ((x + beside, y + 4.0), phrase(stop));
    let ground = r##"<g stroke="#ffffff" stroke-width="4" stroke-linejoin="round" aria-hidden="true">"##;
    let _ = writeln!(out, "{ground}");
    text(out, at, 12, anchor, "#ffffff", &label);
    out.push_str("</g>\n");
    text(out, at, 12, anchor, RED, &label);
}
