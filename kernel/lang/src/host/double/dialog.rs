//! Answers to dialogs, given ahead.
//!
//! Facts: reference control-emulator.md 7.4: names ignore blanks and case; a dialog without answers behaves as in the
//! background, where it fails. The double can set `%Gnn` and system variables only: it does not know the macro's own.

use super::Test;
use crate::diag::Number;
use crate::fault::{Fault, Outcome};
use crate::host::folder::text;
use crate::value::Value;

/// What is answered: the button, and variables with their values.
#[derive(Clone, Debug, Default)]
pub struct Answer {
    /// Label of the button.
    pub button: String,
    /// `%G01` or `$NAME` with the value it gets.
    pub values: Vec<(String, Value)>,
}

fn key(name: &str) -> String {
    name.chars().filter(|c| !c.is_whitespace()).collect::<String>().to_uppercase()
}

impl Test {
    /// Gives the answer to a dialog.
    pub fn answer(&mut self, dialog: &str, answer: Answer) {
        self.answers.insert(key(dialog), answer);
    }

    pub(super) fn dialog(&mut self, arguments: &[Value]) -> Outcome<Value> {
        let name = text(arguments, 0);
        let Some(answer) = self.answers.get(&key(name)).cloned() else {
            let message = format!("the dialog '{name}' cannot be shown here, and no answer was given ahead");
            return Err(Fault::new(Number::NO_DIALOG, message));
        };
        for (variable, value) in answer.values {
            match variable.strip_prefix("%G").and_then(|number| number.parse::<usize>().ok()) {
                Some(index) if index < 100 => self.set_global(index, value),
                _ => self.set_system(&variable, value),
            }
        }
        Ok(Value::text(answer.button))
    }
}
