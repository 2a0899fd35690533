//! Codes of the local frame: translation, rotation, scale and mirror of the program.
//!
//! Facts: reference control-emulator.md 6.7. *Invariant:* the machine does not move; the programmed point changes.
//! Decisions: docs/emulation.md, "Local frame".

use counterpoint_lang::format::wildcard_text;

use crate::act::Act;
use crate::action::cutter;
use crate::action::entry::{Entry, entry_of_kind};
use crate::state::modal::group;
use counterpoint_event::event::Kind;
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::kind::CodeKind;
use counterpoint_machine::ident::kind::local::Change;
use counterpoint_machine::ident::{DataId, codes, data};
use counterpoint_motion::frame::affine::{Affine, Point};
use counterpoint_motion::frame::local::{Part, Programmed, Refused};

/// Codes and what they do.
pub(crate) const ENTRIES: &[Entry] = &[
    entry_of_kind!(CodeKind::Local(part, of) => |act, _row, _code| change(act, part, of)),
    Entry::of(&[codes::TURRET_OPPOSITE], |act, _, _| opposite(act, true)),
    Entry::of(&[codes::TURRET_OWN], |act, _, _| opposite(act, false)),
];

const TRANSLATION: [DataId; 3] = [data::LCS_TRANS_X, data::LCS_TRANS_Y, data::LCS_TRANS_Z];
const ROTATION_CENTER: [DataId; 3] = [data::LCS_ROT_CENTER_X, data::LCS_ROT_CENTER_Y, data::LCS_ROT_CENTER_Z];
const ABOUT: [DataId; 3] = [data::LCS_ROT_ANGLE_X, data::LCS_ROT_ANGLE_Y, data::LCS_ROT_ANGLE_Z];
const TURNS: [DataId; 3] = [data::LCS_ROT_ANGLE_1, data::LCS_ROT_ANGLE_2, data::LCS_ROT_ANGLE_3];
const SCALES: [DataId; 3] = [data::LCS_SCALE_X, data::LCS_SCALE_Y, data::LCS_SCALE_Z];
const SCALE_CENTER: [DataId; 3] = [data::LCS_SCALE_CENTER_X, data::LCS_SCALE_CENTER_Y, data::LCS_SCALE_CENTER_Z];

