//! What is left on a block after all its codes have acted.
//!
//! Facts: reference control-emulator.md 1.3 (unused data), 2.2 step 12.

use super::block::odd;
use super::state::feed_of;
use super::state::group;
use super::{Acted, Kernel};
use crate::diag;
use crate::machine::ident::data;

impl Kernel<'_> {
    /// Remembers modal values, diagnoses the rest.
    #[inline(always)]
    pub(crate) fn leftovers(&mut self) -> Acted {
        // A speed word left is a data word left.
        if self.block.has_leftovers() || self.block.has_oddities() { self.left_over() } else { Ok(()) }
    }

    #[inline(never)]
    fn left_over(&mut self) -> Acted {
        if self.has_any(self.plan.speed_registers) {
            crate::action::spindle::speed_word(self)?;
        }
        if self.block.has_leftovers() {
            for position in 0..self.block.words.len() {
                let Some(word) = self.block.words.get(position).copied() else { break };
                if !word.used {
                    self.leftover_word(word.register, word.value, (word.start, word.end));
                }
            }
        }
        if !self.block.has_oddities() {
            return Ok(());
        }
        self.left_name();
        if !self.block.unknown.is_empty() {
            self.unknown_text();
        }
        if self.block.odd & odd::OPEN_COMMENT != 0 {
            let text = format!("a comment or message has no end in '{}'", self.block_text());
            self.diagnose(&diag::COMMENT_OPEN, text);
        }
        if self.block.odd & odd::DIGITS != 0 {
            let text = format!("a number has more digits than its register's format in '{}'", self.block_text());
            self.diagnose(&diag::TOO_MANY_DIGITS, text);
        }
        if self.block.odd & odd::BYTES != 0 {
            let text = format!("control characters in line {} are passed over", self.line);
            self.diagnose(&diag::BAD_BYTES, text);
        }
        Ok(())
    }

    fn leftover_word(&mut self, register: u8, value: f64, span: (u32, u32)) {
        let machine = self.machine;
        let rows = machine.tables.data_of_register.get(usize::from(register)).map_or(&[][..], Vec::as_slice);
        let (feed, _) = feed_of(self.modal.code(group::FEED));
        let mut known = false;
        let mut axis = false;
        for &index in rows {
            let Some(row) = machine.data.get(usize::from(index)) else { continue };
            // A label that no call takes marks its block; the sequence number of a head tells and does nothing.
            if matches!(row.id, data::LABEL | data::SEQNO_MAIN | data::SEQNO_SIDE)
                || self.plan.ignore.get(usize::from(index)).copied().unwrap_or(false)
            {
                known = true;
                continue;
            }
            let is_axis = machine.data_name(row.id).starts_with("REG_AXIS_");
            axis |= is_axis;
            let other_feed = matches!(row.id, data::FEED_UPM | data::FEED_UPR | data::FEED_1T) && row.id != feed;
            if row.modal && !is_axis && !other_feed {
                let value = (value * row.mul + row.add) * self.unit_factor(row.dimension);
                self.modal.remember(row.id, value);
                known = true;
            } else if row.modal && other_feed {
                known = true;
            }
        }
        if known {
            return;
        }
        let word = self.span_text(span);
        let block = self.block_text();
        if axis && !self.channel_has(register) {
            self.diagnose(
                &diag::AXIS_NOT_IN_CHANNEL,
                format!("channel {} has no axis for {word} in '{block}', the word is dropped", self.rank),
            );
        } else if axis && self.modal.code(group::MOTION).is_none() {
            self.diagnose(&diag::NO_MOTION_MODE, format!("no motion code is active for {word} in '{block}'"));
        } else {
            self.diagnose(&diag::DATA_NOT_USED, format!("{word} is not used by anything in '{block}' and is dropped"));
        }
    }

    /// One of the channel's axes takes words of this register.
    fn channel_has(&self, register: u8) -> bool {
        self.place.axes.iter().any(|axis| {
            self.machine
                .tables
                .rows_of_data
                .get(usize::from(axis.data.0))
                .into_iter()
                .flatten()
                .filter_map(|&row| self.machine.data.get(usize::from(row)))
                .any(|row| row.register == Some(register))
        })
    }

    pub(crate) fn span_text(&self, (start, end): (u32, u32)) -> String {
        let line = self.text_bytes();
        String::from_utf8_lossy(line.get(start as usize..end as usize).unwrap_or_default()).trim().to_owned()
    }

    /// A program name at the begin of its block defines the program; elsewhere it is unknown text.
    pub(crate) fn left_name(&mut self) {
        let Some((start, _)) = self.block.name() else { return };
        let line = self.text_bytes();
        let before = line.get(..start as usize).unwrap_or_default();
        if before.iter().all(|byte| matches!(byte, b' ' | b'\t' | b'/')) {
            self.block.take_name();
        }
    }

    fn unknown_text(&mut self) {
        const MOST: usize = 60;
        let left = self.left_text();
        let mut text = left.split_whitespace().collect::<Vec<_>>().join(" ");
        if text.chars().count() > MOST {
            text = text.chars().take(MOST - 3).chain("...".chars()).collect();
        }
        if text.is_empty() {
            return;
        }
        let block = self.block_text();
        let hint = letter_for_zero(&text, &block);
        self.diagnose(&diag::NOT_RECOGNISED, format!("{text} not recognised in '{block}'{hint}"));
    }
}

/// What to say of a word of the block with the letter O where a zero is meant (`X5O`, `G O1`), if `left` has one.
fn letter_for_zero(left: &str, block: &str) -> String {
    let is_o = |c: char| matches!(c, 'O' | 'o');
    if !left.contains(is_o) {
        return String::new();
    }
    let number = |c: char| c.is_ascii_digit() || is_o(c) || matches!(c, '.' | '+' | '-');
    let mut rest = block;
    let mut before = ' ';
    while let Some(letter) = rest.chars().next() {
        let tail = rest.get(letter.len_utf8()..).unwrap_or_default();
        let address = letter.is_ascii_alphabetic() && !is_o(letter) && !before.is_ascii_alphabetic();
        if address {
            let length = tail.len() - tail.trim_start_matches(number).len();
            let (value, after) = tail.split_at(length);
            let letters = value.chars().filter(|c| is_o(*c)).count();
            let name = letters > 1 || after.starts_with(|c: char| c.is_ascii_alphabetic());
            let name = name && !value.contains(|c: char| c.is_ascii_digit());
            if letters > 0 && !name {
                return format!(": {letter}{value} has the letter O for a zero");
            }
        }
        (rest, before) = (tail, letter);
    }
    String::new()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_letter_for_a_zero_is_found_in_words() {
        let hint = |left: &str, block: &str| letter_for_zero(left, block);
        assert_eq!(hint("O", "G90 G0 X5O Y1."), ": X5O has the letter O for a zero");
        assert_eq!(hint("O.", "G1 X1O. F100"), ": X1O. has the letter O for a zero");
        assert_eq!(hint("GO", "GO X1."), ": GO has the letter O for a zero");
        assert_eq!(hint("o", "g1 z-o.5"), ": z-o.5 has the letter O for a zero");
        assert_eq!(hint("POCKET", "POCKET4(1)"), "");
        assert_eq!(hint("FOO O", "GOTO 1 FOO O"), "");
        assert_eq!(hint("NOISE", "G0 X1. NOISE"), "");
        assert_eq!(hint("Q", "G1 XO Q"), "");
    }
}
