//! Dialogs: questions that macros put to the operator, and the answers a job brings along.
//!
//! Facts: reference control-emulator.md 7.4. Invariants: a job whose answers do not fit its machine does not start; a
//! dialog that no answer is there for fails at once unless the job is attended by an [`operator`].

pub mod answers;
pub mod operator;

use answers::{DialogAnswer, DialogValue};

/// A dialog of a machine.
#[derive(Debug, Clone, PartialEq)]
pub struct Dialog {
    /// Name; blanks and letter case do not count.
    pub name: String,
    /// Title, the name if nothing else is said.
    pub title: String,
    /// Controls from top to bottom.
    pub fields: Vec<DialogField>,
    /// Buttons from left to right, at least one of type OK.
    pub buttons: Vec<Button>,
}

/// A control.
#[derive(Debug, Clone, PartialEq)]
pub struct DialogField {
    /// Text beside it.
    pub label: String,
    /// Macro variable that it shows and sets, empty for a plain text.
    pub variable: String,
    /// The data that it takes.
    pub kind: FieldKind,
    /// Value when the variable has none.
    pub default: Option<DialogValue>,
    /// An empty value is refused.
    pub required: bool,
    /// Variable that has to be set, or must not be, for the control to take anything.
    pub enabled: Option<(String, bool)>,
}

/// The values that a dialog control accepts.
#[derive(Debug, Clone, PartialEq)]
pub enum FieldKind {
    /// Nothing: a text or a frame.
    Label,
    /// A text of at most this many characters.
    Text {
        /// Longest text.
        longest: usize,
    },
    /// A number between limits.
    Number {
        /// Smallest.
        min: f64,
        /// Largest.
        max: f64,
        /// Whole numbers only.
        whole: bool,
    },
    /// On or off.
    Check,
    /// One of some values: radio buttons, a list or a combo box. Label and value, in order.
    Choice(Vec<(String, DialogValue)>),
}

/// A button; its label is the result of the dialog.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Button {
    /// Label.
    pub label: String,
    /// Its effect.
    pub kind: ButtonKind,
}

/// The effect of a button.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ButtonKind {
    /// Writes the values back.
    Ok,
    /// Leaves the variables as they were.
    Cancel,
    /// Sets all fields to their first values.
    Reset,
    /// Opens another dialog.
    Call(String),
}

/// The outcome of a dialog.
#[derive(Debug, Clone, PartialEq)]
pub struct DialogOutcome {
    /// Label of the button.
    pub button: String,
    /// Values for the variables, in the order of the fields; none after Cancel.
    pub values: Vec<(String, DialogValue)>,
}

/// Why a dialog failed; for a macro all of them are an input/output error.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Failure {
    /// The machine has no such dialog.
    #[error("the machine has no dialog '{0}'")]
    Unknown(String),
    /// The job brings no answer: it runs in the background.
    #[error("the job has no answer for the dialog '{0}'")]
    Unanswered(String),
    /// The operator declined.
    #[error("the operator declined the dialog '{0}'")]
    Declined(String),
    /// The time of the server for an answer expired.
    #[error("no operator answered the dialog '{0}' in time")]
    Late(String),
    /// A value cannot be taken.
    #[error("{0}")]
    Refused(String),
}

/// Whether two names mean the same dialog.
#[must_use]
pub fn same_name(a: &str, b: &str) -> bool {
    let plain =
        |name: &str| name.chars().filter(|c| !c.is_whitespace()).flat_map(char::to_lowercase).collect::<String>();
    plain(a) == plain(b)
}

/// The dialog of a name.
#[must_use]
pub fn find<'d>(dialogs: &'d [Dialog], name: &str) -> Option<&'d Dialog> {
    dialogs.iter().find(|dialog| same_name(&dialog.name, name))
}

/// Shows a dialog: fields start from `current` or their defaults, the answer goes over them.
///
/// # Errors
/// There is no such dialog, no answer, or a value that is refused.
pub fn show(
    dialogs: &[Dialog],
    name: &str,
    answer: Option<&DialogAnswer>,
    current: &mut dyn FnMut(&str) -> Option<DialogValue>,
) -> Result<DialogOutcome, Failure> {
    let dialog = find(dialogs, name).ok_or_else(|| Failure::Unknown(name.to_owned()))?;
    let answer = answer.ok_or_else(|| Failure::Unanswered(dialog.name.clone()))?;
    evaluate(dialog, answer, current).map_err(Failure::Refused)
}

/// Meaning of an answer; an error says why it is refused.
fn evaluate(
    dialog: &Dialog,
    answer: &DialogAnswer,
    current: &mut dyn FnMut(&str) -> Option<DialogValue>,
) -> Result<DialogOutcome, String> {
    let button = dialog.button(answer)?;
    let mut values = Vec::new();
    if button.kind == ButtonKind::Ok {
        for field in dialog.bound() {
            if !field.is_enabled(dialog, answer, current) {
                continue;
            }
            let value = answer.value(&field.variable).cloned().or_else(|| field.start(current));
            let value = field.accept(value).map_err(|why| format!("dialog '{}': {why}", dialog.name))?;
            values.extend(value.map(|value| (field.variable.clone(), value)));
        }
    }
    Ok(DialogOutcome { button: button.label.clone(), values })
}

