//! System variables of a running kernel, by index.
//!
//! *Invariant:* the table of the variable for each index is made once from the names; while macros run nothing is
//! looked up by name. Values that the kernel does not have itself are kept here, with their initial values. Facts:
//! reference system-variables.md; positions and decisions: docs/emulation.md.

mod components;
mod coolant;
mod cycles;
pub(crate) mod frames;
pub(crate) mod kernels;
pub(crate) mod offsets;
pub(crate) mod positions;
mod program;
mod spindles;
mod state;
mod threads;
mod tip;

use std::sync::OnceLock;

use counterpoint_lang::diag::DiagnosticNumber;
use counterpoint_lang::fault::{MacroFault, Outcome};
use counterpoint_lang::value::MacroValue;

use crate::context::KernelHost;
use counterpoint_emulator::channel::Kernel;
use counterpoint_fault as diag;
use counterpoint_machine::macros::model::Hook;
use counterpoint_machine::macros::system::{self, ControlVariable, ControlVariableAccess};

/// Reads a variable off the kernel.
type Read = fn(&Kernel<'_>, &[i64]) -> MacroValue;

/// Writes a variable into the kernel.
type Write = fn(&mut Kernel<'_>, &[i64], &MacroValue) -> Outcome<()>;

/// Where a variable comes from.
#[derive(Clone, Copy)]
enum VariableSource {
    /// Kept in the store.
    Kept,
    /// Read off the kernel; written if there is a path.
    State(Read, Option<Write>),
    /// Position of an axis.
    Position(positions::AxisPosition),
    /// Switch of a hook.
    Switch(Hook),
}

struct VariableEntry {
    source: VariableSource,
    variable: &'static ControlVariable,
}

fn rows() -> &'static [VariableEntry] {
    static ROWS: OnceLock<Vec<VariableEntry>> = OnceLock::new();
    ROWS.get_or_init(|| {
        let row = |variable: &'static ControlVariable| VariableEntry { source: source(&variable.name), variable };
        system::table().iter().map(row).collect()
    })
}

fn source(name: &str) -> VariableSource {
    if let Some(hook) = Hook::ALL.into_iter().find(|hook| hook.switch() == Some(name)) {
        return VariableSource::Switch(hook);
    }
    if let Some(place) = positions::place(name) {
        return VariableSource::Position(place);
    }
    let own = [cycles::find, spindles::find, threads::find, coolant::find];
    let own = own.into_iter().chain([kernels::find, frames::find, offsets::find, tip::find, components::find]);
    let found = [program::find, state::find].into_iter().chain(own).find_map(|find| find(name));
    match found {
        Some((read, write)) => VariableSource::State(read, write),
        None => VariableSource::Kept,
    }
}

fn pair(indices: &[i64]) -> (i64, i64) {
    (indices.first().copied().unwrap_or(0), indices.get(1).copied().unwrap_or(0))
}

/// Refuses indices beyond those of a variable.
fn check_indices(variable: &ControlVariable, indices: &[i64]) -> Outcome<()> {
    for (given, most) in indices.iter().zip(&variable.indices) {
        if *given < 1 || most.is_some_and(|most| *given > i64::from(most)) {
            let most = most.map_or_else(|| "no limit".to_owned(), |most| most.to_string());
            let text = format!("the index {given} of {} is not in 1 to {most}", variable.name);
            return Err(MacroFault::new(DiagnosticNumber::OUT_OF_RANGE, text));
        }
    }
    Ok(())
}

/// The value as the variable takes it.
fn checked(variable: &ControlVariable, value: MacroValue) -> Outcome<MacroValue> {
    let value = match (variable.kind, value) {
        (Some(kind), MacroValue::Unset) => kind.initial(),
        (_, MacroValue::Null) if matches!(variable.first, MacroValue::Null) => MacroValue::Null,
        (Some(kind), value) if value.kind() != Some(kind) => return Err(MacroFault::kind(kind.name(), &value)),
        (_, value) => value,
    };
    if let (Some((low, high)), MacroValue::Real(number)) = (variable.range, &value)
        && !(low..=high).contains(number)
    {
        let text = format!("{} takes numbers from {low} to {high}, not {number}", variable.name);
        return Err(MacroFault::new(DiagnosticNumber::BAD_VALUE, text));
    }
    Ok(value)
}

impl KernelHost<'_, '_> {
    pub(crate) fn read_variable(&mut self, index: u32, indices: &[i64]) -> Outcome<MacroValue> {
        let Some(row) = rows().get(index as usize) else { return Ok(MacroValue::Null) };
        if !indices.is_empty() {
            check_indices(row.variable, indices)?;
        }
        Ok(match row.source {
            VariableSource::State(read, _) => read(self.kernel, indices),
            VariableSource::Position(place) => MacroValue::Real(positions::position_of(self, place)),
            VariableSource::Switch(hook) => {
                let switches = &self.kernel.macros.variables.store.switches;
                MacroValue::Logical(switches.get(hook as usize).copied().unwrap_or(true))
            }
            VariableSource::Kept => {
                let runtime = &*self.kernel.macros;
                let (first, second) = pair(indices);
                let element = if indices.is_empty() {
                    None
                } else {
                    runtime.variables.store.elements.get(&(index, first, second))
                };
                element.unwrap_or_else(|| runtime.variables.store.get(index)).clone()
            }
        })
    }

    pub(crate) fn write_variable(&mut self, index: u32, indices: &[i64], value: MacroValue) -> Outcome<()> {
        let Some(row) = rows().get(index as usize) else { return Ok(()) };
        let value = checked(row.variable, value)?;
        check_indices(row.variable, indices)?;
        let machine = self.kernel.channel.env.machine;
        let runtime = &mut *self.kernel.macros;
        if row.variable.access == ControlVariableAccess::Start && !runtime.variables.store.starting {
            let text = format!("{} has no effect after Machine Startup", row.variable.name);
            self.kernel.diagnose(&diag::START_ONLY, text);
            return Ok(());
        }
        match row.source {
            VariableSource::State(_, Some(write)) => return write(self.kernel, indices, &value),
            VariableSource::State(_, None) | VariableSource::Position(_) => {
                let text = format!("{} is kept by this control itself and cannot be set here", row.variable.name);
                return Err(MacroFault::new(DiagnosticNumber::NO_HOST, text));
            }
            VariableSource::Switch(hook) => {
                let on = value.as_logical().unwrap_or(true);
                if let Some(slot) = runtime.variables.store.switches.get_mut(hook as usize) {
                    *slot = on;
                }
                let code = machine.macros.as_deref().and_then(|macros| macros.hook(hook)).filter(|_| on);
                if let Some(slot) = runtime.hooks.on.get_mut(hook as usize) {
                    *slot = code;
                }
            }
            VariableSource::Kept if indices.is_empty() => runtime.variables.store.set(index, value),
            VariableSource::Kept => {
                runtime.variables.store.keep_element(index, pair(indices), value)?;
            }
        }
        Ok(())
    }

    /// Sets a kept variable, if there are macros.
    pub(crate) fn store(&mut self, index: u32, value: impl FnOnce() -> MacroValue) {
        if self.kernel.plan.hooks.is_some() {
            self.kernel.macros.variables.store.set(index, value());
        }
    }
}
