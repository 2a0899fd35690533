//! DEF and REDEF, executed.
//!
//! Facts: reference control-emulator.md 5.4 and 8.5. Decisions: the first definition of the job gives a variable of all
//! channels its value; a definition of the channel that comes again leaves the value; a definition of a program that
//! comes again in the same block begins anew. Invariant: sizes are bounded before anything is made.

use counterpoint_lang::value::MacroValue;

use super::compiled::IndexedName;
use super::declaration::{DeclaredVariable, Initial, VariableDeclaration, VariableScope};
use super::define::LONGEST_TEXT;
use super::value::Type;
use super::variable_store::{MOST_IN_ALL, SiemensVariable, VariableElement, VariableStorage};
use super::variables::declared_key;
use super::{Outcome, Siemens, SiemensBlockError};
use counterpoint_control_api::host::InterpreterHost;
use counterpoint_fault as diag;

/// Most elements of a variable.
const MOST_ELEMENTS: usize = 100_000;
/// Most elements of a variable that all channels share.
const MOST_SHARED: usize = 10_000;

fn refused<T>(text: String) -> Outcome<T> {
    Err(SiemensBlockError::Alarm(&diag::SIEMENS_DEFINITION, text))
}

impl Siemens {
    /// Refuses DEF after a block of its program that defines nothing.
    pub(super) fn check_first(&mut self, host: &dyn InterpreterHost) -> Outcome<()> {
        let place = host.place();
        if !place.as_read || host.shares_programs() {
            return Ok(());
        }
        match self.places(host, place.file).first_block(place.range, place.line) {
            Some(first) if first < place.line => {
                refused(format!("DEF comes after the block of line {first}; definitions come first (alarm 14500)"))
            }
            _ => Ok(()),
        }
    }

    /// DEF, REDEF: with `again` variables that exist get another value, or type.
    pub(super) fn declare(
        &mut self,
        host: &mut dyn InterpreterHost,
        declaration: &VariableDeclaration,
        again: bool,
    ) -> Outcome<()> {
        let Some(kind) = declaration.kind else {
            if !again {
                return super::syntax("DEF needs a type");
            }
            return declaration.variables.iter().try_for_each(|variable| self.redeclare(host, variable));
        };
        let kind = match (kind, &declaration.length) {
            (Type::Text(_), Some(length)) => match self.whole_number(host, length)? {
                length if (1..=i64::from(LONGEST_TEXT)).contains(&length) => Type::Text(length as u16),
                length => return refused(format!("a text length of {length} is not valid")),
            },
            (Type::Text(_), None) => Type::Text(LONGEST_TEXT),
            (kind, _) => kind,
        };
        let scope = match declaration.scope {
            Some(scope) => scope,
            None if self.settings.global => VariableScope::Channel,
            None => VariableScope::Local,
        };
        declaration.variables.iter().try_for_each(|variable| self.declare_one(host, scope, kind, variable, again))
    }

    fn redeclare(&mut self, host: &mut dyn InterpreterHost, variable: &DeclaredVariable) -> Outcome<()> {
        let name = IndexedName { name: variable.name.clone(), index: Vec::new() };
        let Some(target) = self.locate(host, &name)? else {
            return refused(format!("variable {} of REDEF does not exist", variable.name));
        };
        self.begin_with(host, &target, variable.initial.as_ref())
    }

    fn begin_with(
        &mut self,
        host: &mut dyn InterpreterHost,
        target: &VariableElement,
        initial: Option<&Initial>,
    ) -> Outcome<()> {
        match initial {
            None => Ok(()),
            Some(Initial::One(value)) => {
                let value = self.evaluate(host, value)?;
                (0..target.count).try_for_each(|at| {
                    let element = VariableElement { at, whole: false, ..target.clone() };
                    self.store(host, &element, value.clone())
                })
            }
            Some(Initial::List(values)) => self.store_list(host, target, values),
            Some(Initial::Fill(values)) => self.store_fill(host, target, values),
        }
    }

