//! The path of one channel in memory: a flat list of moves.
//!
//! *Invariant:* at most [`MOST`] moves, and no more than the memory of the job has room for. A longer path is thinned:
//! moves of one kind shorter than a tolerance, which grows up to a five-hundredth of the path's extent, become one.
//! Moves that still do not fit are left out.

use counterpoint_event::event::FileId;

/// Moves a channel has at most.
pub const MOST: usize = 500_000;
/// The tolerance grows up to this part of the extent.
const COARSEST: f64 = 500.0;

/// How a move is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum Stroke {
    /// No move: the path begins again here.
    Start,
    /// Positioning.
    Rapid,
    /// Feed, arcs included.
    Feed,
    /// Thread.
    Thread,
}

/// A move to a point, in five words: paths are long.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathMove {
    /// Stroke in the upper two bits; below, the index into [`RecordedPath::curves`] or [`STRAIGHT`].
    tag: u32,
    /// End point in units of [`GRAIN`].
    to: [i32; 3],
    /// Line of its block.
    pub line: u32,
}

/// From this move on a tool works, and lines are those of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PathMark {
    /// Index of the move.
    pub from: u32,
    /// Tool as programmed, 0 = none has been loaded.
    pub tool: u32,
    /// File of the lines.
    pub file: FileId,
}

/// Coordinates are kept in whole ten-thousandths (of a mm or an inch).
const GRAIN: f64 = 1e-4;
/// No curve.
const STRAIGHT: u32 = (1 << 30) - 1;

/// An arc by coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Curve {
    /// Coordinates of its plane, first and second axis.
    pub plane: [u8; 2],
    /// Centre by these.
    pub center: [f64; 2],
    /// Radius.
    pub radius: f64,
    /// Angle of the start, radians from the first axis to the second.
    pub start: f64,
    /// Angle gone through, negative = clockwise, full turns included.
    pub angle: f64,
    /// Full turns in addition to the path from start to end.
    pub turns: u16,
}

/// A coordinate in grains; points further away than 200 m stay at the edge.
#[inline]
fn grains(value: f64) -> i32 {
    (value * (1.0 / GRAIN) + 0.5_f64.copysign(value)) as i32
}

impl PathMove {
    #[inline]
    pub(super) fn new(stroke: Stroke, to: [f64; 3], line: u32) -> Self {
        Self { tag: (stroke as u32) << 30 | STRAIGHT, to: to.map(grains), line }
    }

    /// How it is drawn.
    #[must_use]
    pub fn stroke(&self) -> Stroke {
        match self.tag >> 30 {
            0 => Stroke::Start,
            1 => Stroke::Rapid,
            2 => Stroke::Feed,
            _ => Stroke::Thread,
        }
    }

    /// End point.
    #[must_use]
    pub fn to(&self) -> [f64; 3] {
        self.to.map(|grains| f64::from(grains) / (1.0 / GRAIN))
    }

    fn curve(&self) -> Option<usize> {
        let index = self.tag & STRAIGHT;
        (index != STRAIGHT).then_some(index as usize)
    }

    fn set_curve(&mut self, index: Option<usize>) {
        let index = index.map_or(STRAIGHT, |index| (index as u32).min(STRAIGHT));
        self.tag = self.tag & !STRAIGHT | index;
    }
}

impl Curve {
    /// Point at a share of the arc; `from` and `to` give the coordinate off the plane.
    pub(super) fn at(&self, share: f64, from: &[f64; 3], to: &[f64; 3]) -> [f64; 3] {
        let mut point = *from;
        for (slot, (a, b)) in point.iter_mut().zip(from.iter().zip(to)) {
            *slot = a + (b - a) * share;
        }
        let (sin, cos) = (self.start + self.angle * share).sin_cos();
        for (axis, offset, center) in [(self.plane[0], cos, self.center[0]), (self.plane[1], sin, self.center[1])] {
            if let Some(slot) = point.get_mut(usize::from(axis)) {
                *slot = center + self.radius * offset;
            }
        }
        point
    }
}

/// A place of a path.
#[derive(Debug, Clone, Copy)]
pub(super) struct Here {
    moves: usize,
    curves: usize,
    marks: usize,
    tolerance: f64,
}

/// The path of a channel.
#[derive(Debug, Clone, Default)]
pub struct RecordedPath {
    /// Moves in order.
    pub moves: Vec<PathMove>,
    /// Arcs that moves refer to.
    pub curves: Vec<Curve>,
    /// Tools and files, ascending by move.
    pub marks: Vec<PathMark>,
    /// The end of the path is missing.
    pub truncated: bool,
    tolerance: f64,
    /// Tool and file of the last mark, 0 before the first one.
    marked: u64,
    /// Bytes that it may take.
    room: usize,
}

impl RecordedPath {
    /// The arc of a move.
    #[must_use]
    pub fn curve(&self, of: &PathMove) -> Option<&Curve> {
        self.curves.get(of.curve()?)
    }

