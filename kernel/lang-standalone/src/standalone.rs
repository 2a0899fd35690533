//! A host without a machine: commands are kept as text, files live in memory unless it is given an [`HostEnvironment`].
//!
//! *Invariant:* it answers every function of the language; without prepared data it answers as a control without a
//! model, without a user and without an NC program.

mod commands;
mod dialog;
mod files;
mod variables;

use std::collections::{BTreeMap, VecDeque};

use counterpoint_lang::diag::{self, DiagnosticNumber};
use counterpoint_lang::fault::{MacroFault, Outcome};
use counterpoint_lang::host::{AbsentFn, CompileEnvironment, HostFn, MacroHost, SystemVariable};
use counterpoint_lang::source::MacroSource;
use counterpoint_lang::state::MacroState;
use counterpoint_lang::value::{MacroValue, ValueType};

use crate::answers::{Answers, PreparedAnswer};
use crate::files::VirtualDisk;
use crate::identifiers::{Identifiers, Spelling};
use crate::model;
use crate::output::MacroOutput;
use crate::outside::HostEnvironment;
use crate::program::{self, NcProgram};
use crate::registers;
use crate::tables::ControlTables;
use crate::variables::{Domain, SystemTable};

/// A host without a machine. Any `CODE_…` and `REG_…` exists unless a list is given; system variables are those of its
/// table.
#[derive(Debug, Default)]
pub struct Standalone {
    /// The output of macros.
    pub output: MacroOutput,
    /// Lines that the console gives.
    pub typed: VecDeque<String>,
    /// Files, in memory or outside.
    pub disk: VirtualDisk,
    /// Settings by name.
    pub settings: BTreeMap<String, String>,
    /// The NC program and the current block.
    pub program: NcProgram,
    pub(crate) outside: Option<Box<dyn HostEnvironment>>,
    pub(crate) system: SystemTable,
    pub(crate) globals: Vec<MacroValue>,
    pub(crate) identifiers: Identifiers,
    pub(crate) tables: ControlTables,
    answers: Answers,
    reported_no_model: bool,
}

impl Standalone {
    /// A host with a few system variables.
    #[must_use]
    pub fn new() -> Self {
        let mut host = Self::bare();
        for (name, kind, writable) in [
            ("$S", Some(ValueType::Real), true),
            ("$F", Some(ValueType::Real), true),
            ("$XM", Some(ValueType::Real), false),
            ("$YM", Some(ValueType::Real), false),
            ("$ZM", Some(ValueType::Real), false),
            ("$RAPID", Some(ValueType::Logical), true),
            ("$MCD", Some(ValueType::Text), false),
            ("$MCDRD", Some(ValueType::Text), true),
            ("$MCDNO", Some(ValueType::Real), false),
            ("$COOLNT", None, true),
        ] {
            host.variable(name, kind, writable);
        }
        host
    }

    /// A host without any system variable.
    #[must_use]
    pub fn bare() -> Self {
        let mut host = Self::default();
        for row in diag::TABLE {
            host.add_diagnostic(row.number.0, row.severity, row.about);
        }
        host
    }

    /// Adds a single system variable that begins with the value of its type.
    pub fn variable(&mut self, name: &str, kind: Option<ValueType>, writable: bool) {
        let initial = kind.map_or(MacroValue::Null, ValueType::initial);
        let variable = SystemVariable { name: name.to_owned(), kind, writable, indices: 0 };
        self.system.add(variable, initial, Domain::default());
    }

    /// Adds a system variable; every element of an indexed one begins with `initial`.
    pub fn system_variable(&mut self, variable: SystemVariable, initial: MacroValue, domain: Domain) {
        self.system.add(variable, initial, domain);
    }

    /// Gives a single system variable a value, read-only or not.
    pub fn set_system(&mut self, name: &str, value: MacroValue) {
        self.system.set(name, value);
    }

    /// Names the product that has a system variable which the control does not have.
    pub fn foreign_variables(&mut self, product: fn(&str) -> Option<&'static str>) {
        self.system.foreign = Some(product);
    }

    /// Lets only these `CODE_…` and `REG_…` names exist.
    pub fn only_identifiers(&mut self, names: impl IntoIterator<Item = String>, spelling: Spelling) {
        self.identifiers.only(names, spelling);
    }

    /// Sends lines outside and takes files from there.
    pub fn attach(&mut self, outside: Box<dyn HostEnvironment>) {
        self.outside = Some(outside);
    }

    /// Puts a code or data of the control's tables on the current block; data become modal, too.
    pub fn put_on_block(&mut self, name: &str, value: f64) {
        let index = self.identifiers.index(name);
        let item = if name.starts_with("CODE_") { MacroValue::Code(index) } else { MacroValue::Register(index) };
        self.program.block.put(item, value);
    }

    /// Makes a code a member of a modal group.
    pub fn group(&mut self, code: &str, group: u16) {
        let index = self.identifiers.index(code);
        self.program.block.group(index, group);
    }

    /// Adds a diagnostic to the tables; the text is a string format.
    pub fn add_diagnostic(&mut self, number: u32, severity: u8, text: &str) {
        self.tables.add_diagnostic(number, severity, text);
    }

    /// Adds a macro that `$FMACID` finds.
    pub fn add_macro(&mut self, id: f64, name: &str) {
        self.tables.add_macro(id, name);
    }

    /// Gives the answer to a dialog.
    pub fn answer(&mut self, dialog: &str, answer: PreparedAnswer) {
        self.answers.add(dialog, answer);
    }

