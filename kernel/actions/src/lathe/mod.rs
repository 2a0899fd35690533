//! Turning cycles: a contour roughed, repeated or finished, pecks along one axis, one cut and back.
//!
//! Facts: reference turning-cycles.md 2 to 4; the moves are those of `counterpoint_motion::turning`. *Invariant:* a
//! cycle ends where it began; every move inside is an ordinary motion of the cycle's block; a pass counts as a block,
//! so that limits and cancelling reach it. Decisions: docs/emulation.md, "Turning cycles".

mod contour;
mod lap;
mod moves;
mod screw;
mod strip;
mod words;

pub(crate) use contour::{reading, record};
pub(crate) use moves::go_back;
pub(crate) use strip::strip;

use counterpoint_channel::turning::ContourBlocks;
use counterpoint_channel::turning::ContourCycle;
use counterpoint_channel::turning::ContourTask;
use counterpoint_channel::turning::LathePlane;
use counterpoint_channel::turning::RecordedContour;
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::codes;
use counterpoint_machine::ident::kind::CodeKind;
use counterpoint_machine::ident::kind::turning::TurningCycle;
use counterpoint_machine::index::BySlot;
use counterpoint_motion::arc::PlaneArc;
use counterpoint_motion::contour::element::Element;
use counterpoint_motion::contour::shifted::shifted;
use counterpoint_motion::turning::ContourError;
use counterpoint_motion::turning::ProgrammedContour;
use counterpoint_motion::turning::pattern;
use counterpoint_motion::turning::peck;
use counterpoint_motion::turning::rough;
use counterpoint_program::block::PendingCode;
use moves::Cutting;

use crate::context::ActionContext;
use crate::entry::ActionEntry;
use crate::entry::CompensationEffect;
use crate::entry::entry_of_kind;
use crate::motion::programmed_targets;
use crate::time::check_feed;
use counterpoint_channel::tool_radius::cutter_radius;
use counterpoint_channel::tool_radius::nose_tip;

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] = &[
    entry_of_kind!(CodeKind::Turning(TurningCycle::Finish) => |act, _row, _code| finish(act))
        .moves()
        .contour(CompensationEffect::Ends),
    entry_of_kind!(
        CodeKind::Turning(kind @ (TurningCycle::Rough { .. } | TurningCycle::Pattern | TurningCycle::Peck { .. }
            | TurningCycle::Single { .. } | TurningCycle::Lap(_))) => |act, _row, code| cycle(act, kind, code)
    )
    .moves()
    .contour(CompensationEffect::Leaves),
    ActionEntry::of(&[codes::TURN_PASS], |act, _, _| {
        screw::pass(act);
        Ok(())
    }),
    ActionEntry::of(&[codes::TURN_LAP_STAY], |act, _, _| {
        act.channel_mut().state.others.turning.stays = true;
        Ok(())
    }),
];

fn finish(act: &mut ActionContext<'_, '_>) -> Acted {
    let (first, last) = words::blocks(act);
    let blocks = contour_blocks(act, first, last)?;
    let feed = act.active_feed();
    act.cut_contour(ContourCycle {
        blocks,
        task: ContourTask::Finish { stays: false, off: 0 },
        feed,
        feeds: [None; 2],
    });
    Ok(())
}

fn cycle(act: &mut ActionContext<'_, '_>, kind: TurningCycle, code: &PendingCode) -> Acted {
    let Some(plane) = act.channel().state.lathe_plane() else {
        let text = format!(
            "channel {} has no X and Z for the cycle of '{}'",
            act.channel().at.channel,
            act.channel().block_text()
        );
        act.diagnose(&diag::CYCLE_AXIS, text);
        return Ok(());
    };
    match kind {
        TurningCycle::Finish => Ok(()),
        TurningCycle::Rough { face } => roughing(act, &plane, face),
        TurningCycle::Pattern => repeating(act, &plane),
        TurningCycle::Peck { along_x } => pecking(act, &plane, along_x),
        TurningCycle::Single { face } => single(act, &plane, face, code.modal),
        TurningCycle::Lap(kind) => lap::cycle(act, &plane, kind),
    }
}

/// The numbers of the contour blocks; both are needed.
fn contour_blocks(
    act: &mut ActionContext<'_, '_>,
    first: Option<u32>,
    last: Option<u32>,
) -> Result<ContourBlocks, diag::Halt> {
    first.zip(last).map(|(first, last)| ContourBlocks::Numbers(first, last)).ok_or_else(|| {
        let text = format!(
            "the cycle needs the first and the last block of its contour (P and Q) in '{}'",
            act.channel().block_text()
        );
        act.alarm(&diag::CONTOUR_RANGE, text)
    })
}

