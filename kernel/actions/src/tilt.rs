//! Tilted planes: where they lie, and how the rotary axes turn into them.
//!
//! Facts: reference heidenhain-cycles.md 6, siemens-cycles.md 2; Fanuc G68.2 and G53.1. *Invariant:* a block that says
//! no plane makes none. Decisions: docs/emulation.md, "Tilted planes".

use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::frame_transforms::{PartialPlane, Turned};
use counterpoint_event::event::Kind;
use counterpoint_fault as diag;
use counterpoint_fault::{Acted, Halt};
use counterpoint_lang::format::wildcard_text;
use counterpoint_machine::ident::kind::CodeKind;
use counterpoint_machine::ident::kind::local::FrameChange;
use counterpoint_machine::ident::kind::plane::{PlaneDefinition, Tilt};
use counterpoint_machine::ident::{DataId, data};
use counterpoint_machine::index::{AxisSlot, BySlot};
use counterpoint_motion::frame::affine::{Affine, Point};
use counterpoint_motion::frame::local::LocalFramePart;
use counterpoint_motion::frame::orient::OrientationError;
use counterpoint_motion::frame::plane;
use counterpoint_motion::frame::plane::UNITS;

use crate::context::ActionContext;
use crate::entry::{ActionEntry, entry_of_kind};
use crate::motion::forget_parts;
use crate::retract::{go, rate, retract};

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] =
    &[entry_of_kind!(CodeKind::Plane(tilt) => |act, _row, _code| execute(act, tilt))];

const ZERO: [DataId; 3] = [data::TILT_X, data::TILT_Y, data::TILT_Z];
const SHIFT: [DataId; 3] = [data::TILT_SHIFT_X, data::TILT_SHIFT_Y, data::TILT_SHIFT_Z];
const NUMBERS: [DataId; 9] = [
    data::TILT_1,
    data::TILT_2,
    data::TILT_3,
    data::TILT_4,
    data::TILT_5,
    data::TILT_6,
    data::TILT_7,
    data::TILT_8,
    data::TILT_9,
];

/// Forms by their numbers.
const FORMS: [PlaneDefinition; 7] = [
    PlaneDefinition::Euler,
    PlaneDefinition::Fixed,
    PlaneDefinition::Points,
    PlaneDefinition::Directions,
    PlaneDefinition::Projections,
    PlaneDefinition::Turned,
    PlaneDefinition::Positions,
];

/// A definition: the plane in the frame around it, and the angles of the rotary axes if the definition gives them.
struct Defined {
    plane: Affine,
    angles: Option<Turned>,
}

fn execute(act: &mut ActionContext<'_, '_>, tilt: Tilt) -> Acted {
    match tilt {
        Tilt::On(form) => define(act, form, false),
        Tilt::Add(form) => define(act, form, true),
        Tilt::Off => {
            end(act);
            Ok(())
        }
        Tilt::Cancel if end(act) => Ok(()),
        Tilt::Cancel => super::local::change(act, LocalFramePart::Rotate, FrameChange::Off),
        Tilt::Turn => turn(act, None),
        Tilt::Move => {
            let behind = act.take(data::TILT_DISTANCE).map_or(0.0, |datum| datum.value);
            turn(act, Some(behind))
        }
        Tilt::Side(positive) => {
            act.channel_mut().state.others.tilt.side = Some(positive);
            Ok(())
        }
        Tilt::Table => {
            act.channel_mut().state.others.tilt.table = true;
            Ok(())
        }
    }
}

/// Ends the plane; `false` if there was none.
fn end(act: &mut ActionContext<'_, '_>) -> bool {
    act.channel_mut().state.others.tilt = Default::default();
    let ended = act.channel_mut().end_tilt();
    if ended {
        act.channel_mut().emit(0, Kind::mode("tilt off"));
    }
    ended
}

/// The alarm for a block that says no plane.
fn undefined(act: &mut ActionContext<'_, '_>, why: &str) -> Halt {
    let text = format!("{why} in '{}'; the plane is unchanged", act.channel().block_text());
    act.alarm(&diag::PLANE_UNDEFINED, text)
}

/// The alarm for a channel without rotary axes.
fn no_axes(act: &mut ActionContext<'_, '_>) -> Halt {
    let text = format!(
        "the axes of channel {} do not tilt the tool in '{}'",
        act.channel().at.channel,
        act.channel().block_text()
    );
    act.alarm(&diag::NO_TIP_AXES, text)
}

