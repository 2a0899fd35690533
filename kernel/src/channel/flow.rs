//! Where the program goes: frames of main and subprograms, calls, returns, jumps.
//!
//! Facts: reference control-emulator.md 5.7. Invariant: nesting is bounded; a backward jump is always counted.

use std::sync::Arc;

use rustc_hash::FxHashMap;

use super::{Acted, Halt, Kernel};
use crate::diag;
use crate::dialect::fanuc::Line;
use crate::dialect::fanuc::loops::Pairs;
use crate::log::event::{FileId, Kind};
use crate::machine::model::{MainReturn, Placement};
use crate::mcd::program::Range;

/// One running program text.
#[derive(Debug, Clone)]
pub(crate) struct Frame {
    pub(crate) file: FileId,
    pub(crate) range: Range,
    /// Next line to read.
    pub(crate) next: u32,
    /// Further passes after this one.
    pub(crate) repeats: u32,
    /// It has variables of its own (a macro call).
    pub(crate) own_variables: bool,
    /// Program number, 0 for the main program, and its passes in all.
    pub(crate) called: (u32, u32),
    /// Name for events.
    pub(crate) name: Box<str>,
}

/// What happens after the current block.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Pending {
    /// Call a subprogram.
    Call {
        /// Program number.
        number: u32,
        /// Passes, at least 1.
        passes: u32,
        /// Arguments of a macro call by variable number.
        arguments: Option<Vec<(u8, f64)>>,
    },
    /// Return, optionally to a sequence number of the caller.
    Return(Option<u32>),
}

/// A loop as seen by the last backward jump.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Pass {
    /// File, target line and line of the jump.
    pub(crate) key: (FileId, u32, u32),
    /// Passes so far.
    pub(crate) count: u64,
    /// Clock at the last jump.
    pub(crate) clock: i64,
    /// Something happened in this pass that the next one could see.
    pub(crate) effects: bool,
    /// A shared variable was read in this pass.
    pub(crate) polled: bool,
    /// Nobody else was left to change a variable when this pass began.
    pub(crate) alone: bool,
}

/// Program flow of a channel.
#[derive(Debug, Default)]
pub(crate) struct Flow {
    pub(crate) frames: Vec<Frame>,
    pub(crate) pending: Option<Pending>,
    pub(crate) pass: Pass,
    /// A line may run again, so compiled lines are worth keeping.
    pub(crate) caching: bool,
    /// Compiled lines of the pre-processor.
    pub(crate) compiled: FxHashMap<(FileId, u32), Arc<Line>>,
    /// Loop partners by program (file and first line).
    pub(crate) pairs: FxHashMap<(FileId, u32), Arc<Pairs>>,
    /// The rewind-stop that opens the program has been met.
    pub(crate) opened: bool,
}

