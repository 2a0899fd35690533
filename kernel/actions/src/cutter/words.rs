//! Corner words and angle words of a block: their requests for the contour.
//!
//! They are taken before the move of their block. *Invariant:* a word that the move has no use for is reported.

use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::{CodeId, DataId, codes, data};
use counterpoint_motion::contour::blend::CornerBlend;

use super::corner;
use crate::context::ActionContext;
use counterpoint_channel::corner::{ContourRequest, CornerDirection, CornerRequest};

/// Whether a move has words of corners or angles in its block.
#[inline(always)]
pub(crate) fn has_words(act: &ActionContext<'_, '_>, code: CodeId) -> bool {
    let registers = act.contour_registers();
    let straight = matches!(code, codes::INTERP_LINEAR | codes::RAPID);
    act.channel().block.has_any(if straight { registers.line } else { registers.arc })
}

/// Executes a move with the corner words of its block.
#[cold]
pub(crate) fn with_words<'a, 'k>(
    act: &mut ActionContext<'a, 'k>,
    code: CodeId,
    moves: impl FnOnce(&mut ActionContext<'a, 'k>) -> Acted,
) -> Acted {
    if only_ignored(act, code) {
        return moves(act);
    }
    let asked = take(act, code);
    act.channel().check_stop()?;
    if asked.is_empty() {
        if let Some(cutter) = act.channel_mut().state.place.cutter() {
            cutter.asked = asked;
        }
        return moves(act);
    }
    if !corner::take_part(act) {
        return moves(act);
    }
    if let Some(cutter) = act.channel_mut().state.place.cutter() {
        cutter.asked = asked;
    }
    moves(act)?;
    let left = act.channel_mut().state.place.cutter().map(|cutter| std::mem::take(&mut cutter.asked));
    if left.is_some_and(|left| !left.is_empty()) {
        refused(act, "the block has no move in the plane that it could act on");
    }
    corner::end(act);
    act.channel().check_stop()
}

/// Whether other codes of the block ignore all these words (`G40 I K`): they are neither corners nor angles.
fn only_ignored(act: &ActionContext<'_, '_>, code: CodeId) -> bool {
    let registers = act.contour_registers();
    let registers = if matches!(code, codes::INTERP_LINEAR | codes::RAPID) { registers.line } else { registers.arc };
    let rows = act.channel().block.pending.iter().map(|pending| &act.channel().env.machine.codes[pending.row]);
    let ignored = rows.flat_map(|row| &row.ignores).fold(0_u128, |bits, register| bits | register.bit());
    !act.channel().block.has_any(registers & !ignored)
}

/// A word that cannot act.
fn refused(act: &mut ActionContext<'_, '_>, why: &str) {
    let text = format!("a corner or angle word cannot act in '{}': {why}", act.channel().block_text());
    act.diagnose(&diag::CORNER_REFUSED, text);
}

/// Takes the words of a block with a move.
fn take(act: &mut ActionContext<'_, '_>, code: CodeId) -> ContourRequest {
    let straight = matches!(code, codes::INTERP_LINEAR | codes::RAPID);
    let mut found: Vec<(f64, CornerRequest)> = Vec::new();
    let feed = own_feed(act);
    let mut add = |value: f64, cut: fn(f64) -> CornerBlend, side: Option<CornerDirection>| {
        found.push((value, CornerRequest { cut: cut(value.abs()), side, feed, modal: false }));
    };
    for (id, cut) in [
        (data::CORNER_LEGS, CornerBlend::Legs as fn(f64) -> CornerBlend),
        (data::CORNER_FACE, CornerBlend::Face),
        (data::CORNER_ROUND, CornerBlend::Round),
    ] {
        if let Some(value) = act.take(id).map(|datum| datum.value) {
            add(value, cut, None);
        }
    }
    // Polar interpolation has words of its own.
    if straight && act.channel().state.place.polar().is_none() {
        let [x, _, z] = act.channel().state.place.layout.cartesian;
        for (id, axis, cut) in [
            (data::CORNER_SIDE, None, CornerBlend::Legs as fn(f64) -> CornerBlend),
            (data::CORNER_SIDE_X, x, CornerBlend::Legs),
            (data::CORNER_SIDE_Z, z, CornerBlend::Legs),
            (data::CORNER_SIDE_ROUND, None, CornerBlend::Round),
        ] {
            if let Some(value) = take_beside_axes(act, id) {
                add(value.abs(), cut, Some(CornerDirection { axis, positive: value > 0.0 }));
            }
        }
    }
    if let Some((value, corner)) = corner_of_code(act, feed).filter(|_| straight) {
        found.push((value, corner));
    }
    modal_rounding(act);
    let mut asked = ContourRequest { feed, ..ContourRequest::default() };
    if straight {
        asked.angle = take_beside_axes(act, data::LINE_ANGLE);
    }
    if found.len() > 1 {
        let text = format!("'{}' has more than one corner", act.channel().block_text());
        act.diagnose(&diag::CORNER_TWICE, text);
    }
    match found.first() {
        // Siemens programs switch a corner off by 0.
        Some((value, _)) if *value == 0.0 => {}
        Some((value, _)) if !(*value > 0.0 && value.is_finite()) => refused(act, "its length or radius is not above 0"),
        Some((_, corner)) => asked.corner = Some(*corner),
        None => {}
    }
    if code == codes::RAPID && !asked.is_empty() && !act.channel().env.machine.corners.rapid {
        refused(act, "a rapid move has no corner");
        return ContourRequest::default();
    }
    asked.polar = polar(act);
    asked
}

