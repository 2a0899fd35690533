//! Prepared answers of a job to the dialogs of its machine.
//!
//! Invariant: [`check`] passes exactly when every answer can be taken as it is written. Several answers to one dialog
//! are taken in order, the last one stays.

use std::collections::BTreeMap;
use std::fmt;

use serde::{Deserialize, Serialize};

use super::{Dialog, FieldKind, find, same_name};

/// A value of a field.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum DialogValue {
    /// On or off.
    Flag(bool),
    /// Number.
    Number(f64),
    /// Text.
    Text(String),
}

impl DialogValue {
    /// An empty text.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        matches!(self, Self::Text(text) if text.is_empty())
    }
}

impl fmt::Display for DialogValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Flag(flag) => write!(f, "{flag}"),
            Self::Number(number) => write!(f, "{number}"),
            Self::Text(text) => write!(f, "{text}"),
        }
    }
}

/// An answer to a dialog.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DialogAnswer {
    /// Name of the dialog.
    pub dialog: String,
    /// Label of the button; none = the first of type OK.
    #[serde(default)]
    pub button: Option<String>,
    /// Values by variable; letter case does not count.
    #[serde(default)]
    pub values: BTreeMap<String, DialogValue>,
}

impl DialogAnswer {
    /// Value for a variable.
    #[must_use]
    pub fn value(&self, variable: &str) -> Option<&DialogValue> {
        self.values.iter().find(|(name, _)| name.eq_ignore_ascii_case(variable)).map(|(_, value)| value)
    }
}

/// The answer to the `nth` showing of a dialog in a channel, counted from 0.
#[must_use]
pub fn nth<'a>(answers: &'a [DialogAnswer], dialog: &str, nth: usize) -> Option<&'a DialogAnswer> {
    let of_dialog = answers.iter().filter(|answer| same_name(&answer.dialog, dialog));
    of_dialog.clone().nth(nth).or_else(|| of_dialog.clone().next_back())
}

/// Errors in the answers of a job.
#[must_use]
pub fn check(dialogs: &[Dialog], answers: &[DialogAnswer]) -> Vec<String> {
    let mut wrong = Vec::new();
    for answer in answers {
        let Some(dialog) = find(dialogs, &answer.dialog) else {
            wrong.push(format!("an answer is for the dialog '{}', which the machine does not have", answer.dialog));
            continue;
        };
        wrong.extend(dialog.button(answer).err());
        for (variable, value) in &answer.values {
            let fields = dialog.fields.iter().filter(|field| field.kind != FieldKind::Label);
            match fields.clone().find(|field| field.variable.eq_ignore_ascii_case(variable)) {
                Some(field) => {
                    let refused = field.accept(Some(value.clone())).err();
                    wrong.extend(refused.map(|why| format!("dialog '{}': {why}", dialog.name)));
                }
                None => wrong.push(format!("dialog '{}' has no field for '{variable}'", dialog.name)),
            }
        }
    }
    wrong
}
