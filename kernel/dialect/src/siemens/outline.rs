//! The effect of a block of an 840D program, without executing it.
//!
//! Decisions: a name that is declared as a variable may hold any label or number; names that DEFINE replaces may mean
//! anything. *Invariant:* labels, partners of loops and programs are found as the interpreter finds them.

use rustc_hash::FxHashSet;

use super::expression::{self, Expression, as_name};
use super::jumps::{is_head, shown};
use super::line::{Assigned, Direction, Item, Jump, Label, Line, Structure, read};
use super::run::skipped;
use super::value::Data;
use super::{Outcome, Siemens};
use crate::host::Programs;
use crate::outline::{Argument, Called, Goal, Named, Reader, Step};
use crate::text::without_comment;
use counterpoint_event::FileId;
use counterpoint_program::search::Search;
use counterpoint_program::shape::Range;
use counterpoint_program::spot::Spot;

/// The reader, with the declarations of the blocks so far.
#[derive(Debug, Default)]
pub(super) struct Outlines {
    siemens: Siemens,
    declared: FxHashSet<String>,
}

type Found = Option<(FileId, Range)>;

/// Words without G codes that the interpreter rewrites as functions.
fn without_rewritten(text: &str) -> Vec<u8> {
    let mut words = text.as_bytes().to_vec();
    for at in 0..words.len() {
        let (head, rest) = text.as_bytes().split_at(at);
        let begins = head.last().is_none_or(|byte| !byte.is_ascii_alphanumeric());
        if let [b'G' | b'g', number @ ..] = rest
            && begins
            && super::meanings::is_rewritten(number)
        {
            let digits = number.iter().take_while(|byte| byte.is_ascii_digit()).count();
            words.get_mut(at..=at + digits).unwrap_or_default().fill(b' ');
        }
    }
    words
}

impl Reader for Outlines {
    fn outline(&mut self, programs: &mut dyn Programs, text: &[u8]) -> Vec<Step> {
        let text = String::from_utf8_lossy(text);
        let Some(text) = skipped(programs, &text).filter(|text| !is_head(text)) else { return Vec::new() };
        match read(without_comment(text)) {
            Ok(line) => self.line(programs, &line),
            Err(text) => vec![Step::Mistake(text)],
        }
    }
}

impl Outlines {
    fn line(&mut self, programs: &mut dyn Programs, line: &Line) -> Vec<Step> {
        let passes = line.items.iter().find_map(|item| match item {
            Item::Passes(passes, _) => Some(passes.as_constant().and_then(Data::number)),
            _ => None,
        });
        let passes = match passes {
            None => Some(1),
            Some(passes) => passes.and_then(whole),
        };
        let mut steps = Vec::new();
        for (at, item) in line.items.iter().enumerate() {
            if let Item::If(_, Some(jump)) = item {
                steps.push(Step::Branch(self.goal(programs, jump)));
                let rest = Line { items: line.items.get(at + 1..).unwrap_or_default().to_vec(), ..Line::default() };
                if !rest.items.is_empty() {
                    steps.push(Step::If(self.line(programs, &rest)));
                }
                break;
            }
            if matches!(item, Item::Modal) {
                let rest = Line { items: line.items.get(at + 1..).unwrap_or_default().to_vec(), ..Line::default() };
                // Alone it ends the calls.
                if !rest.items.is_empty() {
                    steps.push(Step::Modal(self.line(programs, &rest)));
                }
                break;
            }
            self.item(programs, item, passes, &mut steps);
        }
        steps
    }

    fn item(&mut self, programs: &mut dyn Programs, item: &Item, passes: Option<u32>, steps: &mut Vec<Step>) {
        match item {
            Item::Text(text) => steps.push(Step::Words(without_rewritten(text))),
            Item::Set { name, value: Assigned::One(value, _), .. }
                if name.name.len() == 1
                    && name.name != "R"
                    && name.index.is_empty()
                    && let Some(number) = value.as_constant().and_then(Data::number) =>
            {
                steps.push(Step::Words(format!("{}{number}", name.name).into_bytes()));
            }
            Item::Set { name, value, .. } => {
                let constant =
                    matches!(value, Assigned::One(value, _) if value.as_constant().is_some()) || name.name.len() > 3;
                if !constant {
                    steps.push(Step::Computed(name.name.clone()));
                }
            }
            Item::Bare(written) => {
                let name = written.to_ascii_uppercase();
                steps.push(self.named(programs, name, Vec::new(), passes));
            }
            Item::Function(name, arguments) => {
                let arguments = arguments.iter().map(|argument| self.argument(argument)).collect();
                steps.push(self.named(programs, name.clone(), arguments, passes));
            }
            Item::Program(name) => {
                let place = self.program(programs, name);
                steps.push(Step::Call(Called { name: name.clone(), place, passes }));
            }
            Item::CallText { name, section: None, .. } => match name.as_constant() {
                Some(Data::Text(path)) => {
                    let place = settled(self.siemens.program_by_path(programs, path.trim()));
                    steps.push(Step::Call(Called { name: path.trim().to_owned(), place, passes }));
                }
                _ => steps.push(Step::Hidden("the name of the program that is called is computed".to_owned())),
            },
            Item::CallText { .. } => steps.push(Step::Hidden("a part of a program is called".to_owned())),
            Item::Return(_, false) => steps.push(Step::Return),
            Item::Return(_, true) => steps.push(Step::Hidden("the return goes to another block".to_owned())),
            Item::Define(name, _) => steps.push(Step::Hidden(format!("DEFINE gives {name} another meaning"))),
            Item::Declare(declaration) | Item::Redeclare(declaration) => {
                self.declared.extend(declaration.variables.iter().map(|variable| variable.name.to_ascii_uppercase()));
            }
            Item::Header(header) => {
                self.declared.extend(header.parameters.iter().map(|parameter| parameter.name.to_ascii_uppercase()));
            }
            Item::If(_, Some(jump)) => steps.push(Step::Branch(self.goal(programs, jump))),
            Item::Goto(jump) => steps.push(Step::Jump(self.goal(programs, jump))),
            Item::Case(_, cases, default) => {
                let jumps = cases.iter().map(|(_, jump)| jump).chain(default);
                steps.extend(jumps.map(|jump| Step::Branch(self.goal(programs, jump))));
            }
            Item::If(_, None)
            | Item::For(..)
            | Item::While(_)
            | Item::Structure(Structure::Loop | Structure::Repeat | Structure::Else) => {
                let loops = !matches!(item, Item::If(..) | Item::Structure(Structure::Else));
                steps.push(self.block(programs, loops));
            }
            Item::RepeatPart { first, last, passes, one_block } => {
                steps.push(self.part(programs, (first, last.as_ref()), passes.as_ref(), *one_block));
            }
            Item::Synchronised(action) if action.coordinates() => {
                steps.push(Step::Hidden("a synchronised action does something for other channels".to_owned()));
            }
            Item::Synchronised(_)
            | Item::Modal
            | Item::Passes(..)
            | Item::External(_)
            | Item::Message(_)
            | Item::Until(_)
            | Item::Structure(_)
            | Item::Shared { .. } => {}
        }
    }

