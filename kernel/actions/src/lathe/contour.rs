//! Actions by which contour blocks are read: moves are recorded with their corners, everything else is skipped or
//! refused.
//!
//! Facts: reference turning-cycles.md 1.3. The actions of moves are those of the control; their motion is recorded.
//! *Invariant:* nothing moves, takes time or reaches another channel.

use counterpoint_channel::modal::plane;
use counterpoint_channel::turning::First;
use counterpoint_emulator::channel::actions::Action;
use counterpoint_event::event::{Motion, MotionKind};
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::kind::CodeKind;
use counterpoint_machine::ident::{CodeId, codes, data};
use counterpoint_machine::index::{AxisSlot, BySlot};
use counterpoint_machine::rows::CodeRow;
use counterpoint_motion::arc as geometry;
use counterpoint_motion::contour::element::{Element, NOISE, distance};
use counterpoint_program::block::PendingCode;

use crate::context::{ActionContext, run_in_context};
use crate::entry::{ActionEntry, CompensationEffect};
use crate::motion::programmed_targets;
use crate::{find, subprogram};

/// A move of the contour.
#[derive(Debug)]
struct Shaping;

/// Definition of the next circle, or of the corner of the block.
#[derive(Debug)]
struct Defining;

run_in_context!(Shaping);
run_in_context!(Defining);

impl Defining {
    fn execute(&self, act: &mut ActionContext<'_, '_>, row: &CodeRow, code: &PendingCode) -> Acted {
        find(row.id).map_or(Ok(()), |entry| entry.execute(act, row, code))
    }
}

/// All other codes.
static OTHERS: ActionEntry = ActionEntry::of(&[], other).contour(CompensationEffect::Waits);

/// The effect of a code while contour blocks are read.
pub(crate) fn reading(id: CodeId) -> Option<&'static dyn Action> {
    let shapes = matches!(
        id,
        codes::RAPID | codes::INTERP_LINEAR | codes::INTERP_THREAD_ARC_CLW | codes::INTERP_THREAD_ARC_CCLW
    ) || matches!(id.kind(), CodeKind::Arc(_) | CodeKind::Thread(_));
    let defines = matches!(
        id,
        codes::INTERP_DEF_CENTER
            | codes::INTERP_DEF_CLW
            | codes::INTERP_DEF_CCLW
            | codes::CORNER_CHAMFER
            | codes::CORNER_ROUND
    );
    Some(match () {
        () if shapes => &Shaping,
        () if defines => &Defining,
        () => &OTHERS,
    })
}

impl Shaping {
    fn execute(&self, act: &mut ActionContext<'_, '_>, row: &CodeRow, code: &PendingCode) -> Acted {
        // E of a thread is the change of its lead.
        let is_thread = matches!(row.id.kind(), CodeKind::Thread(_))
            || matches!(row.id, codes::INTERP_THREAD_ARC_CLW | codes::INTERP_THREAD_ARC_CCLW);
        if !is_thread && let Some(feed) = act.take(data::TURN_CONTOUR_FEED) {
            act.channel_mut().state.others.turning.reading.feed = Some(feed.value);
        }
        if act.channel().state.others.turning.reading.first.is_none() {
            return first(act, row.id);
        }
        find(row.id).map_or(Ok(()), |entry| entry.execute(act, row, code))
    }
}

/// Takes the first move, which gives the start of the contour and decides how the cycle works.
fn first(act: &mut ActionContext<'_, '_>, id: CodeId) -> Acted {
    let (coded, target) = programmed_targets(act);
    if coded == 0 {
        return Ok(());
    }
    if !matches!(id, codes::RAPID | codes::INTERP_LINEAR) {
        let text = format!("the first block of a contour is a straight move, not '{}'", act.channel().block_text());
        return Err(act.alarm(&diag::CONTOUR_FIRST, text));
    }
    act.active_feed();
    act.channel_mut().state.others.turning.reading.first = Some(First { rapid: id == codes::RAPID, coded });
    act.channel_mut().state.place.position = target;
    Ok(())
}

/// G codes that a contour may have besides its moves.
const ALLOWED: [CodeId; 15] = [
    codes::DELAY,
    codes::FEED_UPM,
    codes::FEED_UPR,
    codes::SPINDLE_CSS,
    codes::SPINDLE_RPM,
    codes::SPINDLE_MAXRPM,
    codes::COMP_DIAM_OFF,
    codes::COMP_DIAM_LEFT,
    codes::COMP_DIAM_RIGHT,
    codes::POSITION_ABSOLUTE,
    codes::POSITION_RELATIVE,
    codes::EXACTSTOP,
    codes::EXACTSTOP_ON,
    codes::EXACTSTOP_OFF,
    codes::PLANE_ZX,
];

