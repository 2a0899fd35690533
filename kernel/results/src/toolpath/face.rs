//! The path of live tools as seen on the face of the part: the view of moves of a C axis or a Y axis.
//!
//! Points are those of the part, not of the machine: the tool at radius X and height Y, turned by the angle of C. Moves
//! of polar interpolation, whose axes follow a straight line or an arc on the face, are lines and arcs here as well.
//! *Invariant:* only tools whose moves turn C or move Y are kept, so that turning tools leave no trace.

use counterpoint_event::event::{FileId, Motion, MotionKind, Position};
use counterpoint_event::info;

use super::chords;
use super::store::{Here, PathMove, RecordedPath, Stroke};
use crate::geometry::{Loop, Sweep, scale};

/// A move counts as straight if its length is that of the straight path, within this, mm or inch.
const STRAIGHT: f64 = 1e-3;

/// Builder of the path on the face.
#[derive(Debug)]
pub(super) struct Face {
    x: (usize, f64),
    y: Option<usize>,
    c: Option<usize>,
    z: Option<usize>,
    path: RecordedPath,
    /// Where the moves of the active tool begin.
    of_tool: Here,
    /// The active tool has turned C or moved Y.
    live: bool,
    end: Option<Position>,
}

impl Face {
    /// A builder for a channel with X and one of C and Y; its path may take this many bytes.
    pub(super) fn new(channel: &info::JobChannel, room: u64) -> Option<Self> {
        let find = |name: &str| channel.axes.iter().position(|axis| axis.name == name);
        let x = find("X")?;
        let (y, c) = (find("Y"), find("C").filter(|at| channel.axes.get(*at).is_some_and(|axis| axis.rotary)));
        if y.is_none() && c.is_none() {
            return None;
        }
        let path = RecordedPath::with_capacity(0, room);
        let of_tool = path.here();
        let x = (x, channel.axes.get(x).map_or(1.0, scale));
        Some(Self { x, y, c, z: find("Z"), path, of_tool, live: false, end: None })
    }

    /// Starts another tool.
    pub(super) fn tool(&mut self) {
        if !self.live {
            self.path.rewind(self.of_tool);
        }
        (self.of_tool, self.live, self.end) = (self.path.here(), false, None);
    }

    /// The next motion of a tool, and the file and line of its block.
    pub(super) fn motion(&mut self, motion: &Motion, axes: &[info::JobAxis], tool: u32, (file, line): (FileId, u32)) {
        let changes = |axis: Option<usize>| {
            axis.is_some_and(|at| motion.from.get(at).zip(motion.to.get(at)).is_some_and(|(from, to)| from != to))
        };
        let turns = changes(self.c);
        let way = self.way(motion, axes, turns);
        // A full circle ends where it began.
        let is_aside = |position: &Position| self.y.is_some_and(|y| position.get(y) != motion.from.get(y));
        let is_polar_arc = motion.kind == MotionKind::Linear && motion.plane_axes != [u8::MAX; 2];
        self.live |= turns || is_polar_arc || changes(self.y) || way.iter().any(is_aside);
        self.path.mark(tool, file);
        if !self.end.as_ref().is_some_and(|end| motion.starts_at(end)) {
            self.path.begin(self.point(&motion.from), line);
        }
        let stroke = match motion.kind {
            MotionKind::Rapid => Stroke::Rapid,
            MotionKind::Thread => Stroke::Thread,
            _ => Stroke::Feed,
        };
        for position in way {
            self.path.push(PathMove::new(stroke, self.point(&position), line), None);
        }
        self.path.push(PathMove::new(stroke, self.point(&motion.to), line), None);
        self.end = Some(motion.to);
    }

    /// Positions between the ends of a move that is not a straight line on the face.
    fn way(&self, motion: &Motion, axes: &[info::JobAxis], turns: bool) -> Vec<Position> {
        if let Some(sweep) = Sweep::of(motion, axes) {
            return chords::of_arc(motion, &sweep, axes);
        }
        if let Some(space) = Loop::of(motion, axes) {
            return chords::of_loop(motion, &space);
        }
        if let Some(way) = self.polar_arc(motion) {
            return way;
        }
        let (from, to) = (self.point(&motion.from), self.point(&motion.to));
        let straight = from.iter().zip(to).map(|(from, to)| (to - from).powi(2)).sum::<f64>().sqrt();
        if !turns || motion.kind != MotionKind::Rapid && (motion.length - straight).abs() < STRAIGHT {
            return Vec::new();
        }
        let angle = self.c.and_then(|at| Some((motion.to.get(at)? - motion.from.get(at)?).to_radians()));
        chords::shares(angle.unwrap_or(0.0)).into_iter().map(|share| chords::between(motion, share)).collect()
    }

    /// Positions between the ends of an arc on the face by polar interpolation.
    fn polar_arc(&self, motion: &Motion) -> Option<Vec<Position>> {
        let c = self.c.filter(|_| motion.kind == MotionKind::Linear)?;
        if motion.plane_axes.map(usize::from) != [self.x.0, c] {
            return None;
        }
        let [x, y] = motion.center;
        let ends = [self.point(&motion.from), self.point(&motion.to)];
        let [from, to] = ends.map(|point| [point[0] - x, point[1] - y]);
        let radius = from[0].hypot(from[1]);
        let round = (motion.length.powi(2) - (ends[1][2] - ends[0][2]).powi(2)).max(0.0).sqrt() / radius;
        if !round.is_finite() {
            return None;
        }
        let turned = |angle: f64| {
            let (sin, cos) = angle.sin_cos();
            [from[0] * cos - from[1] * sin, from[0] * sin + from[1] * cos]
        };
        let miss = |angle: f64| (turned(angle)[0] - to[0]).hypot(turned(angle)[1] - to[1]);
        let sweep = if miss(round) <= miss(-round) { round } else { -round };
        let at = |share: f64| {
            let [along, across] = turned(sweep * share);
            let (along, across) = (x + along, y + across);
            let mut position = chords::between(motion, share);
            for (axis, value) in [(self.x.0, along.hypot(across) / self.x.1), (c, across.atan2(along).to_degrees())] {
                if let Some(slot) = position.get_mut(axis) {
                    *slot = value;
                }
            }
            position
        };
        Some(chords::shares(sweep).into_iter().map(at).collect())
    }

    fn point(&self, position: &Position) -> [f64; 3] {
        let value = |at: Option<usize>| at.and_then(|at| position.get(at)).copied().unwrap_or(0.0);
        let (x, y) = (value(Some(self.x.0)) * self.x.1, value(self.y));
        let (sin, cos) = value(self.c).to_radians().sin_cos();
        [x * cos - y * sin, x * sin + y * cos, value(self.z)]
    }

    /// The path of the live tools; none if there was none.
    pub(super) fn finish(mut self) -> Option<RecordedPath> {
        self.tool();
        (!self.path.moves.is_empty()).then_some(self.path)
    }
}
