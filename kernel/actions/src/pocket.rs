//! Pockets of any shape (Haas G150).
//!
//! Facts: operator's manual of the control: the tool goes to the start within the pocket and down from the return plane
//! in levels. In each level it goes once around the outline that the subprogram draws, at the distance of the last
//! pass, then clears the inside by cuts; the last pass is made at the depth alone. Decisions: the tool meets the
//! outline where the path to its first point does; it rises to the return plane between cuts that do not follow each
//! other, and ends there, above the start; the compensation of its block ends with it. *Invariant:* no move comes
//! nearer to the outline than the radius of the tool.

use counterpoint_channel::modal::{group, plane};
use counterpoint_channel::tool_radius::cutter_radius;
use counterpoint_channel::turning::{
    ContourBlocks, ContourCycle, ContourTask, LathePlane, PocketCycle, RecordedContour,
};
use counterpoint_event::event::FeedUnit;
use counterpoint_fault as diag;
use counterpoint_fault::{Acted, Halt};
use counterpoint_machine::ident::{DataId, codes, data};
use counterpoint_machine::index::{AxisSlot, BySlot};
use counterpoint_motion::arc::by_center;
use counterpoint_motion::contour::area::ClearingArea;
use counterpoint_motion::contour::clearing::{Clearing, begun_where};
use counterpoint_motion::contour::closed::{ClosedContour, turned_by};
use counterpoint_motion::contour::element::{Element, Spot};

use crate::context::{ActionContext, CircleSteps};
use crate::entry::ActionEntry;
use crate::motion::{feed_to_point, programmed_targets, rapid_to_point};
use crate::time::check_feed;
use crate::{cutter, turned};
use counterpoint_channel::circular_move::CircularMove;

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] = &[ActionEntry::of(&[codes::POCKET], |act, _, _| pocket(act))];

/// Moves of an outline, and lines of cuts, at most.
const MOST_MOVES: usize = 40;
const MOST_LINES: u32 = 10_000;

fn pocket(act: &mut ActionContext<'_, '_>) -> Acted {
    let mut value = |id: DataId| act.take(id).map(|datum| datum.value);
    let outline = value(data::POCKET_OUTLINE);
    let steps = [data::POCKET_STEP_X, data::POCKET_STEP_Y].map(&mut value);
    let finish = value(data::POCKET_FINISH).unwrap_or(0.0);
    let (level, clear) = (value(data::POCKET_LEVEL), value(data::POCKET_CLEAR));
    super::tool_offsets::take_diameter(act);
    let feed = act.active_feed();
    let (coded, target) = programmed_targets(act);
    let Some((plane, z)) = axes(act) else { return refuse(act, "the plane of X and Y is not active") };
    if act.channel().state.modal.code(group::POSITION) == Some(codes::POSITION_RELATIVE) {
        return refuse(act, "incremental positions (G91) are not emulated, give absolute ones (G90)");
    }
    let Some(outline) = outline.filter(|number| *number >= 1.0 && *number < 1e9 && number.fract() == 0.0) else {
        return refuse(act, "the number P of the subprogram with its outline is missing");
    };
    let (step, across) = match steps {
        [Some(step), None] if step > 0.0 => (step, true),
        [None, Some(step)] if step > 0.0 => (step, false),
        _ => return refuse(act, "either I or J, the distance of the cuts, must be given, above 0"),
    };
    let Some(level) = level.filter(|level| *level > 0.0) else {
        return refuse(act, "the depth Q of a level must be given, above 0");
    };
    let Some(clear) = clear else { return refuse(act, "the return plane R is missing") };
    let depth = target.at(z);
    if coded & z.bit() == 0 || depth >= clear {
        return refuse(act, &format!("a depth Z below the return plane {clear} is missing"));
    }
    if !(0.0..1e6).contains(&finish) {
        return refuse(act, &format!("the last pass K is {finish}, it must not be below 0"));
    }
    check_feed(act, feed.0)?;
    let mut over = act.channel().state.place.programmed();
    for axis in plane.axes {
        *over.at_mut(axis) = target.at(axis);
    }
    let flat = plane.moved(&act.channel().state.place.programmed(), &over);
    if flat != 0 {
        rapid_to_point(act, flat, over)?;
    }
    *over.at_mut(z) = clear;
    rapid_to_point(act, z.bit(), over)?;
    let task = ContourTask::Pocket(PocketCycle { step, across, finish, level, clear, depth });
    act.cut_contour(ContourCycle { blocks: ContourBlocks::Program(outline as u32), task, feed, feeds: [None; 2] });
    Ok(())
}

