//! Words of the blocks of a hole.
//!
//! *Invariant:* a feed at or above the rapid limit is written as FMAX; once a program has used a feed per revolution,
//! every feed has its M function.

use super::super::moves::RAPID;
use super::HeidenhainHoleBuilder;
use counterpoint_control_api::host::{InterpreterHost, MadeWord};
use counterpoint_machine::index::{CodeRowId, RegisterId};

/// The machine's words for holes.
#[derive(Debug, Clone, Copy)]
pub(in super::super) struct HoleWords {
    line: Option<CodeRowId>,
    rapid: Option<CodeRowId>,
    uncompensated: Option<CodeRowId>,
    dwell: Option<CodeRowId>,
    time: Option<(RegisterId, bool)>,
}

impl HoleWords {
    /// Looks the words up in the tables of the machine.
    pub(super) fn of(host: &dyn InterpreterHost) -> Self {
        Self {
            line: host.literal("L"),
            rapid: host.literal("FMAX"),
            uncompensated: host.literal("R0"),
            dwell: host.literal("FUNCTION DWELL"),
            time: host.register_named("TIME"),
        }
    }
}

impl HeidenhainHoleBuilder<'_> {
    fn text(&mut self, row: Option<CodeRowId>) {
        if let Some(row) = row {
            self.blocks.push_text(row);
        }
    }

    fn add(&mut self, register: Option<(RegisterId, bool)>, value: f64) {
        let Some((register, incremental)) = register else { return };
        // The precision of a written value.
        let value = if value.abs() < 1e6 { (value * 1e9).round() / 1e9 } else { value };
        self.blocks.push(MadeWord { register, incremental, value: value + 0.0, written: None, span: (0, 0) });
    }

    fn letter(&mut self, letter: u8, value: f64) {
        let register = self.host.register(letter);
        self.add(register, value);
    }

    fn feed_word(&mut self, feed: f64) {
        if let Some(function) = self.control.units.function_of_feed() {
            self.letter(b'M', function);
        }
        self.letter(b'F', feed);
    }

    /// Moves straight to a level at rapid, without radius compensation.
    pub(super) fn rapid(&mut self, level: f64) {
        self.text(self.words.line);
        self.letter(b'Z', level);
        self.text(self.words.uncompensated);
        self.text(self.words.rapid);
        self.blocks.end();
        self.control.path.rates.rapid_before = true;
    }

    /// Moves straight to a level at a feed.
    pub(super) fn line(&mut self, level: f64, feed: f64) {
        let is_rapid = feed >= RAPID;
        self.text(self.words.line);
        self.letter(b'Z', level);
        if is_rapid {
            self.text(self.words.rapid);
        } else {
            self.feed_word(feed);
        }
        self.blocks.end();
        self.control.path.rates.rapid_before = is_rapid;
    }

    /// Sets the feed in a block of its own.
    pub(super) fn set_feed(&mut self, feed: f64) {
        self.feed_word(feed);
        self.blocks.end();
    }

    /// Executes an M function of the spindle.
    pub(super) fn function(&mut self, number: f64) {
        self.control.variables.control.function(number);
        self.letter(b'M', number);
        self.blocks.end();
    }

    /// Dwells for a time in seconds; 0 adds no block.
    pub(super) fn dwell(&mut self, time: f64) {
        if time == 0.0 {
            return;
        }
        self.text(self.words.dwell);
        self.add(self.words.time, time);
        self.blocks.end();
    }
}
