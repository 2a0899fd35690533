//! Executes O codes and calls.
//!
//! Facts: LinuxCNC documentation, "O codes". Decisions: the search for a subprogram begins in the file of the call,
//! then in the file of the main program, then in a file of its name; a call of an unknown name is an alarm. `return`
//! and `endsub` store their value in #<_value>.

use std::sync::Arc;

use super::line::{OCode, OLabel, OWord, numbered};
use super::places::{OBlock, OBlockKind, OCodeIndex};
use super::text::Rs274Mistake;
use super::{Outcome, Rs274, Rs274Stop};
use counterpoint_control_api::host::{InterpreterHost, ProgramHost, SubprogramCall};
use counterpoint_event::FileId;
use counterpoint_fault as diag;
use counterpoint_program::shape::ProgramRange;

fn loop_fault<T>(text: &str) -> Outcome<T> {
    Err(Rs274Mistake::new(&diag::MACRO_LOOP, 1, text).into())
}

impl Rs274 {
    /// The O codes of a file.
    pub(super) fn places(&mut self, host: &dyn ProgramHost, file: FileId) -> Arc<OCodeIndex> {
        self.places.get(file, || host.source(file).map(|source| OCodeIndex::of(&source)).unwrap_or_default())
    }

    fn go(&mut self, host: &mut dyn InterpreterHost, line: u32) -> Outcome<()> {
        self.caching = true;
        Ok(host.go_to(line)?)
    }

    /// The block of statements to which the current program block belongs.
    fn block_here(&mut self, host: &dyn ProgramHost) -> Outcome<OBlock> {
        let place = host.place();
        match self.places(host, place.file).block_of(place.line) {
            Some(block) => Ok(block.clone()),
            None => loop_fault("the O code has no partner with its label: write both with the same label"),
        }
    }

    fn is_true(&mut self, host: &mut dyn InterpreterHost, code: &OCode) -> Outcome<bool> {
        match code.values.first() {
            Some(condition) => Ok(self.value(host, condition)? != 0.0),
            None => Ok(true),
        }
    }

    /// The condition of a loop.
    fn repeats(&mut self, host: &mut dyn InterpreterHost, code: &OCode) -> Outcome<bool> {
        host.tests_loop(true);
        let holds = self.is_true(host, code);
        host.tests_loop(false);
        holds
    }

    /// Executes an O code.
    pub(super) fn o_code(&mut self, host: &mut dyn InterpreterHost, code: &OCode) -> Outcome<()> {
        let line = host.place().line;
        match code.word {
            OWord::Call => self.call(host, code),
            OWord::Return | OWord::EndSub => self.return_value(host, code),
            OWord::Sub => self.pass_sub(host, line),
            OWord::Program => self.pass_program(host, line),
            OWord::If => {
                let block = self.block_here(host)?;
                if self.is_true(host, code)? { Ok(()) } else { self.branch(host, &block) }
            }
            // The previous branch has run.
            OWord::ElseIf | OWord::Else => {
                let block = self.block_here(host)?;
                self.go(host, block.last.saturating_add(1))
            }
            OWord::EndIf | OWord::Do => self.block_here(host).map(|_| ()),
            OWord::While => {
                let block = self.block_here(host)?;
                let again = self.repeats(host, code)?;
                match block.kind {
                    OBlockKind::Do if again => self.go(host, block.first.saturating_add(1)),
                    OBlockKind::While if !again => self.go(host, block.last.saturating_add(1)),
                    _ => Ok(()),
                }
            }
            OWord::EndWhile => {
                let block = self.block_here(host)?;
                self.go(host, block.first)
            }
            OWord::Repeat => self.repeat(host, code),
            OWord::EndRepeat => self.next_pass(host),
            OWord::Break => {
                let block = self.block_here(host)?;
                self.parameters.repeats().remove(&block.first);
                self.go(host, block.last.saturating_add(1))
            }
            OWord::Continue => {
                let block = self.block_here(host)?;
                self.go(host, if block.kind == OBlockKind::While { block.first } else { block.last })
            }
        }
    }

