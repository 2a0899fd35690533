//! A host without a machine: commands are kept as text, files live in memory unless it is given an [`Outside`].
//!
//! Invariant: it answers every function of the language; what it was not told it answers as a control without a model,
//! without a user and without an NC program.

mod blocks;
mod dialog;
mod files;
mod model;
mod outside;
mod tables;

pub use dialog::Answer;
pub use outside::{Outside, Stream};

use super::{Command, Environment, Folder, Host, HostFn, Step, SystemVariable};
use crate::diag::{self, Diagnostic, Number};
use crate::fault::{Fault, Outcome};
use crate::format::{Register, Registers, any, wildcard_text};
use crate::func::stamp;
use crate::source::Source;
use crate::state::{Scale, State};
use crate::value::{Kind, Value};
use std::collections::{BTreeMap, HashMap};

/// What a system variable takes.
#[derive(Clone, Debug, Default)]
pub struct Domain {
    /// Largest value of each index, none without a limit.
    pub indices: Vec<Option<u32>>,
    /// Smallest and largest number.
    pub values: Option<(f64, f64)>,
    /// `$NULL` is a value, whatever the type.
    pub nullable: bool,
}

/// Gives the name of the tables for one that may be spelled otherwise.
type Spelling = fn(&str) -> Option<&'static str>;

/// The double. Any `CODE_…` and `REG_…` exists unless a list is given; system variables are those of its table.
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
    /// Blocks of the NC program.
    pub program: Vec<String>,
    /// Variables of the NC program by name, upper case, indices in brackets.
    pub nc_variables: BTreeMap<String, Value>,
    /// Lines the console gives.
    pub typed: std::collections::VecDeque<String>,
    outside: Option<Box<dyn Outside>>,
    unheard: bool,
    table: Vec<SystemVariable>,
    values: Vec<Value>,
    elements: HashMap<(u32, Vec<i64>), Value>,
    foreign: Option<fn(&str) -> Option<&'static str>>,
    globals: Vec<Value>,
    domains: Vec<Domain>,
    spelling: Option<Spelling>,
    /// Position of `$DATE`, which is always now.
    date: Option<u32>,
    identifiers: std::cell::RefCell<Vec<String>>,
    groups: HashMap<u32, u16>,
    block: blocks::Block,
    /// Position of the block read next.
    next: usize,
    answers: BTreeMap<String, Answer>,
    table_of_diagnostics: BTreeMap<u32, tables::Entry>,
    named_macros: Vec<tables::Named>,
    said_no_model: bool,
    folder: Folder,
}

