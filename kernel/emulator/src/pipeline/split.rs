//! Stage *split*: the text of a block becomes words, unless it is a statement for the pre-processor.
//!
//! Facts: reference control-emulator.md 2.2.

use counterpoint_control_api::ProgramHost as _;
use counterpoint_program::scan::ScanResult;

use crate::channel::Kernel;
use crate::channel::macro_queries::block_scanner;

impl Kernel<'_> {
    /// Splits a text into words, unless it is for the pre-processor.
    #[inline(always)]
    pub fn split(&mut self, text: &[u8], preprocess: bool) -> ScanResult {
        // Without macros a known one does not come here.
        if preprocess && self.flow.repeats && self.plan.hooks.is_some() && self.is_known_statement() {
            return ScanResult::Statement;
        }
        let (tables, own) = (self.channel.tables, block_scanner(self.plan, &self.channel, &self.macros));
        let scanner = own.as_deref().unwrap_or(&tables.scanner);
        let (secondary, watched) = (self.channel.state.secondary, self.flow.watched);
        match preprocess {
            true => scanner.scan(text, secondary, &mut self.channel.block, watched),
            false => scanner.scan_as(text, secondary, &mut self.channel.block, false),
        }
    }

    /// Whether the pre-processor has executed this line of the program before.
    fn is_known_statement(&mut self) -> bool {
        let (line, interpreter) = (self.unchanged_line(), self.dialect.interpreter.as_deref_mut());
        line.zip(interpreter).is_some_and(|(line, interpreter)| interpreter.executes(line))
    }

    /// Splits the text of the block again, as macros have changed it; the pre-processor has had its turn.
    pub fn split_again(&mut self) {
        let Some(text) = self.channel.context.text.clone() else { return };
        self.split(text.as_bytes(), false);
    }
}
