//! Codes that define the corner at the end of their block.
//!
//! Facts: reference okuma-osp.md (G75, G76), heidenhain-cycles.md 2 (M97, M98), programming manuals of Heidenhain
//! controls (M197). *Invariant:* the corner belongs to the move of its block.

use counterpoint_machine::ident::{codes, data};

use counterpoint_program::block::ContourEnd;

use crate::context::ActionContext;
use crate::cutter;
use crate::entry::{ActionEntry, CompensationEffect};
use counterpoint_fault::Acted;

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] = &[
    ActionEntry::of(&[codes::CORNER_CHAMFER], |act, _, _| cutter::corner_code(act, false))
        .contour(CompensationEffect::Waits),
    ActionEntry::of(&[codes::CORNER_ROUND], |act, _, _| cutter::corner_code(act, true))
        .contour(CompensationEffect::Waits),
    ActionEntry::of(&[codes::CONTOUR_SHARP], |act, _, _| ends(act, ContourEnd::Sharp))
        .contour(CompensationEffect::Waits),
    ActionEntry::of(&[codes::CONTOUR_EXTENDED], |act, _, _| {
        let by = act.take(data::CONTOUR_EXTENSION).map_or(0.0, |datum| datum.value.max(0.0));
        ends(act, ContourEnd::Extended(by))
    })
    .contour(CompensationEffect::Waits),
    ActionEntry::of(&[codes::CONTOUR_OPEN], |act, _, _| ends(act, ContourEnd::Open)).contour(CompensationEffect::Waits),
];

fn ends(act: &mut ActionContext<'_, '_>, end: ContourEnd) -> Acted {
    act.channel_mut().block.flags.end = end;
    Ok(())
}
