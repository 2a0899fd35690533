//! The variables of one kernel, and the external ones that it shares with the PLC and the other channels.
//!
//! Facts: reference channel-synchronisation.md 1.7. Decisions: parameters P and variables V.P and V.S belong to the
//! channel until its program begins again, V.L to the program or subprogram that runs; a variable begins to exist when
//! it is assigned or declared. A read of a synchronous external variable lets everything programmed before be executed
//! first; an asynchronous one is read and written when its block is decoded, which here is when the channel comes to
//! it, before a move that compensation of the tool radius keeps back. Invariant: no value is infinite or not a number.

use std::borrow::Cow;

use counterpoint_fault as diag;
use counterpoint_lang::value::MacroValue;
use counterpoint_machine::model::{External, ExternalKind, Externals};
use rustc_hash::FxHashMap;

use super::{IsgBlockError, Outcome};
use counterpoint_control_api::call_stack::CallStack;
use counterpoint_control_api::host::InterpreterHost;

/// Maximum number of elements of arrays and of variables with names.
const MOST: usize = 100_000;

/// Values of variables with names and of elements, by their full name.
type Values = FxHashMap<Box<str>, f64>;

/// Variables.
#[derive(Debug)]
pub(super) struct IsgVariableStore {
    parameters: FxHashMap<u32, f64>,
    /// V.P, V.S and elements of parameters.
    named: Values,
    /// V.L of the programs that run.
    local: CallStack<Values>,
    /// External variables of this channel alone.
    own: Values,
    /// Those of the machine by name.
    external: FxHashMap<Box<str>, ExternalVariable>,
    /// Names that the machine does not describe are variables of all channels, too.
    any: bool,
}

/// The machine's row of an external variable.
#[derive(Debug, Clone, Copy)]
struct ExternalVariable {
    own: bool,
    synchronous: bool,
    readable: bool,
    writable: bool,
    kind: ExternalKind,
    elements: u32,
    value: f64,
}

/// A name that no row describes.
const ANY: ExternalVariable = ExternalVariable {
    own: false,
    synchronous: true,
    readable: true,
    writable: true,
    kind: ExternalKind::Real,
    elements: 0,
    value: 0.0,
};

impl IsgVariableStore {
    pub(super) fn new(external: &Externals) -> Self {
        let row = |row: &External| {
            let External { own, synchronous, readable, writable, kind, elements, value, .. } = *row;
            (
                format!("V.E.{}", row.name).into(),
                ExternalVariable { own, synchronous, readable, writable, kind, elements, value },
            )
        };
        Self {
            parameters: FxHashMap::default(),
            named: Values::default(),
            local: CallStack::default(),
            own: Values::default(),
            external: external.rows.iter().map(row).collect(),
            any: external.any,
        }
    }

    /// The program begins; `reset` as if it were the first one.
    pub(super) fn begin(&mut self, reset: bool) {
        self.parameters.clear();
        self.named.retain(|name, _| !reset && name.starts_with("V.S."));
        self.local = CallStack::default();
        if reset {
            self.own.clear();
        }
    }

    pub(super) fn enter(&mut self) {
        self.local.enter(Values::default());
    }

    /// Its next pass begins.
    pub(super) fn again(&mut self) {
        if let Some(local) = self.local.called_mut() {
            local.clear();
        }
    }

    pub(super) fn leave(&mut self) {
        self.local.leave();
    }

    /// Bytes that they take, about.
    pub(super) fn bytes(&self) -> usize {
        let local: usize = self.local.iter().map(FxHashMap::len).sum();
        (self.parameters.len() + self.named.len() + local + self.own.len()) * 100
    }

    /// A parameter, if it has a value.
    pub(super) fn parameter(&self, number: u32) -> Option<f64> {
        self.parameters.get(&number).copied()
    }

    /// Sets a parameter; whether that changed anything.
    pub(super) fn set_parameter(&mut self, number: u32, value: f64) -> Outcome<bool> {
        if self.parameters.len() >= MOST && !self.parameters.contains_key(&number) {
            return Err(full());
        }
        Ok(self.parameters.insert(number, value).map(f64::to_bits) != Some(value.to_bits()))
    }

