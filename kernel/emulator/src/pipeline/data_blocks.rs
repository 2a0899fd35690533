//! Data blocks of the program: parameters and tool life, which G10 begins and G11 ends.
//!
//! Facts: general CNC practice (Fanuc G10 L50). Decision: parameters and tool lives are not kept here, so their blocks
//! are passed with one note. *Invariant:* a block of data neither moves an axis nor selects a tool; its lines are
//! counted as work.

use crate::channel::Kernel;
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_program::block::Block;
use counterpoint_program::scan::ScanResult;

/// G number of the end of the data.
const END: f64 = 11.0;

impl Kernel<'_> {
    /// Continues after the block that ends the data.
    pub(crate) fn pass_data_blocks(&mut self) -> Acted {
        let sources = self.channel.env.sources;
        let Some((file, next, last)) = self.flow.frame().map(|frame| (frame.file, frame.next, frame.range.last)) else {
            return Ok(());
        };
        let Some(source) = sources.get(file) else { return Ok(()) };
        let (scanner, secondary) = (&self.channel.tables.scanner, self.channel.state.secondary);
        let mut block = Block::default();
        let mut passed = 0_usize;
        let end = (next..=last).find(|&line| {
            passed += 1;
            let words = scanner.scan_as(source.line(line), secondary, &mut block, false) == ScanResult::Words;
            words
                && block
                    .words
                    .iter()
                    .any(|word| Some(word.register) == self.channel.tables.registers.g && word.value == END)
        });
        self.work(passed)?;
        let text = match end {
            Some(end) => {
                format!("the data of '{}' are not kept: lines {next} to {end} set nothing", self.channel.block_text())
            }
            None => format!("no G11 ends the data of '{}'; they are not kept", self.channel.block_text()),
        };
        if let Some(frame) = self.flow.frame()
            && let Some(end) = end
        {
            (frame.next, frame.offset) = (end + 1, 0);
        }
        self.diagnose(&diag::DATA_BLOCKS, text);
        Ok(())
    }
}