fn roughing(act: &mut ActionContext<'_, '_>, plane: &LathePlane, face: bool) -> Acted {
    let (first, last) = words::blocks(act);
    if first.is_none()
        && last.is_none()
        && act.channel().env.machine.turning.two_lines
        && words::rough_settings(act, face)
    {
        return Ok(());
    }
    let blocks = contour_blocks(act, first, last)?;
    let rough = words::rough(act, plane, face);
    let depth = rough.settings.depth;
    if !(depth > 0.0 && depth.is_finite()) {
        let text = format!("the depth of a level is {depth} in '{}', it must be above 0", act.channel().block_text());
        return Err(act.alarm(&diag::CONTOUR_DEPTH, text));
    }
    let feed = act.active_feed();
    act.cut_contour(ContourCycle {
        blocks,
        task: ContourTask::Rough(rough.settings, rough.pockets),
        feed,
        feeds: [None; 2],
    });
    Ok(())
}

fn repeating(act: &mut ActionContext<'_, '_>, plane: &LathePlane) -> Acted {
    let (first, last) = words::blocks(act);
    if first.is_none() && last.is_none() && act.channel().env.machine.turning.two_lines && words::pattern_settings(act)
    {
        return Ok(());
    }
    let blocks = contour_blocks(act, first, last)?;
    let (allowance, repeats) = words::pattern(act, plane);
    if !(1.0..=999_999.0).contains(&repeats) {
        let text = format!(
            "the contour of '{}' is repeated {repeats} times, it must be at least once",
            act.channel().block_text()
        );
        return Err(act.alarm(&diag::CONTOUR_REPEATS, text));
    }
    let relief = act.channel().state.others.turning.relief;
    let feed = act.active_feed();
    let settings = pattern::PatternRepeatSettings { relief, allowance, passes: repeats as u32 };
    act.cut_contour(ContourCycle { blocks, task: ContourTask::Pattern(settings), feed, feeds: [None; 2] });
    Ok(())
}

fn pecking(act: &mut ActionContext<'_, '_>, plane: &LathePlane, along_x: bool) -> Acted {
    if act.channel().env.machine.turning.two_lines && words::peck_settings(act) {
        return Ok(());
    }
    let words::PeckWords { steps, relief } = words::pecks(act);
    let (feed, unit) = act.active_feed();
    let from = act.channel().state.place.programmed();
    let (_, target) = programmed_targets(act);
    if let Some(step) = steps.into_iter().find(|step| *step < 0.0) {
        let text = format!("the peck or shift {step} is negative in '{}'", act.channel().block_text());
        return Err(act.alarm(&diag::PECK_STEP, text));
    }
    let turned = |[z, x]: [f64; 2]| if along_x { [x, z] } else { [z, x] };
    let [peck, shift] = turned(steps);
    let settings = peck::PeckSettings {
        along_x,
        start: turned(plane.point(&from)),
        end: turned(plane.point(&target)),
        peck,
        shift,
        back: act.channel().state.others.turning.back,
        relief,
    };
    settings.run(&mut Cutting::new(act, plane, (feed, unit)))
}

/// One cut and back.
fn single(act: &mut ActionContext<'_, '_>, plane: &LathePlane, face: bool, implied: bool) -> Acted {
    if act.channel().acting.mode_changed {
        let turning = &mut act.channel_mut().state.others.turning;
        (turning.end, turning.taper) = ([None; 2], 0.0);
    }
    let taper = words::taper(act, face);
    let (feed, unit) = act.active_feed();
    let from = act.channel().state.place.programmed();
    let (coded, target) = programmed_targets(act);
    let mine = plane.axes.iter().fold(0, |bits, axis| bits | axis.bit());
    if coded & mine == 0 && taper.is_none() {
        return Ok(());
    }
    let turning = &mut act.channel_mut().state.others.turning;
    turning.taper = taper.unwrap_or(turning.taper);
    for (slot, axis) in turning.end.iter_mut().zip(plane.axes) {
        if coded & axis.bit() != 0 {
            *slot = Some(target.at(axis));
        }
    }
    if implied {
        act.count_as_block()?;
    }
    let (said, taper) = (act.channel().state.others.turning.end, act.channel().state.others.turning.taper);
    let [start_z, start_x] = plane.point(&from);
    let end = |side: usize, start: f64| {
        let scale = plane.scales.get(side).copied().unwrap_or(1.0);
        said.get(side).copied().flatten().map_or(start, |end| end * scale)
    };
    let (z, x) = (end(0, start_z), end(1, start_x));
    let [begin, back] = match face {
        false => [[start_z, x + taper], [z, start_x]],
        true => [[z + taper, start_x], [start_z, x]],
    };
    use counterpoint_motion::turning::{CycleMove, MoveSink as _};
    let cutting = &mut Cutting::new(act, plane, (feed, unit));
    cutting.go(CycleMove::Rapid(begin))?;
    cutting.go(CycleMove::Feed([z, x]))?;
    cutting.go(CycleMove::Feed(back))?;
    cutting.go(CycleMove::Rapid([start_z, start_x]))
}

