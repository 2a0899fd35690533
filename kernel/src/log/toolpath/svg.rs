//! The toolpath as a picture: one view for lathes, two for mills.
//!
//! The frame fits the cutting moves; rapids beyond it are cut at its border. Invariant: aspect is preserved, all views
//! of a picture have one scale, and of a long path only lines that change the picture are drawn.

mod canvas;
mod frame;
mod pen;

use std::fmt::Write as _;

use super::store::{Path, Stroke};
use super::{Toolpath, View};
use crate::log::svg::{open, text};
use frame::{Bounds, Frame};
use pen::Pen;

const WIDTH: f64 = 1200.0;
const LEFT: f64 = 64.0;
const RIGHT: f64 = WIDTH - 24.0;
const TOP: f64 = 72.0;
/// Height that all views share at most.
const HEIGHT: f64 = 760.0;
const INK: &str = "#1f2933";
const SOFT: &str = "#66727f";
/// Colours of the channels.
const COLORS: [&str; 8] = ["#1f6fb4", "#c2410c", "#2e7d32", "#7b3fa0", "#0f766e", "#a16207", "#be185d", "#475569"];
/// Pixels that a drawn line may be off.
const COARSENESS: f64 = 0.2;
/// Moves beyond which a path is drawn without lines over lines.
const LONG: usize = 5_000;

/// What one view shows: coordinates to the right and up, and their names.
#[derive(Debug, Clone, Copy)]
struct Sight {
    axes: [usize; 2],
    names: [&'static str; 2],
}

fn sights(view: View) -> &'static [Sight] {
    const ZX: [Sight; 1] = [Sight { axes: [0, 1], names: ["Z", "X (radius)"] }];
    const XYZ: [Sight; 2] = [Sight { axes: [0, 1], names: ["X", "Y"] }, Sight { axes: [0, 2], names: ["X", "Z"] }];
    match view {
        View::Zx => &ZX,
        View::Xyz => &XYZ,
    }
}

pub(super) fn draw(toolpath: &Toolpath) -> String {
    let sights = sights(toolpath.view);
    let bounds = Bounds::of(toolpath.channels.iter().map(|c| &c.path));
    let scale = scale(&bounds, sights);
    let mut frames = Vec::new();
    let mut top = TOP;
    for sight in sights {
        let frame = Frame::new(*sight, &bounds, scale, top);
        top = frame.bottom + 56.0;
        frames.push(frame);
    }
    let paths: Vec<String> = frames.iter().map(|frame| strokes(toolpath, frame)).collect();
    let mut out = String::with_capacity(paths.iter().map(String::len).sum::<usize>() + 16 * 1024);
    open(&mut out, WIDTH, top - 12.0);
    title(&mut out, toolpath);
    legend(&mut out, toolpath);
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
fn strokes(toolpath: &Toolpath, frame: &Frame) -> String {
    let mut out = String::new();
    for (index, channel) in toolpath.channels.iter().enumerate() {
        let color = COLORS.get(index % COLORS.len()).copied().unwrap_or(INK);
        let [rapid, feed, thread] = channel_strokes(&channel.path, frame);
        // Many lines get thinner, so that they stay apart.
        let width = match feed.len() {
            0..60_000 => 1.4,
            60_000..300_000 => 0.8,
            _ => 0.45,
        };
        for (d, style) in [
            (rapid, r#"stroke-width="0.8" stroke-dasharray="5 3" stroke-opacity="0.65""#.to_owned()),
            (feed, format!(r#"stroke-width="{width}""#)),
            (thread, r#"stroke-width="2.6" stroke-dasharray="1.5 2""#.to_owned()),
        ] {
            if !d.is_empty() {
                let _ = writeln!(out, r#"<path stroke="{color}" {style} d="{d}"/>"#);
            }
        }
    }
    out
}

fn channel_strokes(path: &Path, frame: &Frame) -> [String; 3] {
    let long = path.moves.len() > LONG;
    let mut pens = [Stroke::Rapid, Stroke::Feed, Stroke::Thread].map(|_| Pen::new(COARSENESS, long));
    let mut from = [0.0; 3];
    let mut last = None;
    for step in &path.moves {
        let pen = match step.stroke() {
            Stroke::Start => None,
            Stroke::Rapid => Some(0),
            Stroke::Feed => Some(1),
            Stroke::Thread => Some(2),
        };
        if let Some(pen) = pen.and_then(|index| pens.get_mut(index)) {
            if last != Some(step.stroke()) {
                pen.begin(frame.pixel(&from));
            }
            match path.curve(step) {
                Some(curve) => pen.arc(curve, &from, &step.to(), frame),
                None => pen.line(frame.pixel(&step.to())),
            }
        }
        (from, last) = (step.to(), Some(step.stroke()));
    }
    pens.map(Pen::finish)
}

fn title(out: &mut String, toolpath: &Toolpath) {
    let mut programs: Vec<&str> = toolpath.channels.iter().map(|c| c.program.as_str()).collect();
    programs.dedup();
    let mut line = programs.join(" + ");
    if line.chars().count() > 70 {
        line = line.chars().take(69).chain(['…']).collect();
    }
    let _ = write!(line, "{}{}", if line.is_empty() { "" } else { " on " }, toolpath.machine);
    text(out, (16.0, 27.0), 17, "start", INK, &line);
    text(out, (RIGHT, 27.0), 15, "end", INK, &format!("toolpath, {}", toolpath.unit));
}

fn legend(out: &mut String, toolpath: &Toolpath) {
    let mut x = LEFT;
    let channels = toolpath.channels.iter().enumerate().map(|(index, channel)| {
        let color = COLORS.get(index % COLORS.len()).copied().unwrap_or(INK);
        let cut = if channel.path.truncated { " (not to its end)" } else { "" };
        (format!("{} {}{cut}", channel.channel, channel.name), color, r#"stroke-width="4""#)
    });
    let kinds = [
        ("feed", r#"stroke-width="1.4""#),
        ("rapid", r#"stroke-width="0.8" stroke-dasharray="5 3""#),
        ("thread", r#"stroke-width="2.6" stroke-dasharray="1.5 2""#),
    ];
    let used = |name: &str| {
        let stroke = match name {
            "feed" => Stroke::Feed,
            "rapid" => Stroke::Rapid,
            _ => Stroke::Thread,
        };
        toolpath.channels.iter().any(|c| c.path.moves.iter().any(|m| m.stroke() == stroke))
    };
    let kinds = kinds.into_iter().filter(|(name, _)| used(name)).map(|(name, style)| (name.to_owned(), SOFT, style));
    for (name, color, style) in channels.chain(kinds) {
        let _ = writeln!(out, r#"<path stroke="{color}" {style} d="M{x:.0} 48h26"/>"#);
        text(out, (x + 32.0, 52.0), 12, "start", SOFT, &name);
        x += 52.0 + 7.2 * name.chars().count() as f64;
    }
}
