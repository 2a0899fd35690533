//! Stages *pre-process* and *split*: the text of a block becomes words, or goes to the pre-processor as a statement.
//!
//! *Invariant:* a block whose words a pre-processor makes continues with the same stages as one that has them.

use counterpoint_fault::Acted;

use crate::channel::Kernel;
use crate::channel::hook_points::{Edited, Origin};
use crate::channel::scan::Kind as Split;

impl Kernel<'_> {
    /// Processes a block from its text up to what is left of it: edit, pre-process, split, codes, leftovers.
    #[inline(always)]
    pub(crate) fn block(&mut self, text: &[u8]) -> Acted {
        let hooks = self.plan.hooks;
        let edited = match hooks {
            Some(hooks) => (hooks.block.edit)(self)?,
            None => Edited::Preprocess,
        };
        if edited == Edited::Dropped {
            return Ok(());
        }
        let (own, preprocess) = (self.own_text(), edited == Edited::Preprocess);
        let text = own.as_deref().map_or(text, String::as_bytes);
        match self.split(text, preprocess) {
            Split::Words => {
                if self.channel.env.trace.is_some() && !self.has_embedded(1) {
                    self.trace_deleted(text);
                }
                if let Some(hooks) = hooks.filter(|_| preprocess) {
                    (hooks.block.preprocessed)(self)?;
                }
                self.words()
            }
            Split::Macro => self.statement_block(text),
        }
    }

    /// Splits a text into words, unless it is for the pre-processor.
    #[inline(always)]
    fn split(&mut self, text: &[u8], preprocess: bool) -> Split {
        let (plan, own) = (self.plan, self.block_scanner());
        let scanner = own.as_deref().unwrap_or(&plan.scanner);
        let (secondary, watched) = (self.channel.state.secondary, self.flow.watched);
        match preprocess {
            true => scanner.scan(text, secondary, &mut self.channel.block, watched),
            false => scanner.scan_as(text, secondary, &mut self.channel.block, false),
        }
    }

    /// Lets the pre-processor carry out a statement; the words that it makes act on the way.
    #[inline(never)]
    fn statement_block(&mut self, text: &[u8]) -> Acted {
        let hooks = self.plan.hooks;
        if let Some(hooks) = hooks {
            (hooks.block.statement)(self, text)?;
        }
        self.macro_line(text)?;
        hooks.map_or(Ok(()), |hooks| (hooks.block.consumed)(self))
    }

    /// Continues with words that the pre-processor made.
    pub(crate) fn made_words(&mut self) -> Acted {
        if let Some(hooks) = self.plan.hooks {
            (hooks.block.made)(self)?;
        }
        self.words()
    }

    /// Continues with the words of a block: messages, codes, leftovers.
    pub(crate) fn words(&mut self) -> Acted {
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
        self.codes(Origin::Text)
    }

    /// Splits the text of the block again, as macros have changed it; the pre-processor has had its turn.
    pub(crate) fn split_again(&mut self) {
        let Some(text) = self.own_text() else { return };
        self.split(text.as_bytes(), false);
    }

    #[cold]
    fn show_messages_of_block(&mut self) {
        let text = self.text_bytes().into_owned();
        self.show_messages(&text);
    }

    /// Operator messages act before anything else on their block (order 100, reference control-emulator.md 5.6).
    pub(crate) fn show_messages(&mut self, line: &[u8]) {
        for index in 0..self.channel.block.messages.len() {
            let Some(&(start, end)) = self.channel.block.messages.get(index) else { break };
            let text = line.get(start as usize..end as usize).unwrap_or_default();
            self.display(String::from_utf8_lossy(text).trim());
        }
        self.channel.block.messages.clear();
    }
}
