//! Coolant: the flow at the main and the side head, auxiliary devices, the pressure of the pump.
//!
//! Facts: reference control-emulator.md 3.2, 6.3, system-variables.md 6. *Invariant:* the flowing coolant is the active
//! code of its modal group; only data without a code are kept here: the last coolant that flowed, and the pressure.

use counterpoint_lang::format::wildcard_text;

use crate::act::Act;
use crate::action::entry::{Contour, Entry, entry_of_kind};
use crate::state::coolant::head;
use crate::state::modal::group;
use counterpoint_event::event::{Coolant, Kind, Outlet};
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::kind::CodeKind;
use counterpoint_machine::ident::kind::coolant::{Flow, Switch};
use counterpoint_machine::ident::{codes, data};

/// Codes with their actions.
pub(crate) const ENTRIES: &[Entry] =
    &[entry_of_kind!(CodeKind::Coolant(of) => |act, _row, _code| switch(act, of)).contour(Contour::Waits)];

/// Executes a code.
pub(super) fn switch(act: &mut Act<'_, '_>, switch: Switch) -> Acted {
    match switch {
        Switch::Fluid(flow, outlet) => flows(act, flow, outlet),
        Switch::Device(number, on) => report(act, Coolant { on, fluid: 0, outlet: Outlet::Device(number) }),
        Switch::Level(level) => {
            let pressure = act.channel().env.machine.pump.pressures.get(usize::from(level)).copied();
            set_pressure(act, pressure.unwrap_or(f64::from(level)));
        }
        Switch::Pressure => match act.take(data::COOLANT_PRESSURE).map(|d| d.value) {
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
pub(super) fn with_spindle(act: &mut Act<'_, '_>, on: bool) {
    let code = if on { codes::COOLANT_ON } else { codes::COOLANT_OFF };
    act.channel_mut().state.modal.activate(group::COOLANT, code, None);
    flows(act, if on { Flow::Again } else { Flow::Off }, Outlet::Main);
}

fn flows(act: &mut Act<'_, '_>, flow: Flow, outlet: Outlet) {
    let fluid = match flow {
        Flow::Off => 0,
        Flow::Again => act.channel().state.others.coolant.last.get(head(outlet)).copied().unwrap_or(1),
        Flow::Fluid(fluid) => {
            act.channel_mut().state.others.coolant.note(fluid, outlet);
            fluid
        }
    };
    report(act, Coolant { on: flow != Flow::Off, fluid, outlet });
}

fn report(act: &mut Act<'_, '_>, coolant: Coolant) {
    act.channel_mut().emit(0, Kind::Coolant(coolant));
}

fn set_pressure(act: &mut Act<'_, '_>, wanted: f64) {
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
