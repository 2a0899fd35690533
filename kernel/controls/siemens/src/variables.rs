//! Access to variables: those of a program, of the channel, of all channels, and R parameters.
//!
//! Facts: reference control-emulator.md 5.4 and 8.5. A name is searched for in the running program, in the main
//! program, in the channel, and in the data that all channels share. Invariants: data that all channels share go
//! through the host; an index is checked before anything is read or written.

use counterpoint_control_api::host::InterpreterHost;
use counterpoint_fault as diag;
use counterpoint_lang::value::MacroValue;

use super::compiled::{Expression, IndexedName, SiemensArgument, as_name};
use super::frame_component::FrameComponent;
use super::item::AssignmentValue;
use super::value::{Data, Type};
use super::variable_store::{MOST_PARAMETERS, VariableElement, VariableStorage};
use super::{Outcome, Siemens, SiemensBlockError, wrong_type};

/// Key of the data that all channels share about a variable itself.
pub(super) fn declared_key(name: &str) -> String {
    format!("{name} DEF")
}

fn element_key(name: &str, at: usize, count: usize) -> String {
    if count == 1 { name.to_owned() } else { format!("{name}[{at}]") }
}

/// Position of an element by its indices.
fn position(name: &str, sizes: &[usize], index: &[i64]) -> Result<usize, String> {
    if index.len() != sizes.len() {
        return Err(format!("{name} has {} indices, not {}", sizes.len(), index.len()));
    }
    let mut at = 0_usize;
    for (&index, &size) in index.iter().zip(sizes) {
        match usize::try_from(index) {
            Ok(inside) if inside < size => at = at * size + inside,
            _ => {
                return Err(format!(
                    "the index {index} of {name} is not between 0 and {} (alarm 17020)",
                    size.saturating_sub(1)
                ));
            }
        }
    }
    Ok(at)
}

fn missing<T>(text: String) -> Outcome<T> {
    Err(SiemensBlockError::Alarm(&diag::MACRO_VARIABLE, text))
}

impl Siemens {
    /// Number of an R parameter; none if it is another name.
    pub(super) fn r_parameter(&mut self, host: &mut dyn InterpreterHost, name: &IndexedName) -> Outcome<Option<u32>> {
        let ("R", [index]) = (name.name.as_str(), name.index.as_slice()) else { return Ok(None) };
        let number = match index.as_constant() {
            Some(Data::Int(number)) => *number,
            _ => self.whole_number(host, index)?,
        };
        match u32::try_from(number) {
            Ok(found) if number <= MOST_PARAMETERS => Ok(Some(found)),
            _ => missing(format!("parameter R{number} does not exist (alarm 12290)")),
        }
    }

    /// Sets an R parameter by its number as written; false for anything else.
    pub(super) fn set_r(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &IndexedName,
        value: &AssignmentValue,
    ) -> Outcome<bool> {
        let (Some(number), AssignmentValue::One(value, _)) = (name.parameter(), value) else { return Ok(false) };
        let value = self.evaluate(host, value)?;
        let Some(value) = value.number() else {
            return wrong_type(format!("{} cannot be a value of {}, for R", value.described(), Type::Real.name()));
        };
        host.effect();
        self.variables.set_parameter(number as usize, value);
        Ok(true)
    }

