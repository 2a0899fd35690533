//! Rows of codes whose conditions are other words of the block (`with`, `without`).
//!
//! *Invariant:* of the rows of a word the first one that fits acts, and with it those that act beside another (`also`).

use crate::channel::Kernel;
use counterpoint_machine::index::CodeRowId;
use counterpoint_machine::rows::CodeRow;

impl Kernel<'_> {
    /// Whether the conditions of a row on other words of the block are met.
    pub(super) fn fits(&self, row: &CodeRow) -> bool {
        let with = row.with.is_empty() || row.with.iter().any(|&r| self.channel.block.has(r));
        with && row.without.iter().all(|&r| !self.channel.block.has(r))
    }

    /// The row of the same text whose conditions are met, or this one.
    #[cold]
    pub(super) fn fitting_text(&self, row: CodeRowId) -> CodeRowId {
        let machine = self.channel.env.machine;
        let same = |other: &&CodeRowId| machine.codes[**other].form == machine.codes[row].form;
        let rows = machine.tables.texts.iter().filter(same);
        rows.copied().find(|&other| self.fits(&machine.codes[other])).unwrap_or(row)
    }

    /// Second pass over words whose rows depend on other words of the block.
    pub(super) fn categorise_conditional(&mut self) {
        let machine = self.channel.env.machine;
        for position in 0..self.channel.block.words.len() {
            let Some(word) = self.channel.block.words.get(position).copied() else { break };
            if word.used {
                continue;
            }
            let candidates = machine.tables.code(word.register, word.value);
            if candidates.is_empty() {
                continue;
            }
            let mut rows = candidates.iter().map(|&index| (index, &machine.codes[index]));
            let chosen = rows.find(|(_, row)| self.fits(row));
            match chosen {
                Some((index, row)) => {
                    self.use_word(position);
                    self.queue(index, row, word.value, false);
                    while let Some((index, row)) = rows.find(|(_, row)| row.also && self.fits(row)) {
                        self.queue(index, row, word.value, false);
                    }
                }
                None => self.data_word(position),
            }
        }
    }
}
