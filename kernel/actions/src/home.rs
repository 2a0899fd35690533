//! Reference points: via an intermediate point to them, and back.
//!
//! Facts: reference control-emulator.md 6.1 (`CODE_GOHOME` has data, via the given point to the reference).

use counterpoint_channel::channel_axis::ChannelAxis;
use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::rotary_words::next_to;
use counterpoint_channel::trace;
use counterpoint_channel::trace::ACTION;
use counterpoint_event::event::Position;
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_lang::format::wildcard_text;
use counterpoint_machine::habits::Home;
use counterpoint_machine::ident::{codes, data};
use counterpoint_machine::index::{AxisSlot, BySlot};

use crate::context::{ActionContext, StraightSteps};
use crate::entry::{ActionEntry, CompensationEffect};
use crate::motion::rapid_to;

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] = &[
    ActionEntry::of(&[codes::GOHOME], |act, _, _| go(act, 1)).contour(CompensationEffect::Leaves),
    ActionEntry::of(&[codes::GOHOME_NTH], |act, _, _| go_nth(act)).contour(CompensationEffect::Leaves),
    ActionEntry::of(&[codes::GOHOME_FLOATING], |act, _, _| go(act, FLOATING)).contour(CompensationEffect::Leaves),
    ActionEntry::of(&[codes::GOHOME_CHECK], |act, _, _| check(act)).contour(CompensationEffect::Leaves),
    ActionEntry::of(&[codes::GOHOME_RETURN], |act, _, _| come_back(act)).contour(CompensationEffect::Leaves),
];

/// Marks the floating reference point.
const FLOATING: usize = 5;

/// Distance within which an axis counts as being at its reference point.
const AT_REFERENCE: f64 = 0.001;

/// To reference point `number` (1 = home) via the programmed point; only coded axes move.
pub(crate) fn go(act: &mut ActionContext<'_, '_>, number: usize) -> Acted {
    if act.channel().env.machine.habits.home == Home::Machine {
        return straight(act, number);
    }
    let (mut coded, via) = act.targets();
    if coded == 0 {
        if !act.channel().env.machine.habits.bare_home {
            return Ok(());
        }
        coded = with_reference(act, number);
    }
    act.added_to(coded, "PS0363 return to the reference point of an axis to which moves are added")?;
    act.trace(ACTION, |channel| trace::action(&home_text(channel, coded, number)));
    check_reference(act, coded, number)?;
    act.channel_mut().state.place.home_via = Some(via);
    rapid_to(act, coded, via)?;
    to_reference(act, coded, number)
}

/// Point `number` of an axis in the machine frame.
fn reference(axis: &ChannelAxis, number: usize) -> Option<f64> {
    match number {
        1 => Some(axis.home),
        FLOATING => axis.floating,
        n => axis.references.get(n.wrapping_sub(2)).copied().flatten(),
    }
}

/// Reports a reference point that the machine does not have for all axes that go there.
fn check_reference(act: &mut ActionContext<'_, '_>, coded: u8, number: usize) -> Acted {
    let lacks = |axis: &ChannelAxis| reference(axis, number).is_none();
    if act.channel().state.place.layout.axes.entries().any(|(slot, axis)| coded & slot.bit() != 0 && lacks(axis)) {
        let name = if number == FLOATING {
            "the floating reference point".into()
        } else {
            format!("reference point {number}")
        };
        let text = format!("{name} is not defined for every axis of '{}'", act.channel().block_text());
        act.diagnose(&diag::NO_REFERENCE, text);
    }
    act.channel().check_stop()
}

/// Straight to the point of the machine frame that the block gives, without words to the reference point.
fn straight(act: &mut ActionContext<'_, '_>, number: usize) -> Acted {
    act.channel_mut().state.place.home_via = Some(act.channel().state.place.position);
    let (coded, target) = machine_targets(act);
    if coded != 0 {
        return rapid_to(act, coded, target);
    }
    let coded = every_axis(act);
    check_reference(act, coded, number)?;
    to_reference(act, coded, number)
}

/// All axes of the channel, bit by axis.
fn every_axis(act: &ActionContext<'_, '_>) -> u8 {
    act.channel().state.place.layout.axes.ids().fold(0, |bits, slot| bits | slot.bit())
}