impl Kernel<'_> {
    /// The frame being executed.
    pub(crate) fn frame(&mut self) -> Option<&mut Frame> {
        self.flow.frames.last_mut()
    }

    /// Carries out what the block asked for at its end.
    pub(crate) fn follow(&mut self) -> Acted {
        match self.flow.pending.take() {
            None => Ok(()),
            Some(Pending::Call { number, passes, arguments }) => self.call(number, passes, arguments),
            Some(Pending::Return(target)) => self.give_back(target),
        }
    }

    fn call(&mut self, number: u32, passes: u32, arguments: Option<Vec<(u8, f64)>>) -> Acted {
        let limit = usize::from(self.options.limits.nesting);
        if self.flow.frames.len() > limit {
            let text =
                format!("more than {limit} subprogram levels at the call of {number} in '{}'", self.block_text());
            return Err(self.alarm(&diag::NESTING, text));
        }
        let mut found = self.find_program(number)?;
        if self.macros.is_some() {
            match self.subprogram_startup((number, passes), 0, found, self.flow.frames.len())? {
                None => return Ok(()),
                Some(place) => found = place,
            }
        }
        let Some((file, range)) = found else {
            let text =
                format!("subprogram {number} is missing, called in '{}'; {}", self.block_text(), self.places(number));
            return Err(self.alarm(&diag::SUBPROGRAM_MISSING, text));
        };
        let level = self.flow.frames.len() as u16;
        let name: Box<str> = format!("O{number:04}").into();
        self.emit(0, Kind::Call { program: name.clone(), level });
        self.flow.caching = true;
        self.flow.pass.effects = true;
        let own_variables = arguments.is_some();
        if let Some(arguments) = arguments {
            self.variables.enter(&arguments);
        }
        self.flow.frames.push(Frame {
            file,
            range,
            next: range.first,
            repeats: passes.saturating_sub(1),
            own_variables,
            called: (number, passes),
            name,
        });
        Ok(())
    }

    /// Return of a subprogram, or of the main program.
    pub(crate) fn give_back(&mut self, target: Option<u32>) -> Acted {
        if self.flow.frames.len() <= 1 {
            return self.main_return(target);
        }
        if let Some(frame) = self.flow.frames.last_mut()
            && frame.repeats > 0
        {
            frame.repeats -= 1;
            frame.next = frame.range.first;
            return if self.macros.is_some() { self.next_pass() } else { Ok(()) };
        }
        if let Some(frame) = self.flow.frames.pop() {
            if frame.own_variables {
                self.variables.leave();
            }
            let level = self.flow.frames.len() as u16;
            self.emit(0, Kind::Return { level });
            if self.macros.is_some() {
                self.subprogram_shutdown(frame.called, frame.called.1.saturating_sub(1), usize::from(level))?;
            }
        }
        match target {
            Some(number) => self.jump_to_sequence(number),
            None => Ok(()),
        }
    }

    fn main_return(&mut self, target: Option<u32>) -> Acted {
        if let Some(number) = target {
            return self.jump_to_sequence(number);
        }
        match self.machine.subprograms.main_return {
            MainReturn::Restart => {
                let first = self.frame().map_or(1, |f| f.range.first);
                self.jump_to_line(first)
            }
            MainReturn::End => {
                self.diagnose(
                    &diag::MAIN_RETURN,
                    "return code in the main program: the control would start again, the run ends after this cycle",
                );
                Err(Halt::End(None))
            }
        }
    }

    /// Goes on at the first line with this sequence number: from here on, else from the top of the program.
    pub(crate) fn jump_to_sequence(&mut self, number: u32) -> Acted {
        let info = self.info;
        let Some((file, range, next)) = self.frame().map(|f| (f.file, f.range, f.next)) else { return Ok(()) };
        let lines = info.source(file).map_or(&[][..], |s| s.sequence_lines(number));
        let inside = |line: &&u32| (range.first..=range.last).contains(*line);
        let found =
            lines.iter().filter(inside).find(|&&line| line >= next).or_else(|| lines.iter().find(inside)).copied();
        match found {
            Some(line) => self.jump_to_line(line),
            None => {
                let text = format!("there is no block N{number} in the program to go to from '{}'", self.block_text());
                Err(self.alarm(&diag::JUMP_TARGET, text))
            }
        }
    }

    /// Goes on at a line of the current program; a jump back ends a pass of a loop.
    pub(crate) fn jump_to_line(&mut self, line: u32) -> Acted {
        let from = self.line;
        if let Some(frame) = self.frame() {
            frame.next = line;
        }
        if line <= from { self.end_pass(line, from) } else { Ok(()) }
    }

    /// Counts a pass; one that took no time costs a tick, and one that only polls may be hopeless.
    fn end_pass(&mut self, target: u32, from: u32) -> Acted {
        self.flow.caching = true;
        let key = (self.file, target, from);
        let pass = self.flow.pass;
        let count = if pass.key == key { pass.count + 1 } else { 1 };
        let timeless = pass.key == key && pass.clock == self.clock;
        let idle = self.idle_blocks;
        let mut alone = false;
        if timeless {
            self.advance(self.machine.sync.poll_ns);
            // A tick is not progress, unless the loop looks at what others may change.
            self.idle_blocks = if pass.polled { 0 } else { idle };
            if pass.polled && !pass.effects {
                alone = self.is_alone()?;
                if alone && pass.alone {
                    return Err(self.spinning(target));
                }
            }
        }
        self.flow.pass = Pass { key, count, clock: self.clock, effects: false, polled: false, alone };
        Ok(())
    }

    /// Looks a program up: the current file, then subprogram files, then files named after the number.
    fn find_program(&mut self, number: u32) -> Result<Option<(FileId, Range)>, Halt> {
        let main = self.flow.frames.first().map(|f| f.file);
        let current = self.flow.frames.last().map(|f| f.file);
        for file in [current, main].into_iter().flatten() {
            if let Some(range) = self.in_file(file, number) {
                return Ok(Some((file, range)));
            }
        }
        for name in self.candidates(number) {
            let Some(file) = self.info.files.iter().position(|f| f.name.eq_ignore_ascii_case(&name)) else { continue };
            let file = file as FileId;
            self.load(file)?;
            if let Some(range) = self.in_file(file, number) {
                return Ok(Some((file, range)));
            }
            if let Some(&range) = self.info.source(file).and_then(|s| s.programs().first())
                && range.number.is_none()
            {
                return Ok(Some((file, range)));
            }
        }
        Ok(None)
    }

    fn in_file(&self, file: FileId, number: u32) -> Option<Range> {
        self.info.source(file)?.programs().iter().find(|r| r.number == Some(number)).copied()
    }

    /// Names of files that may hold a subprogram, in search order.
    fn candidates(&self, number: u32) -> Vec<String> {
        let main = self.flow.frames.first().map_or("", |f| self.info.file_name(f.file));
        let (folder, name) = main.rsplit_once('/').map_or(("", main), |(f, n)| (f, n));
        let stem = name.rsplit_once('.').map_or(name, |(s, _)| s);
        let prefix = if folder.is_empty() { String::new() } else { format!("{folder}/") };
        let extension = &self.machine.subprograms.extension;
        let each = format!("{prefix}{stem}_{number}.{extension}");
        let one = format!("{prefix}{stem}.{extension}");
        let mut out = match self.machine.subprograms.placement {
            Placement::FileEach => vec![each, one],
            Placement::SameFile | Placement::OneFile => vec![one, each],
        };
        let wanted = [format!("O{number:04}"), format!("O{number}"), format!("{number:04}"), number.to_string()];
        for file in &self.info.files {
            let Some(rest) = file.name.strip_prefix(&prefix) else { continue };
            let stem = rest.rsplit_once('.').map_or(rest, |(s, _)| s);
            if wanted.iter().any(|w| w.eq_ignore_ascii_case(stem)) {
                out.push(file.name.clone());
            }
        }
        out
    }

    fn places(&self, number: u32) -> String {
        let mut names = self.candidates(number);
        names.truncate(2);
        format!("looked in the program's file, {} and files named O{number:04}", names.join(", "))
    }
}