/// The plane of X and Y, if it is active, and Z.
fn axes(act: &ActionContext<'_, '_>) -> Option<(LathePlane, AxisSlot)> {
    let plane = act
        .channel()
        .state
        .active_plane()
        .filter(|_| act.channel().state.modal.code(group::PLANE) == Some(codes::PLANE_XY))?;
    let z = act.channel().state.place.layout.cartesian.get(2).copied().flatten()?;
    Some((plane, z))
}

/// Clears the pocket whose outline was read.
pub(crate) fn cut(
    act: &mut ActionContext<'_, '_>,
    pocket: &PocketCycle,
    feed: (Option<f64>, FeedUnit),
    reading: RecordedContour,
) -> Acted {
    let Some((plane, z)) = axes(act) else { return Ok(()) };
    let side = match act.channel().state.modal.code(group::DIAMETER) {
        Some(codes::COMP_DIAM_LEFT) => 1.0,
        Some(codes::COMP_DIAM_RIGHT) => -1.0,
        _ => return refuse(act, "it needs G41 or G42 with the offset D of the tool"),
    };
    let radius = act.channel().diameter_in_force().map_or(0.0, |number| cutter_radius(act.channel(), number));
    cutter::beside(act, None)?;
    if radius <= 0.0 {
        return refuse(act, "the offset D of the tool has no radius");
    }
    let moves = reading.elements.len();
    let first = reading.elements.first().map(|first| first.from);
    let (Some(first), true) = (first, moves <= MOST_MOVES) else {
        return refuse(act, &format!("its outline has {moves} moves, it must have 1 to {MOST_MOVES}"));
    };
    let turn = if pocket.across { -90.0 } else { 0.0 };
    let outline = ClosedContour::open(reading.elements);
    let inside = if outline.is_clockwise() { -1.0 } else { 1.0 };
    let mut area = ClearingArea::default();
    if area.add(outline.turned(turn).elements()).is_err() {
        return refuse(act, "its outline is not closed");
    }
    let start = plane.point(&act.channel().state.place.programmed());
    if side != inside || !outline.holds(start) {
        return refuse(
            act,
            "the tool or the start is outside of its outline: G41 is inside of one that runs counterclockwise, G42 clockwise",
        );
    }
    let clearings = [pocket.finish, 0.0].map(|away| Clearing::of(&area, radius + away));
    let [Some(rough), Some(last)] = clearings else {
        return refuse(act, &format!("the radius {radius} of the tool does not fit into its outline"));
    };
    let line = Element { from: turned_by(start, turn), to: turned_by(first, turn), arc: None };
    let round = |clearing: &Clearing| -> Vec<Vec<Element>> {
        let ways = clearing.ways(&[]).into_iter().map(|way| begun_where(&way, &line));
        ways.map(|way| if side < 0.0 { ClosedContour::open(way).reversed().elements().to_vec() } else { way }).collect()
    };
    let cuts = Cuts { plane, z, turn, clear: pocket.clear, start, feed };
    let rows = rough.rows(pocket.step, MOST_LINES);
    let mut depth = pocket.clear;
    while depth > pocket.depth + 1e-9 {
        depth = (depth - pocket.level).max(pocket.depth);
        for way in round(&rough) {
            cuts.out_of_start(act, &way, depth)?;
        }
        for row in &rows {
            cuts.along(act, row, depth)?;
        }
    }
    if pocket.finish > 0.0 {
        for way in round(&last) {
            cuts.out_of_start(act, &way, pocket.depth)?;
        }
    }
    cuts.over(act, start)
}

