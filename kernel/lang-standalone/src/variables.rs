//! System and global variables.

use std::collections::HashMap;

use counterpoint_lang::diag::DiagnosticNumber;
use counterpoint_lang::fault::{MacroFault, Outcome};
use counterpoint_lang::host::SystemVariable;
use counterpoint_lang::value::MacroValue;

/// Elements of indexed system variables that are kept.
const MOST_ELEMENTS: usize = 1_000_000;

/// The values that a system variable accepts.
#[derive(Clone, Debug, Default)]
pub struct Domain {
    /// Largest value of each index, none without a limit.
    pub indices: Vec<Option<u32>>,
    /// Smallest and largest number.
    pub values: Option<(f64, f64)>,
    /// `$NULL` is a value of every type.
    pub nullable: bool,
}

/// The system variables with their values.
#[derive(Debug, Default)]
pub(crate) struct SystemTable {
    rows: Vec<SystemVariable>,
    domains: Vec<Domain>,
    values: Vec<MacroValue>,
    elements: HashMap<(u32, Vec<i64>), MacroValue>,
    /// Position of `$DATE`, which is always now.
    date: Option<u32>,
    pub(crate) foreign: Option<fn(&str) -> Option<&'static str>>,
}

impl SystemTable {
    pub(crate) fn rows(&self) -> &[SystemVariable] {
        &self.rows
    }

    pub(crate) fn add(&mut self, variable: SystemVariable, initial: MacroValue, domain: Domain) {
        if variable.name == "$DATE" {
            self.date = u32::try_from(self.rows.len()).ok();
        }
        self.rows.push(variable);
        self.domains.push(domain);
        self.values.push(initial);
    }

    pub(crate) fn value(&self, name: &str) -> Option<&MacroValue> {
        self.values.get(self.rows.iter().position(|variable| variable.name == name)?)
    }

    pub(crate) fn text(&self, name: &str) -> String {
        self.value(name).and_then(MacroValue::as_text).unwrap_or("").to_owned()
    }

    pub(crate) fn number(&self, name: &str) -> f64 {
        self.value(name).and_then(MacroValue::as_real).unwrap_or(0.0)
    }

    pub(crate) fn set(&mut self, name: &str, value: MacroValue) {
        let at = self.rows.iter().position(|variable| variable.name == name);
        if let Some(place) = at.and_then(|at| self.values.get_mut(at)) {
            *place = value;
        }
    }

    fn name(&self, index: u32) -> &str {
        self.rows.get(index as usize).map_or("the variable", |variable| variable.name.as_str())
    }

    /// Refuses indices beyond those of a system variable.
    fn check_indices(&self, index: u32, indices: &[i64]) -> Outcome<()> {
        let Some(domain) = self.domains.get(index as usize) else { return Ok(()) };
        for (given, most) in indices.iter().zip(&domain.indices) {
            if *given < 1 || most.is_some_and(|most| *given > i64::from(most)) {
                let most = most.map_or_else(|| "no limit".to_owned(), |most| most.to_string());
                let message = format!("the index {given} of {} is not in 1 to {most}", self.name(index));
                return Err(MacroFault::new(DiagnosticNumber::OUT_OF_RANGE, message));
            }
        }
        Ok(())
    }

    pub(crate) fn read(&self, index: u32, indices: &[i64]) -> Outcome<MacroValue> {
        self.check_indices(index, indices)?;
        let element = if indices.is_empty() { None } else { self.elements.get(&(index, indices.to_vec())) };
        Ok(element.or_else(|| self.values.get(index as usize)).cloned().unwrap_or(MacroValue::Null))
    }

    pub(crate) fn write(&mut self, index: u32, indices: &[i64], value: MacroValue) -> Outcome<()> {
        let kind = self.rows.get(index as usize).and_then(|variable| variable.kind);
        let domain = self.domains.get(index as usize);
        let (range, nullable) = domain.map_or((None, false), |domain| (domain.values, domain.nullable));
        let value = match (kind, value) {
            (Some(kind), MacroValue::Unset) => kind.initial(),
            (_, MacroValue::Null) if nullable => MacroValue::Null,
            (Some(kind), value) if value.kind() != Some(kind) => return Err(MacroFault::kind(kind.name(), &value)),
            (_, value) => value,
        };
        self.check_indices(index, indices)?;
        if let (Some((low, high)), MacroValue::Real(number)) = (range, &value)
            && !(low..=high).contains(number)
        {
            let message = format!("{} takes numbers from {low} to {high}, not {number}", self.name(index));
            return Err(MacroFault::new(DiagnosticNumber::BAD_VALUE, message));
        }
        if !indices.is_empty() {
            if self.elements.len() >= MOST_ELEMENTS {
                return Err(MacroFault::new(DiagnosticNumber::SIZE, "there are too many elements of system variables"));
            }
            self.elements.insert((index, indices.to_vec()), value);
        } else if let Some(place) = self.values.get_mut(index as usize) {
            *place = value;
        }
        Ok(())
    }

    /// Whether it is the variable that is always now.
    pub(crate) fn is_date(&self, index: u32) -> bool {
        self.date == Some(index)
    }

    /// Every value.
    pub(crate) fn all(&self) -> impl Iterator<Item = &MacroValue> {
        self.values.iter().chain(self.elements.values())
    }
}
