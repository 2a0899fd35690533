//! Executes a block part by part in the documented order.
//!
//! Facts: LinuxCNC documentation, "Order of execution". Words that the kernel itself orders form one block. Codes that
//! need the position after other words of their block (G10, G28, G92, cycles, absolute arc centres) act after these
//! words. *Invariant:* a part is executed once.

use std::collections::VecDeque;

use counterpoint_fault as diag;
use counterpoint_machine::ident::codes as ids;

use super::block::{BlockModes, BlockWord, BlockWords};
use super::codes::{NO_MOTION, is_cycle};
use super::line::{Rs274Item, Rs274Line};
use super::offsets::OWN_RADIUS;
use super::text::Rs274Mistake;
use super::{Outcome, PendingBlock, Rs274, Rs274Modes};
use counterpoint_control_api::host::{IdentificationAnswer, InterpreterHost, ModalSnapshot};
use counterpoint_control_api::interpreter::Remaining;
use counterpoint_control_api::words::Span;

/// Part of a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum BlockPart {
    /// Words that act before the other parts.
    Before,
    /// The preset in the direction of another work offset.
    Preset,
    /// G10, G52, G92, and codes that store positions.
    Statement,
    Motion,
    /// The parameters of a probing move.
    Probed,
    /// Stops and ends.
    Stops,
}

/// Modes that M70 or M73 saved.
#[derive(Debug, Clone)]
pub(super) struct SavedModes {
    /// Number of running subprograms at that time.
    depth: usize,
    /// The modes are restored at the end of the subprogram.
    returns: bool,
    kernel: ModalSnapshot,
    own: Rs274Modes,
}

impl Rs274 {
    /// Executes a block; the remaining words are left for the kernel.
    pub(super) fn carry_out(&mut self, host: &mut dyn InterpreterHost, text: &[u8]) -> Outcome<Remaining> {
        self.pending.parts.clear();
        let place = host.place();
        let line = self.read_line((place.file, place.line), text, place.as_read);
        let line = match &*line {
            Ok(line) => line,
            Err(mistake) => return Err(mistake.clone().into()),
        };
        if line.skip && host.skips(None) {
            return Ok(Remaining::Nothing);
        }
        if line.for_sender {
            let text = String::from_utf8_lossy(text).trim().to_owned();
            let why = format!("'{text}' is a line for the sender of the program and has no effect here");
            host.diagnose(&diag::SENDER_LINE, why);
            return Ok(Remaining::Nothing);
        }
        if line.percent {
            self.percent(host)?;
            return Ok(Remaining::Nothing);
        }
        if let Some(number) = line.number {
            host.set_sequence(number);
        }
        if let Some(code) = &line.flow {
            self.o_code(host, code)?;
            return Ok(Remaining::Nothing);
        }
        let words = self.evaluate(host, line)?;
        if let Some(comment) = line.comment.filter(|_| self.kind.has_language()) {
            self.comment(host, text, comment)?;
        }
        self.begin_block(host, words)
    }

    /// Evaluates the words of a block; assignments take effect after all values have been read.
    fn evaluate(&mut self, host: &mut dyn InterpreterHost, line: &Rs274Line) -> Outcome<BlockWords> {
        let (mut words, mut settings) = (BlockWords::default(), Vec::new());
        for item in &line.items {
            match item {
                Rs274Item::Word(word) => {
                    let value = self.value(host, &word.value)?;
                    let (letter, spelled, span) = (word.letter, word.spelled.clone(), word.span);
                    words.add(BlockWord { letter, value, spelled, span }, self.kind)?;
                }
                Rs274Item::Set(name, value) => {
                    let target = self.target(host, name)?;
                    settings.push((target, self.value(host, value)?));
                }
            }
        }
        for (target, value) in settings {
            self.set(host, &target, value)?;
        }
        Ok(words)
    }