impl Test {
    /// A double with a few system variables.
    #[must_use]
    pub fn new() -> Test {
        let mut test = Test::bare();
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

    /// A double without any system variable.
    #[must_use]
    pub fn bare() -> Test {
        let mut test = Test::default();
        for row in diag::TABLE {
            test.add_diagnostic(row.number.0, row.severity, row.about);
        }
        test
    }

    /// Adds a single system variable that begins with the value of its type.
    pub fn variable(&mut self, name: &str, kind: Option<Kind>, writable: bool) {
        let initial = kind.map_or(Value::Null, Kind::initial);
        self.system_variable(
            SystemVariable { name: name.to_owned(), kind, writable, indices: 0 },
            initial,
            Domain::default(),
        );
    }

    /// Adds a system variable; every element of an indexed one begins with `initial`.
    pub fn system_variable(&mut self, variable: SystemVariable, initial: Value, domain: Domain) {
        if variable.name == "$DATE" {
            self.date = u32::try_from(self.table.len()).ok();
        }
        self.table.push(variable);
        self.domains.push(domain);
        self.values.push(initial);
    }

    /// Tells which product has a system variable that the control does not have.
    pub fn foreign_variables(&mut self, product: fn(&str) -> Option<&'static str>) {
        self.foreign = Some(product);
    }

    /// Lets only these `CODE_…` and `REG_…` names exist.
    pub fn only_identifiers(&mut self, names: impl IntoIterator<Item = String>, spelling: Spelling) {
        self.spelling = Some(spelling);
        self.identifiers.borrow_mut().extend(names);
    }

    /// Lets lines go out and files be real.
    pub fn attach(&mut self, outside: Box<dyn Outside>) {
        self.outside = Some(outside);
    }

    fn identifier(&self, name: &str) -> u32 {
        let mut all = self.identifiers.borrow_mut();
        let at = all.iter().position(|other| other == name).unwrap_or_else(|| {
            all.push(name.to_owned());
            all.len() - 1
        });
        u32::try_from(at + 1).unwrap_or(0)
    }

    fn find(&self, name: &str) -> Option<u32> {
        let Some(spelling) = self.spelling else { return Some(self.identifier(name)) };
        let name = spelling(name)?;
        let at = self.identifiers.borrow().iter().position(|other| other == name)?;
        u32::try_from(at + 1).ok()
    }

    fn identifier_name(&self, index: u32, none: &str) -> String {
        let at = (index as usize).checked_sub(1);
        at.and_then(|at| self.identifiers.borrow().get(at).cloned()).unwrap_or_else(|| none.to_owned())
    }

    fn system_value(&self, name: &str) -> Option<&Value> {
        self.values.get(self.table.iter().position(|variable| variable.name == name)?)
    }

    fn system_text(&self, name: &str) -> String {
        self.system_value(name).and_then(Value::as_text).unwrap_or("").to_owned()
    }

    fn system_number(&self, name: &str) -> f64 {
        self.system_value(name).and_then(Value::as_real).unwrap_or(0.0)
    }

    /// Gives a single system variable a value, read-only or not.
    pub fn set_system(&mut self, name: &str, value: Value) {
        let at = self.table.iter().position(|variable| variable.name == name);
        if let Some(place) = at.and_then(|at| self.values.get_mut(at)) {
            *place = value;
        }
    }

    fn set_global(&mut self, index: usize, value: Value) {
        if self.globals.len() <= index {
            self.globals.resize(index + 1, Value::Unset);
        }
        if let Some(place) = self.globals.get_mut(index) {
            *place = value;
        }
    }

    fn variable_name_of(&self, index: u32) -> &str {
        self.table.get(index as usize).map_or("the variable", |variable| variable.name.as_str())
    }

    /// Refuses indices outside of what a system variable has.
    fn inside(&self, index: u32, indices: &[i64]) -> Outcome<()> {
        let Some(domain) = self.domains.get(index as usize) else { return Ok(()) };
        for (given, most) in indices.iter().zip(&domain.indices) {
            if *given < 1 || most.is_some_and(|most| *given > i64::from(most)) {
                let most = most.map_or_else(|| "no limit".to_owned(), |most| most.to_string());
                let message = format!("the index {given} of {} is not in 1 to {most}", self.variable_name_of(index));
                return Err(Fault::new(Number::OUT_OF_RANGE, message));
            }
        }
        Ok(())
    }

    /// Takes a line; a fault that ends the whole run if nobody takes lines any more.
    fn line(&mut self, state: &mut State, stream: Stream, text: &str) -> Outcome<i32> {
        let Some(outside) = &mut self.outside else {
            self.printed.push(text.to_owned());
            return Ok(0);
        };
        self.unheard |= !outside.line(stream, text);
        self.heard(state)
    }

    /// Ends the whole run when nobody takes lines any more.
    fn heard(&self, state: &mut State) -> Outcome<i32> {
        if !self.unheard {
            return Ok(0);
        }
        state.ticks = 0;
        Err(Fault::new(Number::TICKS, "nobody reads what is printed any more"))
    }

    /// A command for the control as text.
    fn noted(&self, command: &Command<'_>) -> String {
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
        }
    }
}

impl Environment for Test {
    fn system(&self) -> &[SystemVariable] {
        &self.table
    }
    fn code(&self, name: &str) -> Option<u32> {
        self.find(name)
    }
    fn register(&self, name: &str) -> Option<u32> {
        self.find(name)
    }
    fn identifiers(&self) -> Vec<String> {
        self.identifiers.borrow().clone()
    }
    fn foreign(&self, name: &str) -> Option<&'static str> {
        self.foreign.and_then(|product| product(name))
    }
    fn include(&mut self, name: &str, from: &str) -> Option<Source> {
        let from = from.replace('\\', "/");
        let beside = from.rfind('/').and_then(|at| from.get(..=at)).map(|folder| format!("{folder}{name}"));
        let beside = beside.and_then(|path| self.load(&path).ok().map(|text| (path, text)));
        let found = beside.or_else(|| self.load(name).ok().map(|text| (name.to_owned(), text)));
        found.map(|(path, text)| Source::new(path, text))
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
        let letter = match register {
            Register::Letter(letter) => letter,
            Register::Index(index) => Test::register_letter(Some(&Value::Real(f64::from(index))))?,
        };
        let text = wildcard_text(value.unwrap_or(0.0));
        Some(if word { format!("{letter}{text}") } else { text })
    }
}

