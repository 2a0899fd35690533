//! Coolant: what flows at the main and the side head, auxiliary devices, the pressure of the pump.
//!
//! Facts: reference control-emulator.md 3.2, 6.3, system-variables.md 6. Invariant: what flows is the active code of its
//! modal group; kept here is only what the codes do not say: what flowed last, and the pressure.

use counterpoint_lang::format::wildcard_text;

use crate::channel::Kernel;
use crate::diag;
use crate::log::event::{Coolant, Kind, Outlet};
use crate::machine::ident::kind::coolant::{Flow, Switch};
use crate::machine::ident::{codes, data};
use crate::state::coolant::head;
use crate::state::modal::group;
use counterpoint_fault::Acted;

/// Carries out a code.
pub(super) fn switch(kernel: &mut Kernel<'_>, switch: Switch) -> Acted {
    match switch {
        Switch::Fluid(flow, outlet) => flows(kernel, flow, outlet),
        Switch::Device(number, on) => tell(kernel, Coolant { on, fluid: 0, outlet: Outlet::Device(number) }),
        Switch::Level(level) => {
            let pressure = kernel.channel.env.machine.pump.pressures.get(usize::from(level)).copied();
            set_pressure(kernel, pressure.unwrap_or(f64::from(level)));
        }
        Switch::Pressure => match kernel.take(data::COOLANT_PRESSURE).map(|d| d.value) {
            Some(pressure) => set_pressure(kernel, pressure),
            None => {
                let text = format!("a coolant pressure needs its value in '{}'", kernel.block_text());
                kernel.diagnose(&diag::DATA_MISSING, text);
            }
        },
    }
    Ok(())
}

/// The coolant that a spindle code brings along: its group follows.
pub(super) fn with_spindle(kernel: &mut Kernel<'_>, on: bool) {
    let code = if on { codes::COOLANT_ON } else { codes::COOLANT_OFF };
    kernel.channel.state.modal.activate(group::COOLANT, code, u16::MAX);
    flows(kernel, if on { Flow::Again } else { Flow::Off }, Outlet::Main);
}

fn flows(kernel: &mut Kernel<'_>, flow: Flow, outlet: Outlet) {
    let fluid = match flow {
        Flow::Off => 0,
        Flow::Again => kernel.channel.state.others.coolant.last.get(head(outlet)).copied().unwrap_or(1),
        Flow::Fluid(fluid) => {
            note(kernel, fluid, outlet);
            fluid
        }
    };
    tell(kernel, Coolant { on: flow != Flow::Off, fluid, outlet });
}

/// What flows is what a later `on` switches on.
pub(crate) fn note(kernel: &mut Kernel<'_>, fluid: u8, outlet: Outlet) {
    if let Some(last) = kernel.channel.state.others.coolant.last.get_mut(head(outlet)).filter(|_| fluid != 0) {
        *last = fluid;
    }
}

fn tell(kernel: &mut Kernel<'_>, coolant: Coolant) {
    kernel.emit(0, Kind::Coolant(coolant));
}

fn set_pressure(kernel: &mut Kernel<'_>, wanted: f64) {
    let largest = kernel.channel.state.others.coolant.largest(&kernel.channel.env.machine.pump);
    let most = if largest > 0.0 { largest } else { f64::INFINITY };
    let pressure = wanted.max(0.0).min(most);
    if pressure != wanted {
        let text = format!(
            "a coolant pressure of {} is not possible in '{}', it becomes {}",
            wildcard_text(wanted),
            kernel.block_text(),
            wildcard_text(pressure)
        );
        kernel.diagnose(&diag::COOLANT_PRESSURE, text);
    }
    let state = &mut kernel.channel.state.others.coolant;
    (state.pressure, state.pump) = (pressure, Some(pressure > 0.0));
    kernel.emit(0, Kind::mode(format!("coolant pressure p={}", wildcard_text(pressure))));
}
