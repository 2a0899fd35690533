//! The store of variables: those of each running program, of the channel, and R parameters.
//!
//! Invariant: the number of elements and their bytes are counted, and bounded by [`MOST_IN_ALL`].

use std::borrow::Cow;

use counterpoint_control_api::call_stack::CallStack;
use counterpoint_event::FileId;
use counterpoint_motion::contour::area::ClearingArea;
use rustc_hash::FxHashMap;

use super::frame_component::FrameComponent;
use super::value::{Data, Type};

/// Most elements of all variables of a kernel.
pub(super) const MOST_IN_ALL: usize = 1_000_000;

/// A variable.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SiemensVariable {
    pub(super) kind: Type,
    pub(super) sizes: Vec<usize>,
    pub(super) values: Vec<Data>,
    /// Where it was defined: the same block may define it again.
    pub(super) born: (FileId, u32),
}

/// Variables of a running program.
#[derive(Debug, Default)]
pub(super) struct SiemensCallLevel {
    pub(super) variables: FxHashMap<String, SiemensVariable>,
    /// The arguments of the call, until PROC takes them.
    pub(super) given: Vec<PassedArgument>,
    /// PROC has taken it.
    pub(super) taken: bool,
    /// Parameters whose values go back: the name, and which of the given ones.
    pub(super) back: Vec<(String, usize)>,
    /// Modal codes that come back at the end.
    pub(super) modes: Option<counterpoint_control_api::host::ModalSnapshot>,
    /// Cycles that run meanwhile a part of their caller does: they do not hide its variables.
    pub(super) aside: Option<counterpoint_control_api::call_stack::Aside<SiemensCallLevel>>,
}

/// An element of a variable.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct VariableElement {
    pub(super) holder: VariableStorage,
    pub(super) name: Cow<'static, str>,
    pub(super) kind: Type,
    pub(super) at: usize,
    /// Elements of the whole variable.
    pub(super) count: usize,
    /// No index was given for an array.
    pub(super) whole: bool,
    /// Part of a frame, along X, Y or Z.
    pub(super) part: Option<(usize, FrameComponent)>,
}

/// An argument.
#[derive(Debug, Clone)]
pub(super) struct PassedArgument {
    pub(super) value: PassedValue,
    /// Where it came from, if that is a variable.
    pub(super) from: Option<VariableElement>,
}

/// The value of an argument.
#[derive(Debug, Clone)]
pub(super) enum PassedValue {
    Missing,
    One(Data),
    Whole(Box<SiemensVariable>),
}

impl PassedArgument {
    /// The same value, as if no variable had given it.
    pub(super) fn without_variable(&self) -> Self {
        Self { value: self.value.clone(), from: None }
    }

    /// Whether the caller has given something.
    pub(super) fn is_there(&self) -> bool {
        !matches!(self.value, PassedValue::Missing)
    }

    /// The number that a parameter of a resident program holds; 0 for a text and without a value.
    ///
    /// # Errors
    /// The parameter cannot hold the value.
    pub(super) fn number_as(&self, name: &str, kind: Type) -> Result<f64, String> {
        match &self.value {
            PassedValue::Missing => Ok(0.0),
            PassedValue::Whole(_) => Err(format!("an array does not fit the parameter {name}")),
            PassedValue::One(Data::Real(value)) if kind == Type::Real => Ok(*value),
            PassedValue::One(value) => match kind.hold(value.clone()) {
                Ok(value) => Ok(value.number().unwrap_or(0.0)),
                Err(text) => Err(format!("{text}, for the parameter {name}")),
            },
        }
    }

    /// Takes the final value of a parameter.
    pub(super) fn take_from(&mut self, variable: &SiemensVariable) {
        self.value = match variable.values.as_slice() {
            [one] if variable.sizes.is_empty() => PassedValue::One(one.clone()),
            _ => PassedValue::Whole(Box::new(variable.clone())),
        };
    }
}

/// All variables of a kernel.
#[derive(Debug, Default)]
pub(super) struct SiemensVariableStore {
    pub(super) calls: CallStack<SiemensCallLevel>,
    pub(super) channel: FxHashMap<String, SiemensVariable>,
    /// Types and sizes of variables that all channels share.
    pub(super) shared: FxHashMap<String, (Type, Vec<usize>)>,
    /// R parameters by number, up to the highest one that was written.
    parameters: Vec<f64>,
    /// Contours that were named for the next cycle.
    pub(super) contours: Vec<String>,
    /// Rim and islands of the pocket that a cycle works on.
    pub(super) area: ClearingArea,
    /// The channel has written or removed files.
    pub(super) writes: bool,
    pub(super) elements: usize,
    /// Bytes of their names, texts and frames.
    texts: usize,
}

