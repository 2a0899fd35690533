//! The toolpath of a job in the work frame.
//!
//! Lathes (a channel with a diameter axis X and a Z) are seen as turners draw: Z to the right, X up as a radius.
//! Everything else is X Y Z, seen from above and from the front. *Invariant:* a channel holds [`store::MOST`] moves at
//! most; beyond that the path gets coarser, and a path that cannot be thinned ends early and says so.
//!
//! As JSON: `{unit, view: "zx" | "xyz", channels: [{channel, name, side, tools, truncated, segments}]}`. `side` is
//! `lower` for a channel that works from below the turning axis; its coordinates are as programmed nevertheless. A
//! slave axis moves straight from where its channel was to where the master has brought it, as feed. `tools` are those
//! that moved, `{tool, name}`. A segment is either `{kind: rapid | feed | thread, points}` with the coordinates of a
//! polyline one after the other (two or three for each point, by the view), or `{kind: arc_cw | arc_ccw, points, plane,
//! center, turns}` with start and end in `points`, the centre by the two axes of `plane`, and full turns in addition. A
//! circle in space, or one whose plane is not seen, is a polyline with the points where a coordinate turns back.
//! Coordinates are rounded to 0.0001. Every segment has `tool` (0 before the first one), `file` and `lines`: the line
//! of each of its moves.
//!
//! A channel of a turning view whose live tools turn C or move Y has `face` too: segments with X, Y and Z of the part,
//! X and Y as radius values with C turned back. A channel that did not reach its end has `stop: {state, file, line}`.

mod chords;
mod face;
mod json;
#[cfg(test)]
mod picture_tests;
pub mod store;
mod svg;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use serde::Serialize;

use crate::geometry::{Loop, Sweep, scale};
use crate::spans::ToolSpan;
use crate::summary::ChannelState;
use counterpoint_event::event::{CarriedMove, FeedUnit, FileId, Motion, MotionKind, Position};
use counterpoint_event::info::{self, Info, MachineUnit};
use face::Face;
use store::{Curve, PathMove, RecordedPath, Stroke};

/// Tools that get colours of their own.
const MOST_TOOLS: usize = 500;

/// How the path is seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ToolpathView {
    /// Turning: Z and the radius X.
    Zx,
    /// X, Y and Z.
    Xyz,
}

/// Where a channel stopped before the end of its program.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct StopPlace {
    /// How it ended.
    pub state: ChannelState,
    /// File of the block.
    pub file: String,
    /// Line of the block, 0 without one.
    pub line: u32,
}

impl ToolpathView {
    /// Letters of the coordinates.
    fn letters(self) -> &'static [char] {
        match self {
            Self::Zx => &['z', 'x'],
            Self::Xyz => &['x', 'y', 'z'],
        }
    }
}

/// Toolpath of a job.
#[derive(Debug, Clone, Serialize)]
pub struct Toolpath {
    /// `mm` or `inch`.
    pub unit: &'static str,
    /// The view, and the meaning of the coordinates.
    pub view: ToolpathView,
    /// Channels with a program, ascending.
    pub channels: Vec<ChannelToolpath>,
    /// Machine, for the title of the picture.
    #[serde(skip)]
    pub machine: String,
    /// Unit of the programs, in which the picture counts.
    #[serde(skip)]
    pub program_unit: MachineUnit,
    /// The job has failed or was cancelled.
    #[serde(skip)]
    pub failed: bool,
}

/// A channel in the toolpath.
#[derive(Debug, Clone)]
pub struct ChannelToolpath {
    /// Number.
    pub channel: u16,
    /// Name.
    pub name: String,
    /// Program, for the title of the picture.
    pub program: String,
    /// Its path.
    pub path: RecordedPath,
    /// The path of its live tools on the face of the part, for a turning view.
    pub face: Option<RecordedPath>,
    /// Where it stopped, if it did not reach the end of its program.
    pub stop: Option<StopPlace>,
    /// It works from below the turning axis.
    pub lower: bool,
    /// Names of its tools, by number, in the order of their first motion.
    pub tools: Vec<(u32, String)>,
    view: ToolpathView,
    info: Arc<Info>,
}

/// Where a channel's coordinates come from.
#[derive(Debug)]
struct Eyes {
    /// Index of the axis and factor to a radius value, for each coordinate.
    axes: [Option<(usize, f64)>; 3],
}