/// Makes a plane.
fn define(act: &mut ActionContext<'_, '_>, form: PlaneDefinition, add: bool) -> Acted {
    let defined = read(act, form, add)?;
    // A further block may complete it.
    let Some(Defined { plane, angles }) = defined else { return Ok(()) };
    if !act.channel().can_tilt() {
        return Err(no_axes(act));
    }
    if act.channel().state.place.polar().is_some() {
        return Err(undefined(act, "interpolation on a face or a cylinder is active"));
    }
    let map = act.channel().state.place.around_plane(add).after(&plane);
    // Feeds and lengths are those of the plane.
    if (map.determinant().abs() - 1.0).abs() > 1e-9 {
        return Err(undefined(act, "a plane does not lie in scaled coordinates"));
    }
    let angles = match angles {
        Some(angles) => Ok(Some(angles)),
        None if act.channel().env.machine.kinematics.tilting.assumed => act.channel().angles_into(&map).map(Some),
        None => Ok(None),
    };
    act.channel_mut().state.others.tilt = Default::default();
    let angles = match angles {
        Ok(angles) => angles,
        Err(why) => return unreached(act, why),
    };
    if !act.channel_mut().tilt(map, angles) {
        return Err(undefined(act, "the plane has no way back"));
    }
    let text = tilt_text(act.channel());
    act.channel_mut().emit(0, Kind::mode(text));
    Ok(())
}

fn unreached(act: &mut ActionContext<'_, '_>, why: OrientationError) -> Acted {
    let why = match why {
        OrientationError::Direction => "no angles of the rotary axes bring the tool square to the plane",
        OrientationError::Travel => "the travel of the rotary axes ends before the plane",
        OrientationError::Side => "the rotary axes do not come into the plane on this side",
    };
    let text = format!("{why} of '{}'; nothing moves", act.channel().block_text());
    Err(act.alarm(&diag::PLANE_UNREACHABLE, text))
}

/// Definition in a block; none if it is a part of a definition that other blocks complete.
fn read(act: &mut ActionContext<'_, '_>, of_code: PlaneDefinition, add: bool) -> Result<Option<Defined>, Halt> {
    let said = act.take(data::TILT_FORM).map(|datum| datum.value);
    let number = said.unwrap_or(0.0);
    let form = match of_code {
        PlaneDefinition::Said => FORMS.iter().enumerate().find(|(at, _)| *at as f64 == number).map(|(_, form)| *form),
        form => Some(form),
    };
    // A factor of the word may leave noise.
    let part = act.take(data::TILT_PART).map(|datum| (datum.value * 1e6).round() / 1e6);
    let zero = lengths(act, ZERO);
    let shift = lengths(act, SHIFT).map(|value| value.unwrap_or(0.0));
    // Words of rotary axes may have the registers of the numbers.
    let numbers = if form == Some(PlaneDefinition::Positions) { [None; 9] } else { numbers(act) };
    let rotation = act.take(data::TILT_ROTATION).map_or(0.0, |datum| datum.value);
    let Some(form) = form else { return Err(undefined(act, "no such form of a plane")) };
    let by_parts = matches!(form, PlaneDefinition::Points | PlaneDefinition::Directions) && part.is_some();
    if by_parts {
        return parts(act, form == PlaneDefinition::Points, part.unwrap_or(0.0), (zero, numbers, rotation));
    }
    if forget_parts(act).is_some() {
        return Err(undefined(act, "a definition by several blocks is not complete"));
    }
    if said.is_none() && form != PlaneDefinition::Positions && !complete(of_code, add, &numbers) {
        return Err(undefined(act, "values of the plane are missing"));
    }
    let of = |from: usize| -> Point { [0, 1, 2].map(|at| numbers.get(from + at).copied().flatten().unwrap_or(0.0)) };
    let mut angles = None;
    let turned = match form {
        PlaneDefinition::Euler if part.is_some() => None,
        PlaneDefinition::Euler => plane::turned([2, 0, 2], of(0)),
        PlaneDefinition::Turned => order(part).and_then(|order| plane::turned(order, of(0))),
        // Angles by axis, in any order.
        PlaneDefinition::Fixed => order(part).and_then(|order| {
            let [a, b, c] = order.map(|axis| of(0).get(axis).copied().unwrap_or(0.0));
            plane::turned_about_fixed(order, [a, b, c])
        }),
        PlaneDefinition::Points => plane::of_points([of(0), of(3), of(6)]),
        PlaneDefinition::Directions => plane::of_directions(of(0), of(3)),
        PlaneDefinition::Projections => {
            let [x, y, z] = of(0);
            plane::of_projections(x, y, z)
        }
        PlaneDefinition::Positions => {
            let said = positions(act);
            let made = act.channel().plane_at(&said);
            angles = Some(said);
            made
        }
        PlaneDefinition::Said => None,
    };
    let Some(turned) = turned else { return Err(undefined(act, "angles, directions or points of no plane")) };
    let around = Affine::rotation(UNITS[2], rotation).unwrap_or(Affine::SAME);
    let zero = zero.map(|value| value.unwrap_or(0.0));
    let plane = Affine::translation(zero).after(&turned).after(&around).after(&Affine::translation(shift));
    Ok(Some(Defined { plane, angles }))
}

