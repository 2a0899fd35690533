//! Tool offsets by which the moves of a block are longer or shorter (Fanuc G45 to G48).
//!
//! Facts: Mitsubishi M700V programming manual 12.6: the offset acts along each axis of the block, in the direction of
//! its move; a distance of 0 has the direction of its sign in G91 and none in G90; canned cycles ignore the code. The
//! distances to circle centres change like those to their ends (examples of the same section). *Invariant:* only the
//! words of the block change, before its motion takes them.

use counterpoint_channel::modal::group;
use counterpoint_channel::tool_radius::cutter_radius;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::dimension::Dimension;
use counterpoint_machine::ident::kind::CodeKind;
use counterpoint_machine::ident::{DataId, codes, data};
use counterpoint_machine::index::BySlot;

use crate::context::ActionContext;
use crate::entry::{ActionEntry, CompensationEffect};

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] = &[
    ActionEntry::of(&[codes::TOOL_LENGTHEN], |act, _, _| lengthen(act, 1.0)).contour(CompensationEffect::Waits),
    ActionEntry::of(&[codes::TOOL_SHORTEN], |act, _, _| lengthen(act, -1.0)).contour(CompensationEffect::Waits),
    ActionEntry::of(&[codes::TOOL_LENGTHEN_TWICE], |act, _, _| lengthen(act, 2.0)).contour(CompensationEffect::Waits),
    ActionEntry::of(&[codes::TOOL_SHORTEN_TWICE], |act, _, _| lengthen(act, -2.0)).contour(CompensationEffect::Waits),
];

const CENTERS: [DataId; 3] = [data::ARC_CENTER_X, data::ARC_CENTER_Y, data::ARC_CENTER_Z];

/// Lengthens the distances of the block by a multiple of the offset.
fn lengthen(act: &mut ActionContext<'_, '_>, times: f64) -> Acted {
    super::tool_offsets::take_diameter(act);
    if act.channel().state.cycle.running {
        return Ok(());
    }
    let by = times * cutter_radius(act.channel(), act.channel().diameter_number());
    let relative = act.channel().state.modal.code(group::POSITION) == Some(codes::POSITION_RELATIVE);
    let stands = act.channel().state.place.programmed();
    for slot in act.channel().state.place.layout.axes.ids() {
        let axis = &act.channel().state.place.layout.axes[slot];
        if axis.rotary {
            continue;
        }
        let way = if relative { MovePart::Distance } else { MovePart::From(stands.at(slot)) };
        change(act, axis.data, way, by);
    }
    if is_circle(act) {
        for id in CENTERS {
            change(act, id, MovePart::Center, by);
        }
    }
    Ok(())
}

/// Whether the block moves along a circle.
fn is_circle(act: &ActionContext<'_, '_>) -> bool {
    let is_arc = |id: counterpoint_machine::ident::CodeId| matches!(id.kind(), CodeKind::Arc(_));
    let rows = act.channel().block.pending.iter().map(|pending| &act.channel().env.machine.codes[pending.row]);
    let mut motions = rows.filter(|row| row.group == group::MOTION).map(|row| row.id).peekable();
    match motions.peek() {
        Some(_) => motions.any(is_arc),
        None => act.channel().state.modal.code(group::MOTION).is_some_and(is_arc),
    }
}

/// The part of a move that a word describes.
#[derive(Clone, Copy)]
enum MovePart {
    /// The distance itself; 0 has the direction of its sign.
    Distance,
    /// The end of the move that starts at this position; a zero distance has no direction.
    From(f64),
    /// The distance from the start to a centre.
    Center,
}

/// Lengthens the distance of one word.
fn change(act: &mut ActionContext<'_, '_>, id: DataId, said: MovePart, by: f64) {
    let registers = act.registers_of(id);
    let factor = act.channel().unit_factor(Dimension::Length);
    for word in &mut act.channel_mut().block.words {
        if word.used || registers & word.register.bit() == 0 {
            continue;
        }
        let (way, no_way_counts) = match said {
            MovePart::From(from) if !word.incremental => (word.value * factor - from, false),
            MovePart::From(_) | MovePart::Distance => (word.value, true),
            MovePart::Center => (word.value, false),
        };
        if way != 0.0 || no_way_counts {
            word.value += by * way.signum() / factor;
        }
    }
}
