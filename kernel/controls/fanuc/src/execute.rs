//! Statements: assignments, branches, loops, printing, and words with expressions.
//!
//! Facts: reference control-emulator.md 5.4, fanuc-variables-and-alarms.md 2.5. *Invariant:* a loop is repeated only by
//! a program that came in through its start.

use counterpoint_fault as diag;
use counterpoint_fault::{Acted, Halt};

use super::access::{Abandoned, HostVariables, abandons, eval, eval_at};
use super::compile::compile;
use super::expr::{Expr, is_vacant, number, to_step, variable_index};
use super::loops::Pairs;
use super::statement::{AssignmentTarget, FanucStatement, PrintItem, TemplateWord, WordName};
use super::{Fanuc, print};
use counterpoint_control_api::host::{InterpreterHost, MadeWord, ProgramHost};
use counterpoint_control_api::interpreter::Remaining;
use counterpoint_event::FileId;
use counterpoint_program::shape::ProgramRange;
use counterpoint_program::spot::BlockStart;

impl Fanuc {
    pub(super) fn statement(
        &mut self,
        host: &mut dyn InterpreterHost,
        statement: &FanucStatement,
    ) -> Result<Remaining, Abandoned> {
        match statement {
            FanucStatement::Words(words) => return template(host, words),
            FanucStatement::IfThen(condition, inner) => {
                if truth(host, condition)? {
                    return self.statement(host, inner);
                }
            }
            FanucStatement::Assign(list) => list.iter().try_for_each(|(target, value)| assign(host, target, value))?,
            FanucStatement::IfGoto(condition, target) => {
                if truth(host, condition)? {
                    self.goto(host, target)?;
                }
            }
            FanucStatement::Goto(target) => self.goto(host, target)?,
            FanucStatement::While(condition, _) => {
                host.tests_loop(true);
                let goes_on = truth(host, condition);
                host.tests_loop(false);
                if goes_on? {
                    self.enter_loop(host)?;
                } else {
                    let (level, start) = (host.level(), host.spot());
                    host.loops().leave(level, start);
                    self.skip_past(host, Pairs::of_loop)?;
                }
            }
            FanucStatement::Do(_) => self.enter_loop(host)?,
            FanucStatement::End(_) => self.end_loop(host)?,
            FanucStatement::IfBlock(condition) => {
                if !truth(host, condition)? {
                    self.skip_past(host, Pairs::of_branch)?;
                }
            }
            FanucStatement::Else => self.skip_past(host, Pairs::of_branch)?,
            FanucStatement::EndIf => {}
            FanucStatement::Shared(shared, operands) => {
                shared.execute(host, operands, |host, operand| eval(host, operand).map(number))?;
            }
            FanucStatement::Print(items) => print_line(host, items, false)?,
            FanucStatement::PrintBinary(items) => print_line(host, items, true)?,
        }
        Ok(Remaining::Nothing)
    }

    /// The block opens a loop, or starts its next pass.
    fn enter_loop(&mut self, host: &mut dyn InterpreterHost) -> Acted {
        let (level, start) = (host.level(), host.spot());
        if host.loops().enter(level, start) && self.pairs(host).of_loop(start).is_none() {
            host.loops().leave(level, start);
            return Err(unpaired(host));
        }
        Ok(())
    }

    /// The end of a loop: its next pass, if the program has come in through its start.
    fn end_loop(&mut self, host: &mut dyn InterpreterHost) -> Acted {
        let Some(start) = self.pairs(host).of_loop(host.spot()) else { return Err(unpaired(host)) };
        let level = host.level();
        if host.loops().repeat(level, start) {
            return host.go_to_block(start);
        }
        let (block, line) = (host.block_text(), start.line);
        let text = format!(
            "'{block}' ends the loop of line {line}, but a jump has entered the loop without passing its start"
        );
        Err(host.alarm(&diag::LOOP_ENTERED, text))
    }

    /// A jump within the program leaves the loops that do not hold its target.
    pub(super) fn leave_loops(&mut self, host: &mut dyn InterpreterHost, target: BlockStart) {
        if host.loops().is_empty() {
            return;
        }
        let (level, pairs) = (host.level(), self.pairs(host));
        host.loops().jump(level, |start| pairs.of_loop(start).is_some_and(|end| (start..=end).contains(&target)));
    }

    /// Continues after the partner of the block.
    fn skip_past(
        &mut self,
        host: &mut dyn InterpreterHost,
        partner: fn(&Pairs, BlockStart) -> Option<BlockStart>,
    ) -> Acted {
        match partner(self.pairs(host), host.spot()) {
            Some(block) => {
                let after = host.after(block);
                host.go_to_block(after)
            }
            None => Err(unpaired(host)),
        }
    }

    /// Partners of the statements of the running program, found once.
    pub(super) fn pairs(&mut self, host: &dyn ProgramHost) -> &Pairs {
        // Without a program there is no source either.
        let (file, range) = host.program().unwrap_or((FileId::MAX, ProgramRange { number: None, first: 1, last: 0 }));
        self.pairs.look((file, range), || {
            let Some(source) = host.source(file) else { return Pairs::default() };
            let mut statements = Vec::new();
            for line in source.walk(range.first, range.last).filter(|&line| has_bracketing(source.line(line))) {
                host.each_block(source.line(line), &mut |offset, text, names| {
                    let block = BlockStart { line, offset: offset as u32 };
                    statements.extend(compile(text, names).map(|compiled| (block, compiled.statement)));
                });
            }
            Pairs::of(statements.into_iter())
        })
    }

