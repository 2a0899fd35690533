//! Variables of coolant: the flow, auxiliary devices, the pump.
//!
//! *Invariant:* a value that a macro sets makes no event. Facts: reference system-variables.md 6.

use counterpoint_channel::coolant::code_of;
use counterpoint_channel::macro_queries::{activate_code, row_of_code};
use counterpoint_channel::modal::group;
use counterpoint_emulator::channel::Kernel;
use counterpoint_event::event::{Coolant, Outlet};
use counterpoint_lang::diag::DiagnosticNumber;
use counterpoint_lang::fault::{MacroFault, Outcome};
use counterpoint_lang::ident::minor_code;
use counterpoint_lang::value::MacroValue;
use counterpoint_machine::ident::kind::CodeKind;
use counterpoint_machine::ident::kind::coolant::CoolantTarget;
use counterpoint_machine::ident::{CodeId, codes};

use super::{Read, Write};

/// Modal group of the first coolant device, less one.
const DEVICES: u16 = 540;

fn number(value: impl Into<f64>) -> MacroValue {
    MacroValue::Real(value.into())
}

fn real(value: &MacroValue) -> f64 {
    value.as_real().filter(|value| value.is_finite()).unwrap_or(0.0)
}

/// The active head: the side one has coolant of its own once a code has switched it.
fn outlet(kernel: &Kernel<'_>) -> Outlet {
    let side = kernel.channel.state.modal.code(group::HEAD) == Some(codes::HEAD_SIDE);
    if side && kernel.channel.state.modal.code(group::COOLANT_SIDE).is_some() { Outlet::Side } else { Outlet::Main }
}

fn fluid(kernel: &Kernel<'_>) -> u8 {
    let group = if outlet(kernel) == Outlet::Side { group::COOLANT_SIDE } else { group::COOLANT };
    kernel.channel.state.others.coolant.fluid(kernel.channel.state.modal.code(group))
}

fn set_fluid(kernel: &mut Kernel<'_>, fluid: u8) -> Outcome<()> {
    let outlet = outlet(kernel);
    match code_of(fluid, outlet).filter(|code| row_of_code(&kernel.channel, *code).is_some()) {
        Some(code) => {
            activate_code(&mut kernel.channel, code);
            kernel.channel.state.others.coolant.note(fluid, outlet);
            Ok(())
        }
        None => Err(MacroFault::new(DiagnosticNumber::BAD_VALUE, "the machine has no code for this coolant")),
    }
}

/// `$COOLNT`: a keyword; a coolant of the machine's own has none, so it is its number.
fn name(kernel: &Kernel<'_>, _: &[i64]) -> MacroValue {
    let fluid = fluid(kernel);
    let word = match fluid {
        0 => Some("OFF".to_owned()),
        1..=4 => Coolant::FLUIDS.get(usize::from(fluid)).map(|word| word.to_uppercase()),
        _ => None,
    };
    word.and_then(|word| minor_code(&word)).map_or(number(fluid), MacroValue::Keyword)
}

fn set_name(kernel: &mut Kernel<'_>, _: &[i64], value: &MacroValue) -> Outcome<()> {
    let is = |word: &str| matches!(value, MacroValue::Keyword(code) if minor_code(word) == Some(*code));
    let named = (0_u8..).zip(["OFF", "FLOOD", "MIST", "TAPKUL", "THRU"]).find(|(_, word)| is(word));
    let given = value.as_real().filter(|number| (5.0..=9.0).contains(number) && number.fract() == 0.0);
    match named.map(|(number, _)| number).or(given.map(|number| number as u8)) {
        Some(fluid) => set_fluid(kernel, fluid),
        None => Err(MacroFault::new(DiagnosticNumber::BAD_VALUE, "unknown coolant")),
    }
}

/// The code of a coolant device; custom tables of a machine need not have it.
fn device(at: &[i64], on: bool) -> Option<CodeId> {
    let number = u8::try_from(*at.first()?).ok()?;
    CodeId::of_kind(CodeKind::Coolant(CoolantTarget::Device(number, on)))
}

fn device_state(kernel: &Kernel<'_>, at: &[i64]) -> MacroValue {
    let group = at.first().and_then(|at| u16::try_from(*at).ok()).map_or(0, |at| DEVICES + at);
    let active = kernel.channel.state.modal.code(group);
    number(match active {
        Some(code) if Some(code) == device(at, true) => 1.0,
        Some(code) if Some(code) == device(at, false) => 0.0,
        _ => -1.0,
    })
}

fn set_device(kernel: &mut Kernel<'_>, at: &[i64], value: &MacroValue) -> Outcome<()> {
    let wanted = match real(value) {
        0.0 => device(at, false),
        1.0 => device(at, true),
        _ => None,
    };
    match wanted.filter(|code| row_of_code(&kernel.channel, *code).is_some()) {
        Some(code) => {
            activate_code(&mut kernel.channel, code);
            Ok(())
        }
        None => Err(MacroFault::new(
            DiagnosticNumber::BAD_VALUE,
            "the machine has no code for this state of the coolant device",
        )),
    }
}

/// How a variable is read and written.
pub(crate) fn find(name: &str) -> Option<(Read, Option<Write>)> {
    let row: (Read, Option<Write>) = match name {
        "$COOLNT" => (self::name, Some(set_name)),
        "$COOLTYP" => (|k, _| number(fluid(k)), Some(|k, _, value| set_fluid(k, real(value) as u8))),
        "$COOLDEV" => (device_state, Some(set_device)),
        "$HPCOOL" => (
            |k, _| k.channel.state.others.coolant.pump.map_or(number(-1), |on| number(u8::from(on))),
            Some(|k, _, value| {
                let state = real(value);
                k.channel.state.others.coolant.pump = (state >= 0.0).then_some(state > 0.0);
                Ok(())
            }),
        ),
        "$PRSSUR" => (
            |k, _| number(k.channel.state.others.coolant.pressure),
            Some(|k, _, value| {
                let largest = k.channel.state.others.coolant.largest(&k.channel.env.machine.pump);
                let wanted = real(value);
                if wanted < 0.0 || largest > 0.0 && wanted > largest {
                    return Err(MacroFault::new(DiagnosticNumber::BAD_VALUE, "this coolant pressure is not possible"));
                }
                k.channel.state.others.coolant.pressure = wanted;
                Ok(())
            }),
        ),
        "$MAXPRSSUR" => (
            |k, _| number(k.channel.state.others.coolant.largest(&k.channel.env.machine.pump)),
            Some(|k, _, value| {
                k.channel.state.others.coolant.limit = real(value).max(0.0);
                Ok(())
            }),
        ),
        _ => return None,
    };
    Some(row)
}
