//! Codes of the local frame: translation, rotation, scale and mirror of the program.
//!
//! Facts: reference control-emulator.md 6.7. Invariant: the machine stands still; the programmed point is what changes.
//! Decisions: docs/emulation.md, "Local frame".

use counterpoint_lang::format::wildcard_text;

use crate::channel::Kernel;
use crate::diag;
use crate::log::event::Kind;
use crate::machine::ident::{DataId, codes, data};
use crate::state::modal::group;
use counterpoint_fault::Acted;
use counterpoint_motion::frame::affine::{Affine, Point};
use counterpoint_motion::frame::local::{Given, Part, Refused};

/// What a code does to its part of the frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Change {
    /// Sets it.
    On,
    /// Adds to the active frame.
    Add,
    /// Takes it away.
    Off,
}

const TRANSLATION: [DataId; 3] = [data::LCS_TRANS_X, data::LCS_TRANS_Y, data::LCS_TRANS_Z];
const ROTATION_CENTER: [DataId; 3] = [data::LCS_ROT_CENTER_X, data::LCS_ROT_CENTER_Y, data::LCS_ROT_CENTER_Z];
const ABOUT: [DataId; 3] = [data::LCS_ROT_ANGLE_X, data::LCS_ROT_ANGLE_Y, data::LCS_ROT_ANGLE_Z];
const TURNS: [DataId; 3] = [data::LCS_ROT_ANGLE_1, data::LCS_ROT_ANGLE_2, data::LCS_ROT_ANGLE_3];
const SCALES: [DataId; 3] = [data::LCS_SCALE_X, data::LCS_SCALE_Y, data::LCS_SCALE_Z];
const SCALE_CENTER: [DataId; 3] = [data::LCS_SCALE_CENTER_X, data::LCS_SCALE_CENTER_Y, data::LCS_SCALE_CENTER_Z];

