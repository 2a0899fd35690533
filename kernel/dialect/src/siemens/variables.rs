//! Variables: those of a program, of the channel, of all channels, and R parameters.
//!
//! Facts: reference control-emulator.md 5.4 and 8.5. A name is searched for in the running program, in the main
//! program, in the channel, and in the data that all channels share. Invariants: data that all channels share go
//! through the host; the number of elements is bounded; an index is checked before anything is read or written.

use counterpoint_motion::contour::area::Area;
use std::borrow::Cow;

use counterpoint_lang::value::Value;
use rustc_hash::FxHashMap;

use super::expression::{Argument, Expression, Name, as_name};
use super::frame::{Frame, Part};
use super::line::Assigned;
use super::value::{Data, Type};
use super::{Fault, Outcome, Siemens, wrong_type};
use crate::call_stack::CallStack;
use crate::host::Host;
use counterpoint_event::FileId;
use counterpoint_fault as diag;

/// Most elements of all variables of a kernel.
pub(super) const MOST_IN_ALL: usize = 1_000_000;
/// Largest number of an R parameter.
pub(super) const MOST_PARAMETERS: i64 = 32_535;

/// A variable.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Variable {
    pub(super) kind: Type,
    pub(super) sizes: Vec<usize>,
    pub(super) values: Vec<Data>,
    /// Where it was defined: the same block may define it again.
    pub(super) born: (FileId, u32),
}

/// Variables of a running program.
#[derive(Debug, Default)]
pub(super) struct Level {
    pub(super) variables: FxHashMap<String, Variable>,
    /// The arguments of the call, until PROC takes them.
    pub(super) given: Vec<super::calls::PassedArgument>,
    /// PROC has taken it.
    pub(super) taken: bool,
    /// Parameters whose values go back: the name, and which of the given ones.
    pub(super) back: Vec<(String, usize)>,
    /// Modal codes that come back at the end.
    pub(super) modes: Option<crate::host::Modes>,
    /// Cycles that run meanwhile a part of their caller does: they do not hide its variables.
    pub(super) aside: Option<crate::call_stack::Aside<Level>>,
}

/// All variables of a kernel.
#[derive(Debug, Default)]
pub(super) struct Variables {
    pub(super) calls: CallStack<Level>,
    pub(super) channel: FxHashMap<String, Variable>,
    /// Types and sizes of variables that all channels share.
    pub(super) shared: FxHashMap<String, (Type, Vec<usize>)>,
    /// R parameters by number, up to the highest one that was written.
    parameters: Vec<f64>,
    /// Contours that were named for the next cycle.
    pub(super) contours: Vec<String>,
    /// Rim and islands of the pocket that a cycle works on.
    pub(super) area: Area,
    /// The channel has written or removed files.
    pub(super) writes: bool,
    pub(super) elements: usize,
    /// Bytes of their names, texts and frames.
    texts: usize,
}

/// Where a variable is kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Holder {
    Level(usize),
    Channel,
    Shared,
    Parameter,
}

/// An element of a variable.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Target {
    pub(super) holder: Holder,
    pub(super) name: Cow<'static, str>,
    pub(super) kind: Type,
    pub(super) at: usize,
    /// Elements of the whole variable.
    pub(super) count: usize,
    /// No index was given for an array.
    pub(super) whole: bool,
    /// Part of a frame, along X, Y or Z.
    pub(super) part: Option<(usize, Part)>,
}

impl Variables {
    /// Bytes that they take, about.
    pub(super) fn bytes(&self) -> usize {
        self.elements * 48 + self.parameters.len() * size_of::<f64>() + self.texts + self.shared.len() * 100
    }

    fn find(&self, name: &str) -> Option<(Holder, &Variable)> {
        let running = self.calls.program_depth();
        let of = |at: usize| self.calls.at(at)?.variables.get(name).map(|found| (Holder::Level(at), found));
        of(running).or_else(|| of(0)).or_else(|| self.channel.get(name).map(|found| (Holder::Channel, found)))
    }

    /// Whether a variable of this name exists in the channel.
    pub(super) fn knows(&self, name: &str) -> bool {
        self.find(name).is_some() || self.shared.contains_key(name)
    }

    /// Value of a variable of one value, without index.
    pub(super) fn scalar(&self, name: &Name) -> Option<&Data> {
        if !name.index.is_empty() {
            return None;
        }
        let (_, variable) = self.find(&name.name)?;
        variable.values.first().filter(|_| variable.sizes.is_empty())
    }

    /// Value of an R parameter.
    pub(super) fn parameter(&self, number: u32) -> f64 {
        self.parameters.get(number as usize).copied().unwrap_or(0.0)
    }

    /// Writes an R parameter, whose number is not too large.
    fn set_parameter(&mut self, number: usize, value: f64) {
        if self.parameters.len() <= number {
            self.parameters.resize(number + 1, 0.0);
        }
        if let Some(slot) = self.parameters.get_mut(number) {
            *slot = value;
        }
    }

