//! Tool tip control: its codes, and the words that say where the tool points.
//!
//! Facts: reference control-emulator.md 6.8, system-variables.md 12. Decisions: docs/emulation.md, "Tool tip control".

use counterpoint_channel::frames::tip::least_turning;
use counterpoint_event::event::{Kind, Position};
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::kind::CodeKind;
use counterpoint_machine::ident::{DataId, codes, data};
use counterpoint_machine::index::BySlot;
use counterpoint_machine::model::paths::DirectionDefault;
use counterpoint_motion::frame::affine::Point;
use counterpoint_motion::frame::tool_direction::direction_by_words;

use crate::context::ActionContext;
use crate::entry::{ActionEntry, entry_of_kind};

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] = &[
    ActionEntry::of(&[codes::RTCP_ON], |act, _, _| on(act, 1)),
    ActionEntry::of(&[codes::RTCP2_ON], |act, _, _| on(act, 2)),
    ActionEntry::of(&[codes::RTCP_AT_ENDS], |act, _, _| on(act, AT_ENDS)),
    ActionEntry::of(&[codes::RTCP_OFF], |act, _, _| off(act)),
    entry_of_kind!(CodeKind::TipFormat(format) => |act, _row, _code| orient(act, format)),
];

/// The method that acts at the ends of moves only.
const AT_ENDS: u8 = 3;

/// Words of the forms that say a direction, by `$TCPFMT`.
const WORDS: [[DataId; 3]; 5] = [
    [data::RTCP_VECTOR_X, data::RTCP_VECTOR_Y, data::RTCP_VECTOR_Z],
    [data::RTCP_2PT_X, data::RTCP_2PT_Y, data::RTCP_2PT_Z],
    [data::RTCP_RPY_X, data::RTCP_RPY_Y, data::RTCP_RPY_Z],
    [data::RTCP_EULER_1, data::RTCP_EULER_2, data::RTCP_EULER_3],
    [data::RTCP_CUSTOM_1, data::RTCP_CUSTOM_2, data::RTCP_CUSTOM_3],
];

/// Names of the forms, by `$TCPFMT` from 1.
const NAMES: [&str; 6] = ["axes", "vector", "2pt", "rpy", "euler", "custom"];

/// Switches it on, with the length offset of the block if there is one.
pub(crate) fn on(act: &mut ActionContext<'_, '_>, method: u8) -> Acted {
    let number = act.take(data::COMP_LENGTH).map(|d| d.value).filter(|n| (0.0..=999_999.0).contains(n));
    if let Some(number) = number {
        super::offset_words::length_on(act, number as u32);
    }
    let follow = act.take(data::TIP_FEED).map(|feed| feed.value).filter(|feed| *feed > 0.0);
    let was = act.channel_mut().end_tip();
    if !act.channel_mut().start_tip(number.is_some()) {
        let text = format!(
            "the axes of channel {} do not allow TCP in '{}'",
            act.channel().at.channel,
            act.channel().block_text()
        );
        act.diagnose(&diag::NO_TIP_AXES, text);
        return Ok(());
    }
    let changed = act.channel().state.others.tip.method != method || !was;
    if follow.is_some() || !was {
        act.channel_mut().state.others.tip.follow = follow;
    }
    act.channel_mut().state.others.tip.method = method;
    act.channel_mut().state.others.tip.format = act.channel().state.others.tip.format.max(1);
    if changed {
        let text = match method {
            2 => "rtcp on method=2",
            AT_ENDS => "rtcp at ends",
            _ => "rtcp on",
        };
        act.channel_mut().emit(0, Kind::mode(text));
    }
    Ok(())
}

/// Switches tool tip control off. A move that compensation holds back has points of the tip, so it is executed first.
pub(crate) fn off(act: &mut ActionContext<'_, '_>) -> Acted {
    if act.channel().state.place.tip().is_some() {
        act.flush_lookahead()?;
    }
    if act.channel_mut().end_tip() {
        act.channel_mut().emit(0, Kind::mode("rtcp off"));
    }
    Ok(())
}

/// How the orientation is written from here on.
pub(crate) fn orient(act: &mut ActionContext<'_, '_>, format: u8) -> Acted {
    act.channel_mut().state.others.tip.format = format;
    if act.channel().acting.mode_changed {
        let name = NAMES.get(usize::from(format).wrapping_sub(1)).copied().unwrap_or("axes");
        act.channel_mut().emit(0, Kind::mode(format!("rtcp orient {name}")));
    }
    Ok(())
}