impl Eyes {
    fn new(channel: &info::JobChannel, view: ToolpathView) -> Self {
        let axis = |letter: &str| {
            let index = channel.axes.iter().position(|a| a.name == letter)?;
            Some((index, scale(channel.axes.get(index)?)))
        };
        Self {
            axes: match view {
                ToolpathView::Zx => [axis("Z"), axis("X"), None],
                ToolpathView::Xyz => [axis("X"), axis("Y"), axis("Z")],
            },
        }
    }

    fn point(&self, position: &[f64]) -> [f64; 3] {
        self.axes.map(|a| a.and_then(|(index, scale)| Some(position.get(index)? * scale)).unwrap_or(0.0))
    }

    /// The coordinate that an axis of the channel is.
    fn coordinate(&self, axis: usize) -> Option<usize> {
        self.axes.iter().position(|a| a.is_some_and(|(index, _)| index == axis))
    }

    /// The arc by coordinates instead of axes; `None` when one of its axes is not seen.
    fn curve(&self, sweep: &Sweep, motion: &Motion) -> Option<Curve> {
        let [first, second] = sweep.axes.map(|axis| self.coordinate(axis));
        let plane = [first? as u8, second? as u8];
        Some(Curve {
            plane,
            center: sweep.center,
            radius: sweep.radius,
            start: sweep.start,
            angle: sweep.angle,
            turns: motion.turns,
        })
    }
}

/// The path of one channel in the making.
#[derive(Debug)]
pub struct Track {
    axes: Vec<info::JobAxis>,
    eyes: Eyes,
    path: RecordedPath,
    face: Option<Face>,
    /// Active tool.
    tool: u32,
    /// Where the last motion ended.
    end: Option<Position>,
    /// The program counts in inches now, if it has selected a unit.
    inch: Option<bool>,
    /// The same at the first cutting move, once there was one.
    cut_in_inch: Option<Option<bool>>,
}

/// How the paths of a job are seen.
fn view(info: &Info) -> ToolpathView {
    let turns = |c: &info::JobChannel| {
        c.axes.iter().any(|a| a.name == "X" && a.diameter) && c.axes.iter().any(|a| a.name == "Z")
    };
    if info.channels.iter().any(turns) { ToolpathView::Zx } else { ToolpathView::Xyz }
}

impl Track {
    /// For a channel that has not moved yet.
    pub fn new(info: &Info, channel: &info::JobChannel) -> Self {
        let (first, last) = channel.lines;
        let lines = if channel.program.is_empty() { 0 } else { last.saturating_sub(first) };
        // A face takes a quarter of the room.
        let face = (view(info) == ToolpathView::Zx).then(|| Face::new(channel, info.room.path / 4)).flatten();
        let room = if face.is_some() { info.room.path / 4 * 3 } else { info.room.path };
        Self {
            axes: channel.axes.clone(),
            eyes: Eyes::new(channel, view(info)),
            path: RecordedPath::with_capacity(lines as usize, room),
            face,
            tool: 0,
            end: None,
            inch: (channel.inch != (info.unit == MachineUnit::Inch)).then_some(channel.inch),
            cut_in_inch: None,
        }
    }

    /// A tool has been loaded.
    pub fn tool(&mut self, tool: u32) {
        self.tool = tool;
        if let Some(face) = &mut self.face {
            face.tool();
        }
    }

    /// The program counts in inches or millimetres from here on.
    pub fn unit(&mut self, inch: bool) {
        self.inch = Some(inch);
    }

    /// File and line of the last move.
    pub(crate) fn last_place(&self) -> Option<(FileId, u32)> {
        Some((self.path.marks.last()?.file, self.path.moves.last()?.line))
    }

    /// The next motion, and the file and line of its block.
    #[inline]
    pub fn motion(&mut self, motion: &Motion, (file, line): (FileId, u32)) {
        self.path.mark(self.tool, file);
        let (stroke, curve) = match motion.kind {
            MotionKind::Rapid => (Stroke::Rapid, None),
            MotionKind::Thread => (Stroke::Thread, None),
            MotionKind::Linear => (Stroke::Feed, None),
            MotionKind::ArcSpace => {
                self.around(motion, line);
                (Stroke::Feed, None)
            }
            MotionKind::ArcCw | MotionKind::ArcCcw => {
                let sweep = Sweep::of(motion, &self.axes);
                let curve = sweep.as_ref().and_then(|sweep| self.eyes.curve(sweep, motion));
                if let (Some(sweep), None) = (&sweep, &curve) {
                    self.aside(motion, sweep, line);
                }
                (Stroke::Feed, curve)
            }
        };
        self.begin(motion, line);
        self.end = Some(motion.to);
        self.path.push(PathMove::new(stroke, self.eyes.point(&motion.to), line), curve);
        if self.face.is_some() || self.cut_in_inch.is_none() {
            self.beside(motion, (file, line));
        }
    }

