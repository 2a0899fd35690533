//! Coolant: what flows at the main and the side head, auxiliary devices, the pressure of the pump.
//!
//! Facts: reference control-emulator.md 3.2, 6.3, system-variables.md 6. Invariant: what flows is the active code of its
//! modal group; kept here is only what the codes do not say: what flowed last, and the pressure.

use counterpoint_fault::Acted;
use counterpoint_lang::format::wildcard_text;

use crate::channel::Kernel;
use crate::channel::state::group;
use crate::diag;
use crate::log::event::{Coolant, Kind, Outlet};
use crate::machine::ident::{self, CodeId, codes, data};
use crate::machine::model::Pump;

/// What a coolant code switches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Switch {
    /// Coolant of the main or the side head.
    Fluid(Flow, Outlet),
    /// An auxiliary device.
    Device(u8, bool),
    /// The pressure that a word gives.
    Pressure,
    /// A pressure of the machine's list.
    Level(u8),
}

/// What flows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Flow {
    Off,
    /// What flowed last.
    Again,
    /// By the numbers of `$COOLTYP`.
    Fluid(u8),
}

/// What the codes of the groups do not say.
#[derive(Debug, Clone, Copy)]
pub(crate) struct State {
    /// What flowed last at the main and at the side head.
    last: [u8; 2],
    /// The high-pressure pump runs; unknown before its first code.
    pub(crate) pump: Option<bool>,
    /// Pressure.
    pub(crate) pressure: f64,
    /// Largest pressure that a macro allows, 0 = that of the machine.
    pub(crate) limit: f64,
}

impl Default for State {
    fn default() -> Self {
        Self { last: [1; 2], pump: None, pressure: 0.0, limit: 0.0 }
    }
}

fn head(outlet: Outlet) -> usize {
    usize::from(outlet == Outlet::Side)
}

impl State {
    /// Largest pressure that is allowed, 0 = any.
    pub(crate) fn largest(&self, pump: &Pump) -> f64 {
        if self.limit > 0.0 { self.limit } else { pump.max_pressure }
    }

    /// What the active code of a head means: 0 off, 1 to 9.
    pub(crate) fn fluid(&self, code: Option<CodeId>) -> u8 {
        match code.and_then(fluid_code) {
            Some((Flow::Fluid(fluid), _)) => fluid,
            Some((Flow::Again, outlet)) => self.last.get(head(outlet)).copied().unwrap_or(1),
            _ => 0,
        }
    }
}

/// What a code of the groups of fluids means.
fn fluid_code(id: CodeId) -> Option<(Flow, Outlet)> {
    let name = ident::code_facts(id)?.name.strip_prefix("CODE_COOLANT_")?;
    let (name, outlet) = match name.strip_suffix("_SIDE") {
        Some(name) => (name, Outlet::Side),
        None => (name, Outlet::Main),
    };
    let flow = match name {
        "OFF" => Flow::Off,
        "ON" => Flow::Again,
        "FLOOD" => Flow::Fluid(1),
        "MIST" => Flow::Fluid(2),
        "TAPKUL" => Flow::Fluid(3),
        "THRU" => Flow::Fluid(4),
        other => Flow::Fluid(other.strip_prefix("TYPE")?.parse().ok()?),
    };
    Some((flow, outlet))
}

/// The code of a fluid at the main or the side head, by its number.
pub(crate) fn code_of(fluid: u8, outlet: Outlet) -> Option<CodeId> {
    let name = match fluid {
        0 => "OFF".to_owned(),
        _ => Coolant::FLUIDS.get(usize::from(fluid))?.to_uppercase(),
    };
    let side = if outlet == Outlet::Side { "_SIDE" } else { "" };
    ident::code(&format!("CODE_COOLANT_{name}{side}"))
}

/// What a code switches, if it is one of coolant.
pub(super) fn of(id: CodeId) -> Option<Switch> {
    if let Some((flow, outlet)) = fluid_code(id) {
        return Some(Switch::Fluid(flow, outlet));
    }
    let name = ident::code_facts(id)?.name.strip_prefix("CODE_COOLANT_")?;
    if let Some((number, state)) = name.strip_prefix("DEV").and_then(|device| device.split_once('_')) {
        return Some(Switch::Device(number.parse().ok()?, state == "ON"));
    }
    match name.strip_prefix("PRESSURE")? {
        "" => Some(Switch::Pressure),
        level => Some(Switch::Level(level.strip_prefix('_')?.parse().ok()?)),
    }
}

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
    kernel.emit(0, Kind::Mode { text: format!("coolant pressure p={}", wildcard_text(pressure)).into() });
}
