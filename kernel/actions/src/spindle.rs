//! Spindles: direction, speed, constant surface speed, speed limit.
//!
//! Facts: reference control-emulator.md 3.3, 6.3; channel-synchronisation.md 1.9 (a spindle that several channels
//! command: the last writer in tag order wins, with a warning when no sync point lies between). A shared spindle is
//! reached only through shared operations; an own one is plain state of the act.

use counterpoint_channel::spindle::is_tool_spindle;
use counterpoint_event::event::SpindleDirection;
use counterpoint_fault as diag;
use counterpoint_fault::{Acted, Halt};
use counterpoint_machine::ident::kind::CodeKind;
use counterpoint_machine::ident::{codes, data};
use counterpoint_sync::shared::SpindleCommand;

use super::spindles::{commanded, driver};
use crate::context::ActionContext;
use crate::cutter;
use crate::entry::{ActionEntry, CompensationEffect, entry_of_kind};

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] = &[
    entry_of_kind!(CodeKind::Spindle { number, direction, coolant } => |act, _row, _code| turn(act, number, direction, coolant))
    .contour(CompensationEffect::Commands),
    ActionEntry::of(&[codes::SPINDLE_CSS], |act, _, _| mode(act, true)).contour(CompensationEffect::Commands),
    ActionEntry::of(&[codes::SPINDLE_RPM], |act, _, _| mode(act, false)).contour(CompensationEffect::Commands),
    ActionEntry::of(&[codes::SPINDLE_MAXRPM], |act, _, _| with_surface_owner(act, limit)).contour(CompensationEffect::Commands),
    ActionEntry::of(&[codes::SPINDLE_CSS_MAIN], |act, _, _| driver(act, 1)),
    ActionEntry::of(&[codes::SPINDLE_CSS_SIDE], |act, _, _| driver(act, 2)),
    ActionEntry::of(&[codes::SPINDLE_CSS_RADIAL], |act, _, _| radial(act)),
];

/// Start, stop, orient, lock. `number` 0 = the spindle of codes without a number.
pub(crate) fn turn(
    act: &mut ActionContext<'_, '_>,
    number: u16,
    direction: SpindleDirection,
    coolant: Option<bool>,
) -> Acted {
    if let Some(on) = coolant {
        super::coolant::with_spindle(act, on);
    }
    if matches!(direction, SpindleDirection::Clockwise | SpindleDirection::CounterClockwise) {
        let turns_tools = is_tool_spindle(act.channel(), number);
        let spindles = &mut act.channel_mut().state.others.spindles;
        spindles.started = number;
        if !turns_tools {
            spindles.turned = number;
        }
    }
    let line = act.channel().at.line;
    let mode = act.channel_mut().state.others.spindles.mode_of_block.take().filter(|(at, _)| *at == line);
    commanded(act, number, |act| {
        let angle = match direction {
            SpindleDirection::Oriented => act.take(data::SPINDLE_ORIENT).map_or(0.0, |d| d.value),
            _ => 0.0,
        };
        let was = act.spindle_command()?.css;
        let css = mode.map_or(was, |(_, css)| css);
        let speed = take_speed(act, css);
        let held = if was && !css { Some(held_speed(act)?) } else { None };
        let driver = driving_channel(act);
        act.command_spindle(|c| {
            c.direction = direction;
            c.angle = angle;
            match mode {
                Some((_, true)) => (c.css, c.driver) = (true, driver),
                Some((_, false)) => leave_surface_speed(c, held),
                None => {}
            }
            set_speed(c, css, speed);
        })
    })
}

/// Constant surface speed or constant speed. Both wait for the spindle code of their block, because they belong to its
/// spindle.
fn mode(act: &mut ActionContext<'_, '_>, css: bool) -> Acted {
    if act.channel().env.machine.habits.speed_follows_codes && has_spindle_code_ahead(act) {
        let line = act.channel().at.line;
        act.channel_mut().state.others.spindles.mode_of_block = Some((line, css));
        return Ok(());
    }
    if css { with_surface_owner(act, self::css) } else { with_speed_owner(act, rpm) }
}

/// Lets an action command the spindle that speeds belong to: the active one, or that of the spindle code in the block,
/// else that started last (`[control] speed_owner`).
fn with_speed_owner(
    act: &mut ActionContext<'_, '_>,
    action: impl FnOnce(&mut ActionContext<'_, '_>) -> Acted,
) -> Acted {
    if !act.channel().env.machine.habits.speed_follows_codes {
        return action(act);
    }
    let number = number_in_block(act).unwrap_or(act.channel().state.others.spindles.started);
    commanded(act, number, action)
}

/// Lets an action command the spindle that constant surface speed and its limit belong to, never a spindle of live
/// tools. On some machines this is the spindle at which the turret works (`[control] surface_owner`).
fn with_surface_owner(
    act: &mut ActionContext<'_, '_>,
    action: impl FnOnce(&mut ActionContext<'_, '_>) -> Acted,
) -> Acted {
    let (habits, spindles) = (&act.channel().env.machine.habits, &act.channel().state.others.spindles);
    let (started, turned) = (spindles.started, spindles.turned);
    let without_code = match habits.surface_of_side {
        _ if !habits.speed_follows_codes => return action(act),
        true => 0,
        false if is_tool_spindle(act.channel(), started) => turned,
        false => started,
    };
    let number = number_in_block(act).unwrap_or(without_code);
    commanded(act, number, action)
}

