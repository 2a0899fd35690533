//! Stage *split*: the text of a block becomes words, unless it is a statement for the pre-processor.
//!
//! Facts: reference control-emulator.md 2.2.

use counterpoint_control_api::ProgramHost as _;
use counterpoint_program::scan::ScanResult;

use crate::channel::Kernel;
use crate::channel::macro_queries::block_scanner;

/// Splits a text into words, unless it is for the pre-processor.
#[inline(always)]
pub fn split(kernel: &mut Kernel<'_>, text: &[u8], preprocess: bool) -> ScanResult {
    // Without macros a known one does not come here.
    if preprocess && kernel.flow.repeats && kernel.plan.hooks.is_some() && is_known_statement(kernel) {
        return ScanResult::Statement;
    }
    let (tables, own) = (kernel.channel.tables, block_scanner(kernel.plan, &kernel.channel, &kernel.macros));
    let scanner = own.as_deref().unwrap_or(&tables.scanner);
    let (secondary, watched) = (kernel.channel.state.secondary, kernel.flow.watched);
    match preprocess {
        true => scanner.scan(text, secondary, &mut kernel.channel.block, watched),
        false => scanner.scan_as(text, secondary, &mut kernel.channel.block, false),
    }
}

/// Whether the pre-processor has executed this line of the program before.
fn is_known_statement(kernel: &mut Kernel<'_>) -> bool {
    let (line, interpreter) = (kernel.unchanged_line(), kernel.dialect.interpreter.as_deref_mut());
    line.zip(interpreter).is_some_and(|(line, interpreter)| interpreter.executes(line))
}

/// Splits the text of the block again, as macros have changed it; the pre-processor has had its turn.
pub fn split_again(kernel: &mut Kernel<'_>) {
    let Some(text) = kernel.channel.context.text.clone() else { return };
    split(kernel, text.as_bytes(), false);
}
