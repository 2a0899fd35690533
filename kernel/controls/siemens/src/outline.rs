//! The effect of a block of an 840D program, without executing it.
//!
//! Decisions: a name that is declared as a variable may hold any label or number; names that DEFINE replaces may mean
//! anything. *Invariant:* labels, partners of loops and programs are found as the interpreter finds them.

use rustc_hash::FxHashSet;

use super::compiled::{Expression, SiemensArgument, as_name};
use super::item::{
    AssignmentValue, JumpDirection, SiemensItem, SiemensJump, SiemensJumpTarget, SiemensLine, Structure,
};
use super::jumps::{is_head, shown};
use super::line::read;
use super::run::skipped;
use super::value::Data;
use super::{Outcome, Siemens};
use counterpoint_control_api::host::ProgramHost;
use counterpoint_control_api::outline::{
    CallOutline, JumpDestination, NamedStatement, OutlineReader, OutlineStep, StatementArgument,
};
use counterpoint_control_api::text::without_comment;
use counterpoint_event::FileId;
use counterpoint_program::search::LabelSearchOrder;
use counterpoint_program::shape::ProgramRange;
use counterpoint_program::spot::BlockStart;

/// The reader, with the declarations of the blocks so far.
#[derive(Debug, Default)]
pub(super) struct SiemensOutlineReader {
    siemens: Siemens,
    declared: FxHashSet<String>,
}

type Found = Option<(FileId, ProgramRange)>;

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

impl OutlineReader for SiemensOutlineReader {
    fn outline(&mut self, programs: &mut dyn ProgramHost, text: &[u8]) -> Vec<OutlineStep> {
        let text = String::from_utf8_lossy(text);
        let Some(text) = skipped(programs, &text).filter(|text| !is_head(text)) else { return Vec::new() };
        match read(without_comment(text)) {
            Ok(line) => self.line(programs, &line),
            Err(text) => vec![OutlineStep::Mistake(text)],
        }
    }
}

impl SiemensOutlineReader {
    fn line(&mut self, programs: &mut dyn ProgramHost, line: &SiemensLine) -> Vec<OutlineStep> {
        let passes = line.items.iter().find_map(|item| match item {
            SiemensItem::Passes(passes, _) => Some(passes.as_constant().and_then(Data::number)),
            _ => None,
        });
        let passes = match passes {
            None => Some(1),
            Some(passes) => passes.and_then(whole),
        };
        let mut steps = Vec::new();
        for (at, item) in line.items.iter().enumerate() {
            if let SiemensItem::If(_, Some(jump)) = item {
                steps.push(OutlineStep::Branch(self.goal(programs, jump)));
                let rest = SiemensLine {
                    items: line.items.get(at + 1..).unwrap_or_default().to_vec(),
                    ..SiemensLine::default()
                };
                if !rest.items.is_empty() {
                    steps.push(OutlineStep::If(self.line(programs, &rest)));
                }
                break;
            }
            if matches!(item, SiemensItem::Modal) {
                let rest = SiemensLine {
                    items: line.items.get(at + 1..).unwrap_or_default().to_vec(),
                    ..SiemensLine::default()
                };
                // Alone it ends the calls.
                if !rest.items.is_empty() {
                    steps.push(OutlineStep::Modal(self.line(programs, &rest)));
                }
                break;
            }
            self.item(programs, item, passes, &mut steps);
        }
        steps
    }

