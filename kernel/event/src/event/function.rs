//! Functions that only take time.

use super::declare::record;
use super::work::WorkClass;

record! {
    /// An M function (or other word) that only takes time from the machine's table.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct TimedFunction {
        /// Register letter, `M` mostly.
        pub letter: char = 1,
        /// Its value.
        pub value: f64 = 2,
    }

    fn work(&self) -> Option<WorkClass> {
        Some(WorkClass::Misc)
    }

    fn action(&self, number: fn(f64) -> String) -> Option<String> {
        Some(format!("function {}={}", self.letter.to_ascii_lowercase(), number(self.value)))
    }
}
