//! Steps of blocks that are more than plain words: statements between channels, calls, jumps.
//!
//! *Invariant:* a statement between channels acts by the services of a run, with the arguments that stand in the
//! program.

use std::sync::Arc;

use counterpoint_control_api::outline::{
    CallOutline, JumpDestination, NamedStatement, OutlineStep, SignalOp, Signalled, StatementArgument,
};
use counterpoint_control_api::{Coordination, Operands, SubprogramCall};
use counterpoint_fault as diag;
use counterpoint_fault::{Acted, Halt};
use counterpoint_program::spot::BlockStart;

use super::Linter;
use super::region::{Looked, ProgramRegion, before};
use counterpoint_channel::callee::Pending;

impl Linter<'_, '_> {
    /// Follows the steps of a block in their order.
    pub(super) fn steps(&mut self, steps: Vec<OutlineStep>) -> Acted {
        let computed = computed(&steps);
        for step in steps {
            let is_jump = matches!(step, OutlineStep::Jump(_));
            self.step(step, &computed)?;
            if is_jump {
                // Text after it is not reached.
                return Ok(());
            }
        }
        Ok(())
    }

    fn step(&mut self, step: OutlineStep, computed: &[String]) -> Acted {
        match step {
            OutlineStep::Words(text) => self.words(&text, computed),
            OutlineStep::Computed(name) if self.decides(&name) => {
                Err(self.lost(&format!("the value of {name} is computed")))
            }
            OutlineStep::Computed(_) => Ok(()),
            OutlineStep::Named(named) => self.named(named),
            OutlineStep::Signal(signal) => self.signal(&signal),
            OutlineStep::Jump(JumpDestination::At(target)) => self.jump(target),
            OutlineStep::Jump(JumpDestination::Missing(what)) => {
                let text = format!("{what} not found in the program for '{}'", self.kernel.channel.block_text());
                Err(self.kernel.alarm(&diag::JUMP_TARGET, text))
            }
            OutlineStep::Jump(JumpDestination::Computed) | OutlineStep::Branch(JumpDestination::Computed) => {
                Err(self.lost("the target of a jump is computed"))
            }
            OutlineStep::Branch(JumpDestination::At(target)) => {
                let here = self.kernel.channel.at.line;
                let part = if target.line > here {
                    ProgramRegion { first: self.behind(), last: before(target) }
                } else {
                    ProgramRegion { first: target.line, last: here }
                };
                self.pass_over(part, BlockStart::line(1), false)
            }
            OutlineStep::Branch(JumpDestination::Missing(what)) => {
                self.report_missing(&what);
                Ok(())
            }
            OutlineStep::Block { end, loops } => {
                let part = ProgramRegion { first: self.behind(), last: end.line.saturating_sub(1) };
                self.pass_over(part, end, loops)
            }
            OutlineStep::Call(called) => self.call(called),
            OutlineStep::Return => {
                self.kernel.ask(Pending::Return(None));
                Ok(())
            }
            OutlineStep::If(steps) => match self.meets_among(&steps)? {
                true => Err(self.lost("the rest of the block depends on a condition")),
                false => Ok(()),
            },
            OutlineStep::Modal(steps) => {
                let is_known = |step: &OutlineStep| {
                    matches!(
                        step,
                        OutlineStep::Named(NamedStatement { program: Some(_), .. })
                            | OutlineStep::Call(CallOutline { place: Some(_), .. })
                    )
                };
                match steps.iter().all(is_known) && !self.meets_among(&steps)? {
                    true => Ok(()),
                    false => Err(self.lost("blocks that move call a program that waits or is not known")),
                }
            }
            OutlineStep::Alarm => Err(self.lost("the program raises an alarm of its own")),
            OutlineStep::Hidden(reason) => Err(self.lost(&reason)),
            OutlineStep::Mistake(text) => {
                let text = format!("{text}, in '{}'", self.kernel.channel.block_text());
                Err(self.kernel.alarm(&diag::LINT_UNREADABLE, text))
            }
        }
    }