impl Host for Test {
    fn read_system(&mut self, index: u32, indices: &[i64]) -> Outcome<Value> {
        self.inside(index, indices)?;
        if self.date == Some(index) {
            let (now, offset, _) = self.now();
            return Ok(Value::text(stamp(now, offset)));
        }
        let element = if indices.is_empty() { None } else { self.elements.get(&(index, indices.to_vec())) };
        Ok(element.or_else(|| self.values.get(index as usize)).cloned().unwrap_or(Value::Null))
    }

    fn write_system(&mut self, index: u32, indices: &[i64], value: Value) -> Outcome<()> {
        let kind = self.table.get(index as usize).and_then(|variable| variable.kind);
        let domain = self.domains.get(index as usize);
        let (range, nullable) = domain.map_or((None, false), |domain| (domain.values, domain.nullable));
        let value = match (kind, value) {
            (Some(kind), Value::Unset) => kind.initial(),
            (_, Value::Null) if nullable => Value::Null,
            (Some(kind), value) if value.kind() != Some(kind) => return Err(Fault::kind(kind.name(), &value)),
            (_, value) => value,
        };
        self.inside(index, indices)?;
        if let (Some((low, high)), Value::Real(number)) = (range, &value)
            && !(low..=high).contains(number)
        {
            let message = format!("{} takes numbers from {low} to {high}, not {number}", self.variable_name_of(index));
            return Err(Fault::new(Number::BAD_VALUE, message));
        }
        if !indices.is_empty() {
            if self.elements.len() >= 1_000_000 {
                return Err(Fault::new(Number::SIZE, "there are too many elements of system variables"));
            }
            self.elements.insert((index, indices.to_vec()), value);
        } else if let Some(place) = self.values.get_mut(index as usize) {
            *place = value;
        }
        Ok(())
    }

    fn global(&mut self, index: u32, _: usize, access: &mut dyn FnMut(&mut Value)) {
        if let Some(value) = self.own_global(index) {
            access(value);
        }
    }

    fn own_global(&mut self, index: u32) -> Option<&mut Value> {
        let index = index as usize;
        if self.globals.len() <= index {
            self.globals.resize(index + 1, Value::Unset);
        }
        self.globals.get_mut(index)
    }

    fn held(&self, scale: &mut Scale) {
        for (index, value) in self.globals.iter().enumerate() {
            let from = scale.bytes;
            scale.add(value);
            scale.held_by(from, || format!("the GLOBAL variable {}", index + 1));
        }
        let from = scale.bytes;
        self.values.iter().chain(self.elements.values()).for_each(|value| scale.add(value));
        scale.held_by(from, || "system variables".to_owned());
    }

    fn command(&mut self, state: &mut State, command: Command<'_>) -> Outcome<i32> {
        self.heard(state)?;
        match &command {
            Command::Print(text) => return self.line(state, Stream::Printed, text),
            Command::System(_) => {
                return Err(Fault::new(Number::SYSTEM_INHIBITED, "SYSTEM commands are switched off"));
            }
            Command::TapeRead => self.read_block(state),
            Command::Search(number) => self.go_to_block(*number),
            _ => {}
        }
        if self.outside.is_none() {
            let line = self.noted(&command);
            self.commands.push(line);
        }
        Ok(0)
    }