    fn item(
        &mut self,
        programs: &mut dyn ProgramHost,
        item: &SiemensItem,
        passes: Option<u32>,
        steps: &mut Vec<OutlineStep>,
    ) {
        match item {
            SiemensItem::Text(text) => steps.push(OutlineStep::Words(without_rewritten(text))),
            SiemensItem::Set { name, value: AssignmentValue::One(value, _), .. }
                if name.name.len() == 1
                    && name.name != "R"
                    && name.index.is_empty()
                    && let Some(number) = value.as_constant().and_then(Data::number) =>
            {
                steps.push(OutlineStep::Words(format!("{}{number}", name.name).into_bytes()));
            }
            SiemensItem::Set { name, value, .. } => {
                let constant = matches!(value, AssignmentValue::One(value, _) if value.as_constant().is_some())
                    || name.name.len() > 3;
                if !constant {
                    steps.push(OutlineStep::Computed(name.name.clone()));
                }
            }
            SiemensItem::Bare(written) => {
                let name = written.to_ascii_uppercase();
                steps.push(self.named(programs, name, Vec::new(), passes));
            }
            SiemensItem::Function(name, arguments) => {
                let arguments = arguments.iter().map(|argument| self.argument(argument)).collect();
                steps.push(self.named(programs, name.clone(), arguments, passes));
            }
            SiemensItem::Program(name) => {
                let place = self.program(programs, name);
                steps.push(OutlineStep::Call(CallOutline { name: name.clone(), place, passes }));
            }
            SiemensItem::CallText { name, section: None, .. } => match name.as_constant() {
                Some(Data::Text(path)) => {
                    let place = settled(self.siemens.program_by_path(programs, path.trim()));
                    steps.push(OutlineStep::Call(CallOutline { name: path.trim().to_owned(), place, passes }));
                }
                _ => steps.push(OutlineStep::Hidden("the name of the program that is called is computed".to_owned())),
            },
            SiemensItem::CallText { .. } => steps.push(OutlineStep::Hidden("a part of a program is called".to_owned())),
            SiemensItem::Return(_, false) => steps.push(OutlineStep::Return),
            SiemensItem::Return(_, true) => {
                steps.push(OutlineStep::Hidden("the return goes to another block".to_owned()))
            }
            SiemensItem::Define(name, _) => {
                steps.push(OutlineStep::Hidden(format!("DEFINE gives {name} another meaning")))
            }
            SiemensItem::Declare(declaration) | SiemensItem::Redeclare(declaration) => {
                self.declared.extend(declaration.variables.iter().map(|variable| variable.name.to_ascii_uppercase()));
            }
            SiemensItem::Header(header) => {
                self.declared.extend(header.parameters.iter().map(|parameter| parameter.name.to_ascii_uppercase()));
            }
            SiemensItem::If(_, Some(jump)) => steps.push(OutlineStep::Branch(self.goal(programs, jump))),
            SiemensItem::Goto(jump) => steps.push(OutlineStep::Jump(self.goal(programs, jump))),
            SiemensItem::Case(_, cases, default) => {
                let jumps = cases.iter().map(|(_, jump)| jump).chain(default);
                steps.extend(jumps.map(|jump| OutlineStep::Branch(self.goal(programs, jump))));
            }
            SiemensItem::If(_, None)
            | SiemensItem::For(..)
            | SiemensItem::While(_)
            | SiemensItem::Structure(Structure::Loop | Structure::Repeat | Structure::Else) => {
                let loops = !matches!(item, SiemensItem::If(..) | SiemensItem::Structure(Structure::Else));
                steps.push(self.block(programs, loops));
            }
            SiemensItem::RepeatPart { first, last, passes, one_block } => {
                steps.push(self.part(programs, (first, last.as_ref()), passes.as_ref(), *one_block));
            }
            SiemensItem::Synchronised(action) if action.coordinates() => {
                steps.push(OutlineStep::Hidden("a synchronised action does something for other channels".to_owned()));
            }
            SiemensItem::Synchronised(_)
            | SiemensItem::Modal
            | SiemensItem::Passes(..)
            | SiemensItem::External(_)
            | SiemensItem::Message(_)
            | SiemensItem::Until(_)
            | SiemensItem::Structure(_)
            | SiemensItem::Shared { .. } => {}
        }
    }

    /// The loop or branch that begins here.
    fn block(&mut self, programs: &dyn ProgramHost, loops: bool) -> OutlineStep {
        let place = programs.place();
        match self.siemens.places(programs, place.file).partners.get(&place.line) {
            Some(partners) => OutlineStep::Block { end: BlockStart::line(partners.last), loops },
            None => OutlineStep::Mistake("the loop or branch has no matching statement".to_owned()),
        }
    }