/// Directions of X, Y and Z.
const UNITS: [Point; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// The part of a code, and what it does to it.
pub(super) fn of(id: crate::machine::ident::CodeId) -> Option<(Part, Change)> {
    Some(match id {
        codes::LCS_TRANSLATE_ON => (Part::Translate, Change::On),
        codes::LCS_TRANSLATE_ADD => (Part::Translate, Change::Add),
        codes::LCS_TRANSLATE_OFF => (Part::Translate, Change::Off),
        codes::LCS_ROTATE_ON => (Part::Rotate, Change::On),
        codes::LCS_ROTATE_ADD => (Part::Rotate, Change::Add),
        codes::LCS_ROTATE_OFF => (Part::Rotate, Change::Off),
        codes::LCS_SCALE_ON => (Part::Scale, Change::On),
        codes::LCS_SCALE_ADD => (Part::Scale, Change::Add),
        codes::LCS_SCALE_OFF => (Part::Scale, Change::Off),
        codes::LCS_MIRROR_ON => (Part::Mirror, Change::On),
        codes::LCS_MIRROR_ADD => (Part::Mirror, Change::Add),
        codes::LCS_MIRROR_OFF => (Part::Mirror, Change::Off),
        _ => return None,
    })
}

/// Carries out a code of the local frame.
pub(super) fn change(kernel: &mut Kernel<'_>, part: Part, change: Change) -> Acted {
    let has = kernel.channel.state.place.has_axes();
    let levels = kernel.channel.cycle_levels();
    let before = kernel.channel.counts_from();
    let made = match (part, change) {
        (Part::Mirror, Change::Off) => {
            let given = fewer_mirrors(kernel);
            kernel.channel.frames().local.set(part, given, has)
        }
        (_, Change::Off) => kernel.channel.frames().local.set(part, None, has),
        _ => {
            let given = match part {
                Part::Translate => translation(kernel, change),
                Part::Rotate => rotation(kernel, change),
                Part::Scale => scale(kernel, change),
                Part::Mirror => mirror(kernel, change),
            };
            match given {
                Some(given) if change == Change::Add => kernel.channel.frames().local.add(part, given, has),
                Some(given) => kernel.channel.frames().local.set(part, Some(given), has),
                // An additive code alone changes nothing.
                None if change == Change::Add => Ok(()),
                None => {
                    let text = format!("the frame needs its data in '{}', it stays as it is", kernel.block_text());
                    kernel.diagnose(&diag::DATA_MISSING, text);
                    return Ok(());
                }
            }
        }
    };
    if let Err(refused) = made {
        refuse(kernel, refused);
    }
    kernel.channel.frames_changed();
    kernel.channel.keep_ways(before);
    kernel.channel.keep_levels(levels);
    let text = kernel.frame_text();
    kernel.emit(0, Kind::mode(text));
    Ok(())
}

/// Says why the frame stays as it is.
pub(crate) fn refuse(kernel: &mut Kernel<'_>, refused: Refused) {
    let block = kernel.block_text();
    let (facts, why) = match refused {
        Refused::NoWayBack => (&diag::FRAME_REFUSED, "would leave no way back to the program"),
        Refused::TooMany => (&diag::FRAME_REFUSED, "has too many additive parts"),
        Refused::MissingAxis => (&diag::FRAME_AXIS, "would move an axis that the channel does not have"),
    };
    kernel.diagnose(facts, format!("the local frame {why} in '{block}', it stays as it is"));
}

/// Takes three values, lengths as geometry.
fn lengths(kernel: &mut Kernel<'_>, ids: [DataId; 3]) -> [Option<f64>; 3] {
    let mut taken = numbers(kernel, ids);
    for (role, slot) in taken.iter_mut().enumerate() {
        *slot = slot.map(|value| value * kernel.channel.state.place.scale_of(role));
    }
    taken
}

fn numbers(kernel: &mut Kernel<'_>, ids: [DataId; 3]) -> [Option<f64>; 3] {
    ids.map(|id| kernel.take(id).map(|datum| datum.value))
}

fn translation(kernel: &mut Kernel<'_>, change: Change) -> Option<Given> {
    let words = lengths(kernel, TRANSLATION);
    words.iter().any(Option::is_some).then(|| {
        let frames = kernel.channel.state.place.frames.as_deref().filter(|_| change == Change::On);
        let before = frames.and_then(|frames| frames.local.part(Part::Translate)).map_or([0.0; 3], |part| part.values);
        let by = filled(words, before);
        Given::new(Affine::translation(by), by)
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
fn center(kernel: &mut Kernel<'_>, ids: [DataId; 3], part: Part, change: Change) -> Point {
    let here = kernel.channel.seen_from_work(&kernel.channel.contour());
    let stands = match kernel.channel.state.place.frames.as_deref() {
        Some(_) if change == Change::Add => kernel.channel.seen(&kernel.channel.programmed()),
        Some(frames) => frames.local.inside_of(part, here).unwrap_or(here),
        None => here,
    };
    let mut missing = [0.0; 3];
    for ((slot, id), stands) in missing.iter_mut().zip(ids).zip(stands) {
        if kernel.plan.data.sources.get(usize::from(id.0)).is_some_and(|sources| !sources.is_empty()) {
            *slot = stands;
        }
    }
    filled(lengths(kernel, ids), missing)
}

fn rotation(kernel: &mut Kernel<'_>, change: Change) -> Option<Given> {
    let angle = kernel.take(data::LCS_ROT_ANGLE).map(|datum| datum.value);
    let (about, turns) = (numbers(kernel, ABOUT), numbers(kernel, TURNS));
    let center = center(kernel, ROTATION_CENTER, Part::Rotate, change);
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
            let direction = direction.unwrap_or_else(|| normal(kernel));
            (Affine::rotation(direction, angle)?, direction, "IJK", angle)
        }
        // About X, then Y, then Z of the frame that stands.
        (None, Some([x, y, z]), _) => (chain([2, 1, 0], [z, y, x])?, [x, y, z], "ABC", 0.0),
        // Each about an axis that the ones before have turned.
        (None, None, Some(angles)) => {
            let order = kernel.channel.env.machine.habits.rotations;
            (chain(order.axes, angles)?, angles, order.name, 0.0)
        }
        (None, None, None) => return None,
    };
    Some(Given { map: map.around(center), values, center: Some(center), order, angle })
}

/// Normal of the active plane.
fn normal(kernel: &Kernel<'_>) -> Point {
    let [x, y, z] = UNITS;
    match kernel.channel.state.modal.code(group::PLANE) {
        Some(codes::PLANE_ZX) => y,
        Some(codes::PLANE_YZ) => x,
        _ => z,
    }
}

fn scale(kernel: &mut Kernel<'_>, change: Change) -> Option<Given> {
    let all = kernel.take(data::LCS_SCALE).map(|datum| datum.value);
    let each = numbers(kernel, SCALES);
    let center = center(kernel, SCALE_CENTER, Part::Scale, change);
    if all.is_none() && each.iter().all(Option::is_none) {
        return None;
    }
    let factors = filled(each, [all.unwrap_or(1.0); 3]);
    Some(Given { center: Some(center), ..Given::new(Affine::scale(factors).around(center), factors) })
}

/// Takes the axis words: where the mirrors stand, and which axes were coded.
fn mirrors(kernel: &mut Kernel<'_>) -> [Option<f64>; 3] {
    let mut words = [None; 3];
    for (role, slot) in words.iter_mut().enumerate() {
        let axis = kernel.channel.state.place.cartesian.get(role).copied().flatten().map(usize::from);
        let Some(axis) = axis.and_then(|axis| kernel.channel.state.place.axes.get(axis)) else { continue };
        let (id, scale) = (axis.data, axis.scale);
        *slot = kernel.take(id).map(|datum| datum.value * scale);
    }
    words
}

/// Mirrored axes and where their mirrors stand.
fn mirrored(kernel: &Kernel<'_>) -> (Point, Point) {
    let frames = kernel.channel.state.place.frames.as_deref();
    let part = frames.and_then(|frames| frames.local.part(Part::Mirror));
    part.map_or(([0.0; 3], [0.0; 3]), |part| (part.values, part.center.unwrap_or_default()))
}

fn mirror_of(flags: Point, at: Point) -> Given {
    let map = Affine::scale(flags.map(|flag| if flag == 1.0 { -1.0 } else { 1.0 })).around(at);
    Given { center: Some(at), ..Given::new(map, flags) }
}

fn mirror(kernel: &mut Kernel<'_>, change: Change) -> Option<Given> {
    let words = mirrors(kernel);
    let (flags, at) = if change == Change::On { mirrored(kernel) } else { Default::default() };
    let flags = filled(words.map(|word| word.map(|_| 1.0)), flags);
    words.iter().any(Option::is_some).then(|| mirror_of(flags, filled(words, at)))
}

/// The mirrors that are left when those of the block are taken away; all go without words.
fn fewer_mirrors(kernel: &mut Kernel<'_>) -> Option<Given> {
    let words = mirrors(kernel);
    let (flags, at) = mirrored(kernel);
    let left = filled(words.map(|word| word.map(|_| 0.0)), flags);
    (words.iter().any(Option::is_some) && left.contains(&1.0)).then(|| mirror_of(left, at))
}

impl Kernel<'_> {
    /// The local frame in the words of the listing.
    pub(crate) fn frame_text(&self) -> String {
        let Some(local) =
            self.channel.state.place.frames.as_deref().map(|frames| &frames.local).filter(|l| l.is_programmed())
        else {
            return "lcs off".to_owned();
        };
        let list = |values: Point| values.map(wildcard_text).join(",");
        let mut text = "lcs".to_owned();
        let told = self.channel.frame_values();
        if local.parts(Part::Translate).next().is_some() {
            text += &format!(" tra={}", list(told.translation));
        }
        if let Some(rotation) = local.parts(Part::Rotate).last() {
            text += &format!(" rot={}", list(rotation.values));
            if rotation.order == "IJK" {
                text += &format!(",{}", wildcard_text(rotation.angle));
            }
        }
        if local.parts(Part::Scale).next().is_some() {
            text += &format!(" sca={}", list(told.scale));
        }
        if local.parts(Part::Mirror).next().is_some() {
            text += &format!(" mir={}", list(told.mirror));
        }
        text
    }
}
