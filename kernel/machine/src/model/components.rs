//! The components of a composite machine.
//!
//! A component is a machine definition of its own with the axes, channels, spindles and waits of the composite.
//! *Invariant:* each channel of a composite has a component; the first one of a channel is active when its program
//! begins. Facts: reference control-emulator.md 8.1, 8.3.

use std::sync::Arc;

use super::Machine;
use crate::preprocessor::Preprocessor;
use crate::rows::CodeForm;

/// A component of a composite machine.
#[derive(Debug, Clone)]
pub struct Component {
    /// The minor word by which macros name it.
    pub designator: String,
    /// Name for people, 1–32 characters.
    pub name: String,
    /// Numbers of the channels that it may work in, ascending.
    pub channels: Vec<u16>,
    /// The behaviour of its control.
    pub machine: Arc<Machine>,
}

/// Readers of the texts of programs.
impl Machine {
    /// This definition; where a component has another pre-processor, the first component with each pre-processor.
    #[must_use]
    pub fn readers(&self) -> Vec<&Machine> {
        let others = self.components.iter().any(|component| component.machine.preprocessor != self.preprocessor);
        if !others {
            return vec![self];
        }
        let mut readers: Vec<&Machine> = Vec::new();
        for component in &self.components {
            if readers.iter().all(|reader| reader.preprocessor != component.machine.preprocessor) {
                readers.push(&component.machine);
            }
        }
        readers
    }

    /// The definitions by which blocks act, with the words that name them: this definition without a name, or the
    /// components.
    pub fn definitions(&self) -> impl Iterator<Item = (&str, &Machine)> {
        let own = self.components.is_empty().then_some(("", self));
        own.into_iter().chain(self.components.iter().map(|one| (one.designator.as_str(), &*one.machine)))
    }

    /// Place among [`readers`](Self::readers) of the one for a pre-processor.
    #[must_use]
    pub fn reader_for(&self, preprocessor: Preprocessor) -> usize {
        self.readers().iter().position(|reader| reader.preprocessor == preprocessor).unwrap_or(0)
    }

    /// The definition with which a channel begins.
    #[must_use]
    pub fn of_channel(&self, channel: u16) -> &Machine {
        let own = self.components.iter().find(|component| component.channels.contains(&channel));
        own.map_or(self, |component| &component.machine)
    }
}

/// Words on the components of a composite machine.
impl Machine {
    /// Whether a table of codes has a word with this letter and number.
    #[must_use]
    pub fn has_word(&self, letter: &str, number: f64) -> bool {
        let of = self.registers.entries().find(|(_, register)| register.name == letter).map(|(id, _)| id);
        of.is_some_and(|of| self.tables.code(of, number).iter().any(|row| self.codes[*row].enable))
    }

    /// The first word of this component whose macro selects another component: `M91`.
    #[must_use]
    pub fn word_that_selects(&self, designator: &str) -> Option<String> {
        let macros = self.macros.as_deref()?;
        let call = format!("$FAPPLY({designator})").to_ascii_uppercase();
        let selects = |code: u16| {
            let text = macros.program.macros.get(usize::from(code)).map_or("", |code| &code.source.text);
            let plain: String = text.chars().filter(|c| !c.is_whitespace()).collect();
            plain.to_ascii_uppercase().contains(&call)
        };
        let mut rows = self.codes.iter().filter(|row| row.enable);
        rows.find_map(|row| {
            let mut own = macros.of_code(row.id).iter().map(|id| &macros.codes[*id]);
            if !own.any(|one| selects(one.code)) {
                return None;
            }
            match &row.form {
                CodeForm::Text(text) => Some(text.trim().to_owned()),
                CodeForm::Register { register, min, .. } => Some(format!("{}{min}", self.registers[*register].name)),
                _ => None,
            }
        })
    }
}
