//! Diagnostics on a kernel with macros: severities, switches, counters, and the diagnostic event macro.
//!
//! Facts: reference control-emulator.md 4.3, 7.5, functions.md 7. *Invariant:* diagnostics raised by the diagnostic
//! macro itself go straight to the log.

use std::sync::Arc;

use counterpoint_channel::burden::{RESULT, shortened};
use counterpoint_channel::custom_diagnostics::customised;
use counterpoint_channel::macros::books::operations::operation_name;
use counterpoint_channel::macros::calls::OutputTask;
use counterpoint_event::event::{Diagnostic, DiagnosticOrigin, Kind};
use counterpoint_fault as diag;
use counterpoint_lang::diag as language;
use counterpoint_lang::diag::{DiagnosticNumber, TABLE};
use counterpoint_lang::fault::{MacroFault, Outcome};
use counterpoint_lang::value::MacroValue;
use counterpoint_machine::macros::model::Hook;

use super::variables::kernels;
use crate::context::KernelHost;

/// Numbers that `$DIAGLIST` keeps.
const MOST_LISTED: usize = 10_000;

/// Severity and text of a number in the tables of the product.
fn shipped(number: u32) -> Option<(u8, &'static str)> {
    let own = diag::ALL.iter().find(|facts| facts.number == number).map(|facts| (facts.severity, facts.title));
    own.or_else(|| of_language(number))
}

/// The same for diagnostics that the macro language raises.
fn of_language(number: u32) -> Option<(u8, &'static str)> {
    TABLE.iter().find(|row| row.number.0 == number).map(|row| (row.severity, row.about))
}

fn number(value: Option<&MacroValue>) -> Option<u32> {
    let number = value?.as_real()?;
    (number.fract() == 0.0 && (0.0..=99_999_999.0).contains(&number)).then_some(number as u32)
}

impl KernelHost<'_, '_> {
    /// Severity and text of a number as a macro may raise it.
    pub(crate) fn diagnostic_entry(&self, number: u32) -> Option<(u8, String)> {
        let (_, text) = self.entry(number)?;
        let (severity, _) = self.state_of(number)?;
        Some((severity, text.to_owned()))
    }

    /// Severity and text of a number on this machine, which may change those of the product and have numbers of its
    /// own.
    fn entry(&self, number: u32) -> Option<(u8, &str)> {
        let rule = self.kernel.channel.env.machine.diagnostics.rule(number);
        let known = shipped(number);
        let severity = rule.and_then(|rule| rule.severity).or(known.map(|(severity, _)| severity))?;
        let text = rule.and_then(|rule| rule.text.as_deref()).or(known.map(|(_, text)| text))?;
        Some((severity, text))
    }

    /// Severity and text that the machine gives to a diagnostic of a macro; none if it is not shown. The text of a
    /// number that ERROR raises is already complete.
    pub(crate) fn customised_of_macro(
        &mut self,
        number: DiagnosticNumber,
        (severity, stops): (u8, bool),
        text: String,
    ) -> Option<(u8, String)> {
        let made = of_language(number.0).is_none().then(|| text.clone());
        let (custom, text) =
            customised(&mut self.kernel.channel, &self.kernel.macros, number.0, (severity, stops), text)?;
        Some(match made {
            Some(made) => (severity, made),
            None => (custom, text),
        })
    }

    /// The statement that raised a diagnostic. The end of a macro because of an error adds nothing to the report of the
    /// error.
    pub(crate) fn origin_of(&self, diagnostic: &language::MacroDiagnostic) -> Option<Box<DiagnosticOrigin>> {
        if diagnostic.number == DiagnosticNumber::TERMAC_GENERATED {
            return None;
        }
        let function = diagnostic.macro_name.as_deref().filter(|_| diagnostic.in_function);
        Some(Box::new(DiagnosticOrigin {
            name: function.or_else(|| self.called_name()).unwrap_or_default().into(),
            file: diagnostic.file.as_str().into(),
            line: diagnostic.line,
            statement: diagnostic.statement.as_deref().unwrap_or_default().into(),
        }))
    }

    /// Sends a diagnostic to the log, with all changes of macros. A diagnostic that `stops` the channel stays in the
    /// log even if macros have switched it off.
    pub(crate) fn issue(
        &mut self,
        (number, severity): (u32, u8),
        text: String,
        (origin, stops): (Option<Box<DiagnosticOrigin>>, bool),
    ) {
        let enabled = || self.kernel.channel.env.machine.diagnostics.rule(number).is_none_or(|rule| rule.enable);
        let enabled = self.kernel.channel.env.machine.diagnostics.is_plain() || enabled();
        let runtime = &mut *self.kernel.macros;
        if !runtime.variables.store.messages {
            if stops {
                self.put_diagnostic((number, severity), &text, origin);
            }
            return;
        }
        let own = number == DiagnosticNumber::AUTHOR.0 || number == DiagnosticNumber::TERMAC_GENERATED.0;
        let (severity, on) = match runtime.diagnostics.severities.get(&number) {
            Some(&(changed, on)) if !own => (changed, on),
            _ => (severity, own || enabled),
        };
        let count = runtime.diagnostics.counts.entry(number).or_default();
        *count = count.saturating_add(1);
        let times = *count;
        match runtime.ready(Hook::Diagnostic) {
            Some(code) => {
                runtime.diagnostics.origin = origin;
                self.diagnostic_macro(code, (number, severity, on, times), text, stops);
            }
            None if on || stops => self.put_diagnostic((number, severity), &text, origin),
            None => {}
        }
    }

