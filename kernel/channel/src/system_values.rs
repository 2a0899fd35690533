//! Values of the system variables of a channel.

use counterpoint_machine::system_variables::SystemVariables;
use rustc_hash::FxHashMap;

/// State of a channel's system variables.
#[derive(Debug, Default)]
pub struct SystemValues {
    /// Values by number, where programs have set one or the machine starts with one.
    pub kept: FxHashMap<u32, f64>,
    /// The offset of the clocks (milliseconds, hours) from simulated time.
    pub clocks: [f64; 2],
}

impl SystemValues {
    /// As the machine starts.
    pub fn new(variables: &SystemVariables) -> Self {
        let system = variables.initial.iter().copied().filter(|&(number, _)| variables.find(number).is_some());
        Self { kept: system.collect(), clocks: [0.0; 2] }
    }

    /// Value of a variable; `first` if none has been set.
    pub fn kept(&self, number: u32, first: f64) -> f64 {
        self.kept.get(&number).copied().unwrap_or(first)
    }
}
