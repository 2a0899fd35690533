//! The effect of a block of an ISG program, without executing it.
//!
//! *Invariant:* labels, partners of control blocks and programs are found as the interpreter finds them.

use super::Isg;
use super::expr::Expr;
use super::line::{Control, Item, Line, Target, read};
use super::places;
use super::signals::Statement;
use crate::host::{Programs, Signal};
use crate::outline::{Called, Goal, Reader, Signalled, Step};
use crate::words::part;
use counterpoint_program::search::Search;
use counterpoint_program::spot::Spot;

impl Reader for Isg {
    fn outline(&mut self, programs: &mut dyn Programs, text: &[u8]) -> Vec<Step> {
        if places::is_head(text) {
            return Vec::new();
        }
        let line = match read(text) {
            Ok(line) => line,
            Err(mistake) => return vec![Step::Mistake(mistake.text)],
        };
        if line.skips.iter().any(|level| programs.skips(*level)) {
            return Vec::new();
        }
        self.steps(programs, &line, text)
    }
}

impl Isg {
    fn steps(&mut self, programs: &mut dyn Programs, line: &Line, text: &[u8]) -> Vec<Step> {
        let (mut plain, mut steps) = (String::new(), Vec::new());
        for item in &line.items {
            match item {
                Item::Word(word) => match word.number {
                    Some(number) => {
                        plain.push(char::from(word.letter));
                        plain.push_str(&part(&line.plain, number));
                        plain.push(' ');
                    }
                    None => steps.push(Step::Computed(char::from(word.letter).to_string())),
                },
                Item::Text(span) => {
                    plain.push_str(part(text, *span).trim());
                    plain.push(' ');
                }
                Item::Control(control) => steps.extend(self.outlined(programs, control)),
                Item::Signal(statement) => steps.push(Step::Signal(signalled(statement))),
                Item::Call { local, name } => steps.push(self.called(programs, *local, name)),
                Item::Return => steps.push(Step::Return),
                Item::Time(..) | Item::Dwell(..) => {}
                Item::Set(..) | Item::Declare(_) | Item::Message(..) | Item::Idle => {}
            }
        }
        steps.insert(0, Step::Words(plain.into_bytes()));
        steps
    }

    fn outlined(&mut self, programs: &dyn Programs, control: &Control) -> Option<Step> {
        Some(match control {
            Control::If(_, Some(target)) => Step::Branch(self.goal(programs, target)),
            Control::Goto(target) => Step::Jump(self.goal(programs, target)),
            _ => {
                let place = programs.place();
                let places = self.places(programs, place.file);
                let opens = matches!(
                    control,
                    Control::If(..) | Control::While(_) | Control::For(..) | Control::Switch(_) | Control::Mark
                );
                match places.block(place.line) {
                    Some(block) if block.first == place.line => {
                        let loops = !matches!(control, Control::If(..) | Control::Switch(_));
                        Step::Block { end: Spot::line(block.last), loops }
                    }
                    Some(_) => return None,
                    // DO and REPEAT are marks, too, but their blocks are known.
                    None if matches!(control, Control::Mark) || !opens => return None,
                    None => Step::Mistake("the control block has no matching statement".to_owned()),
                }
            }
        })
    }

    fn goal(&mut self, programs: &dyn Programs, target: &Target) -> Goal {
        let place = programs.place();
        let places = self.places(programs, place.file);
        let around = places.program(place.range, place.line);
        let (found, shown) = match target {
            Target::Number(number) => {
                let Some(number) = number.as_constant() else { return Goal::Computed };
                let label = (number.fract() == 0.0 && (0.0..=1e9).contains(number)).then_some(*number as u32);
                let found = label.and_then(|label| places.numbers().find(&label, Search::Around, place.line, around));
                (found, format!("block N{number}"))
            }
            Target::Name(name) => {
                (places.names().find(name.as_str(), Search::Around, place.line, around), format!("label [{name}]"))
            }
        };
        found.map_or(Goal::Missing(shown), |line| Goal::At(Spot::line(line)))
    }

    fn called(&mut self, programs: &mut dyn Programs, local: bool, name: &str) -> Step {
        let place = if local {
            let file = programs.place().file;
            self.places(programs, file).subprogram(name).map(|range| (file, range))
        } else {
            match self.file(programs, name) {
                Ok(place) => place,
                Err(_) => return Step::Hidden(format!("the file of {name} cannot be read")),
            }
        };
        Step::Call(Called { name: name.to_owned(), place, passes: Some(1) })
    }
}

/// A statement of signals, if all of its numbers are written.
fn signalled(statement: &Statement) -> Signalled {
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
