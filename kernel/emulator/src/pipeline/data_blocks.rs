//! Data blocks of the program: parameters and tool life, which G10 begins and G11 ends.
//!
//! Facts: general CNC practice (Fanuc G10 L50). Decision: parameters and tool lives are not kept here, so their blocks
//! are skipped with one note. *Invariant:* a block of data neither moves an axis nor selects a tool; its lines are
//! counted as work.

use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_program::block::Block;
use counterpoint_program::scan::ScanResult;

use crate::channel::Kernel;

/// G number of the end of the data.
const END: f64 = 11.0;

/// Continues after the block that ends the data.
pub(crate) fn pass_data_blocks(kernel: &mut Kernel<'_>) -> Acted {
    let sources = kernel.channel.env.sources;
    let Some((file, next, last)) = kernel.flow.frame().map(|frame| (frame.file, frame.next, frame.range.last)) else {
        return Ok(());
    };
    let Some(source) = sources.get(file) else { return Ok(()) };
    let (scanner, secondary) = (&kernel.channel.tables.scanner, kernel.channel.state.secondary);
    let mut block = Block::default();
    let mut passed = 0_usize;
    let end = (next..=last).find(|&line| {
        passed += 1;
        let words = scanner.scan_as(source.line(line), secondary, &mut block, false) == ScanResult::Words;
        words
            && block
                .words
                .iter()
                .any(|word| Some(word.register) == kernel.channel.tables.registers.g && word.value == END)
    });
    kernel.work(passed)?;
    let text = match end {
        Some(end) => {
            format!("the data of '{}' are not kept: lines {next} to {end} set nothing", kernel.channel.block_text())
        }
        None => format!("no G11 ends the data of '{}'; they are not kept", kernel.channel.block_text()),
    };
    if let Some(frame) = kernel.flow.frame()
        && let Some(end) = end
    {
        (frame.next, frame.offset) = (end + 1, 0);
    }
    kernel.diagnose(&diag::DATA_BLOCKS, text);
    Ok(())
}
