//! Branches, loops, jumps and repetitions, executed.
//!
//! Facts: reference control-emulator.md 5.4. Decisions: FOR adds 1 and asks for its last value again after each pass; a
//! part that is repeated runs as a call of its blocks. Invariant: nothing is remembered of a loop, its partners are
//! found in the text.

use super::compiled::Expression;
use super::item::{AssignmentValue, SiemensItem, SiemensJump, SiemensJumpTarget, Structure};
use super::left::SiemensRemainder;
use super::run::{BlockContinuation, MOST_PASSES};
use super::value::Data;
use super::{Outcome, Siemens, syntax};
use counterpoint_control_api::host::{InterpreterHost, SubprogramCall};

impl Siemens {
    /// Branches, loops and jumps.
    pub(super) fn flow(
        &mut self,
        host: &mut dyn InterpreterHost,
        item: &SiemensItem,
        left: &mut SiemensRemainder,
    ) -> Outcome<BlockContinuation> {
        match item {
            SiemensItem::If(condition, jump) => {
                let holds = self.is_true(host, condition)?;
                let gone = match jump {
                    Some(jump) => holds && self.jump(host, jump)?,
                    None if holds => {
                        self.partners(host)?;
                        false
                    }
                    None => {
                        let partners = self.partners(host)?;
                        self.go(host, partners.otherwise.unwrap_or(partners.last).saturating_add(1))?;
                        true
                    }
                };
                // The statements after a jump that is not taken are executed, including further conditions.
                return Ok(if gone { BlockContinuation::Stop } else { BlockContinuation::Continue });
            }
            SiemensItem::Goto(jump) => {
                return Ok(if self.jump(host, jump)? { BlockContinuation::Stop } else { BlockContinuation::Continue });
            }
            SiemensItem::Case(value, cases, default) => self.case(host, value, cases, default.as_ref())?,
            SiemensItem::For(variable, first, _) => {
                let partners = self.partners(host)?;
                let value = AssignmentValue::One(first.clone(), String::new());
                self.set(host, variable, &value, left)?;
                if !self.loop_goes_on(host, item)? {
                    self.go(host, partners.last.saturating_add(1))?;
                }
            }
            SiemensItem::While(condition) | SiemensItem::Until(condition) => {
                host.tests_loop(true);
                let holds = self.is_true(host, condition);
                host.tests_loop(false);
                let holds = holds?;
                let partners = self.partners(host)?;
                let ahead = matches!(item, SiemensItem::While(_));
                if !holds {
                    self.go(host, if ahead { partners.last } else { partners.first }.saturating_add(1))?;
                }
            }
            SiemensItem::Structure(structure) => self.structure(host, *structure)?,
            SiemensItem::RepeatPart { first, last, passes, one_block } => {
                let passes = match passes {
                    Some(passes) => self.whole_number(host, passes)?,
                    None => 1,
                };
                if passes > MOST_PASSES {
                    return syntax(format!("{passes} passes are too many (maximum {MOST_PASSES})"));
                }
                left.call =
                    self.repeated(host, first, last.as_ref(), *one_block, u32::try_from(passes).unwrap_or(0))?;
            }
            _ => {}
        }
        Ok(BlockContinuation::Stop)
    }

    fn structure(&mut self, host: &mut dyn InterpreterHost, structure: Structure) -> Outcome<()> {
        let partners = self.partners(host)?;
        match structure {
            Structure::EndIf | Structure::Loop | Structure::Repeat => Ok(()),
            Structure::Else => self.go(host, partners.last.saturating_add(1)),
            Structure::EndLoop => self.go(host, partners.first.saturating_add(1)),
            Structure::EndWhile => self.go(host, partners.first),
            Structure::EndFor => {
                let file = host.place().file;
                let line = self.line_of(host, file, partners.first);
                let items = line.as_ref().as_ref().map_or(&[][..], |line| &line.items);
                let head = items.iter().find(|item| matches!(item, SiemensItem::For(..)));
                let Some(SiemensItem::For(variable, ..)) = head else { return syntax("ENDFOR has no FOR") };
                let Some(target) = self.locate(host, variable)? else {
                    return syntax(format!("{} of FOR is not a variable", variable.name));
                };
                let value = super::conversions::number(&self.value_of(host, &target)?)?;
                self.store(host, &target, Data::Real(value + 1.0))?;
                match head {
                    Some(head) if self.loop_goes_on(host, head)? => self.go(host, partners.first.saturating_add(1)),
                    _ => Ok(()),
                }
            }
        }
    }

    /// The variable of FOR is not beyond its last value.
    fn loop_goes_on(&mut self, host: &mut dyn InterpreterHost, head: &SiemensItem) -> Outcome<bool> {
        let SiemensItem::For(variable, _, last) = head else { return Ok(false) };
        let value = self.read(host, variable)?;
        let last = self.evaluate(host, last)?;
        Ok(super::conversions::number(&value)? <= super::conversions::number(&last)?)
    }

    fn case(
        &mut self,
        host: &mut dyn InterpreterHost,
        value: &Expression,
        cases: &[(Expression, SiemensJump)],
        default: Option<&SiemensJump>,
    ) -> Outcome<()> {
        let value = self.evaluate(host, value)?;
        for (constant, jump) in cases {
            let constant = self.evaluate(host, constant)?;
            let equal = match (value.number(), constant.number()) {
                (Some(value), Some(constant)) => value == constant,
                _ => value == constant,
            };
            if equal {
                self.jump(host, jump)?;
                return Ok(());
            }
        }
        if let Some(jump) = default {
            self.jump(host, jump)?;
        }
        Ok(())
    }

    /// REPEAT and REPEATB of a part of the program.
    fn repeated(
        &mut self,
        host: &mut dyn InterpreterHost,
        first: &SiemensJumpTarget,
        last: Option<&SiemensJumpTarget>,
        one_block: bool,
        passes: u32,
    ) -> Outcome<Option<SubprogramCall>> {
        let place = host.place();
        let from = self.label_line(host, first, &place)?;
        let to = match last {
            _ if one_block => from,
            Some(last) => self.label_line(host, last, &place)?,
            None => match self.end_label(host, &place, from) {
                Some(line) => line,
                None => place.line.saturating_sub(1),
            },
        };
        if to < from {
            return syntax("the part to be repeated ends before it starts");
        }
        if passes == 0 {
            return Ok(None);
        }
        let name = match first {
            SiemensJumpTarget::Number(number) => format!("N{number}"),
            SiemensJumpTarget::Name(name) => name.clone(),
            SiemensJumpTarget::Value(_) => "REPEAT".to_owned(),
        };
        Ok(Some(self.prepare_part(host, name, (from, to), passes)))
    }
}