    /// The first line that may be skipped from here: the same line if blocks follow in it.
    fn behind(&self) -> u32 {
        let more = self.kernel.flow.frames.last().is_some_and(|frame| frame.offset > 0);
        self.kernel.channel.at.line + u32::from(!more)
    }

    /// Continues after a part of the program that a condition passes, or that a loop repeats, at least at `end`.
    fn pass_over(&mut self, part: ProgramRegion, end: BlockStart, loops: bool) -> Acted {
        match self.look_through(part)? {
            Looked::Clear(grown) => {
                if loops || grown.first <= self.kernel.channel.at.line {
                    self.note_loop();
                }
                let next = BlockStart::line(grown.last.saturating_add(1)).max(end);
                if let Some(frame) = self.kernel.flow.frame().filter(|frame| next > frame.next_block()) {
                    (frame.next, frame.offset) = (next.line, next.offset);
                }
                Ok(())
            }
            Looked::At(line) => {
                Err(self.lost(&format!("whether and how often line {line} acts depends on a condition")))
            }
        }
    }

    /// Says once that loops are taken to end.
    fn note_loop(&mut self) {
        if !std::mem::replace(&mut self.loops, true) {
            let text = format!(
                "loops without waits are taken to end, the first one at '{}'",
                self.kernel.channel.block_text()
            );
            self.kernel.diagnose(&diag::LINT_LOOPS, text);
        }
    }

    /// A jump that depends on a condition leads nowhere.
    pub(super) fn report_missing(&mut self, what: &str) {
        let text = format!(
            "{what} is not in the program, the jump in '{}' is an alarm when it is made",
            self.kernel.channel.block_text()
        );
        self.kernel.diagnose(&diag::LINT_TARGET, text);
    }

    fn named(&mut self, named: NamedStatement) -> Acted {
        let Some(operands) = self.kernel.coordinates(&named.name) else {
            let Some(place) = named.program else { return Ok(()) };
            return self.call(CallOutline { name: named.name, place: Some(place), passes: named.passes });
        };
        let arguments = self.arguments(operands, &named);
        let Some(arguments) = arguments else {
            return Err(self.lost(&format!("the arguments of {} are computed", named.name)));
        };
        let name = named.name.as_str();
        match (operands, arguments) {
            (_, CoordinationArguments::Numbers(numbers)) => match (operands, numbers.as_slice()) {
                (Operands::MarkAndChannels, [mark, channels @ ..]) if !channels.is_empty() => {
                    self.kernel.coordinate(name, *mark, channels)
                }
                (Operands::Channels, channels) if !channels.is_empty() => self.kernel.coordinate(name, 0, channels),
                (Operands::Marks, marks) if !marks.is_empty() => {
                    marks.iter().try_for_each(|mark| self.kernel.coordinate(name, *mark, &[]))
                }
                _ => Err(self.wrong(&format!("{name} needs other arguments"))),
            },
            (_, CoordinationArguments::Program { channel, path, waits }) => {
                if named.program.is_none() && waits {
                    let text = format!("program {path} for channel {channel} not found");
                    return Err(self.kernel.alarm(&diag::CHANNEL_NOT_STARTED, text));
                }
                Coordination::select(self.kernel, channel, &path, named.program)
            }
            (_, CoordinationArguments::Axes(axes)) => {
                axes.iter().try_for_each(|(axis, channel)| Coordination::exchange(self.kernel, name, axis, *channel))
            }
            (_, CoordinationArguments::Nothing) => Err(self.wrong(&format!("{name} needs other arguments"))),
        }
    }

    fn wrong(&mut self, reason: &str) -> Halt {
        let text = format!("{reason}, in '{}'", self.kernel.channel.block_text());
        self.kernel.alarm(&diag::STATEMENT_ARGUMENTS, text)
    }

