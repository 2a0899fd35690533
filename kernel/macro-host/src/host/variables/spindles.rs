//! Variables of spindles.
//!
//! *Invariant:* a value that a macro sets counts from the next action on and makes no event. Facts: reference
//! system-variables.md 6, 9.

use counterpoint_channel::macro_queries::{activate_code, row_of_code};
use counterpoint_channel::modal::group;
use counterpoint_emulator::channel::Kernel;
use counterpoint_event::event::SpindleDirection;
use counterpoint_event::info::MachineUnit;
use counterpoint_lang::diag::DiagnosticNumber;
use counterpoint_lang::fault::{MacroFault, Outcome};
use counterpoint_lang::value::MacroValue;
use counterpoint_machine::ident::codes;
use counterpoint_sync::shared::SpindleCommand;

use super::{Read, Write};

fn number(value: impl Into<f64>) -> MacroValue {
    MacroValue::Real(value.into())
}

fn real(value: &MacroValue) -> f64 {
    value.as_real().filter(|value| value.is_finite()).unwrap_or(0.0)
}

fn turns(command: &SpindleCommand) -> bool {
    matches!(command.direction, SpindleDirection::Clockwise | SpindleDirection::CounterClockwise)
}

/// Changes the command of the channel's spindle.
fn set(kernel: &mut Kernel<'_>, change: impl Fn(&mut SpindleCommand)) -> Outcome<()> {
    if let Err(halt) = kernel.set_spindle(change) {
        kernel.macros.calls.stop(halt);
    }
    Ok(())
}

fn speed(kernel: &Kernel<'_>, _: &[i64]) -> MacroValue {
    let command = &kernel.channel.state.spindle.command;
    number(match (turns(command), command.css) {
        (false, _) => 0.0,
        (true, false) => command.rpm,
        (true, true) => command.surface,
    })
}

fn set_speed(kernel: &mut Kernel<'_>, _: &[i64], value: &MacroValue) -> Outcome<()> {
    let speed = real(value).max(0.0);
    set(kernel, |command| if command.css { command.surface = speed } else { command.rpm = speed })
}

fn mode(kernel: &Kernel<'_>, _: &[i64]) -> MacroValue {
    let command = &kernel.channel.state.spindle.command;
    number(match (turns(command), command.css, kernel.channel.env.machine.unit) {
        (false, ..) => 0.0,
        (true, false, _) => 2.0,
        (true, true, MachineUnit::Inch) => 1.0,
        (true, true, MachineUnit::Mm) => 3.0,
    })
}

/// 0 stops, 2 turns by rev/min, 1 and 3 by surface speed in the unit of the machine.
fn set_mode(kernel: &mut Kernel<'_>, _: &[i64], value: &MacroValue) -> Outcome<()> {
    let mode = real(value);
    if mode == 0.0 {
        activate_code(&mut kernel.channel, codes::SPINDLE_OFF);
        return set(kernel, |command| command.direction = SpindleDirection::Off);
    }
    let css = mode != 2.0;
    let driver = kernel.channel.state.others.spindles.driver.unwrap_or(kernel.channel.at.channel);
    activate_code(&mut kernel.channel, if css { codes::SPINDLE_CSS } else { codes::SPINDLE_RPM });
    set(kernel, |command| {
        if css && !command.css {
            command.driver = driver;
        }
        command.css = css;
    })
}

fn direction(kernel: &Kernel<'_>, _: &[i64]) -> MacroValue {
    number(match kernel.channel.state.spindle.command.direction {
        SpindleDirection::Clockwise => 1.0,
        SpindleDirection::CounterClockwise => 2.0,
        _ => 0.0,
    })
}

/// 0 does not stop.
fn set_direction(kernel: &mut Kernel<'_>, _: &[i64], value: &MacroValue) -> Outcome<()> {
    let (code, direction) = match real(value) {
        1.0 => (codes::SPINDLE_CLW, SpindleDirection::Clockwise),
        2.0 => (codes::SPINDLE_CCLW, SpindleDirection::CounterClockwise),
        _ => return Ok(()),
    };
    activate_code(&mut kernel.channel, code);
    set(kernel, |command| command.direction = direction)
}

fn limit(kernel: &Kernel<'_>, _: &[i64]) -> MacroValue {
    let machine = kernel.channel.state.spindle.id.map_or(0.0, |id| kernel.channel.env.machine.spindles[id].max);
    number(kernel.channel.state.spindle.command.limit.min(machine))
}

fn spindle_in_work(kernel: &Kernel<'_>, _: &[i64]) -> MacroValue {
    let rear = kernel.channel.state.modal.code(group::SPINDLES) == Some(codes::SPINDLE_REAR);
    let word = counterpoint_lang::ident::minor_code(if rear { "REAR" } else { "FRONT" });
    word.map_or(MacroValue::Null, MacroValue::Keyword)
}

fn set_spindle_in_work(kernel: &mut Kernel<'_>, _: &[i64], value: &MacroValue) -> Outcome<()> {
    let is =
        |word| matches!(value, MacroValue::Keyword(code) if counterpoint_lang::ident::minor_code(word) == Some(*code));
    let wanted = match (is("FRONT"), is("REAR")) {
        (true, _) => codes::SPINDLE_FRONT,
        (_, true) => codes::SPINDLE_REAR,
        _ => return Err(MacroFault::new(DiagnosticNumber::BAD_VALUE, "a spindle is FRONT or REAR")),
    };
    if row_of_code(&kernel.channel, wanted).is_none() {
        return Err(MacroFault::new(DiagnosticNumber::BAD_VALUE, "the machine has no code for this spindle"));
    }
    activate_code(&mut kernel.channel, wanted);
    Ok(())
}

/// How a variable is read and written.
pub(crate) fn find(name: &str) -> Option<(Read, Option<Write>)> {
    let row: (Read, Option<Write>) = match name {
        "$S" => (speed, Some(set_speed)),
        "$SR" => (
            |k, _| number(k.channel.state.spindle.command.rpm),
            Some(|k, _, value| {
                let speed = real(value).max(0.0);
                set(k, |command| command.rpm = speed)
            }),
        ),
        "$SS" => (
            |k, _| number(k.channel.state.spindle.command.surface),
            Some(|k, _, value| {
                let speed = real(value).max(0.0);
                set(k, |command| command.surface = speed)
            }),
        ),
        "$SMODE" => (mode, Some(set_mode)),
        "$SDIR" => (direction, Some(set_direction)),
        "$MAXRPM" => (
            limit,
            Some(|k, _, value| {
                let limit = real(value).max(0.0);
                set(k, |command| command.limit = limit)
            }),
        ),
        "$SHEAD" => (
            |k, _| number(k.channel.state.spindle.command.driver),
            Some(|k, _, value| {
                let head = real(value).clamp(0.0, f64::from(u16::MAX)) as u16;
                k.channel.state.others.spindles.driver = (head > 0).then_some(head);
                set(k, |command| command.driver = head)
            }),
        ),
        "$LTHMOD" => (|k, _| number(u8::from(k.channel.state.others.spindles.milling)), None),
        "$STID" => (|k, _| number(k.channel.turning_code()), None),
        "$SMID" => (|k, _| number(k.channel.milling_code()), None),
        "$SPINDLE" => (spindle_in_work, Some(set_spindle_in_work)),
        _ => return None,
    };
    Some(row)
}