    /// A path of about this many moves to come, which may take this many bytes.
    pub(super) fn with_capacity(moves: usize, room: u64) -> Self {
        let room = usize::try_from(room).unwrap_or(usize::MAX);
        Self { moves: Vec::with_capacity(moves.min(MOST).min(room / size_of::<PathMove>())), room, ..Self::default() }
    }

    /// Bytes that it takes.
    fn bytes(&self) -> usize {
        self.moves.len() * size_of::<PathMove>()
            + self.curves.len() * size_of::<Curve>()
            + self.marks.len() * size_of::<PathMark>()
    }

    /// The next move starts here, wherever the last one ended.
    pub(super) fn begin(&mut self, from: [f64; 3], line: u32) {
        let start = PathMove::new(Stroke::Start, from, line);
        if !self.truncated && self.moves.last().is_none_or(|last| last.to != start.to) {
            self.moves.push(start);
        }
    }

    /// The moves that follow are those of this tool, their lines of this file.
    #[inline(always)]
    pub(super) fn mark(&mut self, tool: u32, file: FileId) {
        let key = 1 << 63 | u64::from(tool) << 16 | u64::from(file);
        if self.marked != key {
            self.marked = key;
            self.mark_here(tool, file);
        }
    }

    #[cold]
    #[inline(never)]
    fn mark_here(&mut self, tool: u32, file: FileId) {
        if !self.truncated {
            let from = self.moves.len() as u32;
            self.marks.pop_if(|last| last.from == from);
            self.marks.push(PathMark { from, tool, file });
        }
    }

    /// Moves with one tool and lines of one file, in order.
    pub(super) fn sections(&self) -> impl Iterator<Item = (PathMark, &[PathMove])> {
        let ends = self.marks.iter().skip(1).map(|mark| mark.from as usize).chain([self.moves.len()]);
        self.marks
            .iter()
            .zip(ends)
            .map(|(mark, end)| (*mark, self.moves.get(mark.from as usize..end).unwrap_or_default()))
    }

    #[inline]
    pub(super) fn push(&mut self, mut to: PathMove, curve: Option<Curve>) {
        if self.truncated {
            return;
        }
        if let Some(curve) = curve {
            to.set_curve(Some(self.curves.len()));
            self.curves.push(curve);
        }
        self.moves.push(to);
        if self.moves.len() >= MOST || self.bytes() >= self.room {
            self.thin();
        }
    }

    /// The current place of the path, for [`rewind`](Self::rewind).
    pub(super) fn here(&self) -> Here {
        Here { moves: self.moves.len(), curves: self.curves.len(), marks: self.marks.len(), tolerance: self.tolerance }
    }

    /// Forgets the moves since a place; a path that has been thinned since then keeps them.
    pub(super) fn rewind(&mut self, to: Here) {
        if self.tolerance == to.tolerance && !self.truncated {
            self.moves.truncate(to.moves);
            self.curves.truncate(to.curves);
            self.marks.truncate(to.marks);
            self.marked = 0;
        }
    }

    fn extent(&self) -> f64 {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for step in &self.moves {
            for ((low, high), value) in low.iter_mut().zip(&mut high).zip(step.to()) {
                (*low, *high) = (low.min(value), high.max(value));
            }
        }
        low.iter().zip(&high).map(|(low, high)| high - low).fold(0.0, f64::max)
    }

    fn thin(&mut self) {
        let extent = self.extent();
        while self.moves.len() > MOST / 4 * 3 || self.bytes() > self.room / 4 * 3 {
            if self.tolerance >= extent / COARSEST {
                self.truncated = true;
                return;
            }
            self.tolerance = (self.tolerance * 4.0).max(extent * 1e-5);
            self.coarsen();
        }
    }

    fn coarsen(&mut self) {
        let mut moves: Vec<PathMove> = Vec::with_capacity(self.moves.len());
        let mut curves = Vec::new();
        let mut marks = Vec::with_capacity(self.marks.len());
        let mut marked = self.marks.iter().peekable();
        let mut from = [0.0; 3];
        // The start of the last kept move.
        let mut anchor = from;
        for (index, step) in self.moves.iter().enumerate() {
            let mut step = *step;
            let mark = marked.next_if(|mark| mark.from as usize == index);
            marks.extend(mark.map(|mark| PathMark { from: moves.len() as u32, ..*mark }));
            if let Some(curve) = self.curve(&step) {
                let kept = curve.radius * curve.angle.abs() > self.tolerance;
                step.set_curve(kept.then_some(curves.len()));
                curves.extend(kept.then_some(*curve));
            }
            match moves.last_mut() {
                Some(last)
                    if mark.is_none()
                        && last.tag == step.tag
                        && step.curve().is_none()
                        && step.stroke() != Stroke::Start
                        && far(&anchor, &step.to()) < self.tolerance =>
                {
                    *last = step;
                }
                _ => {
                    anchor = from;
                    moves.push(step);
                }
            }
            from = step.to();
        }
        (self.moves, self.curves, self.marks) = (moves, curves, marks);
    }
}

fn far(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}
