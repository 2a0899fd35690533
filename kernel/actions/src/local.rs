//! Codes of the local frame: translation, rotation, scale and mirror of the program.
//!
//! Facts: reference control-emulator.md 6.7. *Invariant:* the machine does not move; the programmed point changes.
//! Decisions: docs/emulation.md, "Local frame".

use counterpoint_channel::frame_transforms::FrameTransforms;
use counterpoint_channel::modal::group;
use counterpoint_event::event::Kind;
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_lang::format::wildcard_text;
use counterpoint_machine::ident::kind::CodeKind;
use counterpoint_machine::ident::kind::local::FrameChange;
use counterpoint_machine::ident::{DataId, codes, data};
use counterpoint_motion::frame::affine::{Affine, Point};
use counterpoint_motion::frame::beside::Lines;
use counterpoint_motion::frame::local::{FrameError, LocalFramePart, Programmed};

use crate::context::ActionContext;
use crate::cutter;
use crate::dwell::take_factor;
use crate::entry::{ActionEntry, entry_of_kind};
use crate::local_beside as beside;

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] = &[
    entry_of_kind!(CodeKind::Local(part, of) => |act, _row, _code| change(act, part, of)),
    ActionEntry::of(&[codes::TURRET_OPPOSITE], |act, _, _| opposite(act, true)),
    ActionEntry::of(&[codes::TURRET_OWN], |act, _, _| opposite(act, false)),
];

const TRANSLATION: [DataId; 3] = [data::LCS_TRANS_X, data::LCS_TRANS_Y, data::LCS_TRANS_Z];
const ROTATION_CENTER: [DataId; 3] = [data::LCS_ROT_CENTER_X, data::LCS_ROT_CENTER_Y, data::LCS_ROT_CENTER_Z];
const ABOUT: [DataId; 3] = [data::LCS_ROT_ANGLE_X, data::LCS_ROT_ANGLE_Y, data::LCS_ROT_ANGLE_Z];
const TURNS: [DataId; 3] = [data::LCS_ROT_ANGLE_1, data::LCS_ROT_ANGLE_2, data::LCS_ROT_ANGLE_3];
const SCALES: [DataId; 3] = [data::LCS_SCALE_X, data::LCS_SCALE_Y, data::LCS_SCALE_Z];
const SCALE_CENTER: [DataId; 3] = [data::LCS_SCALE_CENTER_X, data::LCS_SCALE_CENTER_Y, data::LCS_SCALE_CENTER_Z];