    fn begin_block(&mut self, host: &mut dyn InterpreterHost, mut words: BlockWords) -> Outcome<Remaining> {
        if words.words.is_empty() && words.g.is_empty() && words.m.is_empty() {
            return Ok(Remaining::Nothing);
        }
        let inverse_time = host.is_active(ids::FEED_1T);
        let has_feed = host.feed() > 0.0;
        let off_plane = match () {
            () if host.is_active(ids::PLANE_ZX) => b'j',
            () if host.is_active(ids::PLANE_YZ) => b'i',
            () => b'k',
        };
        let modes = BlockModes { kind: self.kind, motion: self.modes.motion, inverse_time, has_feed, off_plane };
        words.check(modes)?;
        self.own_functions(host, &words)?;
        let has = |code: &[u16]| words.g.iter().any(|(known, _)| code.contains(known));
        let statement = has(&[100, 281, 301, 520, 920, 921, 922, 923]);
        let goes_home = has(&[280, 300]);
        let probes = matches!(words.motion, Some(382..=385));
        let changes_system = words.g.iter().any(|(code, _)| (540..=593).contains(code));
        let preset = changes_system && self.preset_turns(host);
        if !statement && !goes_home && !probes && !preset && !self.needs_position(host, &words) {
            return self.at_once(host, words);
        }
        let parts = [
            (BlockPart::Before, true),
            (BlockPart::Preset, preset),
            (BlockPart::Statement, statement),
            (BlockPart::Motion, words.motion.is_some() || goes_home),
            (BlockPart::Probed, probes),
            (BlockPart::Stops, true),
        ];
        let parts: VecDeque<BlockPart> = parts.iter().filter(|(_, is)| *is).map(|(part, _)| *part).collect();
        self.pending = PendingBlock { words, parts };
        self.next_part(host)
    }

    /// Leaves the words of a block that the kernel itself orders.
    fn at_once(&mut self, host: &mut dyn InterpreterHost, words: BlockWords) -> Outcome<Remaining> {
        let before = self.push_before(host, &words)?;
        let moves = self.push_motion(host, &words)?;
        let stops = self.push_stops(host, &words)?;
        Ok(if before || moves || stops { Remaining::Words } else { Remaining::Nothing })
    }

    /// Executes parts up to the first part that leaves words.
    pub(super) fn next_part(&mut self, host: &mut dyn InterpreterHost) -> Outcome<Remaining> {
        while let Some(part) = self.pending.parts.pop_front() {
            let words = std::mem::take(&mut self.pending.words);
            let done = self.part(host, part, &words);
            self.pending.words = words;
            if done? {
                if !self.pending.parts.is_empty() {
                    host.continue_block();
                }
                return Ok(Remaining::Words);
            }
        }
        Ok(Remaining::Nothing)
    }

    /// Executes a part. Returns whether it left words.
    fn part(&mut self, host: &mut dyn InterpreterHost, part: BlockPart, words: &BlockWords) -> Outcome<bool> {
        match part {
            BlockPart::Before => self.push_before(host, words),
            BlockPart::Preset => {
                self.apply_preset(host);
                Ok(false)
            }
            BlockPart::Statement => self.statement(host, words).map(|()| false),
            BlockPart::Motion if words.has_g(280) || words.has_g(300) => {
                self.go_home(host, words, usize::from(words.has_g(300)))
            }
            BlockPart::Motion => self.push_motion(host, words),
            BlockPart::Probed => self.probed(host).map(|()| false),
            BlockPart::Stops => self.push_stops(host, words),
        }
    }

    /// Whether the motion depends on the position after the other words of the block.
    fn needs_position(&self, host: &dyn InterpreterHost, words: &BlockWords) -> bool {
        let absolute = words.has_g(901) || self.modes.absolute_centers && !words.has_g(911);
        match words.motion {
            _ if words.has_polar() => true,
            Some(20 | 30) => absolute && !words.has(b'r'),
            Some(50..=53 | 331 | 760) => true,
            Some(motion) if is_cycle(motion) => true,
            Some(0 | 10) => words.has_g(530) && (words.has_g(910) || host.relative() && !words.has_g(900)),
            _ => false,
        }
    }

    /// Adds the words that act before any motion.
    fn push_before(&mut self, host: &mut dyn InterpreterHost, words: &BlockWords) -> Outcome<bool> {
        let mut wrote = false;
        for (code, span) in &words.g {
            wrote |= self.push_g(host, words, *code, *span)?;
        }
        for (code, span) in &words.m {
            if *code == 6
                && let Some(row) = host.literal("SPINDLE OFF AT M6")
            {
                host.push_literal(row, *span);
            }
            if matches!(code, 3..=9 | 19 | 48 | 49) || matches!(code, 100..=199) {
                push_code(host, b'M', f64::from(*code), *span);
                wrote = true;
            }
        }
        let moves = words.motion.is_some_and(|motion| motion != NO_MOTION) && words.has_axes();
        for word in &words.words {
            let is = match word.letter {
                b'f' => !moves,
                b's' | b't' => true,
                b'r' => words.has_m(19),
                b'p' => words.has_g(40),
                _ => false,
            };
            if word.letter == b't' {
                self.modes.selected = Some(word.value as u32);
            }
            // GRBL stores the tool number but does not use it.
            if is && (self.kind.has_language() || word.letter != b't') {
                push_word(host, word)?;
                wrote = true;
            }
        }
        Ok(wrote)
    }

