//! Calls: their arguments and results.
//!
//! Facts: reference control-emulator.md 5.4, 5.7. Arguments are evaluated by the caller; PROC takes them, by value or,
//! with VAR, so that the caller's variable has the parameter's value after the return. Invariant: every subprogram that
//! begins has a level of its own, which goes when it returns.

use std::sync::Arc;

use super::block_text::bare;
use super::compiled::{SiemensArgument, as_name};
use super::declaration::{Parameter, ProcHeader};
use super::item::SiemensItem;
use super::line::read;
use super::variable_store::{PassedArgument, PassedValue, SiemensCallLevel, SiemensVariable, VariableElement};
use super::{Outcome, Siemens, SiemensBlockError, syntax};
use counterpoint_control_api::host::{InterpreterHost, SubprogramCall};
use counterpoint_event::FileId;
use counterpoint_fault as diag;
use counterpoint_program::shape::ProgramRange;

/// A call that is about to begin.
#[derive(Debug)]
pub(super) struct Calling {
    /// Block that calls.
    pub(super) line: u32,
    /// A part of the program, which has no variables of its own.
    pub(super) part: bool,
    /// It is a part of the program that has called this many of those that run.
    pub(super) outer: usize,
    pub(super) given: Arc<Vec<PassedArgument>>,
}

pub(super) fn mismatch<T>(text: String) -> Outcome<T> {
    Err(SiemensBlockError::Alarm(&diag::SIEMENS_ARGUMENTS, text))
}

impl Siemens {
    /// Prepares a call; it is made at the end of the block.
    pub(super) fn prepare_call(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &str,
        place: Option<(FileId, ProgramRange)>,
        arguments: &[SiemensArgument],
    ) -> Outcome<SubprogramCall> {
        if self.variables.writes {
            self.check_unchanged(host, name, place)?;
        }
        if let (false, Some((file, range))) = (arguments.is_empty(), place) {
            let count = self.header_of(host, file, range).map_or(0, |header| header.parameters.len());
            if arguments.len() > count {
                return mismatch(format!("{name} takes {count} arguments, not {} (alarm 12340)", arguments.len()));
            }
        }
        let mut given = Vec::new();
        for argument in arguments {
            given.push(self.given(host, argument)?);
        }
        self.calling = Some(Calling { line: host.place().line, part: false, outer: 0, given: Arc::new(given) });
        Ok(SubprogramCall { name: name.into(), place, passes: 1, closes: true })
    }

    /// Prepares a part of the running program.
    pub(super) fn prepare_part(
        &mut self,
        host: &dyn InterpreterHost,
        name: String,
        range: (u32, u32),
        passes: u32,
    ) -> SubprogramCall {
        let place = host.place();
        self.calling = Some(Calling { line: place.line, part: true, outer: 0, given: Arc::default() });
        let range = ProgramRange { number: None, first: range.0, last: range.1 };
        SubprogramCall { name: name.into(), place: Some((place.file, range)), passes, closes: true }
    }

    fn given(&mut self, host: &mut dyn InterpreterHost, argument: &SiemensArgument) -> Outcome<PassedArgument> {
        let expression = match &argument.value {
            Ok(None) => return Ok(PassedArgument { value: PassedValue::Missing, from: None }),
            Ok(Some(expression)) => expression,
            Err(text) => return syntax(text.clone()),
        };
        if let Some(name) = as_name(expression)
            && (name.name == "R" || self.variables.knows(&name.name))
            && let Some(target) = self.locate(host, name)?
        {
            if target.is_array() {
                let Some(variable) = self.variables.whole(&name.name).cloned() else {
                    return mismatch(format!("the array {} of all channels cannot be an argument", name.name));
                };
                return Ok(PassedArgument { value: PassedValue::Whole(Box::new(variable)), from: Some(target) });
            }
            let value = self.value_of(host, &target)?;
            return Ok(PassedArgument { value: PassedValue::One(value), from: Some(target) });
        }
        let value = self.evaluate(host, expression)?;
        Ok(PassedArgument { value: PassedValue::One(value), from: None })
    }

    /// PROC of a subprogram: its first block.
    pub(super) fn header_of(
        &mut self,
        host: &dyn InterpreterHost,
        file: FileId,
        range: ProgramRange,
    ) -> Option<ProcHeader> {
        let source = host.source(file)?;
        for line in source.walk(range.first, range.last.min(source.lines())) {
            let text = String::from_utf8_lossy(source.line(line));
            let text = bare(&text).trim();
            if text.is_empty() || super::jumps::is_head(text) {
                continue;
            }
            return match read(text).ok()?.items.into_iter().next()? {
                SiemensItem::Header(header) => Some(header),
                _ => None,
            };
        }
        None
    }

    /// A subprogram begins.
    pub(super) fn enter(&mut self, host: &mut dyn InterpreterHost) {
        let line = host.place().line;
        let calls = &mut self.variables.calls;
        match self.calling.take().filter(|calling| calling.line == line) {
            Some(calling) if calling.part => {
                let aside = (calling.outer > 0).then(|| calls.set_aside(calling.outer));
                calls.enter_part(SiemensCallLevel { aside, ..SiemensCallLevel::default() });
            }
            Some(calling) => calls
                .enter(SiemensCallLevel { given: Arc::unwrap_or_clone(calling.given), ..SiemensCallLevel::default() }),
            None => calls.enter(SiemensCallLevel::default()),
        }
    }

