//! `$FDIALOG`: the answers of the job go into the variables of the dialog's fields.
//!
//! Facts: reference control-emulator.md 7.4. Invariants: a value that a dialog writes keeps the type of the variable; a
//! dialog without an answer fails as in the background. Fields are bound to `%G00` to `%G99`, to GLOBAL and OBJECT
//! variables that are declared by name, and to system variables; the local variables of a macro are its own.

use counterpoint_lang::bytecode::SharedVariable;
use counterpoint_lang::diag::DiagnosticNumber;
use counterpoint_lang::fault::{MacroFault, Outcome};
use counterpoint_lang::host::VariableHost;
use counterpoint_lang::value::{MacroValue, ValueType};
use counterpoint_lang::vm::MacroState;

use crate::context::KernelHost;
use counterpoint_machine::macros::system;
use counterpoint_ports::dialog::operator::OpenDialog;
use counterpoint_ports::dialog::{self, Dialog, Failure, FieldKind, answers};

/// Steps that a dialog costs, and each question to the operator besides the bytes of its texts.
const DIALOG_TICKS: usize = 100;

/// A variable that a field may be bound to.
#[derive(Clone, Copy)]
enum Bound {
    /// Shared by macros, with its type if it was declared with one.
    Shared(SharedVariable, Option<ValueType>),
    /// System variable.
    System(u32),
}

fn from_dialog(value: answers::DialogValue) -> MacroValue {
    match value {
        answers::DialogValue::Flag(flag) => MacroValue::Logical(flag),
        answers::DialogValue::Number(number) => MacroValue::Real(number),
        answers::DialogValue::Text(text) => MacroValue::text(text),
    }
}

/// Bytes of a text.
fn length(value: &answers::DialogValue) -> usize {
    if let answers::DialogValue::Text(text) = value { text.len() } else { 0 }
}

fn to_dialog(value: &MacroValue) -> Option<answers::DialogValue> {
    match value {
        MacroValue::Logical(flag) => Some(answers::DialogValue::Flag(*flag)),
        MacroValue::Real(number) => Some(answers::DialogValue::Number(*number)),
        MacroValue::Text(text) => Some(answers::DialogValue::Text(text.as_ref().clone())),
        _ => None,
    }
}

/// A value in the type that the variable has.
fn typed(value: answers::DialogValue, kind: Option<ValueType>) -> Outcome<MacroValue> {
    let text = value.to_string();
    let value = from_dialog(value);
    match kind {
        Some(kind) if value.kind() == Some(kind) => Ok(value),
        None => Ok(value),
        Some(ValueType::Text) => Ok(MacroValue::text(text)),
        Some(ValueType::Real) if text.trim().parse::<f64>().is_ok_and(f64::is_finite) => {
            Ok(MacroValue::Real(text.trim().parse().unwrap_or(0.0)))
        }
        Some(kind) => Err(MacroFault::kind(kind.name(), &value)),
    }
}