/// Directions of X, Y and Z.
const UNITS: [Point; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Executes a code of the local frame.
pub(super) fn change(act: &mut Act<'_, '_>, part: Part, change: Change) -> Acted {
    let has = act.state.place.has_axes();
    let levels = act.cycle_levels();
    let before = act.counts_from();
    let mirrored = cutter::mirror::is_mirrored(act);
    let made = match (part, change) {
        (Part::Mirror, Change::Off) => {
            let given = fewer_mirrors(act);
            act.frames().local.set(part, given, has)
        }
        (_, Change::Off) => act.frames().local.set(part, None, has),
        _ => {
            let given = match part {
                Part::Translate => translation(act, change),
                Part::Rotate => rotation(act, change),
                Part::Scale => scale(act, change),
                Part::Mirror => mirror(act, change),
            };
            match given {
                Some(given) if change == Change::Add => act.frames().local.add(part, given, has),
                Some(given) => act.frames().local.set(part, Some(given), has),
                // An additive code alone changes nothing.
                None if change == Change::Add => Ok(()),
                None => {
                    let text = format!(
                        "the local coordinate system needs its data in '{}'; it is unchanged",
                        act.block_text()
                    );
                    act.diagnose(&diag::DATA_MISSING, text);
                    return Ok(());
                }
            }
        }
    };
    if let Err(refused) = made {
        refuse(act, refused);
    }
    act.frames_changed();
    cutter::mirror::frame_changed(act, mirrored);
    act.keep_ways(before);
    act.keep_levels(levels);
    let text = act.frame_text();
    act.emit(0, Kind::mode(text));
    Ok(())
}

/// The shift of the local frame along these axes ends, bit by axis.
pub(super) fn end_shift(act: &mut Act<'_, '_>, coded: u8) {
    let frames = act.state.place.frames.as_deref();
    let Some(part) = frames.and_then(|frames| frames.local.part(Part::Translate)).copied() else { return };
    let mut by = part.values;
    for (slot, axis) in by.iter_mut().zip(act.state.place.layout.cartesian) {
        if axis.is_some_and(|axis| coded & axis.bit() != 0) {
            *slot = 0.0;
        }
    }
    let has = act.state.place.has_axes();
    if let Err(refused) =
        act.frames().local.set(Part::Translate, Some(Programmed::new(Affine::translation(by), by)), has)
    {
        refuse(act, refused);
    }
    act.frames_changed();
}

/// X is mirrored for tools on the other side of the turning axis: halfway between both turrets.
fn opposite(act: &mut Act<'_, '_>, on: bool) -> Acted {
    let has = act.state.place.has_axes();
    let mirrored = cutter::mirror::is_mirrored(act);
    let at = [act.env.machine.turning.opposite / 2.0, 0.0, 0.0];
    let given = on.then(|| mirror_of([1.0, 0.0, 0.0], at));
    if let Err(refused) = act.frames().local.set(Part::Mirror, given, has) {
        refuse(act, refused);
    }
    act.frames_changed();
    cutter::mirror::frame_changed(act, mirrored);
    let text = act.frame_text();
    act.emit(0, Kind::mode(text));
    Ok(())
}

/// Says why the frame stays as it is.
pub(crate) fn refuse(act: &mut Act<'_, '_>, refused: Refused) {
    let block = act.block_text();
    let (facts, why) = match refused {
        Refused::NoWayBack => (&diag::FRAME_REFUSED, "would have no inverse"),
        Refused::TooMany => (&diag::FRAME_REFUSED, "has too many additive parts"),
        Refused::MissingAxis => (&diag::FRAME_AXIS, "would move an axis that the channel does not have"),
    };
    act.diagnose(facts, format!("the local coordinate system {why} in '{block}'; it is unchanged"));
}

/// Takes three values, lengths as geometry.
fn lengths(act: &mut Act<'_, '_>, ids: [DataId; 3]) -> [Option<f64>; 3] {
    let mut taken = numbers(act, ids);
    for (role, slot) in taken.iter_mut().enumerate() {
        *slot = slot.map(|value| value * act.state.place.scale_of(role));
    }
    taken
}

fn numbers(act: &mut Act<'_, '_>, ids: [DataId; 3]) -> [Option<f64>; 3] {
    ids.map(|id| act.take(id).map(|datum| datum.value))
}

fn translation(act: &mut Act<'_, '_>, change: Change) -> Option<Programmed> {
    let words = lengths(act, TRANSLATION);
    words.iter().any(Option::is_some).then(|| {
        let frames = act.state.place.frames.as_deref().filter(|_| change == Change::On);
        let before = frames.and_then(|frames| frames.local.part(Part::Translate)).map_or([0.0; 3], |part| part.values);
        let by = filled(words, before);
        Programmed::new(Affine::translation(by), by)
    })
}

/// Words, and values for those that are missing.
fn filled(words: [Option<f64>; 3], missing: Point) -> Point {
    let mut values = missing;
    for (slot, word) in values.iter_mut().zip(words) {
        *slot = word.unwrap_or(*slot);
    }
    values
}

/// Takes a centre. A machine that has words for it means the place where the tool stands when the block has none.
fn center(act: &mut Act<'_, '_>, ids: [DataId; 3], part: Part, change: Change) -> Point {
    let here = act.seen_from_work(&act.contour());
    let stands = match act.state.place.frames.as_deref() {
        Some(_) if change == Change::Add => act.seen(&act.programmed()),
        Some(frames) => frames.local.inside_of(part, here).unwrap_or(here),
        None => here,
    };
    let mut missing = [0.0; 3];
    for ((slot, id), stands) in missing.iter_mut().zip(ids).zip(stands) {
        if !act.sources(id).is_empty() {
            *slot = stands;
        }
    }
    filled(lengths(act, ids), missing)
}

fn rotation(act: &mut Act<'_, '_>, change: Change) -> Option<Programmed> {
    let angle = act.take(data::LCS_ROT_ANGLE).map(|datum| datum.value);
    let (about, turns) = (numbers(act, ABOUT), numbers(act, TURNS));
    let center = center(act, ROTATION_CENTER, Part::Rotate, change);
    let given = |words: [Option<f64>; 3]| words.iter().any(Option::is_some).then(|| words.map(|w| w.unwrap_or(0.0)));
    let chain = |axes: [usize; 3], angles: Point| {
        let mut map = Affine::SAME;
        for (axis, angle) in axes.into_iter().zip(angles) {
            map = map.after(&Affine::rotation(UNITS.get(axis).copied()?, angle)?);
        }
        Some(map)
    };
    let (map, values, order, angle) = match (angle, given(about), given(turns)) {
        (Some(angle), direction, _) => {
            let direction = direction.unwrap_or_else(|| normal(act));
            (Affine::rotation(direction, angle)?, direction, "IJK", angle)
        }
        // About X, then Y, then Z of the frame that stands.
        (None, Some([x, y, z]), _) => (chain([2, 1, 0], [z, y, x])?, [x, y, z], "ABC", 0.0),
        // Each about an axis that the ones before have turned.
        (None, None, Some(angles)) => {
            let order = act.env.machine.habits.rotations;
            (chain(order.axes, angles)?, angles, order.name, 0.0)
        }
        (None, None, None) => return None,
    };
    Some(Programmed { map: map.around(center), values, center: Some(center), order, angle })
}

/// Normal of the active plane.
pub(super) fn normal(act: &Act<'_, '_>) -> Point {
    let [x, y, z] = UNITS;
    match act.state.modal.code(group::PLANE) {
        Some(codes::PLANE_ZX) => y,
        Some(codes::PLANE_YZ) => x,
        _ => z,
    }
}

fn scale(act: &mut Act<'_, '_>, change: Change) -> Option<Programmed> {
    let all = act.take_factor(data::LCS_SCALE);
    let each = SCALES.map(|id| act.take_factor(id));
    let center = center(act, SCALE_CENTER, Part::Scale, change);
    if all.is_none() && each.iter().all(Option::is_none) {
        return None;
    }
    let factors = filled(each, [all.unwrap_or(1.0); 3]);
    Some(Programmed { center: Some(center), ..Programmed::new(Affine::scale(factors).around(center), factors) })
}

/// Takes the axis words: where the mirrors stand, and which axes were coded.
fn mirrors(act: &mut Act<'_, '_>) -> [Option<f64>; 3] {
    let mut words = [None; 3];
    for (role, slot) in words.iter_mut().enumerate() {
        let axis = act.state.place.layout.cartesian.get(role).copied().flatten();
        let Some(axis) = axis.map(|axis| &act.state.place.layout.axes[axis]) else { continue };
        let (id, scale) = (axis.data, axis.scale);
        *slot = act.take(id).map(|datum| datum.value * scale);
    }
    words
}

/// Mirrored axes and where their mirrors stand.
fn mirrored(act: &Act<'_, '_>) -> (Point, Point) {
    let frames = act.state.place.frames.as_deref();
    let part = frames.and_then(|frames| frames.local.part(Part::Mirror));
    part.map_or(([0.0; 3], [0.0; 3]), |part| (part.values, part.center.unwrap_or_default()))
}

fn mirror_of(flags: Point, at: Point) -> Programmed {
    let map = Affine::scale(flags.map(|flag| if flag == 1.0 { -1.0 } else { 1.0 })).around(at);
    Programmed { center: Some(at), ..Programmed::new(map, flags) }
}

fn mirror(act: &mut Act<'_, '_>, change: Change) -> Option<Programmed> {
    let words = mirrors(act);
    let (flags, at) = if change == Change::On { mirrored(act) } else { Default::default() };
    let flags = filled(words.map(|word| word.map(|_| 1.0)), flags);
    words.iter().any(Option::is_some).then(|| mirror_of(flags, filled(words, at)))
}

/// The mirrors that are left when those of the block are taken away; all go without words.
fn fewer_mirrors(act: &mut Act<'_, '_>) -> Option<Programmed> {
    let words = mirrors(act);
    let (flags, at) = mirrored(act);
    let left = filled(words.map(|word| word.map(|_| 0.0)), flags);
    (words.iter().any(Option::is_some) && left.contains(&1.0)).then(|| mirror_of(left, at))
}

impl Act<'_, '_> {
    /// The local frame in the words of the listing.
    pub(crate) fn frame_text(&self) -> String {
        let Some(local) = self.state.place.frames.as_deref().map(|frames| &frames.local).filter(|l| l.is_programmed())
        else {
            return "lcs off".to_owned();
        };
        let list = |values: Point| values.map(wildcard_text).join(",");
        let mut text = "lcs".to_owned();
        let values = self.frame_values();
        if local.parts(Part::Translate).next().is_some() {
            text += &format!(" tra={}", list(values.translation));
        }
        if let Some(rotation) = local.parts(Part::Rotate).last() {
            text += &format!(" rot={}", list(rotation.values));
            if rotation.order == "IJK" {
                text += &format!(",{}", wildcard_text(rotation.angle));
            }
        }
        if local.parts(Part::Scale).next().is_some() {
            text += &format!(" sca={}", list(values.scale));
        }
        if local.parts(Part::Mirror).next().is_some() {
            text += &format!(" mir={}", list(values.mirror));
        }
        text
    }
}