/// Codes of calls and ends, for any letter.
const FLOW: [CodeId; 4] = [codes::CALSUB_ID, codes::CALSUB_RETURN, codes::END, codes::REWIND];

/// Frames, which no contour may change.
const FRAMES: [CodeId; 8] = [
    codes::LCS_TRANSLATE_ON,
    codes::LCS_TRANSLATE_ADD,
    codes::LCS_ROTATE_ON,
    codes::LCS_ROTATE_ADD,
    codes::LCS_SCALE_ON,
    codes::LCS_SCALE_ADD,
    codes::LCS_MIRROR_ON,
    codes::LCS_MIRROR_ADD,
];

/// A code that does not shape the contour.
fn other(act: &mut ActionContext<'_, '_>, row: &CodeRow, _: &PendingCode) -> Acted {
    if row.id == codes::DELAY {
        act.take(data::DELAY);
    }
    if row.id == codes::CALSUB_RETURN && act.channel().state.others.turning.reads {
        return subprogram::return_from(act);
    }
    if let codes::COMP_DIAM_LEFT | codes::COMP_DIAM_RIGHT = row.id {
        let side = if row.id == codes::COMP_DIAM_LEFT { 1.0 } else { -1.0 };
        act.channel_mut().state.others.turning.reading.side.get_or_insert(side);
    }
    if row.id == codes::COMP_DIAM_OFF {
        let reading = &mut act.channel_mut().state.others.turning.reading;
        reading.beside = reading.side.and(reading.beside.or(Some(reading.elements.len())));
    }
    let letter = act.channel().env.machine.letter_of(&row.form);
    let allowed = ALLOWED.contains(&row.id) || keeps_plane(act, row.id);
    if FLOW.contains(&row.id) || FRAMES.contains(&row.id) || letter == 'G' && !allowed {
        return refuse(act);
    }
    Ok(())
}

/// Whether a code selects the plane that the contour is already in, as editors of contours write it.
fn keeps_plane(act: &ActionContext<'_, '_>, id: CodeId) -> bool {
    let (Some(own), Some(new)) = (act.channel().state.others.turning.reading.plane, act.channel().state.active_plane())
    else {
        return false;
    };
    plane(id).is_some() && own.axes == new.axes
}

fn refuse(act: &mut ActionContext<'_, '_>) -> Acted {
    let text =
        format!("a contour has G0 to G4, feed, speed, tool and M codes only, not '{}'", act.channel().block_text());
    Err(act.alarm(&diag::CONTOUR_CODE, text))
}

/// The linear axis across a plane.
fn across(act: &ActionContext<'_, '_>, axes: [AxisSlot; 2]) -> Option<AxisSlot> {
    act.channel().state.place.layout.cartesian.iter().flatten().copied().find(|axis| !axes.contains(axis))
}

/// Records a motion as a piece of the contour.
pub(crate) fn record(act: &mut ActionContext<'_, '_>, motion: &Motion) -> Acted {
    let own = act.channel().state.others.turning.reading.plane;
    let Some(plane) = own.or_else(|| act.channel().state.lathe_plane()) else { return Ok(()) };
    let (from, to) = (plane.point(&motion.from), plane.point(&motion.to));
    let arc = match motion.kind {
        MotionKind::ArcCw | MotionKind::ArcCcw => {
            if motion.plane_axes.map(usize::from) != plane.axes.map(|axis| axis.index()) {
                return refuse(act);
            }
            let center = [motion.center[0] * plane.scales[0], motion.center[1] * plane.scales[1]];
            geometry::by_center(from, to, center, motion.kind == MotionKind::ArcCw).ok()
        }
        _ => None,
    };
    if arc.is_some() || distance(from, to) > NOISE {
        let across = across(act, plane.axes);
        let heights = [&motion.from, &motion.to].map(|spot| across.map_or(0.0, |axis| spot.at(axis)));
        let screw = act.channel_mut().state.threads.recorded.take();
        let reading = &mut act.channel_mut().state.others.turning.reading;
        reading.screws.push(screw);
        reading.elements.push(Element { from, to, arc });
        reading.heights.push(heights);
        reading.feeds.push(reading.feed);
        reading.ends_rapid = motion.kind == MotionKind::Rapid;
    }
    act.channel_mut().state.place.position = motion.to;
    act.channel_mut().block.flags.moved = true;
    Ok(())
}
