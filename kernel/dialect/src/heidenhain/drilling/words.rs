//! The blocks of a hole: their words.
//!
//! *Invariant:* a feed from which on a parameter means rapid is FMAX; feeds have their M function once a program has
//! used a feed per revolution.

use super::super::cycles::RAPID;
use super::Hole;
use crate::host::{Host, MadeWord};
use counterpoint_machine::index::{CodeRowId, RegisterId};

/// Words of the machine that holes need.
#[derive(Debug, Clone, Copy)]
pub(in super::super) struct HoleWords {
    line: Option<CodeRowId>,
    rapid: Option<CodeRowId>,
    uncompensated: Option<CodeRowId>,
    dwell: Option<CodeRowId>,
    time: Option<(RegisterId, bool)>,
}

impl HoleWords {
    /// As the tables of the machine have them.
    pub(super) fn of(host: &dyn Host) -> Self {
        Self {
            line: host.literal("L"),
            rapid: host.literal("FMAX"),
            uncompensated: host.literal("R0"),
            dwell: host.literal("FUNCTION DWELL"),
            time: host.register_named("TIME"),
        }
    }
}

impl Hole<'_> {
    fn text(&mut self, row: Option<CodeRowId>) {
        if let Some(row) = row {
            self.blocks.push_text(row);
        }
    }

    fn add(&mut self, register: Option<(RegisterId, bool)>, value: f64) {
        let Some((register, incremental)) = register else { return };
        // As values are written in a block.
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

    /// Straight to a level at rapid, without compensation of the radius.
    pub(super) fn rapid(&mut self, level: f64) {
        self.text(self.words.line);
        self.letter(b'Z', level);
        self.text(self.words.uncompensated);
        self.text(self.words.rapid);
        self.blocks.end();
        self.control.path.rates.rapid_before = true;
    }

    /// Straight to a level with a feed.
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

    /// The feed alone.
    pub(super) fn set_feed(&mut self, feed: f64) {
        self.feed_word(feed);
        self.blocks.end();
    }

    /// An M function of the spindle.
    pub(super) fn function(&mut self, number: f64) {
        self.control.variables.control.function(number);
        self.letter(b'M', number);
        self.blocks.end();
    }

    /// A dwell in seconds; none at 0.
    pub(super) fn dwell(&mut self, time: f64) {
        if time == 0.0 {
            return;
        }
        self.text(self.words.dwell);
        self.add(self.words.time, time);
        self.blocks.end();
    }
}
