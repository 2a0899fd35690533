//! The pole of polar coordinates.
//!
//! Facts: reference siemens-cycles.md (G110 to G112). *Invariant:* the pole is a point of the program; nothing moves.

use counterpoint_fault::Acted;
use counterpoint_machine::ident::codes;

use crate::context::ActionContext;
use crate::cutter::angle::set_pole;
use crate::entry::{ActionEntry, CompensationEffect};

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] = &[
    ActionEntry::of(&[codes::POLE_TOOL], |act, _, _| set(act, From::Tool)).contour(CompensationEffect::Waits),
    ActionEntry::of(&[codes::POLE_ZERO], |act, _, _| set(act, From::Zero)).contour(CompensationEffect::Waits),
    ActionEntry::of(&[codes::POLE_LAST], |act, _, _| set(act, From::Pole)).contour(CompensationEffect::Waits),
];

/// The reference point of the words of a pole.
enum From {
    Tool,
    Zero,
    Pole,
}

fn set(act: &mut ActionContext<'_, '_>, from: From) -> Acted {
    let from = match from {
        From::Tool => act.channel().state.place.programmed(),
        From::Zero => Default::default(),
        From::Pole => act.channel().state.arcs.pole,
    };
    set_pole(act, from);
    act.channel().check_stop()
}
