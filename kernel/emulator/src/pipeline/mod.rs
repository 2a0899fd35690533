//! The path of one block: read, edit, pre-process, split, codes, leftovers, follow.
//!
//! Each stage is a function in a file of its own. A machine with macros adds hooks between the stages (`plan.hooks`); a
//! machine without macros has none of them and goes the same way. *Invariant:* there is one path for all blocks, with
//! any source of their text or words. Facts: reference control-emulator.md 2.2, 2.3.

mod beside_motion;
pub mod codes;
mod contour;
mod cycle_blocks;
mod data_blocks;
mod definitions;
pub mod edit;
pub mod follow;
pub mod implied;
pub mod leftovers;
mod long_comments;
mod messages;
mod owned_words;
mod preprocess;
pub mod read;
mod speed_words;
pub mod split;
mod unit_named;

use counterpoint_channel::macro_queries::has_embedded;
use counterpoint_fault::Acted;
use counterpoint_program::scan::ScanResult;

use crate::channel::Kernel;
use crate::channel::hook_points::{BlockOrigin, BlockTreatment};
use crate::channel::known_blocks::{keep_block, may_only_lead_on};
use crate::pipeline::messages::show_messages_of_block;
use crate::pipeline::preprocess::statement_block;
use crate::pipeline::split::split;
use counterpoint_channel::trace::trace_words;

/// Processes a block from its text to its remaining words: edit, pre-process, split, codes, leftovers.
#[inline(always)]
pub fn process_block(kernel: &mut Kernel<'_>, text: &[u8]) -> Acted {
    let hooks = kernel.plan.hooks;
    let edited = match hooks {
        Some(hooks) => (hooks.block.edit)(kernel)?,
        None => BlockTreatment::Preprocess,
    };
    if edited == BlockTreatment::Dropped {
        return Ok(());
    }
    let (own, preprocess) = (kernel.channel.context.text.clone(), edited == BlockTreatment::Preprocess);
    let text = own.as_deref().map_or(text, String::as_bytes);
    match split(kernel, text, preprocess) {
        ScanResult::Words => {
            if kernel.channel.env.trace.is_some() && !has_embedded(&kernel.channel, &kernel.macros, 1) {
                kernel.trace_deleted(text);
            }
            if let Some(hooks) = hooks.filter(|_| preprocess) {
                (hooks.block.preprocessed)(kernel)?;
            }
            act_words(kernel)?;
            if kernel.flow.repeats && hooks.is_none() && may_only_lead_on(&kernel.channel, &kernel.flow) {
                keep_block(kernel.plan, &kernel.channel, &mut kernel.flow, text);
            }
            Ok(())
        }
        ScanResult::Statement => statement_block(kernel, text),
    }
}

/// Continues with the words of a block: messages, codes, leftovers.
pub fn act_words(kernel: &mut Kernel<'_>) -> Acted {
    let hooks = kernel.plan.hooks;
    if let Some(hooks) = hooks
        && !(hooks.block.words)(kernel)?
    {
        return Ok(());
    }
    if kernel.channel.env.trace.is_some() {
        trace_words(&mut kernel.channel);
    }
    match hooks {
        Some(hooks) => (hooks.block.remarks)(kernel)?,
        None if kernel.channel.block.messages.is_empty() => {}
        None => show_messages_of_block(kernel),
    }
    kernel.codes(BlockOrigin::Text)
}