/// Distance from the pole and angle; the one missing in the block keeps its last value.
pub(crate) fn polar(act: &mut ActionContext<'_, '_>) -> Option<[f64; 2]> {
    let ids = [data::POLE_RADIUS, data::POLE_ANGLE];
    let own = ids.map(|id| act.take(id).map(|datum| datum.value));
    if own == [None; 2] {
        return None;
    }
    let mut both = [0.0; 2];
    for ((slot, id), own) in both.iter_mut().zip(ids).zip(own) {
        if let Some(value) = own {
            act.channel_mut().state.remembered.remember(id, value);
        }
        match act.channel().state.remembered.value(id).filter(|value| value.is_finite()) {
            Some(value) => *slot = value,
            None => refused(act, "distance from the pole and angle are not both known"),
        }
    }
    Some(both)
}

/// The corner that a code of the block makes of a word.
fn corner_of_code(act: &mut ActionContext<'_, '_>, feed: Option<f64>) -> Option<(f64, CornerRequest)> {
    let (rounds, _) =
        act.channel_mut().state.arcs.corner.take().filter(|(_, block)| *block == act.channel().at.blocks)?;
    let value = act.take(data::CORNER_SIZE)?.value;
    let size = value.abs();
    let cut = if rounds { CornerBlend::Round(size) } else { CornerBlend::Legs(size) };
    let side = Some(CornerDirection { axis: None, positive: value > 0.0 });
    Some((size, CornerRequest { cut, side, feed, modal: false }))
}

/// A code that gives the kind of the corner of its block.
pub(crate) fn code(act: &mut ActionContext<'_, '_>, rounds: bool) -> Acted {
    if !act.block_has(data::CORNER_SIZE) {
        refused(act, "the code has no length or radius");
    }
    act.channel_mut().state.arcs.corner = Some((rounds, act.channel().at.blocks));
    act.channel().check_stop()
}

/// A word of a register that no axis of the channel has and no code of the block ignores.
fn take_beside_axes(act: &mut ActionContext<'_, '_>, id: DataId) -> Option<f64> {
    let axes = act.channel().state.place.layout.axes.iter().fold(0, |bits, axis| bits | act.registers_of(axis.data));
    let rows = act.channel().block.pending.iter().map(|pending| &act.channel().env.machine.codes[pending.row]);
    let ignored = rows.flat_map(|row| &row.ignores).fold(0_u128, |bits, &register| bits | 1 << register.index());
    if act.registers_of(id) & (axes | ignored) & act.channel().block.present != 0 {
        return None;
    }
    act.take(id).map(|datum| datum.value)
}

/// Feed of the corners of a block.
fn own_feed(act: &mut ActionContext<'_, '_>) -> Option<f64> {
    if let Some(feed) = act.take(data::CORNER_FEED_MODAL).map(|datum| datum.value) {
        act.channel_mut().state.remembered.remember(data::CORNER_FEED_MODAL, feed);
    }
    let own = act.take(data::CORNER_FEED).map(|datum| datum.value);
    own.or_else(|| act.channel().state.remembered.value(data::CORNER_FEED_MODAL)).filter(|feed| *feed > 0.0)
}

/// Rounding of all corners from this block on.
fn modal_rounding(act: &mut ActionContext<'_, '_>) {
    let Some(radius) = act.take(data::CORNER_ROUND_MODAL).map(|datum| datum.value) else { return };
    if radius < 0.0 || !radius.is_finite() {
        refused(act, "its radius is negative");
        return;
    }
    act.channel_mut().state.place.frames().rounding = (radius > 0.0).then_some(radius);
    if radius > 0.0 {
        corner::take_part(act);
    } else {
        act.channel_mut().state.place.frames_changed();
    }
}
