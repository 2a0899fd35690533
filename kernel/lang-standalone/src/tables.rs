//! Tables of the control: diagnostics and macros.
//!
//! Facts: reference functions.md 8. A diagnostic that is switched off is not reported; a changed severity counts from
//! the next report on.

use std::collections::BTreeMap;

use counterpoint_lang::diag::{DiagnosticNumber, MacroDiagnostic};
use counterpoint_lang::fault::{MacroFault, Outcome};
use counterpoint_lang::state::MacroState;
use counterpoint_lang::value::MacroValue;

use crate::text;

/// A diagnostic of the tables.
#[derive(Clone, Debug)]
struct DiagnosticEntry {
    severity: u8,
    text: String,
    changed: bool,
    on: bool,
}

/// A macro of the control as `$FMACID` knows it.
#[derive(Clone, Debug)]
struct MacroEntry {
    id: f64,
    name: String,
    on: bool,
}

fn number(arguments: &[MacroValue], position: usize) -> u32 {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    arguments.get(position).and_then(MacroValue::as_real).map_or(0, |number| number.max(0.0) as u32)
}

/// Diagnostics and macros of the control.
#[derive(Debug, Default)]
pub(crate) struct ControlTables {
    diagnostics: BTreeMap<u32, DiagnosticEntry>,
    macros: Vec<MacroEntry>,
}

impl ControlTables {
    /// Severity and text of a diagnostic.
    pub(crate) fn diagnostic(&self, number: u32) -> Option<(u8, String)> {
        self.diagnostics.get(&number).map(|entry| (entry.severity, entry.text.clone()))
    }

    /// Adds a diagnostic to the tables; the text is a string format.
    pub(crate) fn add_diagnostic(&mut self, number: u32, severity: u8, text: &str) {
        self.diagnostics.insert(number, DiagnosticEntry { severity, text: text.to_owned(), changed: false, on: true });
    }

    /// Adds a macro that `$FMACID` finds.
    pub(crate) fn add_macro(&mut self, id: f64, name: &str) {
        self.macros.push(MacroEntry { id, name: name.to_owned(), on: true });
    }

    /// The diagnostic as it is reported now, none if it is switched off.
    pub(crate) fn changed(&self, mut diagnostic: MacroDiagnostic) -> Option<MacroDiagnostic> {
        let own = matches!(diagnostic.number, DiagnosticNumber::AUTHOR | DiagnosticNumber::TERMAC_GENERATED);
        match self.diagnostics.get(&diagnostic.number.0).filter(|_| !own) {
            Some(entry) if !entry.on => None,
            Some(entry) if entry.changed => {
                diagnostic.severity = entry.severity;
                Some(diagnostic)
            }
            _ => Some(diagnostic),
        }
    }

    pub(crate) fn severity(&mut self, arguments: &[MacroValue]) -> Outcome<MacroValue> {
        let Some(entry) = self.diagnostics.get_mut(&number(arguments, 0)) else {
            return Ok(MacroValue::Real(-1.0));
        };
        let before = entry.severity;
        if arguments.len() > 1 {
            let wanted = number(arguments, 1);
            let fault = || MacroFault::new(DiagnosticNumber::OUT_OF_RANGE, "a severity is 0 to 99");
            entry.severity = u8::try_from(wanted).ok().filter(|severity| *severity < 100).ok_or_else(fault)?;
            entry.changed = true;
        }
        Ok(MacroValue::Real(f64::from(before)))
    }

    pub(crate) fn switched(&mut self, arguments: &[MacroValue]) -> MacroValue {
        let Some(entry) = self.diagnostics.get_mut(&number(arguments, 0)) else {
            return MacroValue::Logical(false);
        };
        let before = entry.on;
        if let Some(on) = arguments.get(1).and_then(MacroValue::as_logical) {
            entry.on = on;
        }
        MacroValue::Logical(before)
    }

    pub(crate) fn text_of(&self, arguments: &[MacroValue]) -> MacroValue {
        let entry = self.diagnostics.get(&number(arguments, 0));
        MacroValue::text(entry.map_or("", |entry| entry.text.as_str()))
    }

    /// `$FMACID`: of the running macro, which has the identity 0 here, without an expression.
    pub(crate) fn macros(&self, state: &mut MacroState, arguments: &[MacroValue]) -> Outcome<MacroValue> {
        let expression = text(arguments, 0);
        if expression.trim().is_empty() {
            return Ok(MacroValue::sequence(vec![MacroValue::Real(0.0), MacroValue::text("")]));
        }
        let pattern = state.pattern(expression)?;
        let (mut found, mut budget) = (Vec::new(), counterpoint_lang::pattern::STEPS);
        for named in &self.macros {
            if pattern.find(&named.name, 0, &mut budget)?.is_some() {
                found.extend([MacroValue::Real(named.id), MacroValue::text(named.name.as_str())]);
            }
        }
        Ok(MacroValue::sequence(found))
    }

    pub(crate) fn macro_states(&mut self, arguments: &[MacroValue]) -> MacroValue {
        counterpoint_lang::host::macro_states(arguments, |id, on| {
            let named = self.macros.iter_mut().find(|named| named.id == id)?;
            let before = named.on;
            named.on = on.unwrap_or(before);
            Some(before)
        })
    }
}