/// Whether a code of a form of its own has all of its numbers; one that adds has one angle.
fn complete(form: PlaneDefinition, add: bool, numbers: &[Option<f64>]) -> bool {
    let needed = match form {
        PlaneDefinition::Said | PlaneDefinition::Positions => return true,
        PlaneDefinition::Euler | PlaneDefinition::Fixed | PlaneDefinition::Turned | PlaneDefinition::Projections => 3,
        PlaneDefinition::Directions => 6,
        PlaneDefinition::Points => 9,
    };
    let given = numbers.iter().take(needed).filter(|number| number.is_some()).count();
    given == if add { 1 } else { needed }
}

/// The axes of an order by its digits; X, Y, Z without one.
fn order(digits: Option<f64>) -> Option<[usize; 3]> {
    let Some(digits) = digits else { return Some([0, 1, 2]) };
    if !(111.0..=333.0).contains(&digits) || digits.fract() != 0.0 {
        return None;
    }
    let digits = digits as usize;
    let order = [digits / 100, digits / 10 % 10, digits % 10];
    let sound = order.iter().all(|digit| (1..=3).contains(digit)) && order[0] != order[1] && order[1] != order[2];
    sound.then(|| order.map(|digit| digit - 1))
}

/// Takes three lengths, as geometry.
fn lengths(act: &mut ActionContext<'_, '_>, ids: [DataId; 3]) -> [Option<f64>; 3] {
    let mut taken = ids.map(|id| act.take(id).map(|datum| datum.value));
    for (role, slot) in taken.iter_mut().enumerate() {
        *slot = slot.map(|value| value * act.channel().state.place.scale_of(role));
    }
    taken
}

fn numbers(act: &mut ActionContext<'_, '_>) -> [Option<f64>; 9] {
    NUMBERS.map(|id| act.take(id).map(|datum| datum.value))
}

/// Positions of the rotary axes by their words, otherwise by the numbers of the form in the order of the axes; others
/// stay.
fn positions(act: &mut ActionContext<'_, '_>) -> Turned {
    let chain = act.channel().chain();
    let tilts = |axis: &AxisSlot| chain.tables.iter().chain(&chain.heads).any(|joint| joint.axis == *axis);
    let axes: Vec<AxisSlot> = act.channel().state.place.layout.axes.ids().filter(tilts).collect();
    let mut words = Vec::new();
    for axis in &axes {
        words.push(act.take(act.channel().state.place.layout.axes[*axis].data).map(|datum| datum.value));
    }
    if words.iter().all(Option::is_none) {
        words = numbers(act).to_vec();
    }
    let position = |(axis, word): (&AxisSlot, Option<f64>)| {
        (
            *axis,
            word.map_or_else(
                || act.channel().state.place.stand(*axis).at,
                |word| act.channel().state.place.machine_angle(*axis, word),
            ),
        )
    };
    axes.iter().zip(words).map(position).collect()
}