    /// The number of the tool after the tool change of the block.
    fn tool_of(&self, host: &dyn InterpreterHost, words: &BlockWords) -> u32 {
        let said = words.get(b't').map(|tool| tool as u32).or(self.modes.selected);
        said.filter(|_| words.has_m(6)).unwrap_or_else(|| host.tool())
    }

    /// Executes a G code that is not a motion. Returns whether it left words.
    fn push_g(&mut self, host: &mut dyn InterpreterHost, words: &BlockWords, code: u16, span: Span) -> Outcome<bool> {
        let letter = |host: &mut dyn InterpreterHost, letter: u8, value: f64| push_value(host, letter, value, span);
        match code {
            901 | 911 => {
                self.modes.absolute_centers = code == 901;
                return Ok(false);
            }
            430 => {
                let number = words.get(b'h').filter(|number| *number != 0.0);
                let number = number.unwrap_or_else(|| f64::from(self.tool_of(host, words)));
                push_code(host, b'G', 43.0, span);
                letter(host, b'H', number)?;
            }
            431 | 432 => {
                let number = self.own_length(host, words, code == 432)?;
                push_code(host, b'G', 43.0, span);
                letter(host, b'H', f64::from(number))?;
            }
            410 | 420 => {
                let number = words.get(b'd').filter(|number| *number != 0.0);
                let number = number.unwrap_or_else(|| f64::from(self.tool_of(host, words)));
                push_code(host, b'G', f64::from(code) / 10.0, span);
                letter(host, b'D', number)?;
            }
            411 | 421 => {
                if words.has(b'l') {
                    let text = "L of G41.1 is the orientation of a turning tool, which this machine does not have";
                    return Err(Rs274Mistake::new(&diag::REFUSED, 20, text).into());
                }
                let diameter = words.get(b'd').unwrap_or(0.0) * host.length_factor();
                host.set_tool_size(OWN_RADIUS, 1, diameter / 2.0);
                push_code(host, b'G', f64::from(code / 10), span);
                letter(host, b'D', f64::from(OWN_RADIUS))?;
            }
            960 => {
                push_code(host, b'G', 96.0, span);
                if let Some(limit) = words.get(b'd') {
                    let row = host.literal("MAXIMUM SPEED");
                    row.into_iter().for_each(|row| host.push_literal(row, span));
                    push_named(host, "LIMIT", limit, span);
                }
            }
            40
            | 70
            | 80
            | 170
            | 180
            | 190
            | 200
            | 210
            | 400
            | 490
            | 530..=640
            | 900
            | 910
            | 930
            | 940
            | 950
            | 970..=990 => {
                if code == 530 && self.needs_position(host, words) {
                    return Ok(false);
                }
                let had_inverse_time = host.is_active(ids::FEED_1T);
                push_code(host, b'G', f64::from(code) / 10.0, span);
                // LinuxCNC resets the feed to 0; GRBL keeps the feed unless G93 was active.
                if matches!(code, 940 | 950) && !words.has(b'f') && (had_inverse_time || !self.kind.is_firmware()) {
                    letter(host, b'F', 0.0)?;
                }
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    fn push_stops(&mut self, host: &mut dyn InterpreterHost, words: &BlockWords) -> Outcome<bool> {
        let mut wrote = false;
        for (code, span) in &words.m {
            match code {
                0 | 1 | 2 | 30 | 60 => {
                    push_code(host, b'M', f64::from(*code), *span);
                    wrote = true;
                }
                98 => {
                    let (number, passes) = (words.get(b'p').unwrap_or(0.0), words.get(b'l').unwrap_or(1.0));
                    self.call_program(host, number, passes)?;
                }
                99 => host.return_from(),
                _ => {}
            }
        }
        Ok(wrote)
    }

    /// Executes the M codes that belong to the interpreter.
    fn own_functions(&mut self, host: &mut dyn InterpreterHost, words: &BlockWords) -> Outcome<()> {
        for (code, _) in &words.m {
            match code {
                61 => {
                    let text = "M61 sets the tool without a tool change, which is not emulated: write T and M6";
                    return Err(Rs274Mistake::new(&diag::UNKNOWN_CODE, 20, text).into());
                }
                66 => self.read_input(host, words)?,
                70 | 73 => {
                    let (depth, returns) = (self.parameters.depth(), *code == 73);
                    let saved = SavedModes { depth, returns, kernel: host.modes(), own: self.modes.clone() };
                    self.saved.retain(|saved| saved.depth != depth);
                    self.saved.push(saved);
                }
                71 => {
                    let depth = self.parameters.depth();
                    self.saved.retain(|saved| saved.depth != depth);
                }
                72 => {
                    let depth = self.parameters.depth();
                    match self.saved.iter().position(|saved| saved.depth == depth) {
                        Some(at) => self.restore(host, at),
                        None => {
                            let text = "M72 has no saved modes: write M70 before it in the same subprogram";
                            return Err(Rs274Mistake::new(&diag::REFUSED, 20, text).into());
                        }
                    }
                }
                100..=199 if !host.knows_code(b'M', f64::from(*code)) => {
                    let text = format!("M{code} is a user-defined program: add a row for the word to the machine");
                    return Err(Rs274Mistake::new(&diag::UNKNOWN_CODE, 20, text).into());
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// M66: reads the answer of the identification macro; without an answer #5399 keeps its value.
    fn read_input(&mut self, host: &mut dyn InterpreterHost, words: &BlockWords) -> Outcome<()> {
        if words.get(b'l').is_some_and(|how| how.round() > 0.0) {
            if words.has(b'e') {
                let text = "M66 reads the analogue input E at once, so L is 0: remove L";
                return Err(Rs274Mistake::new(&diag::REFUSED, 20, text).into());
            }
            if words.get(b'q').is_none_or(|seconds| seconds <= 0.0) {
                let text = "M66 waits for the input (L), but has no limit: write Q, the seconds, above 0";
                return Err(Rs274Mistake::new(&diag::REFUSED, 28, text).into());
            }
        }
        if host.keeps_moves_back() {
            let text = "M66 is not possible under cutter compensation: write G40 before";
            return Err(Rs274Mistake::new(&diag::REFUSED, 20, text).into());
        }
        if [b'p', b'e'].iter().any(|letter| words.get(*letter).is_some_and(|input| input.round() < 0.0)) {
            return Err(Rs274Mistake::new(&diag::REFUSED, 4, "the number of an input of M66 is negative").into());
        }
        let input = match (words.get(b'p'), words.get(b'e')) {
            (Some(input), None) => format!("M66 P{input}"),
            (None, Some(input)) => format!("M66 E{input}"),
            _ => {
                let text = "M66 needs either P or E, the number of an input";
                return Err(Rs274Mistake::new(&diag::REFUSED, 28, text).into());
            }
        };
        if let IdentificationAnswer::Instead(answer) = host.identify(&input, None)?.unless(&input)
            && let Ok(value) = answer.trim().parse()
        {
            self.parameters.set_number(5399, value)?;
        }
        Ok(())
    }

    fn restore(&mut self, host: &mut dyn InterpreterHost, at: usize) {
        let Some(saved) = self.saved.get(at) else { return };
        host.restore_modes(&saved.kernel);
        self.modes = Rs274Modes { selected: self.modes.selected, ..saved.own.clone() };
    }

    /// Restores the modes that M73 saved in a subprogram when the subprogram returns.
    pub(super) fn restore_on_return(&mut self, host: &mut dyn InterpreterHost) {
        let depth = self.parameters.depth();
        if let Some(at) = self.saved.iter().position(|saved| saved.depth == depth && saved.returns) {
            self.restore(host, at);
        }
        self.saved.retain(|saved| saved.depth < depth);
    }
}

/// Adds a code.
pub(super) fn push_code(host: &mut dyn InterpreterHost, letter: u8, value: f64, span: Span) {
    if let Some(register) = host.register(letter) {
        host.push_value(register, value, Some(&value.to_string()), span);
    }
}

/// Adds a word as the program writes it.
pub(super) fn push_word(host: &mut dyn InterpreterHost, word: &BlockWord) -> Outcome<()> {
    let letter = word.letter.to_ascii_uppercase();
    let Some(register) = host.register(letter) else { return Err(super::offsets::no_axis(letter).into()) };
    match &word.spelled {
        Some(spelled) => host.push_value(register, word.value, Some(spelled), word.span),
        None => host.push_computed(register, word.value, word.span),
    }
    Ok(())
}

/// Adds a word with a value.
pub(super) fn push_value(host: &mut dyn InterpreterHost, letter: u8, value: f64, span: Span) -> Outcome<()> {
    let Some(register) = host.register(letter) else { return Err(super::offsets::no_axis(letter).into()) };
    host.push_computed(register, value, span);
    Ok(())
}

pub(super) fn push_named(host: &mut dyn InterpreterHost, name: &str, value: f64, span: Span) {
    if let Some(register) = host.register_named(name) {
        host.push_computed(register, value, span);
    }
}