/// How the tool moves in the pocket.
struct Cuts {
    plane: LathePlane,
    z: AxisSlot,
    /// Rotation of the cut area, degrees.
    turn: f64,
    clear: f64,
    start: Spot,
    feed: (Option<f64>, FeedUnit),
}

impl Cuts {
    /// To a point at the return plane.
    fn over(&self, act: &mut ActionContext<'_, '_>, spot: Spot) -> Acted {
        let here = act.channel().state.place.programmed();
        let to = self.plane.position(here, spot);
        let flat = self.plane.moved(&here, &to);
        if flat == 0 { Ok(()) } else { rapid_to_point(act, flat, to) }
    }

    fn height(&self, act: &mut ActionContext<'_, '_>, height: f64) -> Acted {
        let mut to = act.channel().state.place.programmed();
        if to.at(self.z) == height {
            return Ok(());
        }
        let rises = height > to.at(self.z);
        *to.at_mut(self.z) = height;
        match self.feed {
            _ if rises => rapid_to_point(act, self.z.bit(), to),
            (feed, unit) => feed_to_point(act, self.z.bit(), to, feed, unit),
        }
    }

    /// Down at the start, to a path and along it, and up.
    fn out_of_start(&self, act: &mut ActionContext<'_, '_>, way: &[Element], depth: f64) -> Acted {
        let Some(first) = way.first() else { return Ok(()) };
        let to = first.from;
        act.count_as_block()?;
        self.over(act, self.start)?;
        self.height(act, depth)?;
        self.go(act, &Element { from: turned_by(self.start, self.turn), to, arc: None })?;
        way.iter().try_for_each(|element| self.go(act, element))?;
        self.height(act, self.clear)
    }

    /// Along cuts that follow each other, from above their beginning.
    fn along(&self, act: &mut ActionContext<'_, '_>, row: &[Element], depth: f64) -> Acted {
        let Some(first) = row.first() else { return Ok(()) };
        act.count_as_block()?;
        self.over(act, turned_by(first.from, -self.turn))?;
        self.height(act, depth)?;
        row.iter().try_for_each(|element| self.go(act, element))?;
        self.height(act, self.clear)
    }

    fn go(&self, act: &mut ActionContext<'_, '_>, element: &Element) -> Acted {
        let from = act.channel().state.place.programmed();
        let to = self.plane.position(from, turned_by(element.to, -self.turn));
        let coded = self.plane.moved(&from, &to);
        let (feed, unit) = self.feed;
        let Some(arc) = &element.arc else {
            return if coded == 0 { Ok(()) } else { feed_to_point(act, coded, to, feed, unit) };
        };
        let [start, end] = [from, to].map(|position| self.plane.point(&position));
        let center = turned_by(arc.center, -self.turn);
        let Ok(made) = by_center(start, end, center, arc.sweep < 0.0) else {
            return feed_to_point(act, coded, to, feed, unit);
        };
        let coded = self.plane.axes.iter().fold(0, |bits, axis| bits | axis.bit());
        let circle = CircularMove { made, coded, from, to, axes: self.plane.axes, turns: 0, feed, unit, screw: None };
        match plane(codes::PLANE_XY) {
            Some(plane) if act.channel().state.place.frames.is_some() => turned::circle(act, plane, &circle),
            _ => act.circle_to(&circle),
        }
    }
}

fn refuse(act: &mut ActionContext<'_, '_>, why: &str) -> Acted {
    let text = format!("the pocket of '{}' is not cut: {why}", act.channel().block_text());
    Err::<(), Halt>(act.alarm(&diag::CYCLE_REFUSED, text))
}
