//! Statements executed.
//!
//! Facts: see [`super::statement`]. Invariant: a block is either executed, left as words, or diagnosed.

use counterpoint_control_api::host::{InterpreterHost, ProgramPlace};
use counterpoint_fault as diag;
use counterpoint_fault::Halt;
use counterpoint_machine::stored::StoredFile;

use super::eval::Evaluator;
use super::foreign_axes::refuse_axes;
use super::formula::Formula;
use super::path::walk;
use super::path_state::{PathBlock, PathBlockKind, axis};
use super::q_parameter::ParameterValue;
use super::statement::{BranchCondition, HeidenhainStatement, Test};
use super::words::{EvaluatedWord, HeidenhainWord, LeftBlock, Rest, headed, joined};
use super::{Heidenhain, HeidenhainLine};

/// The code of a unit.
fn unit(inch: bool) -> &'static str {
    if inch { "INCH" } else { "MM" }
}

impl Heidenhain {
    /// Executes a block; returns its remaining words.
    pub(super) fn carry_out(
        &mut self,
        host: &mut dyn InterpreterHost,
        line: &HeidenhainLine,
        place: ProgramPlace,
    ) -> Result<Vec<LeftBlock>, Halt> {
        match &line.statement {
            HeidenhainStatement::Nothing | HeidenhainStatement::Label(_) | HeidenhainStatement::Contour(_) => {
                Ok(Vec::new())
            }
            HeidenhainStatement::Words(words) | HeidenhainStatement::Path { shape: PathBlockKind::Iso, words, .. }
                if self.is_translated(host) =>
            {
                self.iso_block(host, words, line, place)
            }
            HeidenhainStatement::Words(words) => self.plain(host, words),
            HeidenhainStatement::Assign(name, formula) => {
                let mut evaluator = Evaluator::new(&mut self.variables, host);
                let value = evaluator.value(formula)?;
                evaluator.assign(*name, value).map(|()| Vec::new())
            }
            HeidenhainStatement::Parameters(words) => self.parameters(host, words).map(|()| Vec::new()),
            HeidenhainStatement::Branch(condition, to) => {
                if self.holds(host, condition)? {
                    self.jump(host, to)?;
                }
                Ok(Vec::new())
            }
            HeidenhainStatement::Shared(statement, operands) => {
                let value = |host: &mut dyn InterpreterHost, operand: &Formula| {
                    Evaluator::new(&mut self.variables, host).number(operand)
                };
                statement.execute(host, operands, value).map(|()| Vec::new())
            }
            HeidenhainStatement::Print(text) => self.print(host, text).map(|()| Vec::new()),
            HeidenhainStatement::Send(text) => self.send(host, text).map(|()| Vec::new()),
            HeidenhainStatement::SysRead { to, id, number, index } => {
                self.system_read(host, *to, (id, number, index.as_ref())).map(|()| Vec::new())
            }
            HeidenhainStatement::SysWrite { id, number, index, value } => {
                self.system_write(host, (id, number, index.as_ref()), value).map(|()| Vec::new())
            }
            HeidenhainStatement::EndOfLabel => {
                self.end_label(host);
                Ok(Vec::new())
            }
            HeidenhainStatement::CallLabel { label, repeat } => {
                self.call_label(host, label, repeat.as_ref()).map(|()| Vec::new())
            }
            HeidenhainStatement::CallProgram(name) => {
                let name = self.text(host, name)?;
                self.call_program(host, &name).map(|()| Vec::new())
            }
            HeidenhainStatement::SelectProgram(name) => {
                self.selected.program = Some(self.text(host, name)?);
                Ok(Vec::new())
            }
            HeidenhainStatement::SelectPoints(name) => self.select_points(host, name).map(|()| Vec::new()),
            HeidenhainStatement::SelectDatums(name) => self.select_datums(host, name).map(|()| Vec::new()),
            HeidenhainStatement::SelectContour(name) if self.settings.cycles.contains(&14) => {
                self.select_contour(host, name).map(|()| Vec::new())
            }
            HeidenhainStatement::SelectContour(_) => Err(self.not_understood(host)),
            HeidenhainStatement::CallSelected => match self.selected.program.clone() {
                Some(name) => self.call_program(host, &name).map(|()| Vec::new()),
                None => {
                    let text = format!("no program is selected for '{}'; program SEL PGM first", host.block_text());
                    Err(host.alarm(&diag::SUBPROGRAM_MISSING, text))
                }
            },
            HeidenhainStatement::Begin { iso: true, .. } if line.number.is_some() => self.end_program(host),
            HeidenhainStatement::Begin { inch, words, .. } => self.begin_program(host, *inch, words),
            HeidenhainStatement::End => self.end_program(host),
            HeidenhainStatement::CycleDefinition(words)
                if words.first().is_some_and(|word| &*word.name == "G") && self.is_translated(host) =>
            {
                match Self::iso_definition(words) {
                    Some(words) => self.define_cycle(host, &words, place),
                    None => Err(self.not_understood(host)),
                }
            }
            HeidenhainStatement::CycleDefinition(words) => self.define_cycle(host, words, place),
            HeidenhainStatement::CyclePart { .. } => self.define_by_parts(host, line, place),
            HeidenhainStatement::CycleCall { kind, words } => self.call_cycle(host, (*kind, words), place),
            HeidenhainStatement::ToolCall { tool, words } => self.call_tool(host, tool.as_ref(), words),
            HeidenhainStatement::SelectPreset(words) => self.select_preset(host, words),
            HeidenhainStatement::ToolDefinition { tool, words } => self.define_tool(host, tool, words),
            HeidenhainStatement::Stop(words) => self.stop(host, words),
            HeidenhainStatement::Path { shape, iso, words } => self.path(host, (*shape, *iso, words), line, place),
            HeidenhainStatement::Foreign(words) => {
                let starts = |count: usize| {
                    let first = words.get(..count)?.iter().map(|word| EvaluatedWord::text(&word.name));
                    Some(joined(&first.collect::<Vec<_>>()))
                };
                if !(1..=4).any(|count| starts(count).is_some_and(|text| host.is_code_text(&text))) {
                    return match starts(2).as_deref() {
                        Some("PATTERN DEF") => self.define_pattern(host, words).map(|()| Vec::new()),
                        Some("GLOBAL DEF") => self.define_globally(host, words).map(|()| Vec::new()),
                        Some("CONTOUR DEF") if self.settings.cycles.contains(&14) => {
                            let seen = Evaluator::new(&mut self.variables, host).seen(words)?;
                            match self.define_contours(host, seen.get(2..).unwrap_or_default()) {
                                true => Ok(Vec::new()),
                                false => Err(self.not_understood(host)),
                            }
                        }
                        _ if words.first().is_some_and(|word| &*word.name == "TRANS") => self.transform(host, words),
                        _ => Err(self.not_understood(host)),
                    };
                }
                if words.first().is_some_and(|word| &*word.name == "PLANE") {
                    return self.plane(host, words);
                }
                let mut seen = Evaluator::new(&mut self.variables, host).seen(words)?;
                self.follow(host, &mut seen);
                Ok(vec![seen])
            }
        }
    }