/// The axes that have the point; all axes if none has it, so that this is reported.
fn with_reference(act: &ActionContext<'_, '_>, number: usize) -> u8 {
    let axes = act.channel().state.place.layout.axes.entries().filter(|(_, axis)| reference(axis, number).is_some());
    let found = axes.fold(0, |bits, (slot, _)| bits | slot.bit());
    if found == 0 { every_axis(act) } else { found }
}

/// Takes the axis words as positions of the machine frame.
pub(crate) fn machine_targets(act: &mut ActionContext<'_, '_>) -> (u8, Position) {
    let before = std::mem::replace(&mut act.channel_mut().block.flags.machine_frame, true);
    let taken = act.targets();
    act.channel_mut().block.flags.machine_frame = before;
    taken
}

fn to_reference(act: &mut ActionContext<'_, '_>, coded: u8, number: usize) -> Acted {
    let mut target = act.channel().state.place.machine_point(&act.channel().state.place.position);
    for (slot, axis) in act.channel().state.place.layout.axes.entries().filter(|(slot, _)| coded & slot.bit() != 0) {
        if let Some(point) = reference(axis, number) {
            *target.at_mut(slot) = next_to(act.channel(), slot, target.at(slot), point);
        }
    }
    let target = act.channel().state.place.way_of_machine(&target);
    rapid_to(act, coded, target)?;
    super::offset_words::at_reference(act, coded);
    Ok(())
}

/// `home x, z`, the axes that move; `n=2` for a further reference point.
fn home_text(channel: &ChannelContext<'_>, coded: u8, number: usize) -> String {
    let axes = channel.state.place.layout.axes.ids().filter(|axis| coded & axis.bit() != 0);
    let mut items: Vec<String> = axes.map(|axis| channel.axis_name(axis)).collect();
    if number > 1 {
        items.push(format!("n={number}"));
    }
    format!("home {}", items.join(", "))
}

/// A rapid move after which every axis of the block must be at its first reference point.
fn check(act: &mut ActionContext<'_, '_>) -> Acted {
    let (coded, target) = act.targets();
    rapid_to(act, coded, target)?;
    let machine = act.channel().state.place.machine_point(&act.channel().state.place.position);
    let is_off = |slot: AxisSlot, axis: &ChannelAxis| {
        let home = next_to(act.channel(), slot, machine.at(slot), axis.home);
        coded & slot.bit() != 0 && (machine.at(slot) - home).abs() > AT_REFERENCE
    };
    let off = act.channel().state.place.layout.axes.entries().find(|(slot, axis)| is_off(*slot, axis));
    let Some((slot, home)) = off.map(|(slot, axis)| (slot, axis.home)) else { return Ok(()) };
    let (name, stands) = (act.channel().axis_name(slot), wildcard_text(machine.at(slot)));
    let home = wildcard_text(home);
    let text =
        format!("{name} is at {stands} after '{}', but its reference point is at {home}", act.channel().block_text());
    Err(act.alarm(&diag::NOT_AT_REFERENCE, text))
}

/// To the second, third or fourth reference point; 2 without a number.
pub(crate) fn go_nth(act: &mut ActionContext<'_, '_>) -> Acted {
    let number = act.take(data::GOHOME_NTH).map_or(2.0, |d| d.value);
    if ![2.0, 3.0, 4.0].contains(&number) {
        let text =
            format!("reference point {number} not found in '{}', expected 2, 3 or 4", act.channel().block_text());
        act.diagnose(&diag::NO_REFERENCE, text);
        act.targets();
        return Ok(());
    }
    go(act, number as usize)
}

/// From the reference point via the last intermediate point to the programmed one.
pub(crate) fn come_back(act: &mut ActionContext<'_, '_>) -> Acted {
    let (coded, target) = act.targets();
    if coded == 0 {
        return Ok(());
    }
    match act.channel().state.place.home_via {
        Some(via) => {
            let mut through = act.channel().state.place.position;
            for (index, (slot, value)) in through.iter_mut().zip(via).enumerate() {
                if coded & (1 << index) != 0 {
                    *slot = value;
                }
            }
            rapid_to(act, coded, through)?;
        }
        None => {
            let text = format!("no intermediate point is known for '{}'", act.channel().block_text());
            act.diagnose(&diag::RETURN_WITHOUT_HOME, text);
        }
    }
    rapid_to(act, coded, target)
}
