//! The toolpath as a picture: one view for lathes, two for mills.
//!
//! The frame fits the cutting moves; rapids beyond it are cut at its border. Every tool has a colour, and every line
//! says on hover which block it comes from. *Invariant:* aspect is preserved, all views of a picture have one scale, and
//! of a long path only lines that change the picture are drawn, in a bounded number of pieces.

mod canvas;
mod frame;
mod legend;
mod pen;
mod pieces;

use std::fmt::Write as _;

use super::store::Stroke;
use super::{Channel, Toolpath, View};
use crate::svg::{escape, fit, open, text, width};
use frame::{Bounds, Frame};
use legend::Palette;
use pieces::{Piece, pieces};

const WIDTH: f64 = 1200.0;
const LEFT: f64 = 64.0;
const RIGHT: f64 = WIDTH - 24.0;
/// Top of the first view below a legend of one row.
const TOP: f64 = 78.0;
/// Height that all views share at most.
const HEIGHT: f64 = 760.0;
const INK: &str = "#1f2933";
const SOFT: &str = "#66727f";
/// How the kinds of moves are drawn, those below first.
const KINDS: [(Stroke, &str, &str); 3] = [
    (Stroke::Rapid, "rapid", r#"stroke-width="0.8" stroke-dasharray="5 3" stroke-opacity="0.65""#),
    (Stroke::Feed, "feed", r#"stroke-width="1.4""#),
    (Stroke::Thread, "thread", r#"stroke-width="2.6" stroke-dasharray="1.5 2""#),
];

/// What the upward scale of a view shows.
#[derive(Debug, Clone, Copy)]
struct Upwards {
    name: &'static str,
    /// Shown value of a coordinate of 1.
    factor: f64,
    /// Values count upwards and downwards from zero.
    both_ways: bool,
}

impl Upwards {
    fn note(self) -> &'static str {
        if self.both_ways { ", lower turret below the axis" } else { "" }
    }
}

/// What one view shows: coordinates to the right and up, and their names.
#[derive(Debug, Clone, Copy)]
struct Sight {
    axes: [usize; 2],
    across: &'static str,
    upwards: Upwards,
}

fn sights(toolpath: &Toolpath) -> Vec<Sight> {
    let plain = |name| Upwards { name, factor: 1.0, both_ways: false };
    match toolpath.view {
        View::Zx => {
            let both_ways = toolpath.channels.iter().any(|c| c.lower);
            vec![Sight { axes: [0, 1], across: "Z", upwards: Upwards { name: "X (diameter)", factor: 2.0, both_ways } }]
        }
        View::Xyz => vec![
            Sight { axes: [0, 1], across: "X", upwards: plain("Y") },
            Sight { axes: [0, 2], across: "X", upwards: plain("Z") },
        ],
    }
}

pub(super) fn draw(toolpath: &Toolpath) -> String {
    let sights = sights(toolpath);
    let palette = Palette::new(toolpath);
    let bounds = Bounds::of(toolpath.channels.iter().map(|c| (&c.path, c.lower)));
    let scale = scale(&bounds, &sights);
    let mut frames = Vec::new();
    let mut top = TOP + palette.height();
    for sight in sights {
        let frame = Frame::new(sight, &bounds, scale, top);
        top = frame.bottom + 56.0;
        frames.push(frame);
    }
    let paths: Vec<String> = frames.iter().map(|frame| strokes(toolpath, frame, &palette)).collect();
    let mut out = String::with_capacity(paths.iter().map(String::len).sum::<usize>() + 16 * 1024);
    open(&mut out, WIDTH, top - 12.0);
    title(&mut out, toolpath);
    palette.draw(&mut out);
    for (index, (frame, paths)) in frames.iter().zip(&paths).enumerate() {
        frame.draw(&mut out, index, toolpath.unit, paths);
    }
    out.push_str("</svg>\n");
    out
}

/// Pixels per unit that fit every view.
fn scale(bounds: &Bounds, sights: &[Sight]) -> f64 {
    let heights: f64 = sights.iter().map(|s| bounds.span(s.axes[1])).sum();
    let width = sights.iter().map(|s| bounds.span(s.axes[0])).fold(0.0, f64::max);
    let free = HEIGHT - 56.0 * (sights.len() as f64 - 1.0);
    ((RIGHT - LEFT) / width).min(free / heights)
}

/// All channels in one frame.
fn strokes(toolpath: &Toolpath, frame: &Frame, palette: &Palette) -> String {
    let mut out = String::new();
    for (index, channel) in toolpath.channels.iter().enumerate() {
        let frame = frame.of(channel.lower);
        let pieces = pieces(&channel.path, &frame);
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
    }
    out
}

/// Where a piece comes from: `UPPER T3, part.nc line 12: G1 X34.`.
fn hint(toolpath: &Toolpath, channel: &Channel, piece: &Piece) -> String {
    let mut hint = String::new();
    if toolpath.channels.len() > 1 {
        let _ = write!(hint, "{} ", channel.name);
    }
    if piece.tool > 0 {
        let _ = write!(hint, "T{}, ", piece.tool);
    }
    let _ = write!(hint, "{} ", channel.info.file_name(piece.file));
    let (first, last) = piece.lines;
    if first != last {
        let _ = write!(hint, "lines {first} to {last}");
        return hint;
    }
    let _ = write!(hint, "line {first}");
    let block = channel.info.block_text(piece.file, first, 60);
    if !block.is_empty() {
        let _ = write!(hint, ": {block}");
    }
    hint
}

fn title(out: &mut String, toolpath: &Toolpath) {
    let mut programs: Vec<&str> = toolpath.channels.iter().map(|c| c.program.as_str()).collect();
    programs.dedup();
    let what = format!("toolpath, {}", toolpath.unit);
    let machine = format!("{}{}", if programs.is_empty() { "" } else { " on " }, toolpath.machine);
    let machine = fit(&machine, 17, 360.0);
    let room = RIGHT - 16.0 - width(&what, 15) - 24.0 - width(&machine, 17);
    let line = format!("{}{machine}", fit(&programs.join(" + "), 17, room));
    text(out, (16.0, 27.0), 17, "start", INK, &line);
    text(out, (RIGHT, 27.0), 15, "end", INK, &what);
}
