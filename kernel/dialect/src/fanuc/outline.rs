//! The effect of a block of custom macro, without executing it.
//!
//! *Invariant:* a word keeps its text as written, so that the scanner reads the text of the program.

use super::Fanuc;
use super::compile::compile;
use super::expr::Expr;
use super::statement::{Name, Statement, Target, TemplateWord};
use crate::host::Programs;
use crate::outline::{Goal, Reader, Step, sequence};
use crate::statement::RETURN;
use counterpoint_program::spot::Spot;

/// Variables whose assignment raises an alarm.
const ALARM: u32 = 3000;

impl Reader for Fanuc {
    fn outline(&mut self, programs: &mut dyn Programs, text: &[u8]) -> Vec<Step> {
        programs.strip(text, false, &mut self.stripped);
        match compile(&self.stripped, programs.names()) {
            Ok(line) => {
                let stripped = std::mem::take(&mut self.stripped);
                let mut steps = self.steps(programs, &line.statement, &stripped);
                if let (Some((start, end)), Some(Step::Words(words))) = (line.name, steps.first_mut()) {
                    words.extend_from_slice(stripped.get(start as usize..end as usize).unwrap_or_default());
                }
                self.stripped = stripped;
                steps
            }
            Err(error) => vec![Step::Mistake(error.to_string())],
        }
    }
}

impl Fanuc {
    fn steps(&mut self, programs: &mut dyn Programs, statement: &Statement, text: &[u8]) -> Vec<Step> {
        match statement {
            Statement::Words(words) => self::words(words, text),
            Statement::Assign(list) => {
                let alarms = list.iter().any(|(target, _)| *target == Target::Variable(ALARM));
                if alarms { vec![Step::Alarm] } else { Vec::new() }
            }
            Statement::IfGoto(_, target) => vec![Step::Branch(goal(programs, target))],
            Statement::Goto(target) => vec![Step::Jump(goal(programs, target))],
            Statement::IfThen(_, inner) => vec![Step::If(self.steps(programs, inner, text))],
            Statement::IfBlock(_) | Statement::Else => {
                let here = programs.spot();
                block(self.pairs(programs).of_branch(here), false)
            }
            Statement::While(..) | Statement::Do(_) => {
                let here = programs.spot();
                block(self.pairs(programs).of_loop(here), true)
            }
            Statement::End(_) => {
                let here = programs.spot();
                if self.pairs(programs).of_loop(here).is_some() { Vec::new() } else { block(None, true) }
            }
            Statement::Shared(shared, _) if **shared == RETURN => vec![Step::Return],
            Statement::EndIf | Statement::Shared(..) | Statement::Print(_) | Statement::PrintBinary(_) => Vec::new(),
        }
    }
}

fn block(partner: Option<Spot>, loops: bool) -> Vec<Step> {
    let mistake = || Step::Mistake("the statement has no matching one in the program".to_owned());
    vec![partner.map_or_else(mistake, |end| Step::Block { end, loops })]
}

fn goal(programs: &dyn Programs, target: &Expr) -> Goal {
    target.as_constant().map_or(Goal::Computed, |number| sequence(programs, number.round()))
}

/// Words as they are written, and the addresses of those that are computed.
fn words(words: &[TemplateWord], text: &[u8]) -> Vec<Step> {
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
            Name::Letter(letter) => char::from(letter).to_string(),
            Name::Register(..) | Name::Text(_) => {
                let letters = written.iter().take_while(|byte| byte.is_ascii_alphabetic() || **byte == b',');
                letters.map(|byte| char::from(byte.to_ascii_uppercase())).collect()
            }
        };
        steps.push(Step::Computed(address));
    }
    steps.insert(0, Step::Words(plain));
    steps
}
