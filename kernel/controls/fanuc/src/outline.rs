//! The effect of a block of custom macro, without executing it.
//!
//! *Invariant:* a word keeps its text as written, so that the scanner reads the text of the program.

use super::Fanuc;
use super::compile::compile;
use super::expr::Expr;
use super::statement::{AssignmentTarget, FanucStatement, TemplateWord, WordName};
use counterpoint_control_api::host::ProgramHost;
use counterpoint_control_api::outline::{JumpDestination, OutlineReader, OutlineStep, sequence};
use counterpoint_control_api::statement::RETURN;
use counterpoint_program::spot::BlockStart;

/// Variables whose assignment raises an alarm.
const ALARM: u32 = 3000;

impl OutlineReader for Fanuc {
    fn outline(&mut self, programs: &mut dyn ProgramHost, text: &[u8]) -> Vec<OutlineStep> {
        programs.strip(text, false, &mut self.stripped);
        match compile(&self.stripped, programs.names()) {
            Ok(line) => {
                let stripped = std::mem::take(&mut self.stripped);
                let mut steps = self.steps(programs, &line.statement, &stripped);
                if let (Some((start, end)), Some(OutlineStep::Words(words))) = (line.name, steps.first_mut()) {
                    words.extend_from_slice(stripped.get(start as usize..end as usize).unwrap_or_default());
                }
                self.stripped = stripped;
                steps
            }
            Err(error) => vec![OutlineStep::Mistake(error.to_string())],
        }
    }
}

impl Fanuc {
    fn steps(&mut self, programs: &mut dyn ProgramHost, statement: &FanucStatement, text: &[u8]) -> Vec<OutlineStep> {
        match statement {
            FanucStatement::Words(words) => self::words(words, text),
            FanucStatement::Assign(list) => {
                let alarms = list.iter().any(|(target, _)| *target == AssignmentTarget::Variable(ALARM));
                if alarms { vec![OutlineStep::Alarm] } else { Vec::new() }
            }
            FanucStatement::IfGoto(_, target) => vec![OutlineStep::Branch(goal(programs, target))],
            FanucStatement::Goto(target) => vec![OutlineStep::Jump(goal(programs, target))],
            FanucStatement::IfThen(_, inner) => vec![OutlineStep::If(self.steps(programs, inner, text))],
            FanucStatement::IfBlock(_) | FanucStatement::Else => {
                let here = programs.spot();
                block(self.pairs(programs).of_branch(here), false)
            }
            FanucStatement::While(..) | FanucStatement::Do(_) => {
                let here = programs.spot();
                block(self.pairs(programs).of_loop(here), true)
            }
            FanucStatement::End(_) => {
                let here = programs.spot();
                if self.pairs(programs).of_loop(here).is_some() { Vec::new() } else { block(None, true) }
            }
            FanucStatement::Shared(shared, _) if **shared == RETURN => vec![OutlineStep::Return],
            FanucStatement::EndIf
            | FanucStatement::Shared(..)
            | FanucStatement::Print(_)
            | FanucStatement::PrintBinary(_) => Vec::new(),
        }
    }
}

fn block(partner: Option<BlockStart>, loops: bool) -> Vec<OutlineStep> {
    let mistake = || OutlineStep::Mistake("the statement has no matching one in the program".to_owned());
    vec![partner.map_or_else(mistake, |end| OutlineStep::Block { end, loops })]
}

fn goal(programs: &dyn ProgramHost, target: &Expr) -> JumpDestination {
    target.as_constant().map_or(JumpDestination::Computed, |number| sequence(programs, number.round()))
}

/// Words as they are written, and the addresses of those that are computed.
fn words(words: &[TemplateWord], text: &[u8]) -> Vec<OutlineStep> {
    let mut plain = Vec::with_capacity(text.len());
    let mut steps = Vec::new();
    for word in words {
        let written = text.get(word.start as usize..word.end as usize).unwrap_or_default();
        if word.value.as_constant().is_some() && !written.contains(&b'[') {
            plain.extend_from_slice(written);
            plain.push(b' ');
            continue;
        }
        let address = match word.name {
            WordName::Letter(letter) => char::from(letter).to_string(),
            WordName::Register(..) | WordName::Text(_) => {
                let letters = written.iter().take_while(|byte| byte.is_ascii_alphabetic() || **byte == b',');
                letters.map(|byte| char::from(byte.to_ascii_uppercase())).collect()
            }
        };
        steps.push(OutlineStep::Computed(address));
    }
    steps.insert(0, OutlineStep::Words(plain));
    steps
}