    /// Continues after a false IF: at the first ELSEIF whose condition is true, otherwise at ELSE or at the end.
    fn branch(&mut self, host: &mut dyn InterpreterHost, block: &OBlock) -> Outcome<()> {
        let file = host.place().file;
        for mark in &block.marks {
            let line = self.line_of(host, file, *mark);
            let line = match &*line {
                Ok(line) => line,
                Err(mistake) => return Err(mistake.clone().into()),
            };
            let Some(code) = &line.flow else { continue };
            if self.is_true(host, code)? {
                return self.go(host, mark.saturating_add(1));
            }
        }
        self.go(host, block.last.saturating_add(1))
    }

    fn repeat(&mut self, host: &mut dyn InterpreterHost, code: &OCode) -> Outcome<()> {
        let block = self.block_here(host)?;
        let count = match code.values.first() {
            Some(count) => self.value(host, count)?.round(),
            None => 0.0,
        };
        if count < 1.0 {
            return self.go(host, block.last.saturating_add(1));
        }
        self.parameters.repeats().insert(block.first, count.min(f64::from(u32::MAX)) as u32);
        Ok(())
    }

    fn next_pass(&mut self, host: &mut dyn InterpreterHost) -> Outcome<()> {
        let block = self.block_here(host)?;
        let left = self.parameters.repeats().remove(&block.first).unwrap_or_default();
        if left <= 1 {
            return Ok(());
        }
        self.parameters.repeats().insert(block.first, left - 1);
        // The next pass differs from this one.
        host.effect();
        self.go(host, block.first.saturating_add(1))
    }

    /// Skips the definition of a subprogram, which is not part of the program around it.
    fn pass_sub(&mut self, host: &mut dyn InterpreterHost, line: u32) -> Outcome<()> {
        let place = host.place();
        if let Some(inner) = self.places(host, place.file).nested_in(line) {
            let text =
                format!("line {inner} defines a subprogram inside this subprogram: move the inner definition out");
            return Err(Rs274Mistake::new(&diag::MACRO_LOOP, 1, text).into());
        }
        let Some(end) = self.places(host, place.file).end_of(line) else {
            return loop_fault("the subprogram has no endsub with its label: write it at the end of the subprogram");
        };
        if (place.range.first, place.range.last) == (line, end) { Ok(()) } else { self.go(host, end.saturating_add(1)) }
    }

    /// Handles a line with only a percent sign, which begins or ends a text. GRBL and grblHAL ignore such lines.
    pub(super) fn percent(&mut self, host: &mut dyn InterpreterHost) -> Outcome<()> {
        if self.kind.is_firmware() {
            return Ok(());
        }
        let place = host.place();
        let source = host.source(place.file);
        let first = source.and_then(|source| {
            let is_text = |line: &u32| !source.line(*line).trim_ascii().is_empty();
            let first = source.walk(1, source.lines()).find(is_text)?;
            (source.line(first).trim_ascii() == b"%").then_some(first)
        });
        match first {
            Some(first) if first == place.line => Ok(()),
            Some(_) => Ok(host.go_to(place.range.last.saturating_add(1))?),
            None => {
                let text = "the first line of the file is not '%': write it there, too, or remove this line";
                Err(Rs274Mistake::new(&diag::UNKNOWN_TEXT, 1, text).into())
            }
        }
    }

    /// Ends the running program at the start of another program that M98 calls.
    fn pass_program(&mut self, host: &mut dyn InterpreterHost, line: u32) -> Outcome<()> {
        let place = host.place();
        let places = self.places(host, place.file);
        let is_first = place.range.first == line || !(place.range.first..line).any(|line| places.begins_program(line));
        if is_first { Ok(()) } else { Ok(host.go_to(place.range.last.saturating_add(1))?) }
    }