/// A straight move to a target in the work frame, made by `go`. Where only the ends of moves are those of the tip,
/// one that turns rotary axes is a move of the axes; linear axes without any word of theirs stand.
#[inline(always)]
pub(crate) fn straight_move(
    act: &mut ActionContext<'_, '_>,
    (coded, target): (u8, Position),
    go: impl FnOnce(&mut ActionContext<'_, '_>, u8, Position) -> Acted,
) -> Acted {
    match act.channel().state.place.tip() {
        Some(_) if act.channel().state.others.tip.method == AT_ENDS => straight_at_ends(act, (coded, target), go),
        _ => go(act, coded, target),
    }
}

#[cold]
fn straight_at_ends(
    act: &mut ActionContext<'_, '_>,
    (coded, target): (u8, Position),
    go: impl FnOnce(&mut ActionContext<'_, '_>, u8, Position) -> Acted,
) -> Acted {
    let from = act.channel().state.place.position;
    let of =
        |rotary: bool| act.channel().state.place.layout.axes.entries().filter(move |(_, axis)| axis.rotary == rotary);
    if of(true).all(|(slot, _)| from.at(slot) == target.at(slot)) {
        return go(act, coded, target);
    }
    if act.channel().state.place.is_compensated() {
        let text =
            format!("rotary axes cannot turn under compensation of the radius in '{}'", act.channel().block_text());
        return Err(act.alarm(&diag::REFUSED, text));
    }
    let mut machine = act.channel().state.place.machine_point(&target);
    if of(false).all(|(slot, _)| coded & slot.bit() == 0) {
        let stands = act.channel().state.place.machine_point(&from);
        for (slot, _) in of(false) {
            *machine.at_mut(slot) = stands.at(slot);
        }
    }
    act.channel_mut().end_tip();
    let target = act.channel().state.place.point_of_machine(&machine);
    let done = go(act, coded, target);
    act.channel_mut().start_tip(false);
    done
}

/// Takes the words of the orientation and turns the rotary axes of a move; `coded` and the target in the work
/// frame.
#[cold]
pub(crate) fn orient_words(act: &mut ActionContext<'_, '_>, coded: u8, mut target: Position) -> (u8, Position) {
    let format = act.channel().state.others.tip.format;
    let words = usize::from(format).checked_sub(2).and_then(|at| WORDS.get(at)).copied();
    let (Some(words), Some(_)) = (words, act.channel().state.place.tip()) else { return (coded, target) };
    let given = words.map(|id| act.take(id).map(|datum| datum.value));
    if given.iter().all(Option::is_none) {
        return (coded, target);
    }
    if act.channel().state.place.layout.axes.entries().any(|(slot, axis)| axis.rotary && coded & slot.bit() != 0) {
        let text =
            format!("'{}' has angles as well as a tool direction; the direction counts", act.channel().block_text());
        act.diagnose(&diag::TIP_WORDS_MIXED, text);
    }
    let mut values = match act.channel().env.machine.kinematics.missing {
        DirectionDefault::Keep => {
            act.channel().state.others.tip.words.get(usize::from(format)).copied().unwrap_or_default()
        }
        DirectionDefault::Zero => Point::default(),
    };
    for (slot, given) in values.iter_mut().zip(given) {
        *slot = given.unwrap_or(*slot);
    }
    if let Some(slot) = act.channel_mut().state.others.tip.words.get_mut(usize::from(format)) {
        *slot = values;
    }
    let tip = act.channel().state.place.geometry(&act.channel().state.place.program_point(&target));
    let wanted = direction_by_words(format, values, tip);
    let wanted = wanted.map(|wanted| match act.channel().state.place.frames.as_deref() {
        Some(frames) => frames.direction(wanted),
        None => wanted,
    });
    let Some(solution) = wanted.and_then(|wanted| least_turning(act.channel(), wanted)) else {
        let text = format!(
            "the rotary axes cannot reach the tool direction of '{}'; they do not move",
            act.channel().block_text()
        );
        act.diagnose(&diag::TIP_UNREACHABLE, text);
        return (coded, target);
    };
    let mut coded = coded;
    for (axis, angle) in solution {
        *target.at_mut(axis) = angle;
        coded |= axis.bit();
    }
    (coded, target)
}
