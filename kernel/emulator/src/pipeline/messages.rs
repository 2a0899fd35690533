//! Operator messages of a block.

use crate::channel::Kernel;

impl Kernel<'_> {
    #[cold]
    pub(crate) fn show_messages_of_block(&mut self) {
        let text = self.channel.text_bytes().into_owned();
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
