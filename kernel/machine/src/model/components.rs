//! The components of a composite machine.
//!
//! A component is a machine definition of its own with the axes, channels, spindles and waits of the composite. *Invariant:* each
//! channel of a composite has a component; the first one of a channel is in work when its program begins. Facts: reference
//! control-emulator.md 8.1, 8.3.

use std::sync::Arc;

use super::Machine;
use crate::preprocessor::Preprocessor;

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

/// Who reads the texts of programs.
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
