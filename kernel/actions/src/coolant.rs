//! Coolant: the flow at the main and the side head, auxiliary devices, the pressure of the pump.
//!
//! Facts: reference control-emulator.md 3.2, 6.3, system-variables.md 6. *Invariant:* the flowing coolant is the active
//! code of its modal group; only data without a code are kept here: the last coolant that flowed, and the pressure.

use counterpoint_lang::format::wildcard_text;

use crate::context::ActionContext;
use crate::entry::{ActionEntry, CompensationEffect, entry_of_kind};
use counterpoint_channel::coolant::head;
use counterpoint_channel::modal::group;
use counterpoint_event::event::{Coolant, Kind, Outlet};
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::kind::CodeKind;
use counterpoint_machine::ident::kind::coolant::{CoolantFluid, CoolantTarget};
use counterpoint_machine::ident::{codes, data};

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] =
    &[entry_of_kind!(CodeKind::Coolant(of) => |act, _row, _code| switch(act, of)).contour(CompensationEffect::Waits)];

/// Executes a code.
pub(crate) fn switch(act: &mut ActionContext<'_, '_>, switch: CoolantTarget) -> Acted {
    match switch {
        CoolantTarget::Fluid(flow, outlet) => flows(act, flow, outlet),
        CoolantTarget::Device(number, on) => report(act, Coolant { on, fluid: 0, outlet: Outlet::Device(number) }),
        CoolantTarget::Level(level) => {
            let pressure = act.channel().env.machine.pump.pressures.get(usize::from(level)).copied();
            set_pressure(act, pressure.unwrap_or(f64::from(level)));
        }
        CoolantTarget::Pressure => match act.take(data::COOLANT_PRESSURE).map(|d| d.value) {
            Some(pressure) => set_pressure(act, pressure),
            None => {
                let text = format!("a coolant pressure needs its value in '{}'", act.channel().block_text());
                act.diagnose(&diag::DATA_MISSING, text);
            }
        },
    }
    Ok(())
}

/// The coolant that a spindle code brings along: its group follows.
pub(crate) fn with_spindle(act: &mut ActionContext<'_, '_>, on: bool) {
    let code = if on { codes::COOLANT_ON } else { codes::COOLANT_OFF };
    act.channel_mut().state.modal.activate(group::COOLANT, code, None);
    flows(act, if on { CoolantFluid::Again } else { CoolantFluid::Off }, Outlet::Main);
}

fn flows(act: &mut ActionContext<'_, '_>, flow: CoolantFluid, outlet: Outlet) {
    let fluid = match flow {
        CoolantFluid::Off => 0,
        CoolantFluid::Again => act.channel().state.others.coolant.last.get(head(outlet)).copied().unwrap_or(1),
        CoolantFluid::Fluid(fluid) => {
            act.channel_mut().state.others.coolant.note(fluid, outlet);
            fluid
        }
    };
    report(act, Coolant { on: flow != CoolantFluid::Off, fluid, outlet });
}

fn report(act: &mut ActionContext<'_, '_>, coolant: Coolant) {
    act.channel_mut().emit(0, Kind::Coolant(coolant));
}

fn set_pressure(act: &mut ActionContext<'_, '_>, wanted: f64) {
    let largest = act.channel().state.others.coolant.largest(&act.channel().env.machine.pump);
    let most = if largest > 0.0 { largest } else { f64::INFINITY };
    let pressure = wanted.max(0.0).min(most);
    if pressure != wanted {
        let text = format!(
            "coolant pressure {} is out of range in '{}'; {} is used",
            wildcard_text(wanted),
            act.channel().block_text(),
            wildcard_text(pressure)
        );
        act.diagnose(&diag::COOLANT_PRESSURE, text);
    }
    let state = &mut act.channel_mut().state.others.coolant;
    (state.pressure, state.pump) = (pressure, Some(pressure > 0.0));
    act.channel_mut().emit(0, Kind::mode(format!("coolant pressure p={}", wildcard_text(pressure))));
}