    /// PROC: parameters become variables.
    pub(super) fn take_arguments(&mut self, host: &mut dyn InterpreterHost, header: &ProcHeader) -> Outcome<()> {
        let level = self.variables.calls.program_mut();
        if std::mem::replace(&mut level.taken, true) {
            return Ok(());
        }
        let given = std::mem::take(&mut level.given);
        if given.len() > header.parameters.len() {
            let count = header.parameters.len();
            return mismatch(format!("{} takes {count} arguments, not {}", header.name, given.len()));
        }
        let mut back = Vec::new();
        for (at, parameter) in header.parameters.iter().enumerate() {
            let variable = self.parameter(host, parameter, given.get(at))?;
            if parameter.by_reference && given.get(at).is_some_and(|given| given.from.is_some()) {
                back.push((parameter.name.clone(), at));
            }
            self.variables.keep(&parameter.name, variable);
        }
        let modes = header.save.then(|| host.modes());
        let level = self.variables.calls.program_mut();
        (level.given, level.back) = (given, back);
        if level.modes.is_none() {
            level.modes = modes;
        }
        Ok(())
    }

    fn parameter(
        &mut self,
        host: &mut dyn InterpreterHost,
        parameter: &Parameter,
        given: Option<&PassedArgument>,
    ) -> Outcome<SiemensVariable> {
        let name = &parameter.name;
        let value = match given.map(|given| &given.value) {
            Some(PassedValue::Whole(variable)) if parameter.array && variable.kind == parameter.kind => {
                return Ok((**variable).clone());
            }
            Some(PassedValue::Whole(_)) => return mismatch(format!("an array does not fit the parameter {name}")),
            Some(PassedValue::One(_)) if parameter.array => {
                return mismatch(format!("the parameter {name} is an array"));
            }
            Some(PassedValue::One(value)) => value.clone(),
            Some(PassedValue::Missing) | None if parameter.by_reference => {
                return mismatch(format!(
                    "the parameter {name} needs a variable of the caller, but the argument is missing"
                ));
            }
            Some(PassedValue::Missing) | None => match &parameter.default {
                Some(default) => self.evaluate(host, default)?,
                None => parameter.kind.initial(),
            },
        };
        if parameter.by_reference && given.is_some_and(|given| given.from.is_none()) {
            return mismatch(format!("the parameter {name} needs a variable of the caller"));
        }
        match parameter.kind.hold(value) {
            Ok(value) => Ok(SiemensVariable::one(parameter.kind, value)),
            Err(text) => mismatch(format!("{text}, for the parameter {name}")),
        }
    }

    /// A subprogram has returned: the caller stores the values that it passes back.
    pub(super) fn leave(&mut self, host: &mut dyn InterpreterHost) -> Outcome<()> {
        let Some(level) = self.variables.leave() else { return Ok(()) };
        if let Some(modes) = &level.modes {
            host.restore_modes(modes);
        }
        if self.modal_from.is_some_and(|level| host.level() <= level) {
            self.modal_from = None;
        }
        for (name, given) in &level.back {
            let variable = level.variables.get(name);
            let target = level.given.get(*given).and_then(|given| given.from.as_ref());
            if let (Some(variable), Some(target)) = (variable, target) {
                self.store_back(host, target, variable)?;
            }
        }
        Ok(())
    }

    fn store_back(
        &mut self,
        host: &mut dyn InterpreterHost,
        target: &VariableElement,
        variable: &SiemensVariable,
    ) -> Outcome<()> {
        for (step, value) in variable.values.iter().enumerate() {
            self.store(host, &target.element(step), value.clone())?;
        }
        Ok(())
    }

    /// `L…`, a name, a name with arguments: the subprogram, if there is one.
    pub(super) fn known_program(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &str,
    ) -> Outcome<Option<Option<(FileId, ProgramRange)>>> {
        if !self.settings.subprograms {
            return Ok(None);
        }
        let found = self.program(host, name)?;
        let declared = self.held.externals.contains(name);
        Ok(if found.is_some() || declared { Some(found) } else { None })
    }

    /// The lines between two labels, both of a subprogram or of the running program.
    pub(super) fn section(
        &mut self,
        host: &mut dyn InterpreterHost,
        place: (FileId, ProgramRange),
        labels: &(String, String),
    ) -> Outcome<(FileId, ProgramRange)> {
        let (file, range) = place;
        let at = counterpoint_control_api::host::ProgramPlace {
            file,
            range,
            line: range.first.saturating_sub(1),
            ..host.place()
        };
        let label = |name: &String| super::item::SiemensJumpTarget::Name(name.clone());
        let first = self.label_line(host, &label(&labels.0), &at)?;
        let last = self.label_line(host, &label(&labels.1), &at)?;
        if last < first {
            return syntax(format!("label {} comes before label {}", labels.1, labels.0));
        }
        Ok((file, ProgramRange { number: None, first, last }))
    }
}
