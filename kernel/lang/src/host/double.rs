//! A host without a machine: commands are kept as text, files live in memory.

use super::{Command, Environment, Host, SystemVariable};
use crate::diag::{Diagnostic, Number};
use crate::fault::{Fault, Outcome};
use crate::format::{Register, Registers, any, wildcard_text};
use crate::func::Function;
use crate::source::Source;
use crate::value::{Kind, Value};
use crate::vm::State;
use std::collections::BTreeMap;

/// The double. Any `CODE_…` and `REG_…` exists; system variables are those of `variables`.
#[derive(Debug, Default)]
pub struct Test {
    /// What PPRINT printed and what was written to the console.
    pub printed: Vec<String>,
    /// Commands for the control, one line each.
    pub commands: Vec<String>,
    /// Reported diagnostics.
    pub diagnostics: Vec<Diagnostic>,
    /// Lines of the trace.
    pub traced: Vec<String>,
    /// Files by name.
    pub files: BTreeMap<String, String>,
    /// Settings by name.
    pub settings: BTreeMap<String, String>,
    table: Vec<SystemVariable>,
    values: Vec<Value>,
    globals: Vec<Value>,
    identifiers: std::cell::RefCell<Vec<String>>,
}

impl Test {
    /// A double with a few writable system variables.
    #[must_use]
    pub fn new() -> Test {
        let mut test = Test::default();
        for (name, kind, writable) in [
            ("$S", Some(Kind::Real), true),
            ("$F", Some(Kind::Real), true),
            ("$XM", Some(Kind::Real), false),
            ("$YM", Some(Kind::Real), false),
            ("$ZM", Some(Kind::Real), false),
            ("$RAPID", Some(Kind::Logical), true),
            ("$MCD", Some(Kind::Text), false),
            ("$MCDRD", Some(Kind::Text), true),
            ("$MCDNO", Some(Kind::Real), false),
            ("$COOLNT", None, true),
        ] {
            test.variable(name, kind, writable);
        }
        test
    }

    /// Adds a system variable.
    pub fn variable(&mut self, name: &str, kind: Option<Kind>, writable: bool) {
        self.table.push(SystemVariable { name: name.to_owned(), kind, writable, indices: 0 });
        self.values.push(kind.map_or(Value::Null, Kind::initial));
    }

    fn identifier(&self, name: &str) -> u32 {
        let mut all = self.identifiers.borrow_mut();
        let at = all.iter().position(|other| other == name).unwrap_or_else(|| {
            all.push(name.to_owned());
            all.len() - 1
        });
        u32::try_from(at + 1).unwrap_or(0)
    }

    fn identifier_name(&self, index: u32, none: &str) -> String {
        let at = (index as usize).checked_sub(1);
        at.and_then(|at| self.identifiers.borrow().get(at).cloned()).unwrap_or_else(|| none.to_owned())
    }
}

impl Environment for Test {
    fn system(&self) -> &[SystemVariable] {
        &self.table
    }
    fn code(&self, name: &str) -> Option<u32> {
        Some(self.identifier(name))
    }
    fn register(&self, name: &str) -> Option<u32> {
        Some(self.identifier(name))
    }
    fn identifiers(&self) -> Vec<String> {
        self.identifiers.borrow().clone()
    }
    fn include(&mut self, name: &str, _: &str) -> Option<Source> {
        self.files.get(name).map(|text| Source::new(name, text.as_str()))
    }
}

impl Registers for Test {
    fn code_name(&self, code: u32) -> String {
        self.identifier_name(code, "CODE_NONE")
    }
    fn register_name(&self, register: u32) -> String {
        self.identifier_name(register, "REG_NONE")
    }
    fn register_text(&mut self, register: Register, value: Option<f64>, word: bool) -> Option<String> {
        let Register::Letter(letter) = register else { return None };
        let text = wildcard_text(value.unwrap_or(0.0));
        Some(if word { format!("{letter}{text}") } else { text })
    }
}

impl Host for Test {
    fn read_system(&mut self, index: u32, _: &[i64]) -> Outcome<Value> {
        Ok(self.values.get(index as usize).cloned().unwrap_or(Value::Null))
    }

    fn write_system(&mut self, index: u32, _: &[i64], value: Value) -> Outcome<()> {
        let kind = self.table.get(index as usize).and_then(|variable| variable.kind);
        if let Some(kind) = kind.filter(|kind| value.kind() != Some(*kind)) {
            return Err(Fault::kind(kind.name(), &value));
        }
        if let Some(place) = self.values.get_mut(index as usize) {
            *place = value;
        }
        Ok(())
    }

    fn global(&mut self, index: u32, access: &mut dyn FnMut(&mut Value)) {
        let index = index as usize;
        if self.globals.len() <= index {
            self.globals.resize(index + 1, Value::Unset);
        }
        if let Some(value) = self.globals.get_mut(index) {
            access(value);
        }
    }

    fn command(&mut self, _: &mut State, command: Command<'_>) -> Outcome<i32> {
        let when = |now: bool| if now { "EXEC/NOW" } else { "EXEC/NEXT" };
        let list = |values: &[Value]| {
            let mut text = String::new();
            for value in values {
                text.push(',');
                any(&mut text, value, self);
            }
            text
        };
        let line = match command {
            Command::Print(text) => {
                self.printed.push(text.to_owned());
                return Ok(0);
            }
            Command::System(_) => {
                return Err(Fault::new(Number::SYSTEM_INHIBITED, "SYSTEM commands are switched off"));
            }
            Command::Match(on) => format!("MATCH/{}", if on { "ON" } else { "OFF" }),
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
            Command::Listing(on) => format!("LPRINT/{}", if on { "ON" } else { "OFF" }),
            Command::Skip(lines) => format!("LPRINT/{lines}"),
        };
        self.commands.push(line);
        Ok(0)
    }

    fn function(&mut self, _: &mut State, function: &'static Function, arguments: &[Value]) -> Outcome<Value> {
        if function.name == "$FEOF" && arguments.is_empty() {
            return Ok(Value::Logical(true));
        }
        Err(Fault::new(Number::NO_HOST, format!("{} needs a machine, and there is none here", function.name)))
    }

    fn report(&mut self, diagnostic: Diagnostic) {
        self.diagnostics.push(diagnostic);
    }

    fn trace(&mut self, line: &str) {
        self.traced.push(line.to_owned());
    }

    fn read_file(&mut self, path: &str) -> Option<String> {
        self.files.get(path).cloned()
    }

    fn write_file(&mut self, path: &str, text: &str) -> bool {
        self.files.insert(path.to_owned(), text.to_owned());
        true
    }

    fn write_console(&mut self, line: &str) {
        self.printed.push(line.to_owned());
    }

    fn setting(&self, _: bool, name: &str) -> Option<String> {
        self.settings.get(name).cloned()
    }
}
