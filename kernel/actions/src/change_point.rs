//! The tool-change position: to it, back from it, and on the way to a tool change.
//!
//! Facts: reference control-emulator.md 6.1, 6.3. Decision: like the reference point, with coded axes via the given
//! point and only those, without any all axes that have a position.

use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::habits::Home;
use counterpoint_machine::ident::codes;

use crate::context::{ActionContext, StraightSteps};
use crate::entry::ActionEntry;
use crate::motion::rapid_to;

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] = &[
    ActionEntry::of(&[codes::TOOL_LOAD_POINT], |act, _, _| go(act)),
    ActionEntry::of(&[codes::TOOL_LOAD_RETURN], |act, _, _| come_back(act)),
];

/// To the change position.
pub(crate) fn go(act: &mut ActionContext<'_, '_>) -> Acted {
    act.channel_mut().state.others.before_change =
        Some(act.channel().state.place.machine_point(&act.channel().state.place.position));
    if act.channel().env.machine.habits.home == Home::Machine {
        let (coded, target) = super::home::machine_targets(act);
        return if coded == 0 { to_point(act, 0) } else { rapid_to(act, coded, target) };
    }
    let (coded, via) = act.targets();
    if coded != 0 {
        rapid_to(act, coded, via)?;
    }
    to_point(act, coded)
}

/// Before a tool is loaded.
pub(crate) fn before_load(act: &mut ActionContext<'_, '_>) -> Acted {
    act.channel_mut().state.others.before_change =
        Some(act.channel().state.place.machine_point(&act.channel().state.place.position));
    to_point(act, 0)
}

/// `coded` 0 = all axes that have a position.
fn to_point(act: &mut ActionContext<'_, '_>, coded: u8) -> Acted {
    let mut target = act.channel().state.place.machine_point(&act.channel().state.place.position);
    let (mut moving, mut missing) = (0_u8, false);
    let point = &act.channel().env.machine.tool.change_point;
    for (at, (slot, axis)) in target.iter_mut().zip(&act.channel().state.place.layout.axes).enumerate() {
        if coded != 0 && coded & 1 << at == 0 {
            continue;
        }
        match point[axis.machine] {
            Some(value) => {
                *slot = value;
                moving |= 1 << at;
            }
            None => missing |= coded != 0,
        }
    }
    let target = act.channel().state.place.way_of_machine(&target);
    if missing || moving == 0 {
        let text = format!("no tool-change position is defined for every axis of '{}'", act.channel().block_text());
        act.diagnose(&diag::NO_REFERENCE, text);
    }
    rapid_to(act, moving, target)
}

/// Back: to the programmed point, or to where the axes were.
pub(crate) fn come_back(act: &mut ActionContext<'_, '_>) -> Acted {
    let (coded, target) = act.targets();
    let before = act.channel_mut().state.others.before_change.take();
    if coded != 0 {
        return rapid_to(act, coded, target);
    }
    match before {
        Some(before) => {
            let before = act.channel().state.place.way_of_machine(&before);
            let moved = act
                .channel()
                .state
                .place
                .position
                .iter()
                .zip(&before)
                .take(act.channel().state.place.layout.axes.len())
                .enumerate();
            let moving = moved.filter(|(_, (now, then))| now != then).fold(0, |bits, (at, _)| bits | 1_u8 << at);
            rapid_to(act, moving, before)
        }
        None => {
            let text = format!(
                "the axes have not been sent to the tool-change position before '{}'",
                act.channel().block_text()
            );
            act.diagnose(&diag::RETURN_WITHOUT_HOME, text);
            Ok(())
        }
    }
}