    /// A statement that is not emulated is an alarm, because the following blocks depend on its effect.
    pub(super) fn not_understood(&mut self, host: &mut dyn InterpreterHost) -> Halt {
        let text = format!("'{}' is not supported on this machine", host.block_text());
        host.alarm(&diag::STATEMENT_UNKNOWN, text)
    }

    /// A value that has to be a text.
    pub(super) fn text(
        &mut self,
        host: &mut dyn InterpreterHost,
        formula: &Formula,
    ) -> Result<std::sync::Arc<str>, Halt> {
        Ok(match Evaluator::new(&mut self.variables, host).value(formula)? {
            ParameterValue::Text(text) => text,
            ParameterValue::Number(number) => super::words::shown(number).into(),
        })
    }

    pub(super) fn holds(&mut self, host: &mut dyn InterpreterHost, condition: &BranchCondition) -> Result<bool, Halt> {
        let (left, test, right) = match condition {
            BranchCondition::Defined(name, defined) => return Ok(self.variables.get(*name).is_some() == *defined),
            BranchCondition::Compare(left, test, right) => (left, test, right),
        };
        let mut evaluator = Evaluator::new(&mut self.variables, host);
        let (left, right) = (evaluator.value(left)?, evaluator.value(right)?);
        let order = match (&left, &right) {
            (ParameterValue::Number(left), ParameterValue::Number(right)) => left.partial_cmp(right),
            (ParameterValue::Text(left), ParameterValue::Text(right)) => Some(left.cmp(right)),
            _ => {
                let text = format!("a text and a number cannot be compared in '{}'", host.block_text());
                return Err(host.alarm(&diag::MACRO_DOMAIN, text));
            }
        };
        Ok(match test {
            Test::Equal => order == Some(std::cmp::Ordering::Equal),
            Test::NotEqual => order != Some(std::cmp::Ordering::Equal),
            Test::Greater => order == Some(std::cmp::Ordering::Greater),
            Test::Less => order == Some(std::cmp::Ordering::Less),
        })
    }

    /// Words of a block that the control tells by parameters.
    pub(super) fn functions_of(&mut self, seen: &[EvaluatedWord]) {
        let control = &mut self.variables.control;
        for word in seen {
            match (&*word.name, word.value) {
                ("M", Some(number)) => control.function(number),
                ("T", Some(number)) => control.tool = Some(number),
                ("G", Some(17.0)) => control.tool_axis = Some(2),
                ("G", Some(18.0)) => control.tool_axis = Some(1),
                ("G", Some(19.0)) => control.tool_axis = Some(0),
                _ => {}
            }
        }
    }

    /// STOP.
    pub(super) fn stop(
        &mut self,
        host: &mut dyn InterpreterHost,
        words: &[HeidenhainWord],
    ) -> Result<Vec<LeftBlock>, Halt> {
        let seen = Evaluator::new(&mut self.variables, host).seen(words)?;
        refuse_axes(host, "STOP", &seen)?;
        self.functions_of(&seen);
        let stop = if host.is_code_text("STOP") { EvaluatedWord::text("STOP") } else { EvaluatedWord::made("M", 0.0) };
        Ok(vec![std::iter::once(stop).chain(seen).collect()])
    }