/// A block of a definition that several blocks make (Fanuc G68.2 P2 Q0 to Q3, P3 Q1 and Q2).
fn parts(
    act: &mut ActionContext<'_, '_>,
    points: bool,
    part: f64,
    (zero, numbers, rotation): ([Option<f64>; 3], [Option<f64>; 9], f64),
) -> Result<Option<Defined>, Halt> {
    let last = if points { 3 } else { 2 };
    let started = forget_parts(act);
    if started.is_none() && act.channel().state.place.tilted().is_some() {
        return Err(undefined(act, "a plane is active already"));
    }
    if started.as_ref().is_some_and(|started| started.points != points) {
        return Err(undefined(act, "a definition by several blocks is not complete"));
    }
    // The blocks come in their order; that before the first point may be left out.
    let mut all = started.map_or(PartialPlane { points, known: [None; 4], rotation: 0.0 }, |started| *started);
    let fits = match all.known.iter().rposition(Option::is_some) {
        Some(before) => part == before as f64 + 1.0,
        None => part == 1.0 || points && part == 0.0,
    };
    if !fits || part > f64::from(last) {
        return Err(undefined(act, "Q is not the next one of the definition"));
    }
    let needs: &[Option<f64>] = if points { &zero } else { numbers.get(..3).unwrap_or_default() };
    if part > 0.0 && needs.iter().any(Option::is_none) {
        return Err(undefined(act, "a point or direction needs three values"));
    }
    let value = |of: Option<f64>| of.unwrap_or(0.0);
    let [x, y, z] = zero.map(value);
    let [i, j, k] = [0, 1, 2].map(|at| value(numbers.get(at).copied().flatten()));
    if let Some(slot) = all.known.get_mut(part as usize) {
        *slot = Some([x, y, z, i, j, k]);
    }
    if rotation != 0.0 {
        all.rotation = rotation;
    }
    if part < f64::from(last) {
        act.channel_mut().state.place.frames().parts = Some(Box::new(all));
        return Ok(None);
    }
    let point = |at: usize| -> Point {
        let [x, y, z, ..] = all.known.get(at).copied().flatten().unwrap_or_default();
        [x, y, z]
    };
    let direction = |at: usize| -> Point {
        let [.., i, j, k] = all.known.get(at).copied().flatten().unwrap_or_default();
        [i, j, k]
    };
    let turned = if points {
        plane::of_points([point(1), point(2), point(3)])
    } else {
        plane::of_directions(direction(1), direction(2))
    };
    let Some(turned) = turned else { return Err(undefined(act, "directions or points of no plane")) };
    let around = Affine::rotation(UNITS[2], all.rotation).unwrap_or(Affine::SAME);
    // The zero is the first point, moved along the axes of the plane by the block before it.
    let plane = Affine::translation(point(1)).after(&turned).after(&Affine::translation(point(0))).after(&around);
    Ok(Some(Defined { plane, angles: None }))
}

/// Turns the rotary axes into the plane; `keep`: a point so far behind the tip keeps its place on the part.
fn turn(act: &mut ActionContext<'_, '_>, keep: Option<f64>) -> Acted {
    let known = act.channel().state.place.tilted().map(|tilt| (*tilt.map(), tilt.angles.clone()));
    let angles = match known {
        Some((_, Some(angles))) => Ok(angles),
        Some((map, None)) => act.channel().angles_into(&map),
        None if !act.channel().can_tilt() => return Err(no_axes(act)),
        None => act.channel().angles_into(&Affine::SAME),
    };
    act.channel_mut().state.others.tilt = Default::default();
    let angles = match angles {
        Ok(angles) => angles,
        Err(why) => return unreached(act, why),
    };
    let feed = rate(act);
    if let Some(way) = act.take(data::TILT_RETRACT).map(|datum| datum.value) {
        retract(act, way, feed)?;
    }
    let own = act.channel().state.place.tip().is_some();
    let lifted = act.channel_mut().lift_plane();
    if let Some(behind) = keep.filter(|_| !own) {
        act.channel_mut().keep_tip(behind, false);
    }
    let mut coded = 0;
    let target = if act.channel().state.place.tip().is_some() {
        let mut target = act.channel().state.place.position;
        for (axis, angle) in &angles {
            *target.at_mut(*axis) = angle - act.channel().state.place.shift.at(*axis);
        }
        target
    } else {
        let mut machine = act.channel().state.place.machine_point(&act.channel().state.place.position);
        for (axis, angle) in &angles {
            *machine.at_mut(*axis) = *angle;
        }
        act.channel().state.place.way_of_machine(&machine)
    };
    for (axis, _) in &angles {
        coded |= axis.bit();
    }
    go(act, coded, target, feed)?;
    if keep.is_some() && !own {
        act.channel_mut().end_tip();
    }
    if let Some(lifted) = lifted {
        act.channel_mut().turned_into(lifted, angles);
    }
    Ok(())
}

/// The plane in the words of the listing: its zero and the directions of its X and Z in the frame around it.
pub(crate) fn tilt_text(channel: &ChannelContext<'_>) -> String {
    let Some(map) = channel.state.place.tilted().map(|tilt| *tilt.map()) else {
        return "tilt off".to_owned();
    };
    let list = |point: Point| point.map(|value| wildcard_text((value * 1e6).round() / 1e6 + 0.0)).join(",");
    let mut zero = map.point([0.0; 3]);
    for (role, slot) in zero.iter_mut().enumerate() {
        *slot /= channel.state.place.scale_of(role);
    }
    let [x, _, z] = UNITS.map(|unit| list(map.direction(unit)));
    format!("tilt zero={} x={x} z={z}", list(zero))
}