/// The spindle of the first spindle code in the block.
fn number_in_block(act: &ActionContext<'_, '_>) -> Option<u16> {
    let machine = act.channel().env.machine;
    let mut codes = act.channel().block.pending.iter().map(|pending| machine.codes[pending.row].id.kind());
    codes.find_map(|kind| match kind {
        CodeKind::Spindle { number, .. } => Some(number),
        _ => None,
    })
}

/// Whether a spindle code of the block has not acted yet.
fn has_spindle_code_ahead(act: &ActionContext<'_, '_>) -> bool {
    let (machine, block) = (act.channel().env.machine, &act.channel().block);
    let mut ahead = block.pending.iter().skip(block.next);
    ahead.any(|pending| matches!(machine.codes[pending.row].id.kind(), CodeKind::Spindle { .. }))
}

/// The channel whose X drives constant surface speed.
fn driving_channel(act: &ActionContext<'_, '_>) -> u16 {
    act.channel().state.others.spindles.driver.unwrap_or(act.channel().at.channel)
}

/// Constant surface speed on.
pub(crate) fn css(act: &mut ActionContext<'_, '_>) -> Acted {
    let speed = take_speed(act, true);
    let driver = driving_channel(act);
    act.command_spindle(|c| {
        c.css = true;
        c.driver = driver;
        set_speed(c, true, speed);
    })
}

/// Revolutions per minute on.
pub(crate) fn rpm(act: &mut ActionContext<'_, '_>) -> Acted {
    let speed = take_speed(act, false);
    let held = held_speed(act)?;
    act.command_spindle(|c| {
        leave_surface_speed(c, c.css.then_some(held));
        set_speed(c, false, speed);
    })
}

/// Ends constant surface speed; the current speed remains until the program gives another speed.
fn leave_surface_speed(command: &mut SpindleCommand, held: Option<f64>) {
    command.rpm = held.unwrap_or(command.rpm);
    (command.css, command.radius) = (false, 0.0);
}

/// Speed limit.
pub(crate) fn limit(act: &mut ActionContext<'_, '_>) -> Acted {
    let Some(value) = act.take(data::SPINDLE_RPM_MAX).map(|d| d.value) else {
        let text = format!("a speed limit needs its value in '{}'", act.channel().block_text());
        act.diagnose(&diag::DATA_MISSING, text);
        return Ok(());
    };
    act.command_spindle(|c| c.limit = value)
}

/// The radius at which the surface speed counts, regardless of X; zero or less = at X again.
pub(crate) fn radial(act: &mut ActionContext<'_, '_>) -> Acted {
    let Some(radius) = act.take(data::SPINDLE_CSS_RADIAL).map(|d| d.value) else {
        let text = format!("a radius of constant surface speed needs its value in '{}'", act.channel().block_text());
        act.diagnose(&diag::DATA_MISSING, text);
        return Ok(());
    };
    act.command_spindle(|c| c.radius = radius.max(0.0))
}

/// Stops, orients or reverses the spindle inside a cycle; it stays as it is when it is stopped.
pub(crate) fn turn_inside(act: &mut ActionContext<'_, '_>, direction: SpindleDirection) -> Acted {
    if act.channel().state.spindle.id.is_none() {
        return Ok(());
    }
    act.command_spindle(|c| c.direction = direction)
}

/// An S word that no code took: changes the speed (reference control-emulator.md 3.3).
pub(crate) fn speed_word(act: &mut ActionContext<'_, '_>) -> Acted {
    if act.channel().state.place.frames.is_some() {
        cutter::before(act, CompensationEffect::Commands, codes::SPINDLE_RPM)?;
    }
    with_speed_owner(act, own_speed_word)
}

fn own_speed_word(act: &mut ActionContext<'_, '_>) -> Acted {
    let css = act.spindle_command()?.css;
    match take_speed(act, css) {
        Some(speed) if !act.channel().env.machine.habits.speed_word => {
            act.channel_mut().state.others.spindles.waiting = Some(speed);
            Ok(())
        }
        Some(speed) => act.command_spindle(|c| set_speed(c, css, Some(speed))),
        None => Ok(()),
    }
}

/// The S of a block with a synchronised tap, which turns the spindle itself.
pub(crate) fn tap_speed(act: &mut ActionContext<'_, '_>) -> Acted {
    match take_speed(act, false) {
        Some(speed) => act.command_spindle(|c| set_speed(c, false, Some(speed))),
        None => Ok(()),
    }
}

/// The speed of the block, otherwise one that was left for the next spindle code (reference control-emulator.md 1.5).
fn take_speed(act: &mut ActionContext<'_, '_>, css: bool) -> Option<f64> {
    let word = act.take(if css { data::SPINDLE_CSS } else { data::SPINDLE_RPM });
    // A macro of a spindle code passes the S word of its block as a speed.
    let word = word.or_else(|| if css { act.take(data::SPINDLE_RPM) } else { None });
    if let Some(word) = word {
        act.channel_mut().state.remembered.remember_speed(word.raw);
    }
    let word = word.map(|word| word.value);
    let waiting = act.channel_mut().state.others.spindles.waiting.take();
    word.or(waiting)
}

/// `css`: m/min or ft/min becomes length units per minute.
fn set_speed(command: &mut SpindleCommand, css: bool, speed: Option<f64>) {
    match speed {
        Some(value) if css => command.surface = value,
        Some(value) => command.rpm = value,
        None => {}
    }
}

/// Speed that turns now, rev/min.
fn held_speed(act: &mut ActionContext<'_, '_>) -> Result<f64, Halt> {
    let position = act.channel().state.place.contour();
    let radius = act.channel().state.place.radius(&position);
    Ok(match act.spindle_speed()? {
        Some(turning) => turning.rpm(radius),
        None => act.channel().state.spindle.command.rpm,
    })
}