impl KernelHost<'_, '_> {
    /// Shows a dialog; returns the label of its button.
    pub(crate) fn show_dialog(&mut self, state: &mut MacroState, name: &str) -> Outcome<MacroValue> {
        let (machine, options) = (self.kernel.channel.env.machine, self.kernel.channel.env.options);
        if self.kernel.ports.control.operator().is_some() {
            self.pass_events_on();
        }
        let runtime = &mut *self.kernel.macros;
        let key = dialog::find(&machine.dialogs, name).map_or_else(String::new, |dialog| dialog.name.clone());
        let shown = runtime.outside.asked.dialogs.entry(key).or_default();
        let answer = answers::nth(&options.answers, name, *shown);
        *shown += 1;
        let fields = dialog::find(&machine.dialogs, name).map_or(&[][..], |dialog| dialog.fields.as_slice());
        let takes_numbers = |variable: &str| {
            let field = fields.iter().find(|field| field.variable == variable);
            field.is_some_and(|field| matches!(field.kind, FieldKind::Number { .. }))
        };
        self.kernel.ports.control.note_outside();
        let operator = self.kernel.ports.control.operator();
        let place = self.kernel.channel.at.user_place();
        let (channel, file, line) =
            (self.kernel.channel.at.channel, self.kernel.channel.env.info.file_name(place.file), place.line);
        let mut current = |variable: &str| {
            let value = self.bound(variable).and_then(|at| to_dialog(&self.bound_value(state, at)))?;
            // A field of numbers may be bound to a text.
            match &value {
                answers::DialogValue::Text(text) if takes_numbers(variable) => {
                    Some(text.trim().parse().map_or(value, answers::DialogValue::Number))
                }
                _ => Some(value),
            }
        };
        let mut asked = DIALOG_TICKS;
        let shown = match operator {
            Some(operator) if answer.is_none() => {
                let mut ask = |dialog: &Dialog, values: &[(String, answers::DialogValue)], problem: Option<&str>| {
                    let answer = operator.ask(&OpenDialog { channel, file, line, dialog, values, problem })?;
                    let values = values.iter().map(|(_, value)| value).chain(answer.values.values());
                    asked = values.map(length).fold(asked.saturating_add(DIALOG_TICKS), usize::saturating_add);
                    Ok(answer)
                };
                dialog::operator::converse(&machine.dialogs, name, &mut ask, &mut current)
            }
            _ => dialog::show(&machine.dialogs, name, answer, &mut current),
        };
        // If the end of the run closed the question, this is not a dialog without an answer.
        self.check_running(state)?;
        state.spend(asked)?;
        let shown = shown.map_err(|failure: Failure| {
            let number = match failure {
                Failure::Declined(_) | Failure::Late(_) => DiagnosticNumber::NOT_ANSWERED,
                Failure::Unknown(_) | Failure::Unanswered(_) | Failure::Refused(_) => DiagnosticNumber::NO_DIALOG,
            };
            MacroFault::new(number, failure.to_string())
        })?;
        for (variable, value) in shown.values {
            let Some(at) = self.bound(&variable) else {
                let text = format!("the dialog '{name}' sets {variable}, which is not a variable shared by macros");
                return Err(MacroFault::new(DiagnosticNumber::NO_DIALOG, text));
            };
            self.set_bound(state, at, value)?;
        }
        Ok(MacroValue::text(shown.button))
    }

    /// Passes the events before a question on to watchers while the job waits for the operator. The log is unchanged:
    /// events of moves whose times depend on later moves stay in the kernel.
    fn pass_events_on(&mut self) {
        if self.kernel.channel.emitter.path_stops() {
            self.kernel.channel.come_to_rest();
        }
        self.kernel.channel.flush();
        self.kernel.ports.coordinator.pass_on();
    }

    fn bound(&self, variable: &str) -> Option<Bound> {
        let name = variable.trim().to_ascii_uppercase();
        if name.starts_with('$') {
            let at = system::table().iter().position(|row| row.name == name && row.indices.is_empty())?;
            return u32::try_from(at).ok().map(Bound::System);
        }
        let runtime = &*self.kernel.macros;
        if let Some(number) = name.strip_prefix("%G") {
            let number = number.parse::<u32>().ok().filter(|number| *number < 100)?;
            return Some(Bound::Shared(SharedVariable::Global(number), None));
        }
        let (shared, kind) = runtime.program.shared_variable(&name)?;
        Some(Bound::Shared(shared, kind))
    }

    fn bound_value(&mut self, state: &mut MacroState, at: Bound) -> MacroValue {
        match at {
            Bound::System(index) => self.read_variable(index, &[]).unwrap_or(MacroValue::Null),
            Bound::Shared(SharedVariable::Object(index), _) => {
                state.object(index).map_or(MacroValue::Unset, |value| value.clone())
            }
            Bound::Shared(SharedVariable::Global(index), _) => {
                let mut found = MacroValue::Unset;
                self.global(index, None, &mut |value| found = value.clone());
                found
            }
        }
    }

    fn set_bound(&mut self, state: &mut MacroState, at: Bound, value: answers::DialogValue) -> Outcome<()> {
        let own = match at {
            Bound::System(index) => system::table().get(index as usize).and_then(|row| row.kind),
            Bound::Shared(_, kind) => kind,
        };
        let value = typed(value, own)?;
        match at {
            Bound::System(index) => self.write_variable(index, &[], value)?,
            Bound::Shared(SharedVariable::Object(index), _) => {
                if let Some(slot) = state.object(index) {
                    *slot = value;
                }
            }
            Bound::Shared(SharedVariable::Global(index), _) => {
                let growth = value.as_text().map_or(0, str::len) + 100;
                self.global(index, Some(growth), &mut |slot| *slot = value.clone());
            }
        }
        Ok(())
    }
}
