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
mod follow;
pub mod implied;
pub mod leftovers;
mod long_comments;
mod messages;
mod owned_words;
mod preprocess;
pub mod read;
mod speed_words;
mod split;
mod unit_named;

use counterpoint_fault::Acted;
use counterpoint_program::scan::ScanResult;

use crate::channel::Kernel;
use crate::channel::hook_points::BlockOrigin;
use crate::channel::hook_points::BlockTreatment;
use crate::channel::known_blocks::keep_block;
use crate::channel::known_blocks::may_only_lead_on;
use counterpoint_channel::macro_queries::has_embedded;

impl Kernel<'_> {
    /// Processes a block from its text to its remaining words: edit, pre-process, split, codes, leftovers.
    #[inline(always)]
    pub fn block(&mut self, text: &[u8]) -> Acted {
        let hooks = self.plan.hooks;
        let edited = match hooks {
            Some(hooks) => (hooks.block.edit)(self)?,
            None => BlockTreatment::Preprocess,
        };
        if edited == BlockTreatment::Dropped {
            return Ok(());
        }
        let (own, preprocess) = (self.channel.context.text.clone(), edited == BlockTreatment::Preprocess);
        let text = own.as_deref().map_or(text, String::as_bytes);
        match self.split(text, preprocess) {
            ScanResult::Words => {
                if self.channel.env.trace.is_some() && !has_embedded(&self.channel, &self.macros, 1) {
                    self.trace_deleted(text);
                }
                if let Some(hooks) = hooks.filter(|_| preprocess) {
                    (hooks.block.preprocessed)(self)?;
                }
                self.words()?;
                if self.flow.repeats && hooks.is_none() && may_only_lead_on(&self.channel, &self.flow) {
                    keep_block(self.plan, &self.channel, &mut self.flow, text);
                }
                Ok(())
            }
            ScanResult::Statement => self.statement_block(text),
        }
    }

    /// Continues with the words of a block: messages, codes, leftovers.
    pub fn words(&mut self) -> Acted {
        let hooks = self.plan.hooks;
        if let Some(hooks) = hooks
            && !(hooks.block.words)(self)?
        {
            return Ok(());
        }
        if self.channel.env.trace.is_some() {
            self.trace_words();
        }
        match hooks {
            Some(hooks) => (hooks.block.remarks)(self)?,
            None if self.channel.block.messages.is_empty() => {}
            None => self.show_messages_of_block(),
        }
        self.codes(BlockOrigin::Text)
    }
}
