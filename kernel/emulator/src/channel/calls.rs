//! Counts of subprogram calls.

use super::Kernel;
use counterpoint_fault as diag;

impl Kernel<'_> {
    /// Passes of a repeat word.
    pub fn passes(&mut self, count: f64) -> u32 {
        if count < 0.0 || count.fract() != 0.0 {
            let text = format!("a repeat count is a whole number from 0 in '{}'", self.channel.block_text());
            self.diagnose(&diag::DATA_OUT_OF_RANGE, text);
            return 1;
        }
        let count = count.min(f64::from(u32::MAX - 1)) as u32;
        if self.channel.env.machine.subprograms.repeat_is_executions { count } else { count + 1 }
    }
}
