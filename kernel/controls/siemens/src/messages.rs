//! MSG and SETAL: texts and alarms of the program.
//!
//! Facts: reference control-emulator.md 5.4; alarms 60000 to 69999 are those of users, and their number says whether
//! they stop the channel. *Invariant:* a shown text is a text of the program, never an expression that could be
//! evaluated.

use super::compiled::{SiemensArgument, as_name};
use super::left::SiemensRemainder;
use super::{Outcome, Siemens, SiemensBlockError, syntax};
use counterpoint_control_api::host::InterpreterHost;
use counterpoint_fault as diag;

impl Siemens {
    pub(super) fn message(
        &mut self,
        host: &mut dyn InterpreterHost,
        argument: Option<&SiemensArgument>,
        left: &mut SiemensRemainder,
    ) -> Outcome<()> {
        let text = match argument {
            None => String::new(),
            Some(argument) => match &argument.value {
                Ok(None) => String::new(),
                Ok(Some(expression)) => match as_name(expression) {
                    Some(name)
                        if name.index.is_empty()
                            && !name.name.starts_with('$')
                            && !self.variables.knows(&name.name) =>
                    {
                        argument.text.clone()
                    }
                    _ => self.evaluate(host, expression)?.text(),
                },
                // A text without quotation marks.
                Err(_) if !argument.text.contains('"') => argument.text.clone(),
                Err(text) => return syntax(text.clone()),
            },
        };
        if self.settings.messages {
            host.show(&text);
        } else {
            left.add(&format!("MSG(\"{text}\")"));
        }
        Ok(())
    }

    /// SETAL: an alarm, which stops the channel or is only shown, as its number says.
    pub(super) fn set_alarm(&mut self, host: &mut dyn InterpreterHost, arguments: &[SiemensArgument]) -> Outcome<()> {
        let Some(first) = arguments.first() else { return syntax("SETAL needs the number of an alarm") };
        let number = match self.argument(host, first)? {
            Some(value) => super::conversions::number(&value)?,
            None => return syntax("SETAL needs the number of an alarm"),
        };
        if number.fract() != 0.0 || !(60_000.0..70_000.0).contains(&number) {
            let number = super::number_text::shown(number);
            return super::wrong_type(format!("SETAL sets alarms 60000 to 69999, not {number}"));
        }
        let text = match arguments.get(1) {
            Some(text) => self.argument(host, text)?.map_or_else(String::new, |text| format!(": {}", text.text())),
            None => String::new(),
        };
        self.raise(host, number as u32, format!("the program sets alarm {number}{text}"))
    }

    /// Raises an alarm of a cycle, which stops the channel or is only shown, as its number says.
    pub(super) fn raise(&mut self, host: &mut dyn InterpreterHost, number: u32, text: String) -> Outcome<()> {
        let is_shown = matches!(number / 1000, 60 | 63 | 64 | 67);
        match self.settings.severity {
            Some(severity) => host.report(&diag::SIEMENS_ALARM, severity, text),
            None if is_shown => host.diagnose(&diag::SIEMENS_ALARM, text),
            None => return Err(SiemensBlockError::Alarm(&diag::SIEMENS_STOP, text)),
        }
        Ok(())
    }
}
