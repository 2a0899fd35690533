//! Statements of the pre-processor: assignments, branches, loops.

use std::sync::Arc;

use super::Kernel;
use crate::diag;
use crate::dialect::fanuc::loops::Pairs;
use crate::dialect::fanuc::{self, Expr, Fault, Line, Name, Statement, TemplateWord, is_vacant, number};
use crate::log::event::{Kind, Message};
use crate::mcd::spot::Spot;
use crate::state::block::{Word, irregular};
use counterpoint_fault::{Acted, Halt};

/// Why a statement has come to no end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Left {
    /// The kernel leaves its program.
    Halt(Halt),
    /// The identification macro wants the text with a variable that nobody knows to stay on the block.
    Text,
}

impl From<Halt> for Left {
    fn from(halt: Halt) -> Self {
        Self::Halt(halt)
    }
}

impl Kernel<'_> {
    /// A line with variables or statements.
    pub(crate) fn macro_line(&mut self, text: &[u8]) -> Acted {
        if !self.plan.scanner.has_macros() {
            return self.interpreted_line(text);
        }
        if self.channel.env.trace.is_some() {
            self.trace_deleted(text);
        }
        let line = self.compiled(text, true)?;
        if let Some(number) = line.sequence {
            self.channel.block.sequence = Some(number);
        }
        line.name.into_iter().for_each(|span| self.channel.block.set_name(span));
        match self.statement(&line.statement) {
            Ok(()) => Ok(()),
            Err(Left::Halt(halt)) => Err(halt),
            Err(Left::Text) => {
                self.channel.block.unrecognised.push(line.place);
                self.made_words()
            }
        }
    }

    /// The compiled form of the current line; kept once the program has jumped back or called. `shows` lets its messages
    /// be seen: on every pass, but once for a line that is looked at twice.
    pub(crate) fn compiled(&mut self, text: &[u8], shows: bool) -> Result<Arc<Line>, Halt> {
        let key = (self.channel.at.file, self.channel.at.line);
        // A text of its own is compiled each time: the line number does not stand for it.
        let as_read = self.channel.text.edited.is_none() && self.macros.block.text.is_none();
        if as_read && let Some(line) = self.flow.lines.compiled.get(key) {
            let line = Arc::clone(line);
            self.channel.block.clear();
            if !line.messages.is_empty() {
                self.channel.block.messages.extend_from_slice(&line.messages);
                self.messages_of_line(text, shows);
            }
            return Ok(line);
        }
        let mut stripped = std::mem::take(&mut self.channel.text.stripped);
        let (plan, own) = (self.plan, self.block_scanner());
        let scanner = own.as_deref().unwrap_or(&plan.scanner);
        scanner.strip(text, &mut stripped, &mut self.channel.block);
        let messages = self.channel.block.messages.as_slice().into();
        self.messages_of_line(text, shows);
        let result = fanuc::compile(&stripped, scanner.names());
        self.channel.text.stripped = stripped;
        match result {
            Ok(line) => {
                let line = Arc::new(Line { messages, ..line });
                if self.flow.lines.caching && as_read {
                    self.flow.lines.compiled.insert(key, &line, text.len());
                }
                Ok(line)
            }
            Err(error) => {
                let facts = if error.brackets { &diag::BRACKETS } else { &diag::MACRO_SYNTAX };
                let text = format!("{error} in '{}'", self.block_text());
                Err(self.alarm(facts, text))
            }
        }
    }

    /// Messages of the current line, which a machine with macros has seen to before.
    fn messages_of_line(&mut self, text: &[u8], shows: bool) {
        if shows && self.plan.hooks.is_none() {
            self.show_messages(text);
        }
        self.channel.block.messages.clear();
    }

    fn statement(&mut self, statement: &Statement) -> Result<(), Left> {
        match statement {
            Statement::Words(words) => self.template(words),
            Statement::Assign(list) => list.iter().try_for_each(|(target, value)| self.assign(target, value)),
            Statement::IfGoto(condition, target) => {
                if self.truth(condition)? {
                    self.goto(target)?;
                }
                Ok(())
            }
            Statement::IfThen(condition, inner) => {
                if self.truth(condition)? {
                    self.statement(inner)?;
                }
                Ok(())
            }
            Statement::Goto(target) => self.goto(target),
            Statement::While(condition, _) => {
                if self.truth(condition)? {
                    Ok(self.enter_loop()?)
                } else {
                    self.leave_loop();
                    Ok(self.skip_past(Pairs::of_loop)?)
                }
            }
            Statement::Do(_) => Ok(self.enter_loop()?),
            Statement::End(_) => Ok(self.end_loop()?),
            Statement::IfBlock(condition) => {
                if self.truth(condition)? {
                    Ok(())
                } else {
                    Ok(self.skip_past(Pairs::of_branch)?)
                }
            }
            Statement::Else => Ok(self.skip_past(Pairs::of_branch)?),
            Statement::EndIf => Ok(()),
            Statement::Output(open) => {
                self.flow.printing.open = *open;
                Ok(())
            }
            Statement::Print(items) => self.print(items, false),
            Statement::PrintBinary(items) => self.print(items, true),
        }
    }

    /// The current line opens a loop, or begins its next pass.
    fn enter_loop(&mut self) -> Acted {
        let place = (self.flow.frames.len(), self.spot());
        if self.flow.loops.contains(&place) {
            return Ok(());
        }
        if self.pairs().of_loop(place.1).is_none() {
            return Err(self.unpaired());
        }
        self.flow.loops.push(place);
        Ok(())
    }

    /// The loop that the current line opens is over, and with it those inside.
    fn leave_loop(&mut self) {
        let place = (self.flow.frames.len(), self.spot());
        if let Some(at) = self.flow.loops.iter().position(|inside| *inside == place) {
            self.flow.loops.truncate(at);
        }
    }

    /// The end of a loop: its next pass, if the program has come in through its start.
    fn end_loop(&mut self) -> Acted {
        let Some(start) = self.pairs().of_loop(self.spot()) else { return Err(self.unpaired()) };
        let place = (self.flow.frames.len(), start);
        match self.flow.loops.iter().position(|inside| *inside == place) {
            Some(at) => {
                self.flow.loops.truncate(at + 1);
                self.jump_to(start)
            }
            None => {
                let text = format!(
                    "'{}' ends a loop that line {} opens, but a jump has led into it",
                    self.block_text(),
                    start.line
                );
                Err(self.alarm(&diag::LOOP_ENTERED, text))
            }
        }
    }

    /// A jump within the program leaves the loops that do not hold its target.
    pub(crate) fn leave_loops(&mut self, target: Spot) {
        if self.flow.loops.is_empty() {
            return;
        }
        let (pairs, here) = (self.pairs(), self.flow.frames.len());
        let holds = |start: Spot| pairs.of_loop(start).is_some_and(|end| (start..=end).contains(&target));
        self.flow.loops.retain(|&(level, start)| level != here || holds(start));
    }

    /// Continues after the partner of the current block.
    fn skip_past(&mut self, partner: fn(&Pairs, Spot) -> Option<Spot>) -> Acted {
        match partner(&self.pairs(), self.spot()) {
            Some(spot) => {
                let after = self.after(spot);
                self.jump_to(after)
            }
            None => Err(self.unpaired()),
        }
    }

    fn unpaired(&mut self) -> Halt {
        let text = format!("'{}' has no partner in the program", self.block_text());
        self.alarm(&diag::MACRO_LOOP, text)
    }

    /// Loop partners of the current program, found once.
    fn pairs(&mut self) -> Arc<Pairs> {
        let sources = self.channel.env.sources;
        let Some((file, range)) = self.frame().map(|f| (f.file, f.range)) else { return Arc::default() };
        if let Some(pairs) = self.flow.lines.pairs.get(&(file, range.first)) {
            return Arc::clone(pairs);
        }
        let (plan, switched) = (self.plan, self.switched_scanner());
        let scanner = switched.as_deref().unwrap_or(&plan.scanner);
        let (mut stripped, mut scratch) = (Vec::new(), crate::state::block::Block::default());
        let Some(source) = sources.get(file) else { return Arc::default() };
        let bracketing = source.walk(range.first, range.last).filter(|&line| has_bracketing(source.line(line)));
        let blocks = bracketing.flat_map(|line| {
            scanner.block_starts(source.line(line)).map(move |offset| Spot { line, offset: offset as u32 })
        });
        let statements = blocks.filter_map(|spot| {
            let rest = source.line(spot.line).get(spot.offset as usize..)?;
            let block = rest.get(..scanner.block_end(rest).unwrap_or(rest.len()))?;
            scanner.strip(block, &mut stripped, &mut scratch);
            fanuc::compile(&stripped, scanner.names()).ok().map(|compiled| (spot, compiled.statement))
        });
        let pairs = Arc::new(Pairs::of(statements));
        self.flow.lines.tables += pairs.bytes();
        self.flow.lines.pairs.insert((file, range.first), Arc::clone(&pairs));
        pairs
    }

    fn goto(&mut self, target: &Expr) -> Result<(), Left> {
        let value = number(self.eval(target)?).round();
        if !(1.0..=f64::from(u32::MAX)).contains(&value) {
            let text = format!("{value} is no sequence number to go to in '{}'", self.block_text());
            return Err(self.alarm(&diag::JUMP_TARGET, text).into());
        }
        Ok(self.jump_to_sequence(value as u32)?)
    }

    fn truth(&mut self, condition: &Expr) -> Result<bool, Left> {
        self.eval(condition).map(|v| number(v) != 0.0)
    }

    pub(crate) fn eval(&mut self, expr: &Expr) -> Result<f64, Left> {
        if let Some(value) = expr.as_constant() {
            return Ok(value);
        }
        match expr.eval(self) {
            Ok(value) => Ok(value),
            // What has no value counts as 0 where the machine goes on.
            Err(fault) => self.faulty(&fault).map(|()| 0.0),
        }
    }

    /// A fault ends its statement, unless the machine goes on from it.
    fn faulty(&mut self, fault: &Fault) -> Result<(), Left> {
        if matches!(fault, Fault::Kept(_) | Fault::KeptFunction(_)) {
            return Err(Left::Text);
        }
        match self.fault(fault) {
            Halt::Dropped => Ok(()),
            halt => Err(Left::Halt(halt)),
        }
    }

    /// Alarm of a fault.
    pub(crate) fn fault(&mut self, fault: &Fault) -> Halt {
        let facts = match fault {
            Fault::Stopped => return Halt::Stopped,
            Fault::Division => &diag::MACRO_DIVISION,
            Fault::Overflow => &diag::MACRO_OVERFLOW,
            Fault::Domain(..) => &diag::MACRO_DOMAIN,
            Fault::NoFunction(_) | Fault::KeptFunction(_) => &diag::MACRO_SYNTAX,
            Fault::NoVariable(_) | Fault::ReadOnly(_) | Fault::Kept(_) => &diag::MACRO_VARIABLE,
        };
        let text = format!("{fault} in '{}'", self.block_text());
        self.alarm(facts, text)
    }

    fn assign(&mut self, target: &Expr, value: &Expr) -> Result<(), Left> {
        let value = self.eval(value)?;
        let target = number(self.eval(target)?);
        let index = match fanuc::variable_index(target) {
            Ok(index) => index,
            Err(fault) => return self.faulty(&fault),
        };
        match index {
            3000 => {
                let text = format!("alarm {} raised by the program in '{}'", 3000.0 + number(value), self.block_text());
                Err(self.alarm(&diag::MACRO_ALARM, text).into())
            }
            3006 => {
                let text: Box<str> = self.block_text().into();
                self.emit(0, Kind::Message(Message { text, printed: false }));
                Ok(())
            }
            3001..=3004 => Ok(()),
            _ => match self.set_variable(index, value) {
                Ok(()) => Ok(()),
                Err(fault) => self.faulty(&fault),
            },
        }
    }

    /// Words with expressions become plain words; vacant values drop their word, kept ones stay text.
    fn template(&mut self, words: &[TemplateWord]) -> Result<(), Left> {
        self.flow.pass.effects = true;
        for word in words {
            let steps = if word.written.is_some() { None } else { self.steps_of(word.name) };
            self.dialect.variables.steps = steps.unwrap_or(1.0);
            let value = self.eval(&word.value);
            self.dialect.variables.steps = 1.0;
            let value = match value {
                Ok(value) => value,
                Err(Left::Halt(halt)) => return Err(halt.into()),
                Err(Left::Text) => {
                    self.channel.block.unrecognised.push((word.start, word.end));
                    continue;
                }
            };
            if is_vacant(value) {
                continue;
            }
            let value = steps.map_or(value, |steps| fanuc::to_step(value, steps));
            let register = match word.name {
                Name::Letter(letter) => self.plan.scanner.register(letter),
                Name::Register(register, _) if self.sequence_word(register, value) => continue,
                Name::Register(register, incremental) => Some((register, incremental)),
                Name::Text(row) => {
                    self.channel.block.texts.push(row);
                    continue;
                }
            };
            let value = match (register, word.written) {
                (Some((register, _)), Some(number)) => self.read_by_register(register, number),
                (Some((register, _)), None) => {
                    let of = self.channel.env.machine.registers.get(usize::from(register));
                    let refused =
                        self.channel.is_alarm(&diag::MINUS_SIGN) && of.is_some_and(|register| !register.signed);
                    let wrong = refused && value < 0.0;
                    self.channel.block.flags.irregular |= u8::from(wrong) * irregular::SIGN;
                    value
                }
                _ => value,
            };
            match register {
                Some((register, incremental)) => self.channel.block.push(Word {
                    register,
                    incremental,
                    used: false,
                    value,
                    start: word.start,
                    end: word.end,
                }),
                None => self.channel.block.unrecognised.push((word.start, word.end)),
            }
        }
        if self.channel.env.trace.is_some() {
            self.trace_preprocessed();
        }
        Ok(self.made_words()?)
    }

    /// Steps of one unit that the value of an expression at an address is rounded to.
    fn steps_of(&self, name: Name) -> Option<f64> {
        let register = match name {
            Name::Letter(letter) => self.plan.scanner.register(letter)?.0,
            Name::Register(register, _) => register,
            Name::Text(_) => return None,
        };
        self.plan.rules.steps.get(usize::from(register))?.get(usize::from(self.channel.state.secondary)).copied()
    }

    /// A number beside an expression is read as on a line without one.
    pub(crate) fn read_by_register(&mut self, register: u8, number: fanuc::Number) -> f64 {
        let reading = self.plan.scanner.reading(register, number, self.channel.state.secondary);
        let (value, odd) = reading.unwrap_or((number.value, 0));
        self.channel.block.flags.irregular |= odd;
        value
    }

    /// The first word of the register of sequence numbers is no word.
    fn sequence_word(&mut self, register: u8, value: f64) -> bool {
        let is =
            Some(register) == self.plan.scanner.sequence() && self.channel.block.sequence.is_none() && value >= 0.0;
        if is {
            self.channel.block.sequence = Some(value as u32);
        }
        is
    }
}

/// A line that may hold a bracketing statement.
fn has_bracketing(text: &[u8]) -> bool {
    text.windows(2).any(|pair| match pair {
        [a, b] => {
            let pair = [a.to_ascii_uppercase(), b.to_ascii_uppercase()];
            [*b"DO", *b"EN", *b"IF", *b"EL", *b"WH"].contains(&pair)
        }
        _ => false,
    })
}