    /// Another channel has moved an axis, in a straight line as far as the channel knows.
    #[cold]
    pub fn carried(&mut self, carried: &CarriedMove, place: (FileId, u32)) {
        let ends = [*carried.from, *carried.to];
        self.motion(&Motion::straight(MotionKind::Linear, 0, ends, (0.0, FeedUnit::PerMinute), 0.0), place);
    }

    /// The path on the face, and the unit of the first cutting move.
    fn beside(&mut self, motion: &Motion, place: (FileId, u32)) {
        if motion.kind != MotionKind::Rapid && self.cut_in_inch.is_none() {
            self.cut_in_inch = Some(self.inch);
        }
        if let Some(face) = &mut self.face {
            face.motion(motion, &self.axes, self.tool, place);
        }
    }
}

impl Track {
    /// The path continues where the motion starts.
    #[inline(always)]
    fn begin(&mut self, motion: &Motion, line: u32) {
        if !self.end.as_ref().is_some_and(|end| motion.starts_at(end)) {
            self.path.begin(self.eyes.point(&motion.from), line);
            self.end = Some(motion.from);
        }
    }

    /// A circle whose plane is not seen up to its end: chords, with the points where a coordinate turns back.
    #[cold]
    fn aside(&mut self, motion: &Motion, sweep: &Sweep, line: u32) {
        self.begin(motion, line);
        self.chords(chords::of_arc(motion, sweep, &self.axes), line);
    }

    /// A circle in space up to its end: chords, with the points where a coordinate turns back.
    #[cold]
    fn around(&mut self, motion: &Motion, line: u32) {
        let Some(space) = Loop::of(motion, &self.axes) else { return };
        self.begin(motion, line);
        self.chords(chords::of_loop(motion, &space), line);
    }

    fn chords(&mut self, positions: Vec<Position>, line: u32) {
        for position in positions {
            self.path.push(PathMove::new(Stroke::Feed, self.eyes.point(&position), line), None);
        }
    }
}

/// Tools that moved, with the name that each has when it is first loaded.
fn tools(path: &RecordedPath, spans: &[ToolSpan]) -> Vec<(u32, String)> {
    let mut all: Vec<(u32, String)> = Vec::new();
    for mark in &path.marks {
        if all.len() < MOST_TOOLS && all.iter().all(|(tool, _)| *tool != mark.tool) {
            let name = spans.iter().find(|span| span.tool == mark.tool).map(|span| span.operation.to_string());
            all.push((mark.tool, name.unwrap_or_default()));
        }
    }
    all
}

impl Toolpath {
    /// From the tracks of all channels, the times of their tools and the places where they stopped.
    pub fn new(info: &Arc<Info>, tracks: Vec<(Track, &[ToolSpan], Option<StopPlace>)>, failed: bool) -> Self {
        let view = view(info);
        let inch = tracks.iter().find_map(|(track, ..)| track.cut_in_inch.flatten());
        let channel =
            |(channel, (track, spans, stop)): (&info::JobChannel, (Track, &[ToolSpan], Option<StopPlace>))| {
                ChannelToolpath {
                    channel: channel.number,
                    name: channel.name.clone(),
                    program: channel.program.clone(),
                    lower: channel.lower && view == ToolpathView::Zx,
                    tools: tools(&track.path, spans),
                    path: track.path,
                    face: track.face.and_then(Face::finish),
                    stop,
                    view,
                    info: info.clone(),
                }
            };
        let all = info.channels.iter().zip(tracks).map(channel);
        Self {
            unit: info.unit.name(),
            view,
            channels: all.filter(|c| !c.program.is_empty()).collect(),
            machine: info.machine.clone(),
            program_unit: match inch {
                Some(true) => MachineUnit::Inch,
                Some(false) => MachineUnit::Mm,
                None => info.unit,
            },
            failed,
        }
    }

    /// The toolpath as a picture of 1200 px width.
    #[must_use]
    pub fn svg(&self) -> String {
        svg::draw(self)
    }

    /// Shown value of one unit of the machine: programs in inches are shown in inches.
    fn shown(&self) -> f64 {
        match (self.unit, self.program_unit) {
            ("mm", MachineUnit::Inch) => 1.0 / 25.4,
            ("inch", MachineUnit::Mm) => 25.4,
            _ => 1.0,
        }
    }
}
