//! Operator messages of a block.

use counterpoint_channel::burden::shortened;
use counterpoint_channel::macros::store::names;
use counterpoint_event::event::{Kind, OperatorMessage};
use counterpoint_lang::value::MacroValue;

use crate::channel::Kernel;
use counterpoint_channel::trace;
use counterpoint_channel::trace::trace_line;

impl Kernel<'_> {
    /// Operator messages act before anything else on their block (order 100, reference control-emulator.md 5.6).
    pub(crate) fn show_messages(&mut self, line: &[u8]) {
        for index in 0..self.channel.block.messages.len() {
            let Some(&(start, end)) = self.channel.block.messages.get(index) else { break };
            let text = line.get(start as usize..end as usize).unwrap_or_default();
            self.display(String::from_utf8_lossy(text).trim());
        }
        self.channel.block.messages.clear();
    }

    /// A message to the operator.
    pub fn display(&mut self, text: &str) {
        let text = shortened(text);
        if self.plan.hooks.is_some() {
            self.macros.variables.store.set(names().display, MacroValue::text(text));
        }
        trace_line(&mut self.channel, 'C', |_| trace::code("CODE_DISPLY"));
        self.channel.emit(0, Kind::Message(OperatorMessage { text: text.into(), printed: false }));
    }
}

#[cold]
pub(crate) fn show_messages_of_block(kernel: &mut Kernel<'_>) {
    let text = kernel.channel.text_bytes().into_owned();
    kernel.show_messages(&text);
}
