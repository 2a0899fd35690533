//! The toolpath as a picture: for lathes Z and X, and the face of the part where live tools work; for mills from above,
//! from the front, and in space.
//!
//! The frame fits the cutting moves; rapids beyond it are cut at its border. Every tool has a colour, rapids are grey,
//! holes and places where a channel stopped have marks, and every line says on hover which block it comes from.
//! *Invariant:* aspect is preserved, all views with scales have one scale, and of a long path only lines that change
//! the picture are drawn, in a bounded number of pieces.

mod canvas;
mod colors;
mod frame;
mod holes;
mod legend;
mod pen;
mod pieces;
mod sight;
mod stops;

use std::fmt::Write as _;

use super::store::{RecordedPath, Stroke};
use super::{ChannelToolpath, Toolpath};
use crate::svg::{escape, fit, open, text, width};
use counterpoint_event::event::FileId;
use frame::{PictureBounds, PictureView};
use legend::Palette;
use pieces::{PathPiece, pieces};
use sight::{Sight, ViewedPath, sights};

const WIDTH: f64 = 1200.0;
const LEFT: f64 = 64.0;
const RIGHT: f64 = WIDTH - 24.0;
/// Top of the first view below a legend of one row.
const TOP: f64 = 78.0;
/// Height that all views share at most.
const HEIGHT: f64 = 760.0;
const INK: &str = "#1f2933";
const SOFT: &str = "#66727f";
const RED: &str = "#d62839";
/// Below a view, for its scale and the heading of the next one.
const BETWEEN: f64 = 56.0;
/// How the kinds of moves are drawn, those below first.
const KINDS: [(Stroke, &str, &str); 4] = [
    (Stroke::Start, "change of frame", r##"stroke="#9aa5b1" stroke-width="1.2" stroke-dasharray="1.2 4.8""##),
    (Stroke::Rapid, "rapid", r##"stroke="#9aa5b1" stroke-width="0.8" stroke-dasharray="2 2""##),
    (Stroke::Feed, "feed", r#"stroke-width="1.4""#),
    (Stroke::Thread, "thread", r#"stroke-width="2.6" stroke-dasharray="1.5 2""#),
];

pub(super) fn draw(toolpath: &Toolpath) -> String {
    let palette = Palette::new(toolpath);
    let frames = frames(toolpath, TOP + palette.height());
    let top = frames.last().map_or(TOP, |frame| frame.bottom + BETWEEN);
    let paths: Vec<String> = frames.iter().map(|frame| strokes(toolpath, frame, &palette)).collect();
    let mut out = String::with_capacity(paths.iter().map(String::len).sum::<usize>() + 16 * 1024);
    open(&mut out, WIDTH, top - 12.0);
    title(&mut out, toolpath);
    palette.draw(&mut out);
    let (unit, shown) = (toolpath.program_unit.name(), toolpath.shown());
    for (index, (frame, paths)) in frames.iter().zip(&paths).enumerate() {
        frame.draw(&mut out, index, (unit, shown), paths);
    }
    out.push_str("</svg>\n");
    out
}

/// The views, one below the other from `top` on. All with scales count the same pixels per unit.
fn frames(toolpath: &Toolpath, mut top: f64) -> Vec<PictureView> {
    let bounds = |source| PictureBounds::of(paths(toolpath, source));
    let sights: Vec<(Sight, PictureBounds)> =
        sights(toolpath).into_iter().map(|sight| (sight, bounds(sight.source).seen_by(sight))).collect();
    let common = scale(sights.iter().filter(|(sight, _)| sight.has_scales()), HEIGHT);
    let mut frames = Vec::new();
    for (sight, bounds) in &sights {
        let scale = if sight.has_scales() { common } else { scale(std::iter::once(&(*sight, *bounds)), HEIGHT / 2.0) };
        let frame = PictureView::new(*sight, bounds, scale, top);
        top = frame.bottom + BETWEEN;
        frames.push(frame);
    }
    frames
}

/// Paths of all channels that a view shows, each with whether it is seen below the turning axis.
fn paths(toolpath: &Toolpath, source: ViewedPath) -> impl Iterator<Item = (&RecordedPath, bool)> + Clone {
    toolpath.channels.iter().filter_map(move |channel| match source {
        ViewedPath::Path => Some((&channel.path, channel.lower)),
        ViewedPath::Face => channel.face.as_ref().map(|path| (path, false)),
    })
}

/// Pixels per unit that fit all of these views into a height.
fn scale<'a>(sights: impl Iterator<Item = &'a (Sight, PictureBounds)> + Clone, height: f64) -> f64 {
    let heights: f64 = sights.clone().map(|(_, bounds)| bounds.span(1)).sum();
    let width = sights.clone().map(|(_, bounds)| bounds.span(0)).fold(0.0, f64::max);
    let free = height - BETWEEN * (sights.count() as f64 - 1.0);
    ((RIGHT - LEFT) / width).min(free / heights)
}

/// All channels in one frame.
fn strokes(toolpath: &Toolpath, frame: &PictureView, palette: &Palette) -> String {
    let (mut out, mut marks) = (String::new(), String::new());
    for (index, channel) in toolpath.channels.iter().enumerate() {
        let (path, frame) = match (frame.sight.source, &channel.face) {
            (ViewedPath::Path, _) => (&channel.path, frame.of(channel.lower)),
            (ViewedPath::Face, Some(face)) => (face, frame.clone()),
            (ViewedPath::Face, None) => continue,
        };
        let pieces = pieces(path, &frame, frame.sight.source == ViewedPath::Path);
        let drawn: usize = pieces.iter().filter(|p| p.stroke == Stroke::Feed).map(|p| p.d.len()).sum();
        for of_tool in pieces.chunk_by(|a, b| a.tool == b.tool) {
            let tool = of_tool.first().map_or(0, |piece| piece.tool);
            let _ = writeln!(out, r#"<g stroke="{}">"#, palette.color(index, tool));
            for (stroke, _, style) in KINDS {
                let mut all = of_tool.iter().filter(|piece| piece.stroke == stroke).peekable();
                if all.peek().is_none() {
                    continue;
                }
                // Many lines get thinner, so that they stay apart.
                let _ = match (stroke, drawn) {
                    (Stroke::Feed, 150_000..400_000) => writeln!(out, r#"<g stroke-width="0.8">"#),
                    (Stroke::Feed, 400_000..) => writeln!(out, r#"<g stroke-width="0.45">"#),
                    _ => writeln!(out, "<g {style}>"),
                };
                for piece in all {
                    let hint = escape(&hint(toolpath, channel, piece));
                    let _ = writeln!(out, r#"<path d="{}"><title>{hint}</title></path>"#, piece.d);
                }
                out.push_str("</g>\n");
            }
            out.push_str("</g>\n");
        }
        if frame.sight.shows_holes {
            holes::draw(&mut out, (toolpath, channel), path, &frame, |tool| palette.color(index, tool));
        }
        if let (Some(stop), ViewedPath::Path) = (&channel.stop, frame.sight.source) {
            stops::draw(&mut marks, channel, stop, path, &frame);
        }
    }
    // Above the paths of all channels.
    out + &marks
}

/// Where a piece comes from: `UPPER T3, part.nc line 12: G1 X34.`.
fn hint(toolpath: &Toolpath, channel: &ChannelToolpath, piece: &PathPiece) -> String {
    let place = place(toolpath, channel, (piece.tool, piece.file));
    let (first, last) = piece.lines;
    if first != last {
        return format!("{place}lines {first} to {last}");
    }
    let block = channel.info.block_text(piece.file, first, 60);
    if block.is_empty() { format!("{place}line {first}") } else { format!("{place}line {first}: {block}") }
}

/// `UPPER T3, part.nc `, as far as it is needed.
fn place(toolpath: &Toolpath, channel: &ChannelToolpath, (tool, file): (u32, FileId)) -> String {
    let mut out = String::new();
    if toolpath.channels.len() > 1 {
        let _ = write!(out, "{} ", channel.name);
    }
    if tool > 0 {
        let _ = write!(out, "T{tool}, ");
    }
    let _ = write!(out, "{} ", channel.info.file_name(file));
    out
}

fn title(out: &mut String, toolpath: &Toolpath) {
    let mut programs: Vec<&str> = toolpath.channels.iter().map(|c| c.program.as_str()).collect();
    programs.dedup();
    let what = match stops::sentence(toolpath) {
        Some(stop) => fit(&stop, 15, 560.0),
        None => format!("toolpath, {}", toolpath.program_unit.name()),
    };
    let machine = format!("{}{}", if programs.is_empty() { "" } else { " on " }, toolpath.machine);
    let machine = fit(&machine, 17, 360.0);
    let room = RIGHT - 16.0 - width(&what, 15) - 24.0 - width(&machine, 17);
    let line = format!("{}{machine}", fit(&programs.join(" + "), 17, room));
    text(out, (16.0, 27.0), 17, "start", INK, &line);
    text(out, (RIGHT, 27.0), 15, "end", if toolpath.failed { RED } else { INK }, &what);
}