    fn goto(&mut self, host: &mut dyn InterpreterHost, target: &Expr) -> Result<(), Abandoned> {
        let value = number(eval(host, target)?).round();
        if !(1.0..=f64::from(u32::MAX)).contains(&value) {
            let text = format!("{value} is not a valid sequence number to jump to in '{}'", host.block_text());
            return Err(host.alarm(&diag::JUMP_TARGET, text).into());
        }
        let block = host.sequence(value as u32)?;
        self.leave_loops(host, block);
        Ok(host.go_to_block(block)?)
    }
}

fn unpaired(host: &mut dyn InterpreterHost) -> Halt {
    let text = format!("'{}' has no matching statement in the program", host.block_text());
    host.alarm(&diag::MACRO_LOOP, text)
}

fn truth(host: &mut dyn InterpreterHost, condition: &Expr) -> Result<bool, Abandoned> {
    eval(host, condition).map(|value| number(value) != 0.0)
}

fn assign(host: &mut dyn InterpreterHost, target: &AssignmentTarget, value: &Expr) -> Result<(), Abandoned> {
    let value = eval(host, value)?;
    let index = match target {
        AssignmentTarget::Variable(index) => *index,
        AssignmentTarget::Indirect(target) => match variable_index(number(eval(host, target)?)) {
            Ok(index) => index,
            Err(fault) => return abandons(host, &fault),
        },
    };
    match index {
        3000 => {
            let alarm = f64::from(host.program_alarm()) + number(value);
            let block = host.block_text();
            // The block of a program that this project ships is not shown, but its comment names the cause.
            let own = host.part((0, u32::MAX));
            let comment = comment(&own).filter(|comment| !block.contains(comment));
            let comment = comment.map_or(String::new(), |comment| format!(" ({comment})"));
            let text = format!("alarm {alarm}{comment} raised by the program in '{block}'");
            Err(host.alarm(&diag::MACRO_ALARM, text).into())
        }
        3006 => {
            let text = host.block_text();
            host.log_message(&text);
            Ok(())
        }
        _ => match HostVariables::new(host).set(index, value) {
            Ok(()) => Ok(()),
            Err(fault) => abandons(host, &fault),
        },
    }
}

/// The last comment of a block.
fn comment(block: &str) -> Option<&str> {
    let (_, comment) = block.rsplit_once('(')?;
    Some(comment.split(')').next()?.trim()).filter(|comment| !comment.is_empty())
}

/// Prints a line.
fn print_line(host: &mut dyn InterpreterHost, items: &[PrintItem], binary: bool) -> Result<(), Abandoned> {
    let mut line = String::new();
    for item in items {
        match item {
            PrintItem::Text(text) => line.push_str(text),
            PrintItem::Number(value, whole, fraction) => {
                let value = eval(host, value)?;
                line.push_str(&if binary {
                    print::binary(value, *fraction)
                } else {
                    print::decimal(value, *whole, *fraction, host.output())
                });
            }
        }
    }
    line.push_str(if binary { "\n" } else { host.output().line_end });
    Ok(host.print(&line)?)
}

/// Words with expressions become plain words; vacant values drop their word, kept ones remain text.
fn template(host: &mut dyn InterpreterHost, words: &[TemplateWord]) -> Result<Remaining, Abandoned> {
    host.effect();
    for word in words {
        let span = (word.start, word.end);
        let register = match word.name {
            WordName::Letter(letter) => host.register(letter),
            WordName::Register(register, incremental) => Some((register, incremental)),
            WordName::Text(_) => None,
        };
        let steps = register.filter(|_| word.written.is_none()).and_then(|(register, _)| host.steps(register));
        let value = match eval_at(host, &word.value, steps.unwrap_or(1.0)) {
            Ok(value) if is_vacant(value) => continue,
            Ok(value) => steps.map_or(value, |steps| to_step(value, steps)),
            Err(Abandoned::Text) => {
                host.keep_text(span);
                continue;
            }
            Err(halt) => return Err(halt),
        };
        match (word.name, register) {
            (WordName::Text(row), _) => host.push_text(row),
            (WordName::Register(register, _), _) if host.take_sequence(register, value) => {}
            (_, Some((register, incremental))) => {
                host.push(MadeWord { register, incremental, value, written: word.written, span });
            }
            (_, None) => host.keep_text(span),
        }
    }
    host.words_are_made();
    Ok(Remaining::Words)
}

/// Whether a line may hold a bracketing statement.
fn has_bracketing(text: &[u8]) -> bool {
    text.windows(2).any(|pair| match pair {
        [a, b] => {
            let pair = [a.to_ascii_uppercase(), b.to_ascii_uppercase()];
            [*b"DO", *b"EN", *b"IF", *b"EL", *b"WH"].contains(&pair)
        }
        _ => false,
    })
}