    fn values(&mut self, name: &str) -> &mut Values {
        if name.starts_with("V.L.") { self.local.program_mut() } else { &mut self.named }
    }

    /// A variable of the program by its full name, if it has a value.
    pub(super) fn named(&mut self, name: &str) -> Option<f64> {
        self.values(name).get(name).copied()
    }

    /// Sets a variable of the program; whether that changed anything.
    pub(super) fn set_named(&mut self, name: &str, value: f64) -> Outcome<bool> {
        let values = self.values(name);
        if let Some(slot) = values.get_mut(name) {
            return Ok(std::mem::replace(slot, value).to_bits() != value.to_bits());
        }
        if values.len() >= MOST {
            return Err(full());
        }
        values.insert(name.into(), value);
        Ok(true)
    }

    /// An external variable by its name, with its index.
    fn external(&self, name: &str, index: Option<f64>) -> Outcome<ExternalVariable> {
        let row = match self.external.get(name) {
            Some(row) => *row,
            // Names that the machine does not describe may be arrays of any size.
            None if self.any => ExternalVariable { elements: index.map_or(0, |_| MOST as u32), ..ANY },
            None => return wrong(format!("{name} is not among the external variables of the machine")),
        };
        match (row.elements, index) {
            (0, Some(_)) => wrong(format!("{name} is no array")),
            (0, None) => Ok(row),
            (_, None) => wrong(format!("{name} is an array and needs an index")),
            (elements, Some(index)) if index.fract() == 0.0 && (0.0..f64::from(elements)).contains(&index) => Ok(row),
            (elements, Some(index)) => {
                wrong(format!("{name} has elements 0 to {}, not {index}", elements.saturating_sub(1)))
            }
        }
    }

    /// Reads an external variable.
    pub(super) fn read_external(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &str,
        index: Option<f64>,
    ) -> Outcome<f64> {
        let row = self.external(name, index)?;
        if !row.readable {
            return wrong(format!("{name} can only be written"));
        }
        if row.synchronous {
            if host.keeps_moves_back() {
                let text = "is synchronous and cannot be read while the tool radius is compensated";
                return wrong(format!("20651 {name} {text}"));
            }
            host.catch_up()?;
        }
        let full = full_name(name, index);
        if row.own {
            return Ok(self.own.get(&*full).copied().unwrap_or(row.value));
        }
        Ok(host.shared_number(&full)?.unwrap_or(row.value))
    }

    /// Writes an external variable.
    pub(super) fn write_external(
        &mut self,
        host: &mut dyn InterpreterHost,
        (name, index): (&str, Option<f64>),
        value: f64,
    ) -> Outcome<()> {
        let row = self.external(name, index)?;
        if !row.writable {
            return wrong(format!("{name} can only be read"));
        }
        let value = match row.kind {
            ExternalKind::Real => value,
            ExternalKind::Integer => value.round(),
            ExternalKind::Boolean if value == 0.0 || value == 1.0 => value,
            ExternalKind::Boolean => return wrong(format!("{name} is TRUE or FALSE, not {value}")),
        };
        if row.synchronous {
            host.catch_up()?;
        }
        let full = full_name(name, index);
        if row.own {
            if self.own.insert(full.into(), value).map(f64::to_bits) != Some(value.to_bits()) {
                host.effect();
            }
            return Ok(());
        }
        Ok(host.set_shared(&full, Some(MacroValue::Real(value)))?)
    }
}

fn full_name(name: &str, index: Option<f64>) -> Cow<'_, str> {
    match index {
        Some(index) => Cow::Owned(format!("{name}[{index}]")),
        None => Cow::Borrowed(name),
    }
}

fn wrong<T>(text: String) -> Outcome<T> {
    Err(IsgBlockError::Alarm(&diag::EXTERNAL_VARIABLE, text))
}

fn full() -> IsgBlockError {
    IsgBlockError::Alarm(&diag::MACRO_VARIABLE, format!("more than {MOST} variables have a value"))
}