    fn named(
        &mut self,
        programs: &mut dyn ProgramHost,
        name: String,
        arguments: Vec<StatementArgument>,
        passes: Option<u32>,
    ) -> OutlineStep {
        let program = match arguments.get(1) {
            Some(StatementArgument::Text(path)) => settled(self.siemens.program_by_path(programs, path.trim())),
            _ => None,
        };
        let program = program.or_else(|| self.program(programs, &name));
        OutlineStep::Named(NamedStatement { name, arguments, program, passes })
    }

    fn program(&mut self, programs: &mut dyn ProgramHost, name: &str) -> Found {
        settled(self.siemens.program(programs, name))
    }

    fn argument(&self, argument: &SiemensArgument) -> StatementArgument {
        let Ok(Some(expression)) = &argument.value else { return StatementArgument::Computed };
        match (expression.as_constant(), as_name(expression)) {
            (Some(Data::Text(text)), _) => StatementArgument::Text(text.clone()),
            (Some(value), _) => value.number().map_or(StatementArgument::Computed, StatementArgument::Number),
            (None, Some(name)) if name.index.is_empty() && !self.declared.contains(&name.name) => {
                StatementArgument::Name(name.name.clone())
            }
            _ => StatementArgument::Computed,
        }
    }

    /// Where a jump leads.
    fn goal(&mut self, programs: &dyn ProgramHost, jump: &SiemensJump) -> JumpDestination {
        let place = programs.place();
        let places = self.siemens.places(programs, place.file);
        let around = places.program(place.range, place.line);
        let search = match jump.direction {
            JumpDirection::Start => return JumpDestination::At(BlockStart::line(around.0)),
            JumpDirection::Forward => LabelSearchOrder::Forward,
            JumpDirection::Back => LabelSearchOrder::Back,
            JumpDirection::Either | JumpDirection::Silent => LabelSearchOrder::Around,
        };
        match &jump.target {
            SiemensJumpTarget::Value(_) => JumpDestination::Computed,
            SiemensJumpTarget::Name(name) if self.declared.contains(name) => JumpDestination::Computed,
            label => match places.find(label, search, place.line, around) {
                Some(line) => JumpDestination::At(BlockStart::line(line)),
                // A target that GOTOC does not find is ignored.
                None if jump.direction == JumpDirection::Silent => JumpDestination::At(BlockStart::line(place.line)),
                None => JumpDestination::Missing(shown(label)),
            },
        }
    }

    /// REPEAT and REPEATB of a part of the program.
    fn part(
        &mut self,
        programs: &dyn ProgramHost,
        (first, last): (&SiemensJumpTarget, Option<&SiemensJumpTarget>),
        passes: Option<&Expression>,
        one_block: bool,
    ) -> OutlineStep {
        let place = programs.place();
        let places = self.siemens.places(programs, place.file);
        let around = places.program(place.range, place.line);
        let find = |label: &SiemensJumpTarget| match label {
            SiemensJumpTarget::Value(_) => {
                Err(OutlineStep::Hidden("the label of the part that is repeated is computed".to_owned()))
            }
            label => places
                .find(label, LabelSearchOrder::BackThenForward, place.line, around)
                .ok_or_else(|| OutlineStep::Jump(JumpDestination::Missing(shown(label)))),
        };
        let range = find(first).and_then(|from| {
            let to = match last {
                _ if one_block => from,
                Some(last) => find(last)?,
                None => {
                    let before = place.line.saturating_sub(1);
                    let end = places.labels.find("ENDLABEL", LabelSearchOrder::FromTop, place.line, (from, before));
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
                let place = Some((place.file, ProgramRange { number: None, first: from, last: to }));
                OutlineStep::Call(CallOutline { name: shown(first), place, passes })
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