    /// The loop or branch that begins here.
    fn block(&mut self, programs: &dyn Programs, loops: bool) -> Step {
        let place = programs.place();
        match self.siemens.places(programs, place.file).partners.get(&place.line) {
            Some(partners) => Step::Block { end: Spot::line(partners.last), loops },
            None => Step::Mistake("the loop or branch has no matching statement".to_owned()),
        }
    }

    fn named(
        &mut self,
        programs: &mut dyn Programs,
        name: String,
        arguments: Vec<Argument>,
        passes: Option<u32>,
    ) -> Step {
        let program = match arguments.get(1) {
            Some(Argument::Text(path)) => settled(self.siemens.program_by_path(programs, path.trim())),
            _ => None,
        };
        let program = program.or_else(|| self.program(programs, &name));
        Step::Named(Named { name, arguments, program, passes })
    }

    fn program(&mut self, programs: &mut dyn Programs, name: &str) -> Found {
        settled(self.siemens.program(programs, name))
    }

    fn argument(&self, argument: &expression::Argument) -> Argument {
        let Ok(Some(expression)) = &argument.value else { return Argument::Computed };
        match (expression.as_constant(), as_name(expression)) {
            (Some(Data::Text(text)), _) => Argument::Text(text.clone()),
            (Some(value), _) => value.number().map_or(Argument::Computed, Argument::Number),
            (None, Some(name)) if name.index.is_empty() && !self.declared.contains(&name.name) => {
                Argument::Name(name.name.clone())
            }
            _ => Argument::Computed,
        }
    }

    /// Where a jump leads.
    fn goal(&mut self, programs: &dyn Programs, jump: &Jump) -> Goal {
        let place = programs.place();
        let places = self.siemens.places(programs, place.file);
        let around = places.program(place.range, place.line);
        let search = match jump.direction {
            Direction::Start => return Goal::At(Spot::line(around.0)),
            Direction::Forward => Search::Forward,
            Direction::Back => Search::Back,
            Direction::Either | Direction::Silent => Search::Around,
        };
        match &jump.target {
            Label::Value(_) => Goal::Computed,
            Label::Name(name) if self.declared.contains(name) => Goal::Computed,
            label => match places.find(label, search, place.line, around) {
                Some(line) => Goal::At(Spot::line(line)),
                // A target that GOTOC does not find is ignored.
                None if jump.direction == Direction::Silent => Goal::At(Spot::line(place.line)),
                None => Goal::Missing(shown(label)),
            },
        }
    }

    /// REPEAT and REPEATB of a part of the program.
    fn part(
        &mut self,
        programs: &dyn Programs,
        (first, last): (&Label, Option<&Label>),
        passes: Option<&Expression>,
        one_block: bool,
    ) -> Step {
        let place = programs.place();
        let places = self.siemens.places(programs, place.file);
        let around = places.program(place.range, place.line);
        let find = |label: &Label| match label {
            Label::Value(_) => Err(Step::Hidden("the label of the part that is repeated is computed".to_owned())),
            label => places
                .find(label, Search::BackThenForward, place.line, around)
                .ok_or_else(|| Step::Jump(Goal::Missing(shown(label)))),
        };
        let range = find(first).and_then(|from| {
            let to = match last {
                _ if one_block => from,
                Some(last) => find(last)?,
                None => {
                    let before = place.line.saturating_sub(1);
                    let end = places.labels.find("ENDLABEL", Search::FromTop, place.line, (from, before));
                    end.unwrap_or(before)
                }
            };
            Ok((from, to))
        });
        match range {
            Ok((from, to)) => {
                let passes = match passes {
                    None => Some(1),
                    Some(passes) => passes.as_constant().and_then(Data::number).and_then(whole),
                };
                let place = Some((place.file, Range { number: None, first: from, last: to }));
                Step::Call(Called { name: shown(first), place, passes })
            }
            Err(step) => step,
        }
    }
}

/// The result; a file that cannot be read counts as not found.
fn settled(outcome: Outcome<Found>) -> Found {
    outcome.ok().flatten()
}

/// A number of passes.
fn whole(passes: f64) -> Option<u32> {
    (passes.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&passes)).then_some(passes as u32)
}
