//! Printing statements of custom macro: lines of a file of the job.
//!
//! Facts: reference fanuc-variables-and-alarms.md 2.5. Invariant: all channels write one file, in the order of simulated
//! time; how much is written is bounded.

use super::Kernel;
use super::macros::Left;
use crate::diag;
use crate::dialect::fanuc::{Item, print};

impl Kernel<'_> {
    /// Writes a line.
    pub(crate) fn print(&mut self, items: &[Item], binary: bool) -> Result<(), Left> {
        let machine = self.channel.env.machine;
        let mut line = String::new();
        for item in items {
            match item {
                Item::Text(text) => line.push_str(text),
                Item::Number(value, whole, fraction) => {
                    let value = self.eval(value)?;
                    line.push_str(&if binary {
                        print::binary(value, *fraction)
                    } else {
                        print::decimal(value, *whole, *fraction, &machine.output)
                    });
                }
            }
        }
        line.push_str(if binary { "\n" } else { machine.output.line_end });
        if machine.output.opened
            && !self.flow.printing.open
            && !std::mem::replace(&mut self.flow.printing.closed_reported, true)
        {
            let text = format!("'{}' prints without POPEN before it; its output is kept", self.block_text());
            self.diagnose(&diag::PRINT_CLOSED, text);
        }
        self.flow.pass.effects = true;
        let done = self.shared(|order| order.shared.files.print(&machine.output.file, &line));
        if let Err(text) = done.map_err(Left::Halt)? {
            self.diagnose(&diag::MACRO_FILES, text);
        }
        Ok(())
    }
}
