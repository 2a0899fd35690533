//! Coolant of a channel: the state beyond the active codes.
//!
//! *Invariant:* the flowing coolant is the active code of its modal group.

use counterpoint_event::event::Outlet;
use counterpoint_machine::ident::CodeId;
use counterpoint_machine::ident::kind::CodeKind;
use counterpoint_machine::ident::kind::coolant::{CoolantFluid, CoolantTarget};
use counterpoint_machine::model::Pump;

/// The state beyond the codes of the groups.
#[derive(Debug, Clone, Copy)]
pub struct CoolantState {
    /// The last fluid at the main and at the side head.
    pub last: [u8; 2],
    /// The high-pressure pump runs; unknown before its first code.
    pub pump: Option<bool>,
    /// Pressure.
    pub pressure: f64,
    /// Largest pressure that a macro allows, 0 = that of the machine.
    pub limit: f64,
}

impl Default for CoolantState {
    fn default() -> Self {
        Self { last: [1; 2], pump: None, pressure: 0.0, limit: 0.0 }
    }
}

/// Index of the head that an outlet cools.
pub fn head(outlet: Outlet) -> usize {
    usize::from(outlet == Outlet::Side)
}

impl CoolantState {
    /// Largest pressure that is allowed, 0 = any.
    pub fn largest(&self, pump: &Pump) -> f64 {
        if self.limit > 0.0 { self.limit } else { pump.max_pressure }
    }

    /// Records the flowing coolant, for a later `on` to switch on again.
    pub fn note(&mut self, fluid: u8, outlet: Outlet) {
        if let Some(last) = self.last.get_mut(head(outlet)).filter(|_| fluid != 0) {
            *last = fluid;
        }
    }

    /// The meaning of the active code of a head: 0 off, 1 to 9.
    pub fn fluid(&self, code: Option<CodeId>) -> u8 {
        match code.map(CodeId::kind) {
            Some(CodeKind::Coolant(CoolantTarget::Fluid(CoolantFluid::Fluid(fluid), _))) => fluid,
            Some(CodeKind::Coolant(CoolantTarget::Fluid(CoolantFluid::Again, outlet))) => {
                self.last.get(head(outlet)).copied().unwrap_or(1)
            }
            _ => 0,
        }
    }
}

/// The code of a fluid at the main or the side head, by its number.
pub fn code_of(fluid: u8, outlet: Outlet) -> Option<CodeId> {
    let flow = if fluid == 0 { CoolantFluid::Off } else { CoolantFluid::Fluid(fluid) };
    CodeId::of_kind(CodeKind::Coolant(CoolantTarget::Fluid(flow, outlet)))
}