    fn return_value(&mut self, host: &mut dyn InterpreterHost, code: &OCode) -> Outcome<()> {
        if self.parameters.depth() == 0 {
            return loop_fault("return outside a subprogram");
        }
        let value = match code.values.first() {
            Some(value) => Some(self.value(host, value)?),
            None => None,
        };
        self.parameters.set_named("_value", value.unwrap_or(0.0))?;
        self.parameters.set_named("_value_returned", f64::from(u8::from(value.is_some())))?;
        host.return_from();
        Ok(())
    }

    fn call(&mut self, host: &mut dyn InterpreterHost, code: &OCode) -> Outcome<()> {
        let name = match &code.label {
            OLabel::Text(label) => label.clone(),
            OLabel::Computed(number) => {
                let number = self.value(host, number)?.round();
                if !(0.0..1e9).contains(&number) {
                    return Err(missing_sub(&number.to_string()));
                }
                number.to_string().into()
            }
        };
        let mut arguments = Vec::new();
        for value in &code.values {
            arguments.push(self.value(host, value)?);
        }
        self.caching = true;
        let place = self.find_sub(host, &name)?;
        self.parameters.set_named("_value", 0.0)?;
        self.parameters.set_named("_value_returned", 0.0)?;
        self.parameters.pass(arguments);
        host.call(SubprogramCall { name: Arc::from(&*name), place: Some(place), passes: 1, closes: true });
        Ok(())
    }

    /// The lines of a subprogram.
    pub(super) fn find_sub(&mut self, host: &mut dyn ProgramHost, name: &str) -> Outcome<(FileId, ProgramRange)> {
        self.find(host, name, OCodeIndex::sub)
    }

    /// Finds a subprogram or program in the running file, in the file of the main program, or in a file with its name.
    fn find(
        &mut self,
        host: &mut dyn ProgramHost,
        name: &str,
        range_of: fn(&OCodeIndex, &str) -> Option<ProgramRange>,
    ) -> Outcome<(FileId, ProgramRange)> {
        for file in [host.place().file, host.main_file()] {
            if let Some(range) = range_of(&self.places(host, file), name) {
                return Ok((file, range));
            }
        }
        let stem = |file: &str| {
            let last = file.rsplit(['/', '\\']).next().unwrap_or(file).to_ascii_lowercase();
            last.rsplit_once('.').map_or_else(|| last.clone(), |(stem, _)| stem.to_owned())
        };
        let Some(at) = host.files().iter().position(|file| stem(file) == name) else { return Err(missing_sub(name)) };
        let file = at as FileId;
        host.load(file)?;
        let range = range_of(&self.places(host, file), name);
        range.map_or_else(|| Err(missing_sub(name)), |range| Ok((file, range)))
    }

    /// The lines of a program that M98 calls.
    pub(super) fn find_program(&mut self, host: &mut dyn ProgramHost, name: &str) -> Outcome<(FileId, ProgramRange)> {
        self.find(host, name, OCodeIndex::program)
    }

    /// M98: calls a program, with the parameters of its caller.
    pub(super) fn call_program(&mut self, host: &mut dyn InterpreterHost, number: f64, passes: f64) -> Outcome<()> {
        let name = numbered(&format!("{number:.0}"));
        let (file, range) = self.find_program(host, &name)?;
        self.caching = true;
        if passes >= 1.0 {
            let passes = passes.min(9_999_999.0) as u32;
            host.call(SubprogramCall { name: Arc::from(&*name), place: Some((file, range)), passes, closes: true });
        }
        Ok(())
    }
}

fn missing_sub(name: &str) -> Rs274Stop {
    let text = format!("subprogram o{name} not found: define it in the program, or add a file {name}.ngc to the job");
    Rs274Mistake::new(&diag::JUMP_TARGET, 1, text).into()
}
