//! Commands for the control, kept as text.

use counterpoint_lang::diag::DiagnosticNumber;
use counterpoint_lang::fault::{MacroFault, Outcome};
use counterpoint_lang::format::{FormatRegister, RegisterHost, any, wildcard_text};
use counterpoint_lang::host::{CommandHost, HostCommand};
use counterpoint_lang::state::MacroState;
use counterpoint_lang::value::MacroValue;

use super::Standalone;
use crate::outside::OutputStream;
use crate::registers;

impl RegisterHost for Standalone {
    fn code_name(&self, code: u32) -> String {
        self.identifiers.name(code, "CODE_NONE")
    }
    fn register_name(&self, register: u32) -> String {
        self.identifiers.name(register, "REG_NONE")
    }
    fn register_text(&mut self, register: FormatRegister, value: Option<f64>, word: bool) -> Option<String> {
        let letter = match register {
            FormatRegister::Letter(letter) => letter,
            FormatRegister::Index(index) => registers::letter(Some(&MacroValue::Real(f64::from(index))))?,
        };
        let text = wildcard_text(value.unwrap_or(0.0));
        Some(if word { format!("{letter}{text}") } else { text })
    }
}

impl Standalone {
    /// Takes a line; a fault that ends the whole run if the output accepts no more lines.
    fn show(&mut self, state: &mut MacroState, stream: OutputStream, text: &str) -> Outcome<i32> {
        let Some(outside) = &mut self.outside else {
            self.output.printed.push(text.to_owned());
            return Ok(0);
        };
        self.output.closed |= !outside.line(stream, text);
        self.check_open(state)
    }

    /// Ends the whole run when the output accepts no more lines.
    fn check_open(&self, state: &mut MacroState) -> Outcome<i32> {
        if !self.output.closed {
            return Ok(0);
        }
        state.ticks = 0;
        Err(MacroFault::new(DiagnosticNumber::TICKS, "the output is not read any more"))
    }

    /// A command for the control as text.
    fn command_text(&self, command: &HostCommand<'_>) -> String {
        let when = |now: &bool| if *now { "EXEC/NOW" } else { "EXEC/NEXT" };
        let list = |values: &[MacroValue]| {
            let mut text = String::new();
            for value in values {
                text.push(',');
                any(&mut text, value, self);
            }
            text
        };
        match command {
            HostCommand::Match(on) => format!("MATCH/{}", if *on { "ON" } else { "OFF" }),
            HostCommand::Output(values) => {
                let values: Vec<MacroValue> = values.iter().map(|(_, value)| value.clone()).collect();
                format!("OUTPUT{}", list(&values))
            }
            HostCommand::ExecBlock(now, text) => format!("{},{text}", when(now)),
            HostCommand::ExecItems(now, values) => format!("{}{}", when(now), list(values)),
            HostCommand::TapeRead => "TAPERD".to_owned(),
            HostCommand::TapeWrite => "TAPEWT".to_owned(),
            HostCommand::Search(number) => format!("SEARCH/{number}"),
            HostCommand::SaveModal => "SAVMODAL".to_owned(),
            HostCommand::RestoreModal => "RSTMODAL".to_owned(),
            HostCommand::Listing(on) => format!("LPRINT/{}", if *on { "ON" } else { "OFF" }),
            HostCommand::Skip(lines) => format!("LPRINT/{lines}"),
            HostCommand::Print(text) | HostCommand::System(text) => (*text).to_owned(),
            HostCommand::MatchAgain => String::new(),
        }
    }
}

impl CommandHost for Standalone {
    fn command(&mut self, state: &mut MacroState, command: HostCommand<'_>) -> Outcome<i32> {
        self.check_open(state)?;
        match &command {
            HostCommand::Print(text) => return self.show(state, OutputStream::Printed, text),
            HostCommand::System(_) => {
                return Err(MacroFault::new(DiagnosticNumber::SYSTEM_INHIBITED, "SYSTEM commands are switched off"));
            }
            // No command of the macro's own.
            HostCommand::MatchAgain => return Ok(0),
            HostCommand::TapeRead => self.program.read_block(&mut self.system, state),
            HostCommand::Search(number) => self.program.go_to(*number),
            _ => {}
        }
        if self.outside.is_none() {
            let line = self.command_text(&command);
            self.output.commands.push(line);
        }
        Ok(0)
    }
}