/// Where a variable is kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum VariableStorage {
    Level(usize),
    Channel,
    Shared,
    Parameter,
}

impl SiemensVariableStore {
    /// Bytes that they take, about.
    pub(super) fn bytes(&self) -> usize {
        self.elements * 48 + self.parameters.len() * size_of::<f64>() + self.texts + self.shared.len() * 100
    }

    pub(super) fn find(&self, name: &str) -> Option<(VariableStorage, &SiemensVariable)> {
        let running = self.calls.program_depth();
        let of = |at: usize| self.calls.at(at)?.variables.get(name).map(|found| (VariableStorage::Level(at), found));
        of(running).or_else(|| of(0)).or_else(|| self.channel.get(name).map(|found| (VariableStorage::Channel, found)))
    }

    /// Whether a variable of this name exists in the channel.
    pub(super) fn knows(&self, name: &str) -> bool {
        self.find(name).is_some() || self.shared.contains_key(name)
    }

    /// Value of a variable of one value.
    pub(super) fn scalar(&self, name: &str) -> Option<&Data> {
        let (_, variable) = self.find(name)?;
        variable.values.first().filter(|_| variable.sizes.is_empty())
    }

    /// Value of an R parameter.
    pub(super) fn parameter(&self, number: u32) -> f64 {
        self.parameters.get(number as usize).copied().unwrap_or(0.0)
    }

    /// Writes an R parameter, whose number is not too large.
    pub(super) fn set_parameter(&mut self, number: usize, value: f64) {
        if self.parameters.len() <= number {
            self.parameters.resize(number + 1, 0.0);
        }
        if let Some(slot) = self.parameters.get_mut(number) {
            *slot = value;
        }
    }

    pub(super) fn held(&mut self, holder: VariableStorage, name: &str) -> Option<&mut SiemensVariable> {
        match holder {
            VariableStorage::Level(at) => self.calls.at_mut(at)?.variables.get_mut(name),
            VariableStorage::Channel => self.channel.get_mut(name),
            VariableStorage::Shared | VariableStorage::Parameter => None,
        }
    }

    /// A whole variable, for a parameter that is one.
    pub(super) fn whole(&self, name: &str) -> Option<&SiemensVariable> {
        self.find(name).map(|(_, variable)| variable)
    }

    /// Keeps a variable of the running program; false if there is no room.
    pub(super) fn keep(&mut self, name: &str, variable: SiemensVariable) -> bool {
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
    pub(super) fn keep_in_channel(&mut self, name: &str, variable: SiemensVariable) {
        self.elements += variable.values.len();
        self.texts += variable.bytes();
        if let Some(old) = self.channel.insert(name.to_owned(), variable) {
            self.elements = self.elements.saturating_sub(old.values.len());
            self.texts = self.texts.saturating_sub(old.bytes());
        }
    }

    /// Puts a value in an element of a variable that the kernel holds.
    pub(super) fn put(&mut self, holder: VariableStorage, name: &str, at: usize, value: Data) {
        let Some(slot) = self.held(holder, name).and_then(|held| held.values.get_mut(at)) else { return };
        let (before, after) = (slot.bytes(), value.bytes());
        *slot = value;
        self.texts = (self.texts + after).saturating_sub(before);
    }

    /// A subprogram has returned; the main program stays.
    pub(super) fn leave(&mut self) -> Option<SiemensCallLevel> {
        let mut level = self.calls.leave()?;
        if let Some(aside) = level.aside.take() {
            self.calls.bring_back(aside);
        }
        let count: usize = level.variables.values().map(|variable| variable.values.len()).sum();
        self.elements = self.elements.saturating_sub(count);
        self.texts = self.texts.saturating_sub(level.variables.values().map(SiemensVariable::bytes).sum());
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
        let texts: usize = level.variables.values().map(SiemensVariable::bytes).sum();
        self.texts = self.texts.saturating_sub(texts);
        level.variables.clear();
        level.taken = false;
        self.elements = self.elements.saturating_sub(count);
    }

    /// Variables for the next program of the series.
    pub(super) fn for_next_program(self) -> Self {
        let elements = self.channel.values().map(|variable| variable.values.len()).sum();
        let texts = self.channel.values().map(SiemensVariable::bytes).sum();
        Self { calls: CallStack::default(), elements, texts, ..self }
    }
}

impl SiemensVariable {
    /// Bytes of its name and of its values, in addition to the structures themselves.
    fn bytes(&self) -> usize {
        100 + self.values.iter().map(Data::bytes).sum::<usize>()
    }

    pub(super) fn one(kind: Type, value: Data) -> Self {
        Self { kind, sizes: Vec::new(), values: vec![value], born: (0, 0) }
    }
}

/// Largest number of an R parameter.
pub(super) const MOST_PARAMETERS: i64 = 32_535;