    fn held(&mut self, holder: Holder, name: &str) -> Option<&mut Variable> {
        match holder {
            Holder::Level(at) => self.calls.at_mut(at)?.variables.get_mut(name),
            Holder::Channel => self.channel.get_mut(name),
            Holder::Shared | Holder::Parameter => None,
        }
    }

    /// A whole variable, for a parameter that is one.
    pub(super) fn whole(&self, name: &str) -> Option<&Variable> {
        self.find(name).map(|(_, variable)| variable)
    }

    /// Keeps a variable of the running program; false if there is no room.
    pub(super) fn keep(&mut self, name: &str, variable: Variable) -> bool {
        if self.elements + variable.values.len() > MOST_IN_ALL {
            return false;
        }
        self.elements += variable.values.len();
        self.texts += variable.bytes();
        if let Some(old) = self.calls.program_mut().variables.insert(name.to_owned(), variable) {
            self.elements = self.elements.saturating_sub(old.values.len());
            self.texts = self.texts.saturating_sub(old.bytes());
        }
        true
    }

    /// Keeps a variable of the channel, for which there is room.
    pub(super) fn keep_in_channel(&mut self, name: &str, variable: Variable) {
        self.elements += variable.values.len();
        self.texts += variable.bytes();
        if let Some(old) = self.channel.insert(name.to_owned(), variable) {
            self.elements = self.elements.saturating_sub(old.values.len());
            self.texts = self.texts.saturating_sub(old.bytes());
        }
    }

    /// A subprogram has returned; the main program stays.
    pub(super) fn leave(&mut self) -> Option<Level> {
        let mut level = self.calls.leave()?;
        if let Some(aside) = level.aside.take() {
            self.calls.bring_back(aside);
        }
        let count: usize = level.variables.values().map(|variable| variable.values.len()).sum();
        self.elements = self.elements.saturating_sub(count);
        self.texts = self.texts.saturating_sub(level.variables.values().map(Variable::bytes).sum());
        Some(level)
    }

    /// The next pass of a subprogram starts: its variables are new, and the values passed back are passed in again.
    pub(super) fn again(&mut self) {
        if self.calls.in_part() {
            return;
        }
        let level = self.calls.here_mut();
        for (name, given) in std::mem::take(&mut level.back) {
            if let (Some(variable), Some(given)) = (level.variables.remove(&name), level.given.get_mut(given)) {
                given.take_from(&variable);
            }
        }
        let count: usize = level.variables.values().map(|variable| variable.values.len()).sum();
        let texts: usize = level.variables.values().map(Variable::bytes).sum();
        self.texts = self.texts.saturating_sub(texts);
        level.variables.clear();
        level.taken = false;
        self.elements = self.elements.saturating_sub(count);
    }

    /// Variables for the next program of the series.
    pub(super) fn for_next_program(self) -> Self {
        let elements = self.channel.values().map(|variable| variable.values.len()).sum();
        let texts = self.channel.values().map(Variable::bytes).sum();
        Self { calls: CallStack::default(), elements, texts, ..self }
    }
}

impl Variable {
    /// Bytes of its name and of its values, in addition to the structures themselves.
    fn bytes(&self) -> usize {
        100 + self.values.iter().map(Data::bytes).sum::<usize>()
    }

    pub(super) fn one(kind: Type, value: Data) -> Self {
        Self { kind, sizes: Vec::new(), values: vec![value], born: (0, 0) }
    }
}

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
    Err(Fault::Alarm(&diag::MACRO_VARIABLE, text))
}

