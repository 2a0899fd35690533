//! The effect of a block of an OSP program, without executing it.
//!
//! *Invariant:* labels and programs are found as the interpreter finds them. Decision: the number of passes of a call
//! with Q depends on a setting that macros of the machine make. So with macros that number counts as computed.

use super::lap::{self, LapRole};
use super::line::{BlockPrefix, LineReadOptions, OkumaItem, OkumaJumpTarget, OkumaLine, OkumaStatement, read};
use super::names::normal;
use super::text::prepare;
use super::{Okuma, line};
use counterpoint_control_api::host::ProgramHost;
use counterpoint_control_api::outline::{CallOutline, JumpDestination, OutlineReader, OutlineStep};
use counterpoint_control_api::statement::RETURN;
use counterpoint_control_api::words::part;
use counterpoint_program::spot::BlockStart;

/// The reader.
#[derive(Debug)]
pub(super) struct OkumaOutlineReader {
    okuma: Okuma,
    /// The machine has macros.
    macros: bool,
    /// G81 to G88 may be contours with a name and cycles along them.
    contours: bool,
}

impl OkumaOutlineReader {
    /// For a machine that has macros, which may make any setting, and that has no hole cycle on G81.
    pub(super) fn new(macros: bool, contours: bool) -> Self {
        Self { okuma: Okuma::new(!macros), macros, contours }
    }
}

impl OutlineReader for OkumaOutlineReader {
    fn outline(&mut self, programs: &mut dyn ProgramHost, text: &[u8]) -> Vec<OutlineStep> {
        let whole = self.okuma.continued(programs, text);
        let text = whole.as_ref().map_or(text, |(whole, _)| whole.as_slice());
        let mut block = prepare(text);
        if self.contours && lap::find(&mut block) == Some(LapRole::Begins) {
            return Vec::new();
        }
        match read(block, LineReadOptions { subprograms: true, drawing: self.macros, offsets: self.macros }) {
            Ok(line) => self.line(programs, &line),
            Err(mistake) => vec![OutlineStep::Mistake(mistake.to_string())],
        }
    }
}

impl OkumaOutlineReader {
    fn line(&mut self, programs: &mut dyn ProgramHost, line: &OkumaLine) -> Vec<OutlineStep> {
        let mut skipped = false;
        for head in &line.head {
            if let BlockPrefix::Mark(level) = head {
                skipped = programs.skips(*level);
            }
        }
        if skipped {
            return Vec::new();
        }
        match &line.statement {
            OkumaStatement::Drawing | OkumaStatement::Nothing | OkumaStatement::Continued | OkumaStatement::ModOut => {
                Vec::new()
            }
            OkumaStatement::Goto(condition, target) => {
                let goal = self.goal(programs, target);
                vec![if condition.is_some() { OutlineStep::Branch(goal) } else { OutlineStep::Jump(goal) }]
            }
            OkumaStatement::Loop(..) => {
                vec![self.partner(programs).map_or_else(unpaired, |end| OutlineStep::Block { end, loops: true })]
            }
            OkumaStatement::EndLoop(_) => self.partner(programs).map_or_else(|| vec![unpaired()], |_| Vec::new()),
            OkumaStatement::Call(call) => vec![self.call(programs, call)],
            OkumaStatement::ModIn(_) => vec![OutlineStep::Hidden("blocks that move call a program (MODIN)".to_owned())],
            OkumaStatement::Shared(shared, _) if **shared == RETURN => vec![OutlineStep::Return],
            OkumaStatement::Shared(..) => Vec::new(),
            OkumaStatement::Items(items) => words(items, &line.plain),
        }
    }

    /// The partner of a statement of a loop.
    fn partner(&mut self, programs: &dyn ProgramHost) -> Option<BlockStart> {
        let place = programs.place();
        self.okuma.index(programs, place.file).loops.partner(place.line).map(BlockStart::line)
    }

    fn goal(&mut self, programs: &dyn ProgramHost, target: &OkumaJumpTarget) -> JumpDestination {
        let OkumaJumpTarget::Named(name) = target else { return JumpDestination::Computed };
        let place = programs.place();
        let found = self.okuma.index(programs, place.file).label(name, place.line, place.range);
        found.map_or_else(
            || JumpDestination::Missing(format!("block N{name}")),
            |line| JumpDestination::At(BlockStart::line(line)),
        )
    }

    fn call(&mut self, programs: &mut dyn ProgramHost, call: &line::OkumaCall) -> OutlineStep {
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
            Ok(place) => OutlineStep::Call(CallOutline { name: call.name.clone(), place, passes }),
            Err(_) => OutlineStep::Hidden(format!("the file of {} cannot be read", call.name)),
        }
    }
}

/// A statement of a loop without a partner.
fn unpaired() -> OutlineStep {
    OutlineStep::Mistake("the statement has no matching one in the program".to_owned())
}

/// Words of a block: those with numbers as they are written.
fn words(items: &[OkumaItem], text: &[u8]) -> Vec<OutlineStep> {
    let (mut plain, mut steps) = (String::new(), Vec::new());
    for item in items {
        match item {
            OkumaItem::Plain(span) => plain.push_str(&part(text, *span)),
            OkumaItem::Set { name, number: Some(number), .. } if name.len() == 1 => {
                plain.push_str(name);
                plain.push_str(&part(text, *number));
            }
            OkumaItem::Set { name, .. } => steps.push(OutlineStep::Computed(name.clone())),
            OkumaItem::Text { .. } | OkumaItem::OfTool(..) => {}
        }
        plain.push(' ');
    }
    steps.insert(0, OutlineStep::Words(plain.into_bytes()));
    steps
}