impl Dialog {
    /// Fields with a variable.
    fn bound(&self) -> impl Iterator<Item = &DialogField> {
        self.fields.iter().filter(|field| !field.variable.is_empty())
    }

    /// Values that the fields begin with, by variable, then those of other variables that decide about fields.
    fn start(&self, current: &mut dyn FnMut(&str) -> Option<DialogValue>) -> Vec<(String, DialogValue)> {
        let mut values: Vec<(String, DialogValue)> =
            self.bound().filter_map(|field| Some((field.variable.clone(), field.start(current)?))).collect();
        for (variable, _) in self.fields.iter().filter_map(|field| field.enabled.as_ref()) {
            if !values.iter().any(|(known, _)| known.eq_ignore_ascii_case(variable)) {
                values.extend(current(variable).map(|value| (variable.clone(), value)));
            }
        }
        values
    }

    /// The button an answer presses: the named one, otherwise the first of type OK.
    fn button(&self, answer: &DialogAnswer) -> Result<&Button, String> {
        let found = match &answer.button {
            Some(label) => self.buttons.iter().find(|button| button.label.eq_ignore_ascii_case(label)),
            None => self.buttons.iter().find(|button| button.kind == ButtonKind::Ok),
        };
        let label = answer.button.as_deref().unwrap_or("OK");
        match found {
            Some(button) if matches!(button.kind, ButtonKind::Ok | ButtonKind::Cancel) => Ok(button),
            Some(_) => Err(format!("dialog '{}': the button '{label}' does not end it", self.name)),
            None => Err(format!("dialog '{}' has no button '{label}'", self.name)),
        }
    }
}

impl DialogField {
    /// Whether it takes values: the variable that decides, as it is entered in the same dialog or stands, is set or
    /// not.
    fn is_enabled(
        &self,
        dialog: &Dialog,
        answer: &DialogAnswer,
        current: &mut dyn FnMut(&str) -> Option<DialogValue>,
    ) -> bool {
        let Some((variable, wanted)) = &self.enabled else { return true };
        let shown = dialog.bound().find(|field| field.variable.eq_ignore_ascii_case(variable));
        let value = shown.and_then(|field| answer.value(variable).cloned().or_else(|| field.start(current)));
        let value = value.or_else(|| current(variable));
        let set = match value {
            Some(DialogValue::Flag(flag)) => flag,
            Some(DialogValue::Number(number)) => number != 0.0,
            Some(DialogValue::Text(text)) => !text.is_empty(),
            None => false,
        };
        set == *wanted
    }

    /// The value it begins with: that of its variable, otherwise its default.
    fn start(&self, current: &mut dyn FnMut(&str) -> Option<DialogValue>) -> Option<DialogValue> {
        current(&self.variable).filter(|value| !value.is_empty()).or_else(|| self.default.clone())
    }

    /// The value as the field takes it.
    ///
    /// # Errors
    /// Why it is refused.
    pub fn accept(&self, value: Option<DialogValue>) -> Result<Option<DialogValue>, String> {
        let name = &self.variable;
        let Some(value) = value.filter(|value| !value.is_empty()) else {
            return if self.required { Err(format!("{name} needs a value")) } else { Ok(None) };
        };
        match (&self.kind, &value) {
            (FieldKind::Text { longest }, DialogValue::Text(text)) if text.chars().count() <= *longest => {
                Ok(Some(value))
            }
            (FieldKind::Text { longest }, DialogValue::Text(_)) => {
                Err(format!("{name} takes {longest} characters at most"))
            }
            (FieldKind::Text { .. }, other) => Ok(Some(DialogValue::Text(other.to_string()))),
            (FieldKind::Number { min, max, whole }, DialogValue::Number(number)) => {
                if !(*min..=*max).contains(number) {
                    Err(format!("{name} must be {min} to {max}, not {number}"))
                } else if *whole && number.fract() != 0.0 {
                    Err(format!("{name} must be a whole number, not {number}"))
                } else {
                    Ok(Some(value))
                }
            }
            (FieldKind::Check, DialogValue::Flag(_)) => Ok(Some(value)),
            (FieldKind::Choice(choices), given) => {
                let by_label = |label: &str| matches!(given, DialogValue::Text(text) if text == label);
                let chosen = choices.iter().find(|(label, choice)| choice == given || by_label(label));
                chosen.map(|(_, choice)| Some(choice.clone())).ok_or_else(|| {
                    let labels: Vec<&str> = choices.iter().map(|(label, _)| label.as_str()).collect();
                    format!("{name} must be one of {}, not {given}", labels.join(", "))
                })
            }
            (FieldKind::Number { .. }, _) => Err(format!("{name} must be a number, not {value}")),
            (FieldKind::Check, _) => Err(format!("{name} must be true or false, not {value}")),
            (FieldKind::Label, _) => Ok(None),
        }
    }
}

#[cfg(test)]
mod tests;