impl Siemens {
    /// Number of an R parameter; none if it is another name.
    pub(super) fn r_parameter(&mut self, host: &mut dyn Host, name: &Name) -> Outcome<Option<u32>> {
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
    pub(super) fn set_r(&mut self, host: &mut dyn Host, name: &Name, value: &Assigned) -> Outcome<bool> {
        let (Some(number), Assigned::One(value, _)) = (name.parameter(), value) else { return Ok(false) };
        let value = self.evaluate(host, value)?;
        let Some(value) = value.number() else {
            return wrong_type(format!("{} cannot be a value of {}, for R", value.described(), Type::Real.name()));
        };
        host.effect();
        self.variables.set_parameter(number as usize, value);
        Ok(true)
    }

    /// Where a variable is; none if there is none of this name.
    pub(super) fn locate(&mut self, host: &mut dyn Host, name: &Name) -> Outcome<Option<Target>> {
        if name.name == "R" {
            let Some(number) = self.r_parameter(host, name)? else { return Ok(None) };
            let (holder, kind, at) = (Holder::Parameter, Type::Real, number as usize);
            return Ok(Some(Target { holder, name: "R".into(), kind, at, count: at + 1, whole: false, part: None }));
        }
        let (holder, kind, sizes) = match self.variables.find(&name.name) {
            Some((holder, variable)) => (holder, variable.kind, variable.sizes.clone()),
            None => match self.shared_variable(host, &name.name)? {
                Some((kind, sizes)) => (Holder::Shared, kind, sizes),
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
        Ok(Some(Target { holder, name: name.name.clone().into(), kind, at, count, whole, part }))
    }

    /// Type and sizes of a variable that all channels share.
    pub(super) fn shared_variable(&mut self, host: &mut dyn Host, name: &str) -> Outcome<Option<(Type, Vec<usize>)>> {
        if let Some(known) = self.variables.shared.get(name) {
            return Ok(Some(known.clone()));
        }
        let Some(Value::Text(text)) = host.shared(&declared_key(name))? else { return Ok(None) };
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
    pub(super) fn value_of(&mut self, host: &mut dyn Host, target: &Target) -> Outcome<Data> {
        if target.whole {
            return missing(format!("{} is an array; program its indices", target.name));
        }
        let value = match target.holder {
            Holder::Parameter => Data::Real(self.variables.parameter(target.at as u32)),
            Holder::Shared => {
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
    pub(super) fn store(&mut self, host: &mut dyn Host, target: &Target, value: Data) -> Outcome<()> {
        let value = match target.part {
            None => value,
            Some((axis, part)) => {
                let whole = Target { part: None, ..target.clone() };
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
            Holder::Parameter => {
                self.variables.set_parameter(target.at, value.number().unwrap_or(0.0));
            }
            Holder::Shared => {
                host.set_shared(&element_key(&target.name, target.at, target.count), Some(value.value()))?;
            }
            holder => {
                let held = self.variables.held(holder, &target.name);
                if let Some(slot) = held.and_then(|held| held.values.get_mut(target.at)) {
                    let (before, after) = (slot.bytes(), value.bytes());
                    *slot = value;
                    self.variables.texts = (self.variables.texts + after).saturating_sub(before);
                }
            }
        }
        Ok(())
    }

    /// Assigns the value after `=`.
    pub(super) fn assign(&mut self, host: &mut dyn Host, target: &Target, value: &Assigned) -> Outcome<()> {
        match value {
            Assigned::One(..) if target.whole => missing(format!("{} is an array; program its indices", target.name)),
            Assigned::One(value, _) => {
                let value = self.evaluate(host, value)?;
                self.store(host, target, value)
            }
            Assigned::List(values) => self.store_list(host, target, values),
            Assigned::Fill(values) => self.store_fill(host, target, values),
            Assigned::Positioned(_, _, way) => {
                wrong_type(format!("{way} is for addresses only; {} is a variable", target.name))
            }
        }
    }

    pub(super) fn store_list(&mut self, host: &mut dyn Host, target: &Target, values: &[Argument]) -> Outcome<()> {
        for (step, argument) in values.iter().enumerate() {
            let element = Target { at: target.at + step, whole: false, ..target.clone() };
            if element.at >= target.count && target.holder != Holder::Parameter {
                return missing(format!("{} has {} elements, the list has more values", target.name, target.count));
            }
            if let Some(value) = self.argument(host, argument)? {
                self.store(host, &element, value)?;
            }
        }
        Ok(())
    }

    pub(super) fn store_fill(&mut self, host: &mut dyn Host, target: &Target, values: &[Argument]) -> Outcome<()> {
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
        let mut element = Target { whole: false, ..target.clone() };
        for _ in 0..count {
            host.work(1)?;
            self.store(host, &element, value.clone())?;
            element.at += 1;
        }
        Ok(())
    }

    /// Axis and part of a frame in an index.
    pub(super) fn frame_part(&mut self, host: &mut dyn Host, index: &[Expression]) -> Outcome<(usize, Part)> {
        let [axis, part] = index else { return super::syntax("a frame has an axis and a part in its index") };
        let part = match as_name(part) {
            Some(name) if name.index.is_empty() => Part::named(&name.name),
            _ => None,
        };
        let Some(part) = part else { return super::syntax("a part of a frame is TR, FI, RT, SC or MI") };
        let axis = self.evaluate(host, axis)?;
        Ok((super::frames::place(host, &axis, part)?, part))
    }

    /// A variable's value for macros; a frame gives its twelve numbers.
    pub(super) fn read_for_macro(&mut self, host: &mut dyn Host, name: &Name) -> Outcome<Option<Data>> {
        if name.name.starts_with('$') {
            return self.system(host, name);
        }
        match self.locate(host, name)? {
            Some(target) => self.value_of(host, &target).map(Some),
            None => Ok(None),
        }
    }

    pub(super) fn set_for_macro(&mut self, host: &mut dyn Host, name: &Name, value: &Value) -> Outcome<bool> {
        let Some(target) = self.locate(host, name)?.filter(|target| !target.whole) else { return Ok(false) };
        let kind = if target.part.is_some() { Type::Real } else { target.kind };
        let Some(value) = kind.taken_from(value) else { return Ok(false) };
        self.store(host, &target, value)?;
        Ok(true)
    }
}

impl Target {
    /// A whole array.
    pub(super) fn is_array(&self) -> bool {
        self.whole
    }

    /// An element this many after this one.
    pub(super) fn element(&self, behind: usize) -> Self {
        Self { at: self.at + behind, whole: false, ..self.clone() }
    }
}

/// A frame that a value has to be.
pub(super) fn as_frame(value: Data) -> Outcome<Frame> {
    match value {
        Data::Frame(frame) => Ok(*frame),
        other => wrong_type(format!("{} is not a frame", other.described())),
    }
}