    fn diagnostic_macro(
        &mut self,
        code: u16,
        (number, severity, on, times): (u32, u8, bool, u32),
        text: String,
        stops: bool,
    ) {
        let mut arguments = [
            MacroValue::Real(f64::from(u8::from(on))),
            MacroValue::Real(f64::from(number)),
            MacroValue::Real(f64::from(severity)),
            MacroValue::Real(f64::from(times)),
            MacroValue::text(text),
        ];
        let [_, number, severity, _, text] = &arguments;
        let came = Arc::new([number.clone(), severity.clone(), text.clone()]);
        match self.hooks().run_macro(code, OutputTask::Diagnostic(came), &mut arguments) {
            Err(halt) => self.kernel.macros.calls.stop(halt),
            // OUTPUT has issued it already.
            Ok(1..) => {}
            Ok(0) => {
                let [flag, number, severity, _, text] = &arguments;
                if stops || flag.as_real() != Some(0.0) {
                    let values = [number.clone(), severity.clone(), text.clone()];
                    if let Err(fault) = self.output_diagnostic(&values) {
                        self.put_diagnostic((fault.number.0, fault.number.severity()), &fault.message, None);
                    }
                }
            }
        }
    }

    /// Issues the diagnostic in `$P2`, `$P3` and `$P5` of the diagnostic macro.
    pub(crate) fn output_diagnostic(&mut self, [index, severity, text]: &[MacroValue; 3]) -> Outcome<()> {
        let wrong = |what: &str| {
            MacroFault::new(DiagnosticNumber(diag::MACRO_RESULT.number), format!("{what} of a diagnostic"))
        };
        let index = number(Some(index)).ok_or_else(|| wrong("not a valid number"))?;
        let severity = number(Some(severity)).filter(|s| *s < 100).ok_or_else(|| wrong("not a valid severity"))?;
        let text = text.as_text().ok_or_else(|| wrong("not a valid text"))?;
        let origin = self.kernel.macros.diagnostics.origin.clone();
        self.put_diagnostic((index, severity as u8), text, origin);
        Ok(())
    }

    /// Counts and logs.
    fn put_diagnostic(&mut self, (number, severity): (u32, u8), text: &str, origin: Option<Box<DiagnosticOrigin>>) {
        self.kernel.channel.reports.alarms.count(severity);
        self.kernel.macros.books.diagnosed(severity);
        let class = match severity {
            0..=3 => 0,
            4..=7 => 1,
            8..=15 => 2,
            _ => 3,
        };
        let store = &mut self.kernel.macros.variables.store;
        if let Some(count) = store.counts.get_mut(class) {
            *count += 1.0;
        }
        if store.listed.len() < MOST_LISTED {
            store.listed.push(number);
        }
        let text: String = shortened(text).chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
        let operation = operation_name(&self.kernel.macros.variables.store).into();
        let kernel = kernels::kernel_name(self).into();
        self.kernel.channel.burden.result(text.len() + RESULT);
        let unrecognised = self.kernel.channel.reports.take_unrecognised(number, &text);
        let race = self.kernel.channel.reports.take_race(number);
        let text = text.into();
        let diagnostic = Diagnostic { number, severity, text, operation, kernel, origin, unrecognised, race };
        self.kernel.channel.emit(0, Kind::Diagnostic(Box::new(diagnostic)));
    }

    /// `$FERSEV`: severity before the change, −1 for an unknown number.
    pub(crate) fn severity_of(&mut self, arguments: &[MacroValue]) -> Outcome<MacroValue> {
        let Some((index, (severity, on))) = number(arguments.first()).and_then(|n| Some((n, self.state_of(n)?))) else {
            return Ok(MacroValue::Real(-1.0));
        };
        if arguments.len() > 1 {
            let wanted = number(arguments.get(1)).filter(|severity| *severity < 100);
            let wanted =
                wanted.ok_or_else(|| MacroFault::new(DiagnosticNumber::OUT_OF_RANGE, "a severity is 0 to 99"))?;
            self.kernel.macros.diagnostics.severities.insert(index, (wanted as u8, on));
        }
        Ok(MacroValue::Real(f64::from(severity)))
    }

    /// `$FERSTA`: whether it was on before the change.
    pub(crate) fn switched(&mut self, arguments: &[MacroValue]) -> MacroValue {
        let Some((index, (severity, on))) = number(arguments.first()).and_then(|n| Some((n, self.state_of(n)?))) else {
            return MacroValue::Logical(false);
        };
        if let Some(wanted) = arguments.get(1).and_then(MacroValue::as_logical) {
            self.kernel.macros.diagnostics.severities.insert(index, (severity, wanted));
        }
        MacroValue::Logical(on)
    }

    /// `$FERTXT`.
    pub(crate) fn text_of(&self, arguments: &[MacroValue]) -> MacroValue {
        let entry = number(arguments.first()).and_then(|number| self.entry(number));
        MacroValue::text(entry.map_or("", |(_, text)| text))
    }

    fn state_of(&self, number: u32) -> Option<(u8, bool)> {
        let (severity, _) = self.entry(number)?;
        let changed = self.kernel.macros.diagnostics.severities.get(&number).copied();
        let on = || self.kernel.channel.env.machine.diagnostics.rule(number).is_none_or(|rule| rule.enable);
        Some(changed.unwrap_or_else(|| (severity, on())))
    }
}
