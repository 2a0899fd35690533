//! Commands for the control, kept as text.

use counterpoint_lang::diag::Number;
use counterpoint_lang::fault::{Fault, Outcome};
use counterpoint_lang::format::{Register, Registers, any, wildcard_text};
use counterpoint_lang::host::{Blocks, Command};
use counterpoint_lang::state::State;
use counterpoint_lang::value::Value;

use super::Standalone;
use crate::outside::Stream;
use crate::registers;

impl Registers for Standalone {
    fn code_name(&self, code: u32) -> String {
        self.identifiers.name(code, "CODE_NONE")
    }
    fn register_name(&self, register: u32) -> String {
        self.identifiers.name(register, "REG_NONE")
    }
    fn register_text(&mut self, register: Register, value: Option<f64>, word: bool) -> Option<String> {
        let letter = match register {
            Register::Letter(letter) => letter,
            Register::Index(index) => registers::letter(Some(&Value::Real(f64::from(index))))?,
        };
        let text = wildcard_text(value.unwrap_or(0.0));
        Some(if word { format!("{letter}{text}") } else { text })
    }
}

impl Standalone {
    /// Takes a line; a fault that ends the whole run if the output accepts no more lines.
    fn show(&mut self, state: &mut State, stream: Stream, text: &str) -> Outcome<i32> {
        let Some(outside) = &mut self.outside else {
            self.output.printed.push(text.to_owned());
            return Ok(0);
        };
        self.output.closed |= !outside.line(stream, text);
        self.check_open(state)
    }

    /// Ends the whole run when the output accepts no more lines.
    fn check_open(&self, state: &mut State) -> Outcome<i32> {
        if !self.output.closed {
            return Ok(0);
        }
        state.ticks = 0;
        Err(Fault::new(Number::TICKS, "the output is not read any more"))
    }

    /// A command for the control as text.
    fn command_text(&self, command: &Command<'_>) -> String {
        let when = |now: &bool| if *now { "EXEC/NOW" } else { "EXEC/NEXT" };
        let list = |values: &[Value]| {
            let mut text = String::new();
            for value in values {
                text.push(',');
                any(&mut text, value, self);
            }
            text
        };
        match command {
            Command::Match(on) => format!("MATCH/{}", if *on { "ON" } else { "OFF" }),
            Command::Output(values) => {
                let values: Vec<Value> = values.iter().map(|(_, value)| value.clone()).collect();
                format!("OUTPUT{}", list(&values))
            }
            Command::ExecBlock(now, text) => format!("{},{text}", when(now)),
            Command::ExecItems(now, values) => format!("{}{}", when(now), list(values)),
            Command::TapeRead => "TAPERD".to_owned(),
            Command::TapeWrite => "TAPEWT".to_owned(),
            Command::Search(number) => format!("SEARCH/{number}"),
            Command::SaveModal => "SAVMODAL".to_owned(),
            Command::RestoreModal => "RSTMODAL".to_owned(),
            Command::Listing(on) => format!("LPRINT/{}", if *on { "ON" } else { "OFF" }),
            Command::Skip(lines) => format!("LPRINT/{lines}"),
            Command::Print(text) | Command::System(text) => (*text).to_owned(),
            Command::MatchAgain => String::new(),
        }
    }
}

impl Blocks for Standalone {
    fn command(&mut self, state: &mut State, command: Command<'_>) -> Outcome<i32> {
        self.check_open(state)?;
        match &command {
            Command::Print(text) => return self.show(state, Stream::Printed, text),
            Command::System(_) => {
                return Err(Fault::new(Number::SYSTEM_INHIBITED, "SYSTEM commands are switched off"));
            }
            // No command of the macro's own.
            Command::MatchAgain => return Ok(0),
            Command::TapeRead => self.program.read_block(&mut self.system, state),
            Command::Search(number) => self.program.go_to(*number),
            _ => {}
        }
        if self.outside.is_none() {
            let line = self.command_text(&command);
            self.output.commands.push(line);
        }
        Ok(0)
    }
}