/// Directions of X, Y and Z.
const UNITS: [Point; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// A part as the block gives it: of X, Y and Z, and of the axes beside them.
struct ProgrammedPart {
    local: Option<Programmed>,
    beside: Option<Lines>,
}

/// Executes a code of the local frame.
pub(crate) fn change(act: &mut ActionContext<'_, '_>, part: LocalFramePart, change: FrameChange) -> Acted {
    let levels = act.channel_mut().state.cycle_levels();
    let before = act.channel().counts_from();
    let mirrored = cutter::mirror::is_mirrored(act);
    let given = match (part, change) {
        (LocalFramePart::Mirror, FrameChange::Off) => fewer_mirrors(act),
        (_, FrameChange::Off) => ProgrammedPart { local: None, beside: None },
        _ => {
            let given = given(act, part, change);
            // An additive code alone changes nothing.
            if given.local.is_none() && given.beside.is_none() && change != FrameChange::Add {
                let text = format!(
                    "the local coordinate system needs its data in '{}'; it is unchanged",
                    act.channel().block_text()
                );
                act.diagnose(&diag::DATA_MISSING, text);
                return Ok(());
            }
            given
        }
    };
    if let Err(refused) = put(act, part, change, given) {
        refuse(act, refused);
    }
    act.channel_mut().state.place.frames_changed();
    cutter::mirror::frame_changed(act, mirrored);
    act.channel_mut().state.place.keep_ways(before);
    act.channel_mut().state.keep_levels(levels);
    let text = frame_text(act);
    act.channel_mut().emit(0, Kind::mode(text));
    Ok(())
}

/// The shift of the local frame along these axes ends, bit by axis.
pub(crate) fn end_shift(act: &mut ActionContext<'_, '_>, coded: u8) {
    beside::end_shift(act, coded);
    let frames = act.channel().state.place.frames.as_deref();
    let Some(part) = frames.and_then(|frames| frames.local.part(LocalFramePart::Translate)).copied() else { return };
    let mut by = part.values;
    for (slot, axis) in by.iter_mut().zip(act.channel().state.place.layout.cartesian) {
        if axis.is_some_and(|axis| coded & axis.bit() != 0) {
            *slot = 0.0;
        }
    }
    let has = act.channel().state.place.has_axes();
    if let Err(refused) = act.channel_mut().state.place.frames().local.set(
        LocalFramePart::Translate,
        Some(Programmed::new(Affine::translation(by), by)),
        has,
    ) {
        refuse(act, refused);
    }
    act.channel_mut().state.place.frames_changed();
}

/// Exchanges the local shifts when another work offset becomes active, if each has its own.
pub(crate) fn exchange_shifts(act: &mut ActionContext<'_, '_>, old: u32, new: u32) {
    let [old, new] = [old, new].map(|number| number.max(1));
    if !act.channel().env.machine.habits.shift_of_each || old == new || act.channel().state.place.frames.is_none() {
        return;
    }
    let frames = act.channel_mut().state.place.frames();
    let local = frames.local.part(LocalFramePart::Translate).copied();
    let beside = frames.beside.as_deref().and_then(|beside| beside.part(LocalFramePart::Translate)).copied();
    let mut kept = frames.shifts.take().unwrap_or_default();
    let (next, next_beside) = kept.remove(&new).unwrap_or_default();
    if local.is_some() || beside.is_some() {
        kept.insert(old, (local, beside));
    }
    frames.shifts = Some(kept).filter(|kept| !kept.is_empty());
    if (local, beside) == (next, next_beside) {
        return;
    }
    if let Err(refused) =
        put(act, LocalFramePart::Translate, FrameChange::On, ProgrammedPart { local: next, beside: next_beside })
    {
        refuse(act, refused);
    }
    act.channel_mut().state.place.frames_changed();
    let text = frame_text(act);
    act.channel_mut().emit(0, Kind::mode(text));
}

/// X is mirrored for tools on the other side of the turning axis: halfway between both turrets.
fn opposite(act: &mut ActionContext<'_, '_>, on: bool) -> Acted {
    let has = act.channel().state.place.has_axes();
    let mirrored = cutter::mirror::is_mirrored(act);
    let at = [act.channel().env.machine.turning.opposite / 2.0, 0.0, 0.0];
    let given = on.then(|| mirror_of([1.0, 0.0, 0.0], at));
    if let Err(refused) = act.channel_mut().state.place.frames().local.set(LocalFramePart::Mirror, given, has) {
        refuse(act, refused);
    }
    act.channel_mut().state.place.frames_changed();
    cutter::mirror::frame_changed(act, mirrored);
    let text = frame_text(act);
    act.channel_mut().emit(0, Kind::mode(text));
    Ok(())
}

/// Takes the data of a part. Axes that a translation or a mirror does not name keep their values.
fn given(act: &mut ActionContext<'_, '_>, part: LocalFramePart, change: FrameChange) -> ProgrammedPart {
    let adds = change == FrameChange::Add;
    let (local, beside) = match part {
        LocalFramePart::Translate => (translation(act, change), beside::translation(act, adds)),
        LocalFramePart::Rotate => return ProgrammedPart { local: rotation(act, change), beside: None },
        LocalFramePart::Scale => return ProgrammedPart { local: scale(act, change), beside: beside::scale(act) },
        LocalFramePart::Mirror => (mirror(act, change), beside::mirror(act, adds)),
    };
    if adds || local.is_none() && beside.is_none() {
        return ProgrammedPart { local, beside };
    }
    let frames = act.channel().state.place.frames.as_deref();
    let kept = |frames: &FrameTransforms| frames.local.part(part).copied();
    let kept_beside = |frames: &FrameTransforms| frames.beside.as_deref()?.part(part).copied();
    ProgrammedPart {
        local: local.or_else(|| frames.and_then(kept)),
        beside: beside.or_else(|| frames.and_then(kept_beside)),
    }
}

/// Puts a part into force for all axes, or for none.
fn put(
    act: &mut ActionContext<'_, '_>,
    part: LocalFramePart,
    change: FrameChange,
    given: ProgrammedPart,
) -> Result<(), FrameError> {
    let has = act.channel().state.place.has_axes();
    let frames = act.channel_mut().state.place.frames();
    let now = || frames.beside.as_deref().cloned().unwrap_or_default();
    let beside = match (change, given.beside) {
        (FrameChange::Add, Some(lines)) => Some(now().with_added(part, lines)?),
        (FrameChange::Add, None) => None,
        (_, None) if frames.beside.is_none() => None,
        (_, lines) => Some(now().with(part, lines)?),
    };
    match (change, given.local) {
        (FrameChange::Add, Some(given)) => frames.local.add(part, given, has)?,
        (FrameChange::Add, None) => {}
        (_, given) => frames.local.set(part, given, has)?,
    }
    if let Some(beside) = beside {
        frames.beside = Some(Box::new(beside)).filter(|beside| !beside.is_empty());
    }
    Ok(())
}

/// Says why the frame stays as it is.
pub(crate) fn refuse(act: &mut ActionContext<'_, '_>, refused: FrameError) {
    let block = act.channel().block_text();
    let (facts, why) = match refused {
        FrameError::NoWayBack => (&diag::FRAME_REFUSED, "would have no inverse"),
        FrameError::TooMany => (&diag::FRAME_REFUSED, "has too many additive parts"),
        FrameError::MissingAxis => (&diag::FRAME_AXIS, "would move an axis that the channel does not have"),
    };
    act.diagnose(facts, format!("the local coordinate system {why} in '{block}'; it is unchanged"));
}

/// Takes three values, lengths as geometry.
fn lengths(act: &mut ActionContext<'_, '_>, ids: [DataId; 3]) -> [Option<f64>; 3] {
    let mut taken = numbers(act, ids);
    for (role, slot) in taken.iter_mut().enumerate() {
        *slot = slot.map(|value| value * act.channel().state.place.scale_of(role));
    }
    taken
}

fn numbers(act: &mut ActionContext<'_, '_>, ids: [DataId; 3]) -> [Option<f64>; 3] {
    ids.map(|id| act.take(id).map(|datum| datum.value))
}

fn translation(act: &mut ActionContext<'_, '_>, change: FrameChange) -> Option<Programmed> {
    let words = lengths(act, TRANSLATION);
    words.iter().any(Option::is_some).then(|| {
        let frames = act.channel().state.place.frames.as_deref().filter(|_| change == FrameChange::On);
        let before =
            frames.and_then(|frames| frames.local.part(LocalFramePart::Translate)).map_or([0.0; 3], |part| part.values);
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

/// Takes a centre. A machine that has words for it means the place where the tool is when the block has none.
fn center(act: &mut ActionContext<'_, '_>, ids: [DataId; 3], part: LocalFramePart, change: FrameChange) -> Point {
    let here = act.channel().state.place.seen_from_work(&act.channel().state.place.contour());
    let stands = match act.channel().state.place.frames.as_deref() {
        Some(_) if change == FrameChange::Add => {
            act.channel().state.place.seen(&act.channel().state.place.programmed())
        }
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

fn rotation(act: &mut ActionContext<'_, '_>, change: FrameChange) -> Option<Programmed> {
    let angle = act.take(data::LCS_ROT_ANGLE).map(|datum| datum.value);
    let (about, turns) = (numbers(act, ABOUT), numbers(act, TURNS));
    let bare = change == FrameChange::On && about.iter().chain(&turns).all(Option::is_none);
    let angle = angle.or_else(|| act.channel().env.machine.habits.rotation_angle.filter(|_| bare));
    let named = ROTATION_CENTER.map(|id| act.block_has(id));
    let center = center(act, ROTATION_CENTER, LocalFramePart::Rotate, change);
    let frames = act.channel().state.place.frames.as_deref().filter(|_| act.channel().env.machine.habits.scaled_center);
    let inside = |part: LocalFramePart| frames.and_then(|frames| frames.local.part(part)).map(|given| given.map);
    let mirror = inside(LocalFramePart::Mirror);
    let mut center = inside(LocalFramePart::Scale).map_or(center, |scale| scale.point(center));
    if let Some(mirror) = mirror {
        // The position of the tool is outside the mirror already.
        let image = mirror.point(center);
        let own = center.iter_mut().zip(image).zip(named).filter(|(_, named)| !named);
        own.for_each(|((slot, image), _)| *slot = image);
    }
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
            let order = act.channel().env.machine.habits.rotations;
            (chain(order.axes, angles)?, angles, order.name, 0.0)
        }
        (None, None, None) => return None,
    };
    let map = map.around(center);
    // In the image the rotation has its own image: about the mirrored centre, in the other sense.
    let map = mirror.map_or(map, |mirror| mirror.after(&map).after(&mirror));
    Some(Programmed { map, values, center: Some(center), order, angle })
}

/// Normal of the active plane.
pub(crate) fn normal(act: &ActionContext<'_, '_>) -> Point {
    let [x, y, z] = UNITS;
    match act.channel().state.modal.code(group::PLANE) {
        Some(codes::PLANE_ZX) => y,
        Some(codes::PLANE_YZ) => x,
        _ => z,
    }
}

fn scale(act: &mut ActionContext<'_, '_>, change: FrameChange) -> Option<Programmed> {
    let all = take_factor(act, data::LCS_SCALE);
    let each = SCALES.map(|id| take_factor(act, id));
    let bare = change == FrameChange::On && each.iter().all(Option::is_none);
    let all = all.or_else(|| act.channel().env.machine.habits.scale_factor.filter(|_| bare));
    let center = center(act, SCALE_CENTER, LocalFramePart::Scale, change);
    if all.is_none() && each.iter().all(Option::is_none) {
        return None;
    }
    let factors = filled(each, [all.unwrap_or(1.0); 3]);
    Some(Programmed { center: Some(center), ..Programmed::new(Affine::scale(factors).around(center), factors) })
}

/// Takes the axis words: where the mirrors are, and which axes were coded.
fn mirrors(act: &mut ActionContext<'_, '_>) -> [Option<f64>; 3] {
    let mut words = [None; 3];
    for (role, slot) in words.iter_mut().enumerate() {
        let axis = act.channel().state.place.layout.cartesian.get(role).copied().flatten();
        let Some(axis) = axis.map(|axis| &act.channel().state.place.layout.axes[axis]) else { continue };
        let (id, scale) = (axis.data, axis.scale);
        *slot = act.take(id).map(|datum| datum.value * scale);
    }
    words
}

/// Mirrored axes and where their mirrors are.
fn mirrored(act: &ActionContext<'_, '_>) -> (Point, Point) {
    let frames = act.channel().state.place.frames.as_deref();
    let part = frames.and_then(|frames| frames.local.part(LocalFramePart::Mirror));
    part.map_or(([0.0; 3], [0.0; 3]), |part| (part.values, part.center.unwrap_or_default()))
}

fn mirror_of(flags: Point, at: Point) -> Programmed {
    let map = Affine::scale(flags.map(|flag| if flag == 1.0 { -1.0 } else { 1.0 })).around(at);
    Programmed { center: Some(at), ..Programmed::new(map, flags) }
}

fn mirror(act: &mut ActionContext<'_, '_>, change: FrameChange) -> Option<Programmed> {
    let words = mirrors(act);
    let (flags, at) = if change == FrameChange::On { mirrored(act) } else { Default::default() };
    let flags = filled(words.map(|word| word.map(|_| 1.0)), flags);
    words.iter().any(Option::is_some).then(|| mirror_of(flags, filled(words, at)))
}

/// The mirrors that remain when those of the block are removed; all go without words.
fn fewer_mirrors(act: &mut ActionContext<'_, '_>) -> ProgrammedPart {
    let words = mirrors(act);
    let (flags, at) = mirrored(act);
    let left = filled(words.map(|word| word.map(|_| 0.0)), flags);
    let lines = beside::fewer_mirrors(act);
    if words.iter().all(Option::is_none) && lines.is_none() {
        return ProgrammedPart { local: None, beside: None };
    }
    let beside = lines.or_else(|| {
        let frames = act.channel().state.place.frames.as_deref()?.beside.as_deref()?;
        frames.part(LocalFramePart::Mirror).copied()
    });
    ProgrammedPart { local: left.contains(&1.0).then(|| mirror_of(left, at)), beside }
}

/// The local frame in the words of the listing.
pub(crate) fn frame_text(act: &ActionContext<'_, '_>) -> String {
    let Some(frames) = act.channel().state.place.frames.as_deref() else { return "lcs off".to_owned() };
    let local = &frames.local;
    if !local.is_programmed() && frames.beside.is_none() {
        return "lcs off".to_owned();
    }
    let list = |values: Point| values.map(wildcard_text).join(",");
    let mut text = "lcs".to_owned();
    let values = act.channel().state.place.frame_values();
    let mut part = |part: LocalFramePart, word: &str, values: Point| {
        let beside = beside::text(act, part);
        if local.parts(part).next().is_some() || !beside.is_empty() {
            text += &format!(" {word}={}{beside}", list(values));
        }
        if let Some(rotation) = local.parts(LocalFramePart::Rotate).last().filter(|_| part == LocalFramePart::Translate)
        {
            text += &format!(" rot={}", list(rotation.values));
            if rotation.order == "IJK" {
                text += &format!(",{}", wildcard_text(rotation.angle));
            }
        }
    };
    part(LocalFramePart::Translate, "tra", values.translation);
    part(LocalFramePart::Scale, "sca", values.scale);
    part(LocalFramePart::Mirror, "mir", values.mirror);
    text
}