    /// Where a variable is; none if there is none of this name.
    pub(super) fn locate(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &IndexedName,
    ) -> Outcome<Option<VariableElement>> {
        if name.name == "R" {
            let Some(number) = self.r_parameter(host, name)? else { return Ok(None) };
            let (holder, kind, at) = (VariableStorage::Parameter, Type::Real, number as usize);
            return Ok(Some(VariableElement {
                holder,
                name: "R".into(),
                kind,
                at,
                count: at + 1,
                whole: false,
                part: None,
            }));
        }
        let (holder, kind, sizes) = match self.variables.find(&name.name) {
            Some((holder, variable)) => (holder, variable.kind, variable.sizes.clone()),
            None => match self.shared_variable(host, &name.name)? {
                Some((kind, sizes)) => (VariableStorage::Shared, kind, sizes),
                None => return Ok(None),
            },
        };
        let count = sizes.iter().product::<usize>().max(1);
        let (plain, part) = match kind {
            Type::Frame if name.index.len() == sizes.len() + 2 => {
                let (plain, part) = name.index.split_at(sizes.len());
                (plain, Some(self.frame_part(host, part)?))
            }
            _ => (name.index.as_slice(), None),
        };
        let whole = plain.is_empty() && !sizes.is_empty();
        let at = if whole {
            0
        } else {
            let index = plain.iter().map(|index| self.whole_number(host, index)).collect::<Outcome<Vec<_>>>()?;
            position(&name.name, &sizes, &index).or_else(missing)?
        };
        Ok(Some(VariableElement { holder, name: name.name.clone().into(), kind, at, count, whole, part }))
    }

    /// Type and sizes of a variable that all channels share.
    pub(super) fn shared_variable(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &str,
    ) -> Outcome<Option<(Type, Vec<usize>)>> {
        if let Some(known) = self.variables.shared.get(name) {
            return Ok(Some(known.clone()));
        }
        let Some(MacroValue::Text(text)) = host.shared(&declared_key(name))? else { return Ok(None) };
        let mut fields = text.split(' ');
        let kind = fields.next().and_then(Type::named);
        let length = fields.next().and_then(|field| field.parse().ok()).unwrap_or(0);
        let sizes = fields.filter_map(|field| field.parse().ok()).collect::<Vec<usize>>();
        let Some(kind) = kind.map(|kind| if kind == Type::Text(0) { Type::Text(length) } else { kind }) else {
            return Ok(None);
        };
        self.variables.shared.insert(name.to_owned(), (kind, sizes.clone()));
        Ok(Some((kind, sizes)))
    }

    /// Value of an element.
    pub(super) fn value_of(&mut self, host: &mut dyn InterpreterHost, target: &VariableElement) -> Outcome<Data> {
        if target.whole {
            return missing(format!("{} is an array; program its indices", target.name));
        }
        let value = match target.holder {
            VariableStorage::Parameter => Data::Real(self.variables.parameter(target.at as u32)),
            VariableStorage::Shared => {
                let found = host.shared(&element_key(&target.name, target.at, target.count))?;
                found.and_then(|value| target.kind.taken_from(&value)).unwrap_or_else(|| target.kind.initial())
            }
            holder => match self.variables.held(holder, &target.name).and_then(|held| held.values.get(target.at)) {
                Some(value) => value.clone(),
                None => return missing(format!("variable {} does not exist", target.name)),
            },
        };
        match (target.part, &value) {
            (Some((axis, part)), Data::Frame(frame)) => Ok(Data::Real(super::frames::part_of(frame, axis, part)?)),
            _ => Ok(value),
        }
    }

    /// Sets an element.
    pub(super) fn store(
        &mut self,
        host: &mut dyn InterpreterHost,
        target: &VariableElement,
        value: Data,
    ) -> Outcome<()> {
        let value = match target.part {
            None => value,
            Some((axis, part)) => {
                let whole = VariableElement { part: None, ..target.clone() };
                let Data::Frame(frame) = self.value_of(host, &whole)? else {
                    return wrong_type("the variable is not a frame");
                };
                Data::Frame(Box::new(super::frames::with_part(&frame, axis, part, &value)?))
            }
        };
        let value = match target.kind.hold(value) {
            Ok(value) => value,
            Err(text) => return wrong_type(format!("{text}, for {}", target.name)),
        };
        host.effect();
        match target.holder {
            VariableStorage::Parameter => {
                self.variables.set_parameter(target.at, value.number().unwrap_or(0.0));
            }
            VariableStorage::Shared => {
                host.set_shared(&element_key(&target.name, target.at, target.count), Some(value.value()))?;
            }
            holder => self.variables.put(holder, &target.name, target.at, value),
        }
        Ok(())
    }