    fn declare_one(
        &mut self,
        host: &mut dyn InterpreterHost,
        scope: VariableScope,
        kind: Type,
        declared: &DeclaredVariable,
        again: bool,
    ) -> Outcome<()> {
        let name = &declared.name;
        if super::functions::is_function(name) || name.starts_with('$') || super::expression::parameter(name).is_some()
        {
            return refused(format!("{name} is reserved by the control"));
        }
        if declared.sizes.len() > 3 {
            return refused(format!("{name} has {} dimensions (maximum 3)", declared.sizes.len()));
        }
        let mut sizes = Vec::new();
        for size in &declared.sizes {
            match self.whole_number(host, size)? {
                size if size >= 1 && size <= MOST_ELEMENTS as i64 => sizes.push(size as usize),
                size => return refused(format!("{name} cannot have {size} elements in a dimension")),
            }
        }
        let count = sizes.iter().product::<usize>().max(1);
        let most = if scope == VariableScope::Nck { MOST_SHARED } else { MOST_ELEMENTS };
        if count > most {
            return refused(format!("{name} has {count} elements (maximum {most})"));
        }
        if scope == VariableScope::Nck {
            return self.declare_shared(host, kind, sizes, declared, again);
        }
        host.work(count)?;
        let place = host.place();
        let variable =
            SiemensVariable { kind, sizes, values: vec![kind.initial(); count], born: (place.file, place.line) };
        let variables = &mut self.variables;
        let running = variables.calls.program_depth();
        let old = match scope {
            VariableScope::Channel => variables.channel.get(name),
            _ => variables.calls.at(running).and_then(|level| level.variables.get(name)),
        };
        if let Some(old) = old.filter(|_| !again) {
            if scope == VariableScope::Channel && (old.kind, &old.sizes) == (kind, &variable.sizes) {
                // The definitions of the channel are read with each program, their values stay.
                return Ok(());
            }
            if old.born != variable.born || scope == VariableScope::Channel {
                return refused(format!("{name} is defined twice (alarm 12170)"));
            }
        }
        if variables.elements + count > MOST_IN_ALL {
            return refused("there is no room for more variables".to_owned());
        }
        let holder = if scope == VariableScope::Channel {
            variables.keep_in_channel(name, variable);
            VariableStorage::Channel
        } else {
            variables.keep(name, variable);
            VariableStorage::Level(running)
        };
        let target =
            VariableElement { holder, name: name.clone().into(), kind, at: 0, count, whole: false, part: None };
        self.begin_with(host, &target, declared.initial.as_ref())
    }

    /// The first definition of the job gives the variable its value.
    fn declare_shared(
        &mut self,
        host: &mut dyn InterpreterHost,
        kind: Type,
        sizes: Vec<usize>,
        declared: &DeclaredVariable,
        again: bool,
    ) -> Outcome<()> {
        let name = &declared.name;
        let known = self.shared_variable(host, name)?;
        if let Some((known, known_sizes)) = known.filter(|_| !again) {
            if (known, &known_sizes) == (kind, &sizes) {
                return Ok(());
            }
            return refused(format!("another channel defines {name} differently"));
        }
        let count = sizes.iter().product::<usize>().max(1);
        let length = if let Type::Text(length) = kind { length } else { 0 };
        let mut text = format!("{} {length}", kind.name());
        for size in &sizes {
            text.push_str(&format!(" {size}"));
        }
        host.set_shared(&declared_key(name), Some(MacroValue::text(text)))?;
        self.variables.shared.insert(name.clone(), (kind, sizes));
        let target = VariableElement {
            holder: VariableStorage::Shared,
            name: name.clone().into(),
            kind,
            at: 0,
            count,
            whole: false,
            part: None,
        };
        self.begin_with(host, &target, declared.initial.as_ref())
    }
}
