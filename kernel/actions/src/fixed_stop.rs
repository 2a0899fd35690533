//! Moves against a fixed stop: one block, or all feed moves between two codes.
//!
//! Facts: reference shop-machines.md 2, 5, 6, 12 (push check, torque skip). Decisions: the distances of
//! approach and overtravel apply only to a move of one axis. *Invariant:* after its block no axis remains marked.

use counterpoint_channel::probing::Probing;
use counterpoint_event::event::{FeedUnit, Kind, Motion, MotionKind, Position};
use counterpoint_fault::Acted;
use counterpoint_machine::ident::{codes, data};
use counterpoint_machine::index::{AxisSlot, BySlot};

use crate::context::{ActionContext, StraightSteps};
use crate::entry::{ActionEntry, CompensationEffect};
use crate::motion::rapid_to;

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] = &[
    ActionEntry::of(&[codes::FIXED_STOP_MOVE], |act, _, _| press(act)).moves().contour(CompensationEffect::Leaves),
    ActionEntry::of(&[codes::FIXED_STOP_ON], |act, _, _| switch(act, true)),
    ActionEntry::of(&[codes::FIXED_STOP_OFF], |act, _, _| switch(act, false)),
];

fn switch(act: &mut ActionContext<'_, '_>, on: bool) -> Acted {
    let modal = &mut act.channel_mut().state.others.spindles.fixed_stops.modal;
    if std::mem::replace(modal, on) != on {
        act.note_effect();
        act.channel_mut().emit(0, Kind::mode(if on { "fixed stop on" } else { "fixed stop off" }.to_owned()));
    }
    Ok(())
}

/// Makes a feed move to a stop. The approach looks for the stop, too: it is refused where it would pass the stop.
fn press(act: &mut ActionContext<'_, '_>) -> Acted {
    let (feed, unit) = act.active_feed();
    let [approach, beyond] = [data::FIXED_STOP_APPROACH, data::FIXED_STOP_OVERTRAVEL]
        .map(|id| act.take(id).map_or(0.0, |datum| datum.value.abs()));
    act.take(data::FIXED_STOP_FORCE);
    act.take(data::FIXED_STOP_CHECK);
    let (coded, target) = act.targets();
    if coded == 0 {
        return Ok(());
    }
    act.channel_mut().state.others.spindles.fixed_stops.once = coded;
    let moved = approach_and_feed(act, (coded, target), [approach, beyond], (feed, unit));
    act.channel_mut().state.others.spindles.fixed_stops.once = 0;
    moved?;
    let (end, block) = (act.channel().state.place.position, act.channel().at.blocks);
    *act.channel_mut().state.skip = Probing { result: 1.0, end, block };
    Ok(())
}

/// Approaches at rapid to a distance before the target, and continues at feed to a distance beyond it.
fn approach_and_feed(
    act: &mut ActionContext<'_, '_>,
    (coded, target): (u8, Position),
    [approach, beyond]: [f64; 2],
    (feed, unit): (Option<f64>, FeedUnit),
) -> Acted {
    let mut end = target;
    if let Some(axis) = only_axis(act, coded) {
        let from = act.channel().state.place.position.at(axis);
        let way = target.at(axis) - from;
        if approach > 0.0 && approach < way.abs() {
            let mut start = target;
            *start.at_mut(axis) -= approach.copysign(way);
            rapid_to(act, coded, start)?;
        }
        *end.at_mut(axis) += if way == 0.0 { 0.0 } else { beyond.copysign(way) };
    }
    let from = act.channel().state.place.position;
    if end == from { stand(act, coded, from) } else { act.feed_to(coded, end, feed, unit) }
}

/// Makes a move without length: the axes must already be at the stop.
fn stand(act: &mut ActionContext<'_, '_>, coded: u8, at: Position) -> Acted {
    let feed = act.active_feed();
    let feed = (feed.0.unwrap_or(0.0), feed.1);
    act.travel(0.0, &Motion::straight(MotionKind::Linear, coded, [at, at], feed, 0.0))
}

/// The axis of the block, if there is only one.
fn only_axis(act: &ActionContext<'_, '_>, coded: u8) -> Option<AxisSlot> {
    act.channel().state.place.layout.axes.ids().find(|axis| axis.bit() == coded)
}