    /// Place of a global variable.
    pub(crate) fn global_place(&mut self, index: usize) -> Option<&mut MacroValue> {
        if self.globals.len() <= index {
            self.globals.resize(index + 1, MacroValue::Unset);
        }
        self.globals.get_mut(index)
    }

    /// `$FDIALOG`: the button of the answer that was given ahead; its values are set.
    fn dialog(&mut self, arguments: &[MacroValue]) -> Outcome<MacroValue> {
        let answer = self.answers.find(crate::text(arguments, 0))?;
        for (variable, value) in answer.values {
            match variable.strip_prefix("%G").and_then(|number| number.parse::<usize>().ok()) {
                Some(index) if index < 100 => {
                    if let Some(place) = self.global_place(index) {
                        *place = value;
                    }
                }
                _ => self.system.set(&variable, value),
            }
        }
        Ok(MacroValue::text(answer.button))
    }

    /// Result of a function of a machine model; one message per run.
    fn without_model(&mut self, state: &mut MacroState, function: HostFn) -> MacroValue {
        if !std::mem::replace(&mut self.reported_no_model, true) {
            let message = format!("{} needs a machine model, and there is none here", function.name());
            state.warn(MacroFault::new(DiagnosticNumber::NO_MODEL, message));
        }
        model::nothing(function)
    }
}

impl CompileEnvironment for Standalone {
    fn system(&self) -> &[SystemVariable] {
        self.system.rows()
    }
    fn code(&self, name: &str) -> Option<u32> {
        self.identifiers.find(name)
    }
    fn register(&self, name: &str) -> Option<u32> {
        self.identifiers.find(name)
    }
    fn identifiers(&self) -> Vec<String> {
        self.identifiers.all()
    }
    fn foreign(&self, name: &str) -> Option<&'static str> {
        self.system.foreign.and_then(|product| product(name))
    }
    fn include(&mut self, name: &str, from: &str) -> Option<MacroSource> {
        let from = from.replace('\\', "/");
        let beside = from.rfind('/').and_then(|at| from.get(..=at)).map(|folder| format!("{folder}{name}"));
        let beside = beside.and_then(|path| self.load(&path).ok().map(|text| (path, text)));
        let found = beside.or_else(|| self.load(name).ok().map(|text| (name.to_owned(), text)));
        found.map(|(path, text)| MacroSource::new(path, text))
    }
}

impl MacroHost for Standalone {
    fn function(&mut self, state: &mut MacroState, function: HostFn, arguments: &[MacroValue]) -> Outcome<MacroValue> {
        Ok(match function {
            HostFn::EndOfProgram => MacroValue::Logical(self.program.is_at_end()),
            HostFn::MachineFrame => MacroValue::numbers(&[1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]),
            HostFn::Dialog => self.dialog(arguments)?,
            HostFn::File(of) => {
                let program = self.system.text("$TAPEN");
                self.with_files(|folder, shelf| folder.function(shelf, state, (of, arguments), &program))?
            }
            HostFn::Absent(AbsentFn::Pause | AbsentFn::Apply) => MacroValue::Logical(false),
            HostFn::Absent(AbsentFn::Document) => model::out_of_scope(state, function),
            HostFn::DiagnosticSeverity => self.tables.severity(arguments)?,
            HostFn::DiagnosticState => self.tables.switched(arguments),
            HostFn::DiagnosticText => self.tables.text_of(arguments),
            HostFn::MacroNames => self.tables.macros(state, arguments)?,
            HostFn::MacroStates => self.tables.macro_states(arguments),
            HostFn::RegisterFormat => registers::format(arguments),
            HostFn::RegisterPosition => registers::position(arguments),
            HostFn::AddItem => self.program.block.add(state, arguments)?,
            HostFn::TakeItem => self.program.block.seek(arguments, true)?,
            HostFn::SeekItem => self.program.block.seek(arguments, false)?,
            HostFn::ActiveCode => self.program.block.active(arguments, false),
            HostFn::SetActiveCode => self.program.block.active(arguments, true),
            HostFn::DataAsCode | HostFn::Restart => MacroValue::Logical(true),
            HostFn::NcVariable => self.program.variable(arguments),
            HostFn::SetNcVariable => self.program.set_variable(arguments),
            HostFn::PreProcessorSetting => program::setting(state, arguments),
            HostFn::SearchForward => self.program.search(&mut self.system, state, arguments, true)?,
            HostFn::SearchBackward => self.program.search(&mut self.system, state, arguments, false)?,
            HostFn::ForwardKinematics => model::kinematics(&self.system, arguments, false)?,
            HostFn::InverseKinematics => model::kinematics(&self.system, arguments, true)?,
            HostFn::ConfigureKinematics | HostFn::SelectRotaryAxes | HostFn::Unwind => MacroValue::Real(1.0),
            _ => self.without_model(state, function),
        })
    }

    fn now(&self) -> (f64, i32, String) {
        self.outside.as_ref().map_or((0.0, 0, "UTC".to_owned()), |outside| outside.now())
    }

    fn setting(&self, definition: bool, name: &str) -> Option<String> {
        let variable = || self.system.value(name).and_then(MacroValue::as_text).map(str::to_owned);
        let own = || self.settings.get(name).cloned().or_else(variable);
        match &self.outside {
            Some(outside) if !definition => own().or_else(|| outside.environment(name)),
            _ => own(),
        }
    }
}
