//! Blocks that macros issue: EXEC processes one within the block in process, EXEC/NEXT leaves one for later.
//!
//! *Invariant:* words left in the block around them stay. Facts: reference control-emulator.md 4.4.

use std::sync::Arc;

use counterpoint_channel::block_places::blocks_of;
use counterpoint_channel::burden;
use counterpoint_channel::callee::Pending;
use counterpoint_channel::channel_context::Acting;
use counterpoint_channel::context::BlockContext;
use counterpoint_channel::macros::issued::Later;
use counterpoint_emulator::channel::hook_points::BlockOrigin;
use counterpoint_emulator::pipeline::process_block;
use counterpoint_emulator::pipeline::read::begin_block;
use counterpoint_event::event::{Kind, Listing};
use counterpoint_fault as diag;
use counterpoint_fault::{Acted, Halt};
use counterpoint_lang::value::MacroValue;
use counterpoint_program::block::Block;

use crate::context::MacroHooks;
use crate::host::block;

/// A block that another one within it interrupts.
struct Outer {
    block: Block,
    context: BlockContext,
    acting: Acting,
    /// Its requests at its end.
    pending: Option<Pending>,
}

impl MacroHooks<'_, '_> {
    /// Processes a block that EXEC/NEXT left, in place of reading one; none if nothing was left.
    pub(crate) fn next_issued(&mut self) -> Option<Acted> {
        let block = self.kernel.macros.issued.later.pop_front()?;
        self.name_block(&block);
        let done = begin_block(self.kernel).and_then(|()| self.process_later(block));
        Some(done.and_then(|()| self.kernel.follow()))
    }

    /// The blocks of a text that EXEC issues: as in a file, line ends and the machine's character end a block.
    pub(crate) fn blocks_of_text(&self, text: &str) -> Vec<Arc<String>> {
        let lines = text.split(['\n', '\r']).flat_map(|line| blocks_of(&self.kernel.channel, line.as_bytes()));
        lines.map(|(block, _)| Arc::new(String::from_utf8_lossy(block).into_owned())).collect()
    }

    /// Processes a text as a block.
    pub(crate) fn issued_block(&mut self, text: Arc<String>) -> Acted {
        self.kernel.channel.context.begin(Some(text));
        self.kernel.macros.variables.store.number = 0;
        process_block(self.kernel, &[])
    }

    /// Writes such a block to the listing: it is not a line of a file.
    fn name_block(&mut self, block: &Later) {
        let text = match block {
            Later::Text(text, _) => text.to_string(),
            Later::Items(items, _) => self.host().listed(items),
        };
        self.kernel.channel.emit(0, Kind::listing(Listing::Block(burden::shortened(&text).into())));
    }

    /// Processes such a block.
    fn process_later(&mut self, block: Later) -> Acted {
        let (Later::Text(_, matching) | Later::Items(_, matching)) = block;
        let set = |hooks: &mut Self, matching| {
            hooks.kernel.macros.hooks.matching = matching;
        };
        set(self, matching);
        let done = match block {
            Later::Text(text, _) => self.issued_block(text),
            Later::Items(items, _) => {
                self.kernel.channel.block.clear();
                self.item_block(&items)
            }
        };
        set(self, true);
        done
    }

    /// Processes a block inside another block, which keeps its remaining words.
    pub(crate) fn nested_block(&mut self, process: impl FnOnce(&mut Self) -> Acted) -> Acted {
        let outer = self.enter_block();
        // A block within a block is one, too.
        let begun = self.kernel.work(burden::BLOCK).and_then(|()| self.kernel.check_limits());
        let done = begun.and_then(|()| process(self)).and_then(|()| self.call_at_once());
        self.leave_block(outer);
        // The rest of the inner block is dropped, not that of the outer block.
        if done == Err(Halt::Dropped) { Ok(()) } else { done }
    }

    /// Puts the block in process aside for one within it.
    fn enter_block(&mut self) -> Outer {
        let mut inner = self.kernel.macros.issued.spares.pop().unwrap_or_default();
        inner.clear();
        Outer {
            block: std::mem::replace(&mut self.kernel.channel.block, inner),
            context: self.kernel.channel.context.enter(),
            acting: Acting { as_data: self.kernel.channel.acting.as_data.take(), ..self.kernel.channel.acting },
            pending: self.kernel.flow.pending.take(),
        }
    }

    /// Continues with the block that was set aside.
    fn leave_block(&mut self, outer: Outer) {
        let Outer { block, context, acting, pending } = outer;
        self.kernel.channel.acting = acting;
        // An end waits for the end of the block that was interrupted.
        match std::mem::replace(&mut self.kernel.flow.pending, pending) {
            Some(own) if self.kernel.flow.pending.is_some() => self.kernel.ask(own),
            Some(own) => self.kernel.flow.pending = Some(own),
            None => {}
        }
        self.kernel.channel.state.remembered.remember_sequence(self.kernel.channel.block.sequence);
        let nested = std::mem::replace(&mut self.kernel.channel.block, block);
        self.kernel.macros.issued.spares.push(nested);
        self.kernel.channel.context = context;
    }

    /// A block given as identifiers and values: straight to the code loop.
    pub(crate) fn item_block(&mut self, items: &[MacroValue]) -> Acted {
        self.kernel.channel.context.text = Some(Arc::default());
        let mut items = items.iter();
        while let Some(item) = items.next() {
            if let Some(id) = self.host().code_id(item) {
                if !self.host().add_code(id, 0.0) {
                    self.no_such_code(id);
                }
            } else if let Some(id) = self.host().data_id(item) {
                match items.next().and_then(MacroValue::as_real) {
                    Some(value) if block::knows_data(self.kernel.channel.env.machine, id) => {
                        self.kernel.channel.block.added.push((id, value))
                    }
                    Some(_) => {
                        let text =
                            format!("this machine has no word for {}", self.kernel.channel.env.machine.data_name(id));
                        self.kernel.diagnose(&diag::DATA_MISSING, text);
                    }
                    None => {
                        let text =
                            format!("EXEC needs a number after {}", self.kernel.channel.env.machine.data_name(id));
                        self.kernel.diagnose(&diag::MACRO_RESULT, text);
                    }
                }
            } else {
                let text = format!("EXEC takes codes, and data with their values, not {}", item.kind_name());
                self.kernel.diagnose(&diag::MACRO_RESULT, text);
            }
        }
        self.kernel.codes(BlockOrigin::Items)
    }

    /// Reports that EXEC or OUTPUT named a code without a row.
    pub(crate) fn no_such_code(&mut self, id: counterpoint_machine::ident::CodeId) {
        let name = self.kernel.channel.env.machine.code_name(id).to_owned();
        self.kernel.diagnose(&diag::CODE_NOT_HERE, format!("this machine has no {name}, it cannot act"));
    }
}