    /// The arguments of a statement; none if one of them is computed.
    fn arguments(&self, operands: Operands, named: &NamedStatement) -> Option<CoordinationArguments> {
        let channel = |argument: &StatementArgument| match argument {
            StatementArgument::Name(name) => self.kernel.channel_named(name).map(i64::from),
            other => number(other),
        };
        Some(match operands {
            Operands::MarkAndChannels => {
                let mut numbers = Vec::new();
                for (at, argument) in named.arguments.iter().enumerate() {
                    numbers.push(if at == 0 { number(argument)? } else { channel(argument)? });
                }
                CoordinationArguments::Numbers(numbers)
            }
            Operands::Marks => {
                CoordinationArguments::Numbers(named.arguments.iter().map(number).collect::<Option<_>>()?)
            }
            Operands::Channels => {
                CoordinationArguments::Numbers(named.arguments.iter().map(channel).collect::<Option<_>>()?)
            }
            Operands::Program => {
                let [who, StatementArgument::Text(path), mode @ ..] = named.arguments.as_slice() else {
                    return Some(CoordinationArguments::Nothing);
                };
                let waits = !matches!(mode, [StatementArgument::Text(mode)] if mode.eq_ignore_ascii_case("N"));
                CoordinationArguments::Program { channel: channel(who)?, path: path.trim().to_owned(), waits }
            }
            Operands::Axes | Operands::AxesAndChannels => {
                let each = if operands == Operands::Axes { 1 } else { 2 };
                if named.arguments.is_empty() || !named.arguments.len().is_multiple_of(each) {
                    return Some(CoordinationArguments::Nothing);
                }
                let mut axes = Vec::new();
                for pair in named.arguments.chunks(each) {
                    let axis = match pair.first()? {
                        StatementArgument::Name(name) | StatementArgument::Text(name) => name.clone(),
                        StatementArgument::Number(_) | StatementArgument::Computed => return None,
                    };
                    axes.push((axis, pair.get(1).map(|argument| channel(argument).ok_or(())).transpose().ok()?));
                }
                CoordinationArguments::Axes(axes)
            }
        })
    }

    fn signal(&mut self, statement: &Signalled) -> Acted {
        let Some(signal) = &statement.signal else { return Err(self.lost("the statement of signals is computed")) };
        match statement.deed {
            SignalOp::Send => self.kernel.send(statement.row, signal),
            SignalOp::Remove => self.kernel.remove_signal(statement.row, signal),
            SignalOp::Wait => self.kernel.receive(statement.row, signal, true).map(|_| ()),
            SignalOp::Read => self.kernel.receive(statement.row, signal, false).map(|_| ()),
        }
    }

    fn call(&mut self, called: CallOutline) -> Acted {
        self.check_calls()?;
        let CallOutline { name, place, passes } = called;
        let Some((file, range)) = place else {
            let text = format!("subprogram {name} not found, called in '{}'", self.kernel.channel.block_text());
            return self.kernel.program_missing(text);
        };
        let Some(passes) = passes else {
            return match self.meets_in_program(file, range)? {
                None => Ok(()),
                Some(_) => Err(self.lost(&format!("how often {name} runs is computed"))),
            };
        };
        // Cycles of the machine are not the user's to correct, and no shipped one meets a channel.
        let info = self.kernel.channel.env.info;
        if info.is_resident(file) || info.is_stored(file) && self.meets_in_program(file, range)?.is_none() {
            return Ok(());
        }
        if passes > 0 {
            let call = SubprogramCall { name: Arc::from(name), place, passes, closes: true };
            self.kernel.ask(Pending::CallText(Box::new(call)));
        }
        Ok(())
    }
}

/// Arguments of a statement between channels.
enum CoordinationArguments {
    Numbers(Vec<i64>),
    Program {
        channel: i64,
        path: String,
        waits: bool,
    },
    Axes(Vec<(String, Option<i64>)>),
    /// Neither of these; the required data are missing.
    Nothing,
}

/// A whole number.
fn number(argument: &StatementArgument) -> Option<i64> {
    match argument {
        StatementArgument::Number(number) if number.fract() == 0.0 && number.abs() <= 1e9 => Some(*number as i64),
        _ => None,
    }
}

/// Names of words whose values are computed.
pub(super) fn computed(steps: &[OutlineStep]) -> Vec<String> {
    let names = steps.iter().filter_map(|step| match step {
        OutlineStep::Computed(name) => Some(name.clone()),
        _ => None,
    });
    names.collect()
}
