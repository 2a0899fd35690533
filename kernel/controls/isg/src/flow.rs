//! Control blocks, jumps and calls, executed.
//!
//! Facts: reference channel-synchronisation.md 1.7. Decisions: FOR asks for its last value and its step after each pass
//! and ends beyond the last value in the direction of the step; a branch of SWITCH runs on into the next one unless it
//! breaks. A subprogram `L NAME` is a file of that name, with or without its ending, beside the calling one or stored
//! with the machine. Invariant: nothing is remembered of a loop, its partners are found in the text.

use std::sync::Arc;

use super::expr::{Expr, IsgVariable};
use super::line::{ControlStatement, IsgItem, IsgJumpTarget};
use super::places::{ControlBlock, ControlBlockKind, IsgFileIndex};
use super::{Isg, IsgBlockError, Outcome};
use counterpoint_control_api::host::{InterpreterHost, ProgramHost, SubprogramCall};
use counterpoint_event::FileId;
use counterpoint_fault as diag;
use counterpoint_program::search::LabelSearchOrder;
use counterpoint_program::shape::ProgramRange;

fn loop_fault<T>(text: &str) -> Outcome<T> {
    Err(IsgBlockError::Alarm(&diag::MACRO_LOOP, text.to_owned()))
}

/// A condition is true from this absolute value on (TwinCAT programming manual, "Control blocks: IF branching").
const FULFILLED: f64 = 0.5;

impl Isg {
    /// Labels and control blocks of a file.
    pub(super) fn places(&mut self, host: &dyn ProgramHost, file: FileId) -> Arc<IsgFileIndex> {
        self.places.get(file, || host.source(file).map(|source| IsgFileIndex::of(&source)).unwrap_or_default())
    }

    /// The control block of the block in process.
    fn block_here(&mut self, host: &mut dyn InterpreterHost) -> Outcome<ControlBlock> {
        let place = host.place();
        let places = self.places(host, place.file);
        match places.block(place.line).filter(|block| block.last >= place.range.first) {
            Some(block) => Ok(block.clone()),
            None => loop_fault("the control block has no matching statement"),
        }
    }

    fn go(&mut self, host: &mut dyn InterpreterHost, line: u32) -> Outcome<()> {
        self.caching = true;
        let range = host.place().range;
        if line < range.first || line > range.last.saturating_add(1) {
            return Err(IsgBlockError::Alarm(&diag::JUMP_TARGET, "the jump leaves its program".to_owned()));
        }
        Ok(host.go_to(line)?)
    }

    fn is_true(&mut self, host: &mut dyn InterpreterHost, condition: &Expr) -> Outcome<bool> {
        Ok(self.value(host, condition)?.abs() >= FULFILLED)
    }

    /// The condition of a loop.
    fn repeats(&mut self, host: &mut dyn InterpreterHost, condition: &Expr) -> Outcome<bool> {
        host.tests_loop(true);
        let holds = self.is_true(host, condition);
        host.tests_loop(false);
        holds
    }

    /// The flow item of another line of the program.
    fn item_at(&mut self, host: &mut dyn InterpreterHost, line: u32) -> Outcome<Option<ControlStatement>> {
        let file = host.place().file;
        let line = self.line_of(host, file, line);
        let line = match &*line {
            Ok(line) => line,
            Err(mistake) => return Err(mistake.clone().into()),
        };
        Ok(line
            .items
            .iter()
            .find_map(|item| if let IsgItem::Control(control) = item { Some(control.clone()) } else { None }))
    }

    /// Executes a control block.
    pub(super) fn control(&mut self, host: &mut dyn InterpreterHost, control: &ControlStatement) -> Outcome<()> {
        match control {
            ControlStatement::Mark => Ok(()),
            ControlStatement::If(condition, Some(target)) => {
                if self.is_true(host, condition)? {
                    self.jump(host, target)
                } else {
                    Ok(())
                }
            }
            ControlStatement::Goto(target) => self.jump(host, target),
            ControlStatement::If(condition, None) => {
                let block = self.block_here(host)?;
                if self.is_true(host, condition)? { Ok(()) } else { self.branch(host, &block) }
            }
            // The branch before it has run.
            ControlStatement::Else | ControlStatement::ElseIf(_) => {
                let block = self.block_here(host)?;
                self.go(host, block.last.saturating_add(1))
            }
            ControlStatement::Switch(value) => {
                let block = self.block_here(host)?;
                let value = self.value(host, value)?;
                self.choose(host, &block, value)
            }
            ControlStatement::Case(_) => self.block_here(host).map(|_| ()),
            ControlStatement::While(condition) => {
                let block = self.block_here(host)?;
                if self.repeats(host, condition)? { Ok(()) } else { self.go(host, block.last.saturating_add(1)) }
            }
            ControlStatement::Until(condition) => {
                let block = self.block_here(host)?;
                if self.repeats(host, condition)? { Ok(()) } else { self.go(host, block.first.saturating_add(1)) }
            }
            ControlStatement::For(variable, first, last, step) => {
                let block = self.block_here(host)?;
                let first = self.value(host, first)?;
                self.assign(host, variable, first)?;
                if self.goes_on(host, (variable, first), (last, step))? {
                    return Ok(());
                }
                self.go(host, block.last.saturating_add(1))
            }
            ControlStatement::EndFor => {
                let block = self.block_here(host)?;
                let Some(ControlStatement::For(variable, _, last, step)) = self.item_at(host, block.first)? else {
                    return loop_fault("$ENDFOR has no $FOR");
                };
                let value = self.read(host, &variable)? + self.value(host, &step)?;
                self.assign(host, &variable, value)?;
                if self.goes_on(host, (&variable, value), (&last, &step))? {
                    return self.go(host, block.first.saturating_add(1));
                }
                Ok(())
            }
            ControlStatement::EndWhile => {
                let block = self.block_here(host)?;
                self.go(host, block.first)
            }
            ControlStatement::EndDo(condition) => {
                let block = self.block_here(host)?;
                let again = match condition {
                    Some(condition) => self.repeats(host, condition)?,
                    None => true,
                };
                if again { self.go(host, block.first.saturating_add(1)) } else { Ok(()) }
            }
            ControlStatement::Break => {
                let block = self.block_here(host)?;
                self.go(host, block.last.saturating_add(1))
            }
            ControlStatement::Continue => {
                let block = self.block_here(host)?;
                match block.kind {
                    ControlBlockKind::While => self.go(host, block.first),
                    _ => self.go(host, block.last),
                }
            }
        }
    }