    pub(super) fn plain(
        &mut self,
        host: &mut dyn InterpreterHost,
        words: &[HeidenhainWord],
    ) -> Result<Vec<LeftBlock>, Halt> {
        let mut seen = Evaluator::new(&mut self.variables, host).seen(words)?;
        self.functions_of(&seen);
        self.follow(host, &mut seen);
        let mut before = self.function_words(host, &mut seen)?;
        self.feed_units(host, &mut seen)?;
        before.extend(self.retract(host, &mut seen));
        self.cycle_calls(host, &mut seen, false)?;
        self.after_block(&seen);
        before.push(seen);
        Ok(before)
    }

    /// Several parameters of a cycle in a block of their own.
    fn parameters(&mut self, host: &mut dyn InterpreterHost, words: &[HeidenhainWord]) -> Result<(), Halt> {
        let mut evaluator = Evaluator::new(&mut self.variables, host);
        for word in evaluator.seen(words)? {
            if let (Some(name), Some(value)) = (super::cycles::parameter_of(&word.name), word.value) {
                evaluator.assign(name, ParameterValue::Number(value))?;
            }
        }
        Ok(())
    }

    /// Units are codes of the machine. A program that is called may have another one, until it returns; cycles of the
    /// control count as the program that calls them.
    fn begin_program(
        &mut self,
        host: &mut dyn InterpreterHost,
        inch: Option<bool>,
        words: &[HeidenhainWord],
    ) -> Result<Vec<LeftBlock>, Halt> {
        let file = host.place().file;
        if host.files().get(usize::from(file)).is_some_and(|name| name.starts_with(StoredFile::ROOT)) {
            return Ok(Vec::new());
        }
        let called = self.variables.calls.depth() > 0;
        // Q113 is the unit of the main program.
        if let Some(inch) = inch.filter(|_| !called) {
            self.variables.control.inch = inch;
        }
        if !words.is_empty() && !self.is_translated(host) {
            let seen = Evaluator::new(&mut self.variables, host).seen(words)?;
            return Ok(vec![seen]);
        }
        let Some(inch) = inch else { return Ok(Vec::new()) };
        if host.is_code_text(unit(inch)) {
            if called && inch != self.units.inches {
                self.variables.calls.here_mut().caller_in_inches = Some(self.units.inches);
            }
            self.units.inches = inch;
            return Ok(vec![headed(unit(inch), [])]);
        }
        if inch {
            let text = format!("the machine has no code INCH for '{}'", host.block_text());
            return Err(host.alarm(&diag::STATEMENT_UNKNOWN, text));
        }
        Ok(Vec::new())
    }

    /// The unit of the program that has called the ending one, if the units differ.
    pub(super) fn unit_of_caller(&mut self, host: &dyn InterpreterHost) -> Option<LeftBlock> {
        let inches = self.variables.calls.here_mut().caller_in_inches.take()?;
        self.units.inches = inches;
        Some(unit(inches)).filter(|unit| host.is_code_text(unit)).map(|unit| headed(unit, []))
    }

    pub(super) fn path(
        &mut self,
        host: &mut dyn InterpreterHost,
        (shape, iso, words): (PathBlockKind, bool, &[HeidenhainWord]),
        line: &HeidenhainLine,
        place: ProgramPlace,
    ) -> Result<Vec<LeftBlock>, Halt> {
        if shape == PathBlockKind::Space && !host.is_code_text("LN") {
            return Err(self.not_understood(host));
        }
        let mut seen = Evaluator::new(&mut self.variables, host).seen(words)?;
        // Old programs have words without a value.
        let is_bare = |word: &EvaluatedWord| word.value.is_none() && word.rest == Rest::Nothing;
        seen.retain(|word| !is_bare(word) || !matches!(&*word.name, "R" | "F" | "M"));
        self.cycles.contours.unroll(&mut seen);
        self.rapid_feeds(&mut seen);
        self.functions_of(&seen);
        self.follow(host, &mut seen);
        if shape == PathBlockKind::Space {
            self.directions(host, &mut seen)?;
        }
        let mut lines = self.function_words(host, &mut seen)?;
        self.feed_units(host, &mut seen)?;
        lines.extend(self.retract(host, &mut seen));
        let moves = seen.iter().any(|word| {
            word.value.is_some()
                && (axis(&word.name).is_some() || matches!(&*word.name, "PR" | "PA" | "IPR" | "IPA" | "H"))
        });
        self.cycle_calls(host, &mut seen, moves)?;
        self.after_block(&seen);
        let rapid = self.rapid_on_circle(host, shape, &seen)?;
        let step = PathBlock { shape, iso, seen, line: place.line, number: line.number, rapid };
        self.path.free.selects.clear();
        let ahead = if place.as_read { self.ahead(host, shape, line.next, place)? } else { Vec::new() };
        lines.extend(walk(&mut self.path, host, &step, &ahead)?);
        Ok(lines)
    }
}
