//! The effect of a block of an OSP program, without executing it.
//!
//! *Invariant:* labels and programs are found as the interpreter finds them. Decision: the number of passes of a call
//! with Q depends on a setting that macros of the machine make. So with macros that number counts as computed.

use super::lap::{self, Lap};
use super::line::{Head, Item, Line, Statement, Target, Wanted, read};
use super::names::normal;
use super::text::prepare;
use super::{Okuma, line};
use crate::host::Programs;
use crate::outline::{Called, Goal, Reader, Step};
use crate::statement::RETURN;
use crate::words::part;
use counterpoint_program::spot::Spot;

/// The reader.
#[derive(Debug)]
pub(super) struct Outlines {
    okuma: Okuma,
    /// The machine has macros.
    macros: bool,
    /// G81 to G88 may be contours with a name and cycles along them.
    contours: bool,
}

impl Outlines {
    /// For a machine that has macros, which may make any setting, and that has no hole cycle on G81.
    pub(super) fn new(macros: bool, contours: bool) -> Self {
        Self { okuma: Okuma::new(!macros), macros, contours }
    }
}

impl Reader for Outlines {
    fn outline(&mut self, programs: &mut dyn Programs, text: &[u8]) -> Vec<Step> {
        let whole = self.okuma.continued(programs, text);
        let text = whole.as_ref().map_or(text, |(whole, _)| whole.as_slice());
        let mut block = prepare(text);
        if self.contours && lap::find(&mut block) == Some(Lap::Begins) {
            return Vec::new();
        }
        match read(block, Wanted { subprograms: true, drawing: self.macros, offsets: self.macros }) {
            Ok(line) => self.line(programs, &line),
            Err(mistake) => vec![Step::Mistake(mistake.to_string())],
        }
    }
}

impl Outlines {
    fn line(&mut self, programs: &mut dyn Programs, line: &Line) -> Vec<Step> {
        let mut skipped = false;
        for head in &line.head {
            if let Head::Mark(level) = head {
                skipped = programs.skips(*level);
            }
        }
        if skipped {
            return Vec::new();
        }
        match &line.statement {
            Statement::Drawing | Statement::Nothing | Statement::Continued | Statement::ModOut => Vec::new(),
            Statement::Goto(condition, target) => {
                let goal = self.goal(programs, target);
                vec![if condition.is_some() { Step::Branch(goal) } else { Step::Jump(goal) }]
            }
            Statement::Loop(..) => {
                vec![self.partner(programs).map_or_else(unpaired, |end| Step::Block { end, loops: true })]
            }
            Statement::EndLoop(_) => self.partner(programs).map_or_else(|| vec![unpaired()], |_| Vec::new()),
            Statement::Call(call) => vec![self.call(programs, call)],
            Statement::ModIn(_) => vec![Step::Hidden("blocks that move call a program (MODIN)".to_owned())],
            Statement::Shared(shared, _) if **shared == RETURN => vec![Step::Return],
            Statement::Shared(..) => Vec::new(),
            Statement::Items(items) => words(items, &line.plain),
        }
    }

    /// The partner of a statement of a loop.
    fn partner(&mut self, programs: &dyn Programs) -> Option<Spot> {
        let place = programs.place();
        self.okuma.index(programs, place.file).loops.partner(place.line).map(Spot::line)
    }

    fn goal(&mut self, programs: &dyn Programs, target: &Target) -> Goal {
        let Target::Named(name) = target else { return Goal::Computed };
        let place = programs.place();
        let found = self.okuma.index(programs, place.file).label(name, place.line, place.range);
        found.map_or_else(|| Goal::Missing(format!("block N{name}")), |line| Goal::At(Spot::line(line)))
    }

    fn call(&mut self, programs: &mut dyn Programs, call: &line::Call) -> Step {
        let place = self.okuma.find(programs, normal(call.name.get(1..).unwrap_or_default()));
        let passes = match &call.repeats {
            None => Some(1),
            Some(_) if self.macros => None,
            Some(count) => {
                let count = count.as_constant().filter(|count| count.fract() == 0.0 && (0.0..=9999.0).contains(*count));
                count.map(|count| *count as u32 + 1)
            }
        };
        match place {
            Ok(place) => Step::Call(Called { name: call.name.clone(), place, passes }),
            Err(_) => Step::Hidden(format!("the file of {} cannot be read", call.name)),
        }
    }
}

/// A statement of a loop without a partner.
fn unpaired() -> Step {
    Step::Mistake("the statement has no matching one in the program".to_owned())
}

/// Words of a block: those with numbers as they are written.
fn words(items: &[Item], text: &[u8]) -> Vec<Step> {
    let (mut plain, mut steps) = (String::new(), Vec::new());
    for item in items {
        match item {
            Item::Plain(span) => plain.push_str(&part(text, *span)),
            Item::Set { name, number: Some(number), .. } if name.len() == 1 => {
                plain.push_str(name);
                plain.push_str(&part(text, *number));
            }
            Item::Set { name, .. } => steps.push(Step::Computed(name.clone())),
            Item::Text { .. } | Item::OfTool(..) => {}
        }
        plain.push(' ');
    }
    steps.insert(0, Step::Words(plain.into_bytes()));
    steps
}
