//! Commands: everything that goes to the host.
//!
//! Facts: reference macro-language.md 3.2 to 3.5.

use super::slots::{get, slots};
use super::{report, units};
use crate::bytecode::{CommandCode, CompiledMacro, Slot};
use crate::diag::DiagnosticNumber;
use crate::fault::{MacroFault, Outcome};
use crate::host::{HostCommand, MacroHost};
use crate::state::{MacroState, pay_to_look, pay_to_write, whole};
use crate::value::MacroValue;

/// Executes a command; true if the macro issued a diagnostic that ends it.
pub(super) fn command(
    state: &mut MacroState,
    host: &mut dyn MacroHost,
    code: &CompiledMacro,
    frame: &[MacroValue],
    (command, list): (CommandCode, u16),
    at: usize,
) -> Outcome<bool> {
    let slots = slots(code, list);
    let first = slots.first().map_or(&MacroValue::Unset, |slot| get(frame, *slot));
    let number = || first.as_real().ok_or_else(|| MacroFault::kind("a number", first));
    let request = match command {
        CommandCode::MatchOn => HostCommand::Match(true),
        CommandCode::MatchOff => HostCommand::Match(false),
        CommandCode::MatchAgain => HostCommand::MatchAgain,
        CommandCode::TapeRead => HostCommand::TapeRead,
        CommandCode::TapeWrite => HostCommand::TapeWrite,
        CommandCode::SaveModal => HostCommand::SaveModal,
        CommandCode::RestoreModal => HostCommand::RestoreModal,
        CommandCode::ListingOn => HostCommand::Listing(true),
        CommandCode::ListingOff => HostCommand::Listing(false),
        CommandCode::Search => HostCommand::Search(whole(number()?)),
        CommandCode::Skip => HostCommand::Skip(whole(number()?)),
        CommandCode::Output => return output(state, host, code, frame),
        CommandCode::ExecNextFormat | CommandCode::ExecNowFormat => {
            let text = formatted(state, host, frame, slots)?;
            let now = command == CommandCode::ExecNowFormat;
            host.command(state, HostCommand::ExecBlock(now, &text))?;
            return Ok(false);
        }
        CommandCode::ExecNext | CommandCode::ExecNow => {
            return exec(state, host, frame, slots, command == CommandCode::ExecNow);
        }
        CommandCode::Print => {
            let text = formatted(state, host, frame, slots)?;
            host.command(state, HostCommand::Print(&text))?;
            return Ok(false);
        }
        CommandCode::System => {
            let text = first.as_text().ok_or_else(|| MacroFault::kind("a text", first))?;
            state.status = host.command(state, HostCommand::System(text))?;
            return Ok(false);
        }
        CommandCode::Open => {
            let values: Vec<MacroValue> = slots.iter().map(|slot| get(frame, *slot).clone()).collect();
            units::open(state, host, &values)?;
            return Ok(false);
        }
        CommandCode::Close => {
            let number = number()?;
            state.spend(units::size(state, number) / 64)?;
            units::close(state, host, number);
            return Ok(false);
        }
        CommandCode::Write => {
            let text = formatted(state, host, frame, slots.get(1..).unwrap_or(&[]))?;
            units::write(state, host, number()?, &text)?;
            return Ok(false);
        }
        CommandCode::Error => return error(state, host, code, frame, slots, at),
    };
    host.command(state, request)?;
    Ok(false)
}

/// The values of registers, which are looked at as a whole.
fn given(state: &mut MacroState, frame: &[MacroValue], slots: &[Slot]) -> Outcome<Vec<MacroValue>> {
    slots.iter().map(|slot| get(frame, *slot)).try_for_each(|value| pay_to_write(state, value))?;
    Ok(slots.iter().map(|slot| get(frame, *slot).clone()).collect())
}

fn formatted(
    state: &mut MacroState,
    host: &mut dyn MacroHost,
    frame: &[MacroValue],
    slots: &[Slot],
) -> Outcome<String> {
    let Some((format, values)) = slots.split_first() else { return Ok(String::new()) };
    let text = get(frame, *format);
    let text = text.as_text().ok_or_else(|| MacroFault::kind("a format", text))?;
    let format = state.format(text, false)?;
    let mut out = String::new();
    let values = given(state, frame, values)?;
    crate::format::write(&mut out, &format, &values, host)?;
    state.check_text(out.len())?;
    state.spend(out.len() / 16)?;
    Ok(out)
}

fn output(
    state: &mut MacroState,
    host: &mut dyn MacroHost,
    code: &CompiledMacro,
    frame: &[MacroValue],
) -> Outcome<bool> {
    code.signature.arguments.iter().try_for_each(|(_, slot)| pay_to_look(state, get(frame, *slot)))?;
    let mut arguments: Vec<(u8, MacroValue)> =
        code.signature.arguments.iter().map(|(number, slot)| (*number, get(frame, *slot).clone())).collect();
    arguments.sort_by_key(|(number, _)| *number);
    host.command(state, HostCommand::Output(&arguments))?;
    Ok(false)
}

fn exec(
    state: &mut MacroState,
    host: &mut dyn MacroHost,
    frame: &[MacroValue],
    slots: &[Slot],
    now: bool,
) -> Outcome<bool> {
    let values = given(state, frame, slots)?;
    match values.as_slice() {
        [MacroValue::Text(text)] => {
            let text = text.as_ref().clone();
            host.command(state, HostCommand::ExecBlock(now, &text))?;
        }
        [MacroValue::Text(_), ..] => {
            let text = formatted(state, host, frame, slots)?;
            host.command(state, HostCommand::ExecBlock(now, &text))?;
        }
        items => {
            host.command(state, HostCommand::ExecItems(now, items))?;
        }
    }
    Ok(false)
}

fn error(
    state: &mut MacroState,
    host: &mut dyn MacroHost,
    code: &CompiledMacro,
    frame: &[MacroValue],
    slots: &[Slot],
    at: usize,
) -> Outcome<bool> {
    let first = slots.first().map_or(&MacroValue::Unset, |slot| get(frame, *slot));
    let number = first.as_real().ok_or_else(|| MacroFault::kind("a severity or a number", first))?;
    let place = code.places.get(at).copied().unwrap_or_default();
    let rest = slots.get(1..).unwrap_or(&[]);
    if (0.0..=99.0).contains(&number) {
        let text = formatted(state, host, frame, rest)?;
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let severity = number as u8;
        report(code, place, MacroFault::new(DiagnosticNumber::AUTHOR, text), severity, state, host);
        return Ok(severity >= 8);
    }
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let index = number.max(0.0) as u32;
    let Some((severity, text)) = host.diagnostic(index) else {
        let message = format!("unknown diagnostic {index:08}");
        return Err(MacroFault::new(DiagnosticNumber::UNKNOWN_DIAGNOSTIC, message));
    };
    let format = state.format(&text, false)?;
    let values = given(state, frame, rest)?;
    let mut out = String::new();
    crate::format::write(&mut out, &format, &values, host)?;
    state.check_text(out.len())?;
    state.spend(out.len() / 16)?;
    report(code, place, MacroFault::new(DiagnosticNumber(index), out), severity, state, host);
    Ok(severity >= 8)
}