    fn function(&mut self, state: &mut State, function: HostFn, arguments: &[Value]) -> Outcome<Value> {
        let (call, program) = ((function, arguments), self.system_text("$TAPEN"));
        if let Some(answer) = self.with_files(|folder, shelf| folder.function(shelf, state, call, &program)) {
            return answer;
        }
        Ok(match function {
            HostFn::EndOfProgram => Value::Logical(self.next >= self.program.len()),
            HostFn::MachineFrame => Value::numbers(&[1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]),
            HostFn::Dialog => self.dialog(arguments)?,
            HostFn::Pause => Value::Logical(false),
            HostFn::Document => Test::out_of_scope(state, function),
            HostFn::DiagnosticSeverity => self.severity(arguments)?,
            HostFn::DiagnosticState => self.switched(arguments),
            HostFn::DiagnosticText => self.text_of(arguments),
            HostFn::MacroNames => self.macros(state, arguments)?,
            HostFn::MacroStates => self.macro_states(arguments),
            HostFn::RegisterFormat => Test::register_format(arguments),
            HostFn::RegisterPosition => Test::register_position(arguments),
            HostFn::AddItem => self.add(state, arguments)?,
            HostFn::TakeItem => self.seek(arguments, true)?,
            HostFn::SeekItem => self.seek(arguments, false)?,
            HostFn::ActiveCode => self.active(arguments, false),
            HostFn::SetActiveCode => self.active(arguments, true),
            HostFn::DataAsCode | HostFn::Restart => Value::Logical(true),
            HostFn::NcVariable => self.nc_variable(arguments),
            HostFn::SetNcVariable => self.set_nc_variable(arguments),
            HostFn::PreProcessorSetting => Test::setting_of_pre_processor(state, arguments),
            HostFn::SearchForward => self.search(state, arguments, true)?,
            HostFn::SearchBackward => self.search(state, arguments, false)?,
            HostFn::Apply => Value::Logical(false),
            HostFn::ForwardKinematics => self.kinematics(arguments, false)?,
            HostFn::InverseKinematics => self.kinematics(arguments, true)?,
            HostFn::ConfigureKinematics | HostFn::SelectRotaryAxes | HostFn::Unwind => Value::Real(1.0),
            _ => self.without_model(state, function),
        })
    }

    fn report(&mut self, _: &mut State, diagnostic: Diagnostic) {
        let Some(diagnostic) = self.changed(diagnostic).filter(|_| !self.unheard) else { return };
        match &mut self.outside {
            Some(outside) => outside.report(&diagnostic),
            None => self.diagnostics.push(diagnostic),
        }
    }

    fn diagnostic(&self, number: u32) -> Option<(u8, String)> {
        self.table_of_diagnostics.get(&number).map(|entry| (entry.severity, entry.text.clone()))
    }

    fn trace(&mut self, step: Step<'_>) {
        let line = step.to_string();
        match &mut self.outside {
            Some(_) if self.unheard => {}
            Some(outside) => self.unheard = !outside.line(Stream::Traced, &line),
            None => self.traced.push(line),
        }
    }

    fn may_open(&mut self, state: &mut State, path: &str) -> i32 {
        self.with_files(|folder, shelf| folder.openable(shelf, state, path))
    }

    fn may_write(&mut self, path: &str) -> i32 {
        self.with_files(|folder, shelf| folder.writable(shelf, path))
    }

    fn read_file(&mut self, path: &str) -> Option<String> {
        self.load(path).ok()
    }

    fn write_file(&mut self, path: &str, text: &str) -> bool {
        self.with_files(|folder, shelf| folder.save(shelf, path, text)).is_ok()
    }

    fn read_console(&mut self) -> Option<String> {
        match &mut self.outside {
            Some(outside) => outside.console(),
            None => self.typed.pop_front(),
        }
    }

    fn write_console(&mut self, line: &str) {
        match &mut self.outside {
            Some(outside) => {
                outside.line(Stream::Console, line);
            }
            None => self.printed.push(line.to_owned()),
        }
    }

    fn now(&self) -> (f64, i32, String) {
        self.outside.as_ref().map_or((0.0, 0, "UTC".to_owned()), |outside| outside.now())
    }

    fn setting(&self, definition: bool, name: &str) -> Option<String> {
        let variable = || self.system_value(name).and_then(Value::as_text).map(str::to_owned);
        let own = || self.settings.get(name).cloned().or_else(variable);
        match &self.outside {
            Some(outside) if !definition => own().or_else(|| outside.environment(name)),
            _ => own(),
        }
    }
}