/// The path of the imaginary tip whose nose goes beside a contour, up to a piece; as it is where the tool has no nose.
fn beside(
    act: &ActionContext<'_, '_>,
    contour: &[Element],
    (side, until): (f64, Option<usize>),
) -> Option<Vec<Element>> {
    let number = act.channel().diameter_number();
    let radius = cutter_radius(act.channel(), number);
    if radius <= 0.0 {
        return Some(contour.to_vec());
    }
    let tip = nose_tip(act.channel(), number, codes::PLANE_ZX).map(|part| part * radius);
    let back = |[z, x]: [f64; 2]| [z - tip[0], x - tip[1]];
    let of_tip = |element: Element| {
        let arc = element.arc.map(|arc| PlaneArc { center: back(arc.center), ..arc });
        Element { from: back(element.from), to: back(element.to), arc }
    };
    let (beside, rest) = contour.split_at_checked(until.map_or(contour.len(), |until| until.min(contour.len())))?;
    if beside.is_empty() {
        return Some(rest.to_vec());
    }
    let mut way: Vec<Element> = shifted(beside, side, radius)?.into_iter().map(of_tip).collect();
    for element in rest {
        // The first one leads from beside the contour onto it.
        let from = way.last().map_or(element.from, |last| last.to);
        way.push(if from == element.from { *element } else { Element { from, to: element.to, arc: None } });
    }
    Some(way)
}

/// Cuts along a contour that was read.
pub(crate) fn cut(act: &mut ActionContext<'_, '_>, cycle: &ContourCycle, reading: RecordedContour) -> Acted {
    let Some((plane, first)) = act.channel().state.lathe_plane().zip(reading.first) else {
        let text = format!("the contour of '{}' has no move", act.channel().block_text());
        return Err(act.alarm(&diag::CONTOUR_FIRST, text));
    };
    let mut elements = reading.elements;
    if reading.ends_rapid && act.channel().env.machine.turning.retracts && matches!(cycle.task, ContourTask::Rough(..))
    {
        elements.pop();
    }
    if let ContourTask::Thread { face } = cycle.task {
        return screw::cut(act, &plane, face, (reading.start, &elements, &reading.screws));
    }
    if reading.screws.iter().any(Option::is_some) {
        let text = format!("the contour of '{}' has threads, which only G88 cuts", act.channel().block_text());
        return Err(act.alarm(&diag::CONTOUR_CODE, text));
    }
    let mut feeds = reading.feeds;
    if let (ContourTask::Rough(rough::RoughSettings { lap: Some(_), .. }, _), Some(side)) = (cycle.task, reading.side) {
        let Some(beside) = beside(act, &elements, (side, reading.beside)) else {
            let text =
                format!("the nose of the tool does not fit into the contour of '{}'", act.channel().block_text());
            return Err(act.alarm(&diag::CYCLE_REFUSED, text));
        };
        // Feeds belong to pieces as they were programmed.
        feeds.truncate(if beside.len() == elements.len() { beside.len() } else { 0 });
        elements = beside;
    }
    let shape = ProgrammedContour { start: reading.start, elements, blank: reading.blank, rapid: first.rapid };
    let refused = match cycle.task {
        ContourTask::Finish { .. } | ContourTask::Pocket(_) | ContourTask::Thread { .. } => None,
        ContourTask::Rough(settings, pockets) => {
            let both = plane.axes.iter().all(|axis| first.coded & axis.bit() != 0);
            let pockets = pockets.unwrap_or(both && act.channel().env.machine.turning.pockets);
            match rough::RoughCycle::new(&shape, rough::RoughSettings { pockets, ..settings }) {
                Ok(rough) => {
                    check_feed(act, cycle.feed.0)?;
                    rough.run(&mut Cutting::new(act, &plane, cycle.feed).with_feeds(cycle.feeds, feeds))?;
                    None
                }
                Err(refusal) => Some(refusal),
            }
        }
        ContourTask::Pattern(settings) => {
            check_feed(act, cycle.feed.0)?;
            pattern::run(&shape, &settings, &mut Cutting::new(act, &plane, cycle.feed))?;
            None
        }
    };
    let Some(refusal) = refused else {
        super::cutter::after_thread(act);
        return Ok(());
    };
    let block = act.channel().block_text();
    let (facts, why) = match refusal {
        ContourError::TurnsBack => (&diag::CONTOUR_BACK, "turns back along the cut"),
        ContourError::BeyondStart => (&diag::CONTOUR_BEYOND, "reaches beyond the start point of the cycle"),
        ContourError::Nothing => (&diag::CONTOUR_FIRST, "has no piece to cut"),
    };
    Err(act.alarm(facts, format!("the contour of '{block}' {why}")))
}
