//! `$FDK`, `$FIK`, `$FKINCFG`, `$FKINROT`: the rotary axes of the channel as functions of macros.
//!
//! Facts: reference functions.md 10. Machine positions are those of `$XM`, so neither tools nor fixtures count, except
//! that the fixture offset has placed the part. Decision: a position that cannot be reached is `$NULL`.

use crate::host::rotary;
use crate::host::variables::positions;
use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::position::MotionState;
use counterpoint_lang::diag::DiagnosticNumber;
use counterpoint_lang::fault::{MacroFault, Outcome};
use counterpoint_lang::value::MacroValue;
use counterpoint_machine::index::{AxisSlot, BySlot};

use super::rotary::{RotarySubject, is};
use counterpoint_event::event::{MAX_AXES, Position};
use counterpoint_motion::frame::affine::Point;
use counterpoint_motion::frame::kinematics::{Angles, Chain, Joint, unit};

/// Six numbers by the elements of `$AXES`, or position and direction.
type Six = [f64; 6];

fn numbers(value: Option<&MacroValue>, mut into: Six) -> Outcome<Six> {
    match value {
        Some(MacroValue::Sequence(given)) => {
            for (slot, value) in into.iter_mut().zip(given.iter()) {
                *slot = value.as_real().ok_or_else(|| MacroFault::kind("a number", value))?;
            }
            Ok(into)
        }
        None => Ok(into),
        Some(value) => Err(MacroFault::kind("a sequence", value)),
    }
}

fn halves([x, y, z, i, j, k]: Six) -> (Point, Point) {
    ([x, y, z], [i, j, k])
}

/// Machine positions of `$XM` where the axes are.
fn machine_now(channel: &ChannelContext<'_>) -> Position {
    let mut at = channel.state.place.machine_point(&channel.state.place.position);
    for ((slot, shift), preset) in at.iter_mut().zip(&channel.state.place.shift).zip(&channel.state.place.preset) {
        *slot += preset - shift;
    }
    at
}

/// From positions of `$XM` to the joints without a tool, by channel axis.
fn fixture(channel: &ChannelContext<'_>) -> Position {
    let tool = channel.tool_shift();
    let mut fixture = [0.0; MAX_AXES];
    for (((slot, shift), preset), tool) in
        fixture.iter_mut().zip(&channel.state.place.shift).zip(&channel.state.place.preset).zip(tool)
    {
        *slot = shift - preset - tool;
    }
    fixture
}

/// `$FDK`: position and direction on the part of machine positions.
pub(crate) fn forward(channel: &ChannelContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    let given = numbers(arguments.first(), by_elements(&channel.state.place, &machine_now(channel)))?;
    let fixture = fixture(channel);
    let mut joints = machine_now(channel);
    for (axis, value) in positions::six_axes(&channel.state.place).into_iter().zip(given) {
        if let Some(axis) = axis {
            *joints.at_mut(axis) = value;
        }
    }
    for (slot, fixture) in joints.iter_mut().zip(fixture) {
        *slot += fixture;
    }
    let chain = channel.chain();
    let angle = |axis: AxisSlot| joints.at(axis);
    let tip = chain.tip(channel.state.place.geometry(&joints), [0.0; 3], angle);
    let (Some(tip), Some(direction)) = (tip, chain.direction(angle)) else { return Ok(MacroValue::Null) };
    let base = channel.state.place.geometry(&fixture);
    let mut point = tip;
    for (slot, base) in point.iter_mut().zip(base) {
        *slot -= base;
    }
    Ok(MacroValue::numbers(&[programmed_units(&channel.state.place, point), direction].concat()))
}

/// `$FIK`: machine positions of a position and direction on the part.
pub(crate) fn backward(channel: &ChannelContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    let (given, number) = match arguments {
        [] => (None, None),
        [first @ MacroValue::Sequence(_)] => (Some(first), None),
        [first] => (None, Some(first)),
        [first, second, ..] => (Some(first), Some(second)),
    };
    let now = match forward(channel, &[])? {
        value @ MacroValue::Sequence(_) => numbers(Some(&value), [0.0; 6])?,
        _ => return Ok(MacroValue::Null),
    };
    let (point, direction) = halves(numbers(given, now)?);
    let number = number.and_then(MacroValue::as_real).unwrap_or(0.0);
    if ![0.0, 1.0, 2.0].contains(&number) {
        return Err(MacroFault::new(DiagnosticNumber::OUT_OF_RANGE, format!("a solution is 0, 1 or 2, not {number}")));
    }
    let chain = channel.chain();
    let all: Vec<Angles<AxisSlot>> = if chain.tables.is_empty() && chain.heads.is_empty() {
        vec![Vec::new()]
    } else {
        chain.solve(direction).iter().map(|one| channel.state.place.near(one)).collect()
    };
    let reached: Vec<Six> = all.iter().map(|solution| machine_positions(channel, &chain, solution, point)).collect();
    let chosen = chosen(channel, &all, &reached, number).and_then(|at| reached.get(at));
    Ok(chosen.map_or(MacroValue::Null, |six| MacroValue::numbers(six)))
}

