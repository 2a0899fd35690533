//! Holes: places at which a tool goes down and returns, seen along the tool.
//!
//! *Invariant:* a tool that leaves a place sideways at its feed depth has made no hole; each place has one mark for
//! each tool, regardless of the number of pecks.

use std::fmt::Write as _;

use rustc_hash::FxHashSet;

use super::frame::PictureView;
use super::place;
use crate::svg::{escape, px};
use crate::toolpath::store::{RecordedPath, Stroke};
use crate::toolpath::{ChannelToolpath, Toolpath};
use counterpoint_event::event::FileId;

/// Marks of a path at most.
const MOST: usize = 5_000;
/// Radius of a mark, px.
const RADIUS: f64 = 3.5;
/// Moves within this stay at a place.
const STILL: f64 = 1e-3;

/// A hole.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct DrawnHole {
    at: [f64; 3],
    tool: u32,
    file: FileId,
    line: u32,
}

/// The holes of a path in their order, [`MOST`] at most.
pub(super) fn holes(path: &RecordedPath) -> Vec<DrawnHole> {
    let mut found = Vec::new();
    let mut from = [0.0; 3];
    // The deepest feed at the place where the tool is.
    let mut deepest: Option<DrawnHole> = None;
    for (mark, moves) in path.sections() {
        for step in moves {
            let to = step.to();
            let stays = (to[0] - from[0]).abs() < STILL && (to[1] - from[1]).abs() < STILL;
            if !stays {
                found.extend(deepest.take().filter(|hole| from[2] > hole.at[2] + STILL));
                if found.len() >= MOST {
                    return found;
                }
            }
            let feeds = matches!(step.stroke(), Stroke::Feed | Stroke::Thread) && path.curve(step).is_none();
            if stays && feeds && to[2] < from[2] - STILL && deepest.is_none_or(|hole| to[2] < hole.at[2]) {
                deepest = Some(DrawnHole { at: to, tool: mark.tool, file: mark.file, line: step.line });
            }
            from = to;
        }
    }
    found.extend(deepest.filter(|hole| from[2] > hole.at[2] + STILL));
    found
}

/// Draws the marks.
pub(super) fn draw<'c>(
    out: &mut String,
    (toolpath, channel): (&Toolpath, &ChannelToolpath),
    path: &RecordedPath,
    frame: &PictureView,
    color: impl Fn(u32) -> &'c str,
) {
    let mut drawn = FxHashSet::default();
    for hole in holes(path) {
        let [x, y] = frame.pixel(&hole.at);
        if !drawn.insert((hole.tool, px(x), px(y))) {
            continue;
        }
        let place = place(toolpath, channel, (hole.tool, hole.file));
        let hint = escape(&format!("{place}line {}: hole to Z{:.3}", hole.line, hole.at[2] * toolpath.shown()));
        let _ = writeln!(
            out,
            r##"<g stroke="{}" stroke-width="1.4"><circle cx="{x:.1}" cy="{y:.1}" r="{RADIUS}" fill="#ffffff"><title>{hint}</title></circle><path d="M{:.1} {y:.1}h{w:.1}M{x:.1} {:.1}v{w:.1}"/></g>"##,
            color(hole.tool),
            x - RADIUS,
            y - RADIUS,
            w = RADIUS * 2.0
        );
    }
}

/// Whether the path has a hole, for the legend.
pub(super) fn has_any(path: &RecordedPath) -> bool {
    !holes(path).is_empty()
}
