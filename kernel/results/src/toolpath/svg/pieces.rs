//! The path of one channel in pieces that a reader can point at.
//!
//! A short path has a piece for every block, a long one for many blocks together. *Invariant:* there are no more than
//! [`MOST`] pieces and three for every window, however long the path is, and pieces shorter than a few pixels are
//! joined with the next ones.

use super::frame::PictureView;
use super::pen::Pen;
use crate::toolpath::store::{RecordedPath, Stroke};
use counterpoint_event::event::FileId;

/// Pixels that a drawn line may be off.
const COARSENESS: f64 = 0.2;
/// Moves beyond which a path is drawn without lines over lines.
const LONG: usize = 5_000;
/// Windows that a path is divided into.
const WINDOWS: usize = 1_500;
/// Pieces from which a change of tool or file no longer begins a new one.
const MOST: usize = 5_000;
/// Minimum length of a piece, px.
const LEAST: f64 = 4.0;

/// A part of the path.
pub(super) struct PathPiece {
    pub(super) stroke: Stroke,
    pub(super) tool: u32,
    pub(super) file: FileId,
    /// First and last line.
    pub(super) lines: (u32, u32),
    /// The drawn content.
    pub(super) d: String,
}

struct PathPieceBuilder {
    pens: [(Stroke, Pen); 4],
    pieces: Vec<PathPiece>,
    tool: u32,
    file: FileId,
    lines: (u32, u32),
    moves: usize,
}

impl PathPieceBuilder {
    /// Ends the pieces of the window.
    fn cut(&mut self) {
        for (stroke, pen) in &mut self.pens {
            let d = pen.cut();
            if !d.is_empty() {
                let (stroke, tool, file, lines) = (*stroke, self.tool, self.file, self.lines);
                self.pieces.push(PathPiece { stroke, tool, file, lines, d });
            }
        }
        self.moves = 0;
    }

    /// Whether the pieces are worth pointing at.
    fn visible(&self) -> bool {
        self.pens.iter().map(|(_, pen)| pen.way()).sum::<f64>() >= LEAST
    }
}

/// The path in pieces, in order. With `breaks`, a place where the path starts again elsewhere is joined with its
/// previous end.
pub(super) fn pieces(path: &RecordedPath, frame: &PictureView, breaks: bool) -> Vec<PathPiece> {
    let long = path.moves.len() > LONG;
    let window = path.moves.len().div_ceil(WINDOWS).max(1);
    let pens = [Stroke::Start, Stroke::Rapid, Stroke::Feed, Stroke::Thread].map(|stroke| match stroke {
        Stroke::Start | Stroke::Rapid if !long => (stroke, Pen::dashed(COARSENESS)),
        _ => (stroke, Pen::new(COARSENESS, long)),
    });
    let mut cutter = PathPieceBuilder { pens, pieces: Vec::new(), tool: 0, file: 0, lines: (0, 0), moves: 0 };
    let (mut from, mut last, mut begun) = ([0.0; 3], None, false);
    for (mark, moves) in path.sections() {
        let changes = cutter.tool != mark.tool || cutter.file != mark.file && cutter.visible() && window == 1;
        if changes && cutter.pieces.len() < MOST {
            cutter.cut();
            last = None;
        }
        if cutter.moves == 0 {
            (cutter.tool, cutter.file) = (mark.tool, mark.file);
        }
        for step in moves {
            if cutter.moves >= window && step.line != cutter.lines.1 && cutter.visible() {
                cutter.cut();
                (cutter.tool, cutter.file) = (mark.tool, mark.file);
                last = None;
            }
            if cutter.moves == 0 {
                cutter.lines = (step.line, step.line);
            }
            if cutter.file == mark.file {
                cutter.lines.1 = step.line;
            }
            let stroke = step.stroke();
            let drawn = stroke != Stroke::Start || breaks && begun;
            begun = true;
            if let Some((_, pen)) = cutter.pens.iter_mut().find(|(of, _)| *of == stroke && drawn) {
                if last != Some(stroke) {
                    pen.begin(frame.pixel(&from));
                }
                match path.curve(step) {
                    Some(curve) => pen.arc(curve, &from, &step.to(), frame),
                    None => pen.line(frame.pixel(&step.to())),
                }
                cutter.moves += 1;
            }
            (from, last) = (step.to(), Some(stroke));
        }
    }
    cutter.cut();
    cutter.pieces
}