/// Machine positions of a solution, by the elements of `$AXES`.
fn machine_positions(
    channel: &ChannelContext<'_>,
    chain: &Chain<AxisSlot>,
    solution: &Angles<AxisSlot>,
    point: Point,
) -> Six {
    let fixture = fixture(channel);
    let mut joints = machine_now(channel);
    for (slot, fixture) in joints.iter_mut().zip(fixture) {
        *slot += fixture;
    }
    for (axis, angle) in solution {
        let shift = channel.state.place.shift.at(*axis);
        if let Some(angle) = angle {
            *joints.at_mut(*axis) = angle + shift;
        }
    }
    let angle = |axis: AxisSlot| joints.at(axis);
    let base = channel.state.place.geometry(&fixture);
    let mut part = point;
    for (role, (slot, base)) in part.iter_mut().zip(base).enumerate() {
        *slot = *slot * channel.state.place.scale_of(role) + base;
    }
    let mut linear = chain.linear(part, [0.0; 3], angle);
    for (slot, base) in linear.iter_mut().zip(base) {
        *slot -= base;
    }
    let mut out = joints;
    for ((slot, fixture), axis) in out.iter_mut().zip(fixture).zip(&channel.state.place.layout.axes) {
        *slot -= if axis.rotary { fixture } else { 0.0 };
    }
    let mut six = by_elements(&channel.state.place, &out);
    for (slot, value) in six.iter_mut().zip(programmed_units(&channel.state.place, linear)) {
        *slot = value;
    }
    six
}

/// The solution with a number: 0 is the first within the limits, 1 the one with the least turning (of equal
/// solutions the one with the shortest travel of the linear axes), 2 the other solution.
fn chosen(channel: &ChannelContext<'_>, all: &[Angles<AxisSlot>], reached: &[Six], number: f64) -> Option<usize> {
    if number != 1.0 && number != 2.0 {
        return all.iter().position(|one| channel.state.place.within(one)).or((!all.is_empty()).then_some(0));
    }
    let [x, y, z, ..] = by_elements(&channel.state.place, &machine_now(channel));
    let way = |[a, b, c, ..]: &Six| (a - x).hypot(b - y).hypot(c - z);
    // Differences of rounding decide nothing.
    let rounded = |value: f64| (value * 1e6).round();
    let mut sorted: Vec<(f64, f64, usize)> = all
        .iter()
        .zip(reached)
        .enumerate()
        .map(|(at, (one, six))| (rounded(channel.state.place.turned(one)), rounded(way(six)), at))
        .collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let wanted = if number == 2.0 { sorted.last() } else { sorted.first() };
    wanted.map(|(.., at)| *at)
}

/// Takes over changed kinematics; nothing moves. `false` if tool tip control could not continue.
fn change_kinematics(
    channel: &mut ChannelContext<'_>,
    change: impl FnOnce(&mut counterpoint_channel::frames::tip::TipSettings),
) -> bool {
    let before = channel.state.others.tip.clone();
    change(&mut channel.state.others.tip);
    if channel.state.place.tip().is_none() {
        return true;
    }
    if !channel.chain().is_possible() {
        channel.state.others.tip = before;
        return false;
    }
    let machine = channel.state.place.machine_point(&channel.state.place.position);
    channel.refresh_tip();
    channel.state.place.position = channel.state.place.point_of_machine(&machine);
    channel.state.place.frames_changed();
    true
}

/// `$FKINCFG`: moves a rotary axis or the tool axis, or puts it back.
pub(crate) fn configure(channel: &mut ChannelContext<'_>, arguments: &[MacroValue]) -> MacroValue {
    let done = configured(channel, arguments).unwrap_or(false);
    MacroValue::Real(f64::from(u8::from(done)))
}

fn configured(channel: &mut ChannelContext<'_>, arguments: &[MacroValue]) -> Option<bool> {
    let (named, count) = rotary::named_axis(channel, arguments, 0)?;
    let rest = arguments.get(count..)?;
    if is(rest.first(), "OFF") {
        return Some(match named {
            RotarySubject::Missing => false,
            RotarySubject::Tool => change_kinematics(channel, |settings| settings.direction = None),
            RotarySubject::Axis(axis) => change_kinematics(channel, |s| s.changed.retain(|joint| joint.axis != axis)),
        });
    }
    let mut six = [0.0; 6];
    for (slot, value) in six.iter_mut().zip(rest.iter()) {
        *slot = value.as_real()?;
    }
    let (center, vector) = halves(six);
    let valid = rest.len() == 6 && unit(vector).is_some() && center.iter().all(|value| value.is_finite());
    Some(match named {
        RotarySubject::Tool if valid => change_kinematics(channel, |settings| settings.direction = Some(vector)),
        RotarySubject::Axis(axis) if valid && channel.state.place.layout.axes[axis].rotary => {
            change_kinematics(channel, |settings| {
                settings.changed.retain(|joint| joint.axis != axis);
                settings.changed.push(Joint { axis, vector, center });
            })
        }
        _ => false,
    })
}

/// `$FKINROT`: the rotary axes of tool tip control.
pub(crate) fn choose_rotary(channel: &mut ChannelContext<'_>, arguments: &[MacroValue]) -> MacroValue {
    let (mut at, mut chosen) = (0, Vec::new());
    while at < arguments.len() {
        match rotary::named_axis(channel, arguments, at) {
            Some((RotarySubject::Axis(axis), count)) if channel.state.place.layout.axes[axis].rotary => {
                if chosen.contains(&axis) {
                    return MacroValue::Real(0.0);
                }
                chosen.push(axis);
                at += count;
            }
            _ => return MacroValue::Real(0.0),
        }
    }
    let valid = (1..=2).contains(&chosen.len());
    let done = valid && change_kinematics(channel, |settings| settings.chosen = chosen);
    MacroValue::Real(f64::from(u8::from(done)))
}

fn by_elements(place: &MotionState, of: &Position) -> Six {
    positions::six_axes(place).map(|axis| axis.map_or(0.0, |axis| of.at(axis)))
}

fn programmed_units(place: &MotionState, point: Point) -> Point {
    let mut point = point;
    for (role, slot) in point.iter_mut().enumerate() {
        *slot /= place.scale_of(role);
    }
    point
}