    /// The variable of FOR is not beyond its last value.
    fn goes_on(
        &mut self,
        host: &mut dyn InterpreterHost,
        (_, value): (&IsgVariable, f64),
        (last, step): (&Expr, &Expr),
    ) -> Outcome<bool> {
        let (last, step) = (self.value(host, last)?, self.value(host, step)?);
        if step == 0.0 {
            return loop_fault("the step of $FOR is 0");
        }
        Ok(if step > 0.0 { value <= last } else { value >= last })
    }

    /// The condition of IF does not hold: the first ELSEIF that does, otherwise ELSE, otherwise the end.
    fn branch(&mut self, host: &mut dyn InterpreterHost, block: &ControlBlock) -> Outcome<()> {
        for mark in &block.marks {
            let holds = match self.item_at(host, *mark)? {
                Some(ControlStatement::ElseIf(condition)) => self.is_true(host, &condition)?,
                _ => true,
            };
            if holds {
                return self.go(host, mark.saturating_add(1));
            }
        }
        self.go(host, block.last.saturating_add(1))
    }

    /// The CASE of a value, otherwise DEFAULT, otherwise the end.
    fn choose(&mut self, host: &mut dyn InterpreterHost, block: &ControlBlock, value: f64) -> Outcome<()> {
        let mut default = block.last;
        for mark in &block.marks {
            match self.item_at(host, *mark)? {
                Some(ControlStatement::Case(case)) => {
                    if self.value(host, &case)? == value {
                        return self.go(host, mark.saturating_add(1));
                    }
                }
                _ => default = *mark,
            }
        }
        self.go(host, default.saturating_add(1))
    }

    fn jump(&mut self, host: &mut dyn InterpreterHost, target: &IsgJumpTarget) -> Outcome<()> {
        let place = host.place();
        let places = self.places(host, place.file);
        let around = places.program(place.range, place.line);
        let (found, shown) = match target {
            IsgJumpTarget::Number(number) => {
                let number = self.value(host, number)?;
                let label =
                    if number.fract() == 0.0 && (0.0..=1e9).contains(&number) { Some(number as u32) } else { None };
                let find = |label| places.numbers().find(&label, LabelSearchOrder::Around, place.line, around);
                (label.and_then(find), format!("block N{number}"))
            }
            IsgJumpTarget::Name(name) => (
                places.names().find(name.as_str(), LabelSearchOrder::Around, place.line, around),
                format!("label [{name}]"),
            ),
        };
        match found {
            Some(line) => self.go(host, line),
            None => Err(IsgBlockError::Alarm(&diag::JUMP_TARGET, format!("{shown} not found in the program"))),
        }
    }

    /// A call of a local subprogram, or of a file.
    pub(super) fn call(&mut self, host: &mut dyn InterpreterHost, local: bool, name: &str) -> Outcome<()> {
        self.caching = true;
        let place = if local {
            let file = host.place().file;
            self.places(host, file).subprogram(name).map(|range| (file, range))
        } else {
            self.file(host, name)?
        };
        host.call(SubprogramCall { name: Arc::from(name), place, passes: 1, closes: true });
        Ok(())
    }

    /// The main program of a file.
    pub(super) fn file(&mut self, host: &mut dyn ProgramHost, name: &str) -> Outcome<Option<(FileId, ProgramRange)>> {
        let files = host.files();
        let last = |file: &str| file.rsplit(['/', '\\']).next().unwrap_or(file).to_ascii_uppercase();
        let wanted = last(name);
        let stem = |file: &str| last(file).rsplit_once('.').map_or_else(|| last(file), |(stem, _)| stem.to_owned());
        let exact = files.iter().position(|file| last(file) == wanted);
        let Some(at) = exact.or_else(|| files.iter().position(|file| stem(file) == wanted)) else { return Ok(None) };
        let file = at as FileId;
        host.load(file)?;
        let main = self.places(host, file).main();
        let whole = || host.source(file).map(|source| ProgramRange { number: None, first: 1, last: source.lines() });
        Ok(main.or_else(whole).map(|range| (file, range)))
    }
}