    /// Assigns the value after `=`.
    pub(super) fn assign(
        &mut self,
        host: &mut dyn InterpreterHost,
        target: &VariableElement,
        value: &AssignmentValue,
    ) -> Outcome<()> {
        match value {
            AssignmentValue::One(..) if target.whole => {
                missing(format!("{} is an array; program its indices", target.name))
            }
            AssignmentValue::One(value, _) => {
                let value = self.evaluate(host, value)?;
                self.store(host, target, value)
            }
            AssignmentValue::List(values) => self.store_list(host, target, values),
            AssignmentValue::Fill(values) => self.store_fill(host, target, values),
            AssignmentValue::Positioned(_, _, way) => {
                wrong_type(format!("{way} is for addresses only; {} is a variable", target.name))
            }
        }
    }

    pub(super) fn store_list(
        &mut self,
        host: &mut dyn InterpreterHost,
        target: &VariableElement,
        values: &[SiemensArgument],
    ) -> Outcome<()> {
        for (step, argument) in values.iter().enumerate() {
            let element = VariableElement { at: target.at + step, whole: false, ..target.clone() };
            if element.at >= target.count && target.holder != VariableStorage::Parameter {
                return missing(format!("{} has {} elements, the list has more values", target.name, target.count));
            }
            if let Some(value) = self.argument(host, argument)? {
                self.store(host, &element, value)?;
            }
        }
        Ok(())
    }

    pub(super) fn store_fill(
        &mut self,
        host: &mut dyn InterpreterHost,
        target: &VariableElement,
        values: &[SiemensArgument],
    ) -> Outcome<()> {
        let mut values = values.iter();
        let value = match values.next() {
            Some(argument) => self.argument(host, argument)?,
            None => None,
        };
        let Some(value) = value else { return super::syntax("REP needs a value") };
        let rest = target.count.saturating_sub(target.at);
        let count = match values.next() {
            Some(argument) => match self.argument(host, argument)?.and_then(|count| count.number()) {
                Some(count) if count >= 0.0 => (count as usize).min(rest),
                _ => return wrong_type("the number of values of REP is not valid"),
            },
            None => rest,
        };
        let mut element = VariableElement { whole: false, ..target.clone() };
        for _ in 0..count {
            host.work(1)?;
            self.store(host, &element, value.clone())?;
            element.at += 1;
        }
        Ok(())
    }

    /// Axis and part of a frame in an index.
    pub(super) fn frame_part(
        &mut self,
        host: &mut dyn InterpreterHost,
        index: &[Expression],
    ) -> Outcome<(usize, FrameComponent)> {
        let [axis, part] = index else { return super::syntax("a frame has an axis and a part in its index") };
        let part = match as_name(part) {
            Some(name) if name.index.is_empty() => FrameComponent::named(&name.name),
            _ => None,
        };
        let Some(part) = part else { return super::syntax("a part of a frame is TR, FI, RT, SC or MI") };
        let axis = self.evaluate(host, axis)?;
        Ok((super::frames::place(host, &axis, part)?, part))
    }

    /// A variable's value for macros; a frame gives its twelve numbers.
    pub(super) fn read_for_macro(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &IndexedName,
    ) -> Outcome<Option<Data>> {
        if name.name.starts_with('$') {
            return self.system(host, name);
        }
        match self.locate(host, name)? {
            Some(target) => self.value_of(host, &target).map(Some),
            None => Ok(None),
        }
    }

    pub(super) fn set_for_macro(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &IndexedName,
        value: &MacroValue,
    ) -> Outcome<bool> {
        let Some(target) = self.locate(host, name)?.filter(|target| !target.whole) else { return Ok(false) };
        let kind = if target.part.is_some() { Type::Real } else { target.kind };
        let Some(value) = kind.taken_from(value) else { return Ok(false) };
        self.store(host, &target, value)?;
        Ok(true)
    }
}

impl VariableElement {
    /// A whole array.
    pub(super) fn is_array(&self) -> bool {
        self.whole
    }

    /// An element this many after this one.
    pub(super) fn element(&self, behind: usize) -> Self {
        Self { at: self.at + behind, whole: false, ..self.clone() }
    }
}
