//! The effect of a block of an ISG program, without executing it.
//!
//! *Invariant:* labels, partners of control blocks and programs are found as the interpreter finds them.

use super::Isg;
use super::expr::Expr;
use super::line::{ControlStatement, IsgItem, IsgJumpTarget, IsgLine, read};
use super::places;
use super::signals::SignalStatement;
use counterpoint_control_api::host::{ProgramHost, Signal};
use counterpoint_control_api::outline::{CallOutline, JumpDestination, OutlineReader, OutlineStep, Signalled};
use counterpoint_control_api::words::part;
use counterpoint_program::search::LabelSearchOrder;
use counterpoint_program::spot::BlockStart;

impl OutlineReader for Isg {
    fn outline(&mut self, programs: &mut dyn ProgramHost, text: &[u8]) -> Vec<OutlineStep> {
        if places::is_head(text) {
            return Vec::new();
        }
        let line = match read(text) {
            Ok(line) => line,
            Err(mistake) => return vec![OutlineStep::Mistake(mistake.text)],
        };
        if line.skips.iter().any(|level| programs.skips(*level)) {
            return Vec::new();
        }
        self.steps(programs, &line, text)
    }
}

impl Isg {
    fn steps(&mut self, programs: &mut dyn ProgramHost, line: &IsgLine, text: &[u8]) -> Vec<OutlineStep> {
        let (mut plain, mut steps) = (String::new(), Vec::new());
        for item in &line.items {
            match item {
                IsgItem::Word(word) => match word.number {
                    Some(number) => {
                        plain.push(char::from(word.letter));
                        plain.push_str(&part(&line.plain, number));
                        plain.push(' ');
                    }
                    None => steps.push(OutlineStep::Computed(char::from(word.letter).to_string())),
                },
                IsgItem::Text(span) => {
                    plain.push_str(part(text, *span).trim());
                    plain.push(' ');
                }
                IsgItem::Control(control) => steps.extend(self.outlined(programs, control)),
                IsgItem::Signal(statement) => steps.push(OutlineStep::Signal(signalled(statement))),
                IsgItem::Call { local, name } => steps.push(self.called(programs, *local, name)),
                IsgItem::Return => steps.push(OutlineStep::Return),
                IsgItem::Time(..) | IsgItem::Dwell(..) => {}
                IsgItem::Set(..) | IsgItem::Declare(_) | IsgItem::Message(..) | IsgItem::Idle => {}
            }
        }
        steps.insert(0, OutlineStep::Words(plain.into_bytes()));
        steps
    }

    fn outlined(&mut self, programs: &dyn ProgramHost, control: &ControlStatement) -> Option<OutlineStep> {
        Some(match control {
            ControlStatement::If(_, Some(target)) => OutlineStep::Branch(self.goal(programs, target)),
            ControlStatement::Goto(target) => OutlineStep::Jump(self.goal(programs, target)),
            _ => {
                let place = programs.place();
                let places = self.places(programs, place.file);
                let opens = matches!(
                    control,
                    ControlStatement::If(..)
                        | ControlStatement::While(_)
                        | ControlStatement::For(..)
                        | ControlStatement::Switch(_)
                        | ControlStatement::Mark
                );
                match places.block(place.line) {
                    Some(block) if block.first == place.line => {
                        let loops = !matches!(control, ControlStatement::If(..) | ControlStatement::Switch(_));
                        OutlineStep::Block { end: BlockStart::line(block.last), loops }
                    }
                    Some(_) => return None,
                    // DO and REPEAT are marks, too, but their blocks are known.
                    None if matches!(control, ControlStatement::Mark) || !opens => return None,
                    None => OutlineStep::Mistake("the control block has no matching statement".to_owned()),
                }
            }
        })
    }

    fn goal(&mut self, programs: &dyn ProgramHost, target: &IsgJumpTarget) -> JumpDestination {
        let place = programs.place();
        let places = self.places(programs, place.file);
        let around = places.program(place.range, place.line);
        let (found, shown) = match target {
            IsgJumpTarget::Number(number) => {
                let Some(number) = number.as_constant() else { return JumpDestination::Computed };
                let label = (number.fract() == 0.0 && (0.0..=1e9).contains(number)).then_some(*number as u32);
                let found =
                    label.and_then(|label| places.numbers().find(&label, LabelSearchOrder::Around, place.line, around));
                (found, format!("block N{number}"))
            }
            IsgJumpTarget::Name(name) => (
                places.names().find(name.as_str(), LabelSearchOrder::Around, place.line, around),
                format!("label [{name}]"),
            ),
        };
        found.map_or(JumpDestination::Missing(shown), |line| JumpDestination::At(BlockStart::line(line)))
    }

    fn called(&mut self, programs: &mut dyn ProgramHost, local: bool, name: &str) -> OutlineStep {
        let place = if local {
            let file = programs.place().file;
            self.places(programs, file).subprogram(name).map(|range| (file, range))
        } else {
            match self.file(programs, name) {
                Ok(place) => place,
                Err(_) => return OutlineStep::Hidden(format!("the file of {name} cannot be read")),
            }
        };
        OutlineStep::Call(CallOutline { name: name.to_owned(), place, passes: Some(1) })
    }
}

/// A statement of signals, if all of its numbers are written.
fn signalled(statement: &SignalStatement) -> Signalled {
    let number = |expr: &Expr| expr.as_constant().copied();
    let all = |list: &[Expr]| list.iter().map(number).collect::<Option<Vec<f64>>>();
    let maybe = |expr: &Option<Expr>| match expr {
        None => Some(None),
        Some(expr) => number(expr).map(Some),
    };
    let signal = || {
        Some(Signal {
            number: number(&statement.number)?,
            last: maybe(&statement.last)?,
            channels: all(&statement.channels)?,
            uses: maybe(&statement.uses)?,
            values: Vec::new(),
        })
    };
    Signalled { deed: statement.deed, row: statement.row(), signal: signal() }
}
