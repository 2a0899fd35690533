//! The effect of a block on the flow, without executing it.
//!
//! *Invariant:* subprograms and partners of O codes are found as the interpreter finds them.

use super::Rs274;
use super::line::{OCode, OLabel, OWord, Rs274Item, Rs274Line, numbered, read};
use super::places::OBlockKind;
use counterpoint_control_api::host::ProgramHost;
use counterpoint_control_api::outline::{CallOutline, JumpDestination, OutlineReader, OutlineStep};
use counterpoint_program::spot::BlockStart;

impl OutlineReader for Rs274 {
    fn outline(&mut self, programs: &mut dyn ProgramHost, text: &[u8]) -> Vec<OutlineStep> {
        let line = match read(text, self.kind.has_language()) {
            Ok(line) => line,
            Err(mistake) => return vec![OutlineStep::Mistake(mistake.text)],
        };
        if line.skip && programs.skips(None) {
            return Vec::new();
        }
        match &line.flow {
            Some(code) => self.outlined(programs, code).into_iter().collect(),
            None => self.words(programs, &line),
        }
    }
}

impl Rs274 {
    fn words(&mut self, programs: &mut dyn ProgramHost, line: &Rs274Line) -> Vec<OutlineStep> {
        let (mut plain, mut steps, mut called, mut passes) = (String::new(), Vec::new(), None, Some(1));
        let (mut calls, mut returns) = (false, false);
        for item in &line.items {
            let Rs274Item::Word(word) = item else { continue };
            let letter = char::from(word.letter.to_ascii_uppercase());
            match word.value.as_constant() {
                Some(value) if word.letter == b'm' && *value == 98.0 => calls = true,
                Some(value) if word.letter == b'm' && *value == 99.0 => returns = true,
                // The interpreter executes these itself.
                Some(value) if word.letter == b'm' && (50.0..74.0).contains(value) && *value != 60.0 => {}
                Some(_) if word.letter == b't' && !self.kind.has_language() => {}
                Some(value) if matches!(word.letter, b'm' | b't') => plain.push_str(&format!("{letter}{value} ")),
                Some(value) if word.letter == b'p' => called = Some(*value),
                Some(value) if word.letter == b'l' => passes = Some(*value as u32),
                Some(_) => {}
                None => steps.push(OutlineStep::Computed(letter.to_string())),
            }
        }
        if calls && let Some(number) = called {
            let name = numbered(&format!("{number:.0}"));
            let place = self.find_program(programs, &name).ok();
            steps.push(OutlineStep::Call(CallOutline { name: name.into(), place, passes }));
        }
        if returns {
            steps.push(OutlineStep::Return);
        }
        steps.insert(0, OutlineStep::Words(plain.into_bytes()));
        steps
    }

    fn outlined(&mut self, programs: &mut dyn ProgramHost, code: &OCode) -> Option<OutlineStep> {
        let place = programs.place();
        let after = |line: u32| OutlineStep::Jump(JumpDestination::At(BlockStart::line(line.saturating_add(1))));
        Some(match code.word {
            OWord::Call => {
                let OLabel::Text(name) = &code.label else {
                    return Some(OutlineStep::Hidden("the subprogram is computed".to_owned()));
                };
                let place = self.find_sub(programs, name).ok();
                OutlineStep::Call(CallOutline { name: name.to_string(), place, passes: Some(1) })
            }
            OWord::Return | OWord::EndSub => OutlineStep::Return,
            OWord::Sub => {
                let end = self.places(programs, place.file).end_of(place.line)?;
                if (place.range.first, place.range.last) == (place.line, end) {
                    return None;
                }
                after(end)
            }
            OWord::Program => return None,
            _ => match self.places(programs, place.file).block_of(place.line) {
                Some(block) if block.first == place.line => {
                    OutlineStep::Block { end: BlockStart::line(block.last), loops: block.kind != OBlockKind::If }
                }
                Some(_) => return None,
                None => OutlineStep::Mistake("the O code has no partner with its label".to_owned()),
            },
        })
    }
}
