//! Answers to dialogs, given ahead.
//!
//! Facts: reference control-emulator.md 7.4: names ignore blanks and case; a dialog without answers behaves as in the
//! background, where it fails. Answers set `%Gnn` and system variables only: the macro's own are not known here.

use std::collections::BTreeMap;

use counterpoint_lang::diag::DiagnosticNumber;
use counterpoint_lang::fault::{MacroFault, Outcome};
use counterpoint_lang::value::MacroValue;

/// An answer: the button, and variables with their values.
#[derive(Clone, Debug, Default)]
pub struct PreparedAnswer {
    /// Label of the button.
    pub button: String,
    /// `%G01` or `$NAME` with the value it gets.
    pub values: Vec<(String, MacroValue)>,
}

fn key(name: &str) -> String {
    name.chars().filter(|c| !c.is_whitespace()).collect::<String>().to_uppercase()
}

/// Answers by dialog.
#[derive(Debug, Default)]
pub(crate) struct Answers(BTreeMap<String, PreparedAnswer>);

impl Answers {
    pub(crate) fn add(&mut self, dialog: &str, answer: PreparedAnswer) {
        self.0.insert(key(dialog), answer);
    }

    pub(crate) fn find(&self, dialog: &str) -> Outcome<PreparedAnswer> {
        self.0.get(&key(dialog)).cloned().ok_or_else(|| {
            let message = format!("the dialog '{dialog}' cannot be shown here, and no answer was given ahead");
            MacroFault::new(DiagnosticNumber::NO_DIALOG, message)
        })
    }
}
