//! Q, QL, QR and QS parameters.
//!
//! Facts: Heidenhain pre-processor pages: Q and QS 0 to 1999, QL and QR 0 to 499; release notes: Q108 to Q111 and Q113
//! come from the control. Decisions: Q and QS belong to the channel, QL to the program or cycle that uses them,
//! labels in it included, QR outlives a restart of the program. Invariant: an index in here is one that exists.

use std::sync::Arc;

use counterpoint_control_api::call_stack::CallStack;
use counterpoint_control_api::host::InterpreterHost;
use rustc_hash::FxHashMap;

use super::q_parameter::{ParameterKind, ParameterValue, QParameter};

/// The data that the control supplies in its own Q parameters.
#[derive(Debug, Clone, Default)]
pub(super) struct ControlState {
    /// Tool called last.
    pub(super) tool: Option<f64>,
    /// Allowances of TOOL CALL.
    pub(super) allowances: [f64; 2],
    /// Tool axis, 0 = X.
    pub(super) tool_axis: Option<usize>,
    /// M3, M4, M5 after M3, M5 after M4: 0 to 3.
    pub(super) spindle: Option<u8>,
    pub(super) coolant: bool,
    /// The main program counts in inches; while a cycle runs, the program that has called it.
    pub(super) inch: bool,
}

impl ControlState {
    /// Value of a parameter that the control sets.
    fn get(&self, index: u32, host: &dyn InterpreterHost) -> Option<f64> {
        let in_force = || host.tool_in_force().map(|length| length / host.length_factor());
        Some(match index {
            108 => in_force()[1],
            109 => self.tool_axis.map_or(-1.0, |axis| axis as f64),
            110 => self.spindle.map_or(-1.0, f64::from),
            111 => f64::from(u8::from(self.coolant)),
            113 => f64::from(u8::from(self.inch)),
            114 => in_force()[0],
            _ => return None,
        })
    }

    /// An M function acts.
    pub(super) fn function(&mut self, number: f64) {
        match number {
            3.0 | 13.0 => self.spindle = Some(0),
            4.0 | 14.0 => self.spindle = Some(1),
            5.0 => self.spindle = self.spindle.map(|now| if now % 2 == 1 { 3 } else { 2 }),
            _ => {}
        }
        match number {
            8.0 | 13.0 | 14.0 => self.coolant = true,
            9.0 => self.coolant = false,
            _ => {}
        }
    }
}

/// Local data of a running program or label.
#[derive(Debug, Clone, Default)]
pub(super) struct HeidenhainCallLevel {
    /// QL parameters; a label has none.
    local: FxHashMap<u32, f64>,
    /// Remaining passes of the running repeats, by line of their call.
    pub(super) repeats: Vec<(u32, u32)>,
    /// Whether the program that has called this one counts in inches, where this one does not count as it does.
    pub(super) caller_in_inches: Option<bool>,
}

/// The parameters of a kernel.
#[derive(Debug, Default)]
pub(super) struct QParameterStore {
    q: FxHashMap<u32, f64>,
    kept: FxHashMap<u32, f64>,
    texts: FxHashMap<u32, Arc<str>>,
    /// Of the programs and labels that run; labels use the parameters of their program.
    pub(super) calls: CallStack<HeidenhainCallLevel>,
    pub(super) control: ControlState,
}

impl QParameterStore {
    /// Whether there can be such a parameter.
    pub(super) fn exists(name: QParameter) -> bool {
        name.index <= name.kind.last()
    }

    /// Bytes that they take, about.
    pub(super) fn bytes(&self) -> usize {
        let texts: usize = self.texts.values().map(|text| text.len() + 60).sum();
        let local: usize = self.calls.iter().map(|level| level.local.len() * 32).sum();
        texts + local + (self.q.len() + self.kept.len()) * 32
    }

    fn numbers(&self, kind: ParameterKind) -> Option<&FxHashMap<u32, f64>> {
        match kind {
            ParameterKind::Q => Some(&self.q),
            ParameterKind::Kept => Some(&self.kept),
            ParameterKind::Local => Some(&self.calls.program().local),
            ParameterKind::Text => None,
        }
    }

    /// Value of a parameter, if it was set.
    pub(super) fn get(&self, name: QParameter) -> Option<ParameterValue> {
        match self.numbers(name.kind) {
            Some(numbers) => numbers.get(&name.index).copied().map(ParameterValue::Number),
            None => self.texts.get(&name.index).cloned().map(ParameterValue::Text),
        }
    }

    /// The control's own value of a parameter that was not set.
    pub(super) fn of_control(&self, name: QParameter, host: &dyn InterpreterHost) -> Option<ParameterValue> {
        if name.kind == ParameterKind::Q {
            self.control.get(name.index, host).map(ParameterValue::Number)
        } else {
            None
        }
    }

    /// Sets a parameter that exists to a value of its kind; whether that is so.
    pub(super) fn set(&mut self, name: QParameter, value: ParameterValue) -> bool {
        if !Self::exists(name) {
            return false;
        }
        match (name.kind, value) {
            (ParameterKind::Text, ParameterValue::Text(text)) => {
                self.texts.insert(name.index, text);
            }
            (ParameterKind::Q, ParameterValue::Number(value)) => {
                self.q.insert(name.index, value);
            }
            (ParameterKind::Kept, ParameterValue::Number(value)) => {
                self.kept.insert(name.index, value);
            }
            (ParameterKind::Local, ParameterValue::Number(value)) => {
                self.calls.program_mut().local.insert(name.index, value);
            }
            _ => return false,
        }
        true
    }

    /// Gives a parameter the value back that it had, or none.
    pub(super) fn put_back(&mut self, name: QParameter, value: Option<ParameterValue>) {
        if let Some(value) = value {
            self.set(name, value);
            return;
        }
        match name.kind {
            ParameterKind::Q => self.q.remove(&name.index),
            ParameterKind::Kept => self.kept.remove(&name.index),
            ParameterKind::Local => self.calls.program_mut().local.remove(&name.index),
            ParameterKind::Text => {
                self.texts.remove(&name.index);
                None
            }
        };
    }

    /// The program begins again.
    pub(super) fn begin(&mut self, reset: bool) {
        self.calls = CallStack::default();
        if reset {
            self.q.clear();
            self.texts.clear();
            self.control = ControlState::default();
        }
    }
}
