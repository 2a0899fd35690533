//! Words of spindles: SPOS, SPOSA, LIMS and S with a number, SETMS.
//!
//! Facts: programming manual, fundamentals: `SPOS[n]=` and `LIMS[n]=` concern spindle n, without a number the master
//! spindle, which SETMS chooses; under G96 and after G25 and G26 `S<n>=` is a cutting speed or a limit, like S.
//! Decisions: an oriented stop is M19 with its angle, so the block also waits with SPOSA; a limit of a spindle other
//! than the master takes effect at its SETMS, since LIMS concerns the cutting speed of the master spindle. *Invariant:*
//! a block has one oriented stop of a spindle.

use super::compiled::{Expression, IndexedName, SiemensArgument};
use super::item::{AssignmentValue, PositionMode, SiemensItem};
use super::left::SiemensRemainder;
use super::value::Data;
use super::{Outcome, Siemens, SiemensBlockError, syntax, wrong_type};
use counterpoint_control_api::host::InterpreterHost;
use counterpoint_fault as diag;
use counterpoint_machine::ident::codes;

/// Numbers of spindles.
const SPINDLES: std::ops::RangeInclusive<i64> = 1..=31;

/// Whether a word makes a limit or a cutting speed of S, or ends the cutting speed.
pub(super) fn changes_speed(item: &SiemensItem) -> bool {
    let SiemensItem::Text(text) = item else { return false };
    let digits = text.strip_prefix(['G', 'g']).map_or("", |digits| digits.trim_start().trim_start_matches('0'));
    matches!(digits, "25" | "26" | "96" | "961" | "962" | "97" | "971" | "972" | "973")
}

/// `S<n>`
fn numbered_speed(address: &str) -> Option<i64> {
    address.strip_prefix('S').and_then(|digits| digits.parse().ok()).filter(|number| SPINDLES.contains(number))
}

/// G functions under which S is a cutting speed.
fn is_cutting_speed(word: &str) -> bool {
    word.strip_prefix(['G', 'g']).is_some_and(|digits| matches!(digits, "96" | "961" | "962"))
}

/// Whether the words are an oriented stop in the words of the machine.
fn is_stop(word: &str) -> bool {
    word.strip_prefix(['M', 'm']).is_some_and(|digits| digits.trim_start_matches('0') == "19")
}

impl Siemens {
    /// A word of a spindle; false if it is another word.
    pub(super) fn spindle_word(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &IndexedName,
        value: &AssignmentValue,
        left: &mut SiemensRemainder,
    ) -> Outcome<bool> {
        match (name.name.as_str(), name.index.as_slice()) {
            ("SPOS" | "SPOSA", index @ ([] | [_])) if host.is_register("SPOS=") => {
                self.orient_spindle(host, index.first(), value, left).map(|()| true)
            }
            ("LIMS", [index]) if host.is_register("LIMS=") => {
                let spindle = self.spindle_of(host, Some(index))?;
                let AssignmentValue::One(value, _) = value else { return syntax("LIMS[n] takes a speed") };
                let limit = super::conversions::number(&self.evaluate(host, value)?)?;
                self.limit_spindle(host, spindle, limit, left)?;
                Ok(true)
            }
            (address, []) if left.speed_is_other => {
                let Some(spindle) = numbered_speed(address) else { return Ok(false) };
                let AssignmentValue::One(value, _) = value else { return syntax(format!("{address} takes a speed")) };
                let value = super::conversions::number(&self.evaluate(host, value)?)?;
                if spindle == self.master(host)? {
                    left.add(&format!("S{}", Data::Real(value).word()));
                    return Ok(true);
                }
                if left.words.split(' ').any(|word| word.eq_ignore_ascii_case("G25")) {
                    return Ok(true);
                }
                if left.words.split(' ').any(|word| word.eq_ignore_ascii_case("G26")) {
                    self.held.limits.insert(spindle, value);
                    return Ok(true);
                }
                if !left.words.split(' ').any(is_cutting_speed) {
                    return Ok(false);
                }
                let text = format!(
                    "{address}= is a cutting speed only of the master spindle; program SETMS({spindle}) before it"
                );
                Err(SiemensBlockError::Alarm(&diag::SIEMENS_STATE, text))
            }
            _ => Ok(false),
        }
    }

    /// Number of the master spindle.
    fn master(&mut self, host: &mut dyn InterpreterHost) -> Outcome<i64> {
        let name = IndexedName { name: "$P_MSNUM".to_owned(), index: Vec::new() };
        match self.read(host, &name) {
            Ok(value) => Ok(value.number().map_or(1, |number| number as i64)),
            Err(SiemensBlockError::Alarm(..)) => Ok(1),
            Err(halt) => Err(halt),
        }
    }

    /// The spindle of an index, or the master spindle.
    fn spindle_of(&mut self, host: &mut dyn InterpreterHost, index: Option<&Expression>) -> Outcome<i64> {
        let Some(index) = index else { return self.master(host) };
        let number = self.whole_number(host, index)?;
        if SPINDLES.contains(&number) { Ok(number) } else { wrong_type(format!("spindle {number} does not exist")) }
    }

    /// SPOS and SPOSA.
    fn orient_spindle(
        &mut self,
        host: &mut dyn InterpreterHost,
        index: Option<&Expression>,
        value: &AssignmentValue,
        left: &mut SiemensRemainder,
    ) -> Outcome<()> {
        let master = self.master(host)?;
        let spindle = match index {
            None => master,
            Some(_) => self.spindle_of(host, index)?,
        };
        let (way, value) = match value {
            AssignmentValue::One(value, _) => (PositionMode::Absolute, value),
            AssignmentValue::Positioned(way, value, _) => (*way, value),
            AssignmentValue::List(_) | AssignmentValue::Fill(_) => return syntax("SPOS takes an angle"),
        };
        let value = super::conversions::number(&self.evaluate(host, value)?)?;
        if value.abs() > 1e9 {
            return wrong_type("the angle of SPOS is out of range");
        }
        let angle = match way {
            PositionMode::Incremental => {
                let oriented = spindle == master && host.is_active(codes::SPINDLE_ORIENT);
                let Some(last) = self.held.spindle.filter(|_| oriented) else {
                    return syntax("SPOS=IC( ) needs an SPOS before it, without M3, M4 or M5 in between");
                };
                (last + value).rem_euclid(360.0)
            }
            PositionMode::Absolute
            | PositionMode::Shortest
            | PositionMode::Positive
            | PositionMode::Negative
            | PositionMode::Value => value,
            _ => return syntax("SPOS takes an angle, AC, IC, DC, ACP or ACN"),
        };
        let stop = if spindle == master {
            self.held.spindle = Some(angle);
            "M19".to_owned()
        } else {
            let stop = format!("M{spindle}=19");
            if !host.is_code_text(&stop) {
                return wrong_type(format!("the channel has no spindle {spindle} for SPOS"));
            }
            stop
        };
        left.add(&format!("{stop} SPOS={}", Data::Real(angle).word()));
        left.oriented |= spindle == master;
        Ok(())
    }

    /// LIMS of a spindle.
    fn limit_spindle(
        &mut self,
        host: &mut dyn InterpreterHost,
        spindle: i64,
        limit: f64,
        left: &mut SiemensRemainder,
    ) -> Outcome<()> {
        if !(0.0..=999_999.0).contains(&limit) {
            return wrong_type("the limit of LIMS is out of range");
        }
        if spindle == self.master(host)? {
            left.add(&format!("LIMS={}", Data::Real(limit).word()));
        } else {
            self.held.limits.insert(spindle, limit);
        }
        Ok(())
    }

    /// SETMS, SETMS(n): the words that choose the master spindle; false if the machine has none.
    pub(super) fn master_spindle(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &str,
        arguments: &[SiemensArgument],
        left: &mut SiemensRemainder,
    ) -> Outcome<bool> {
        if name != "SETMS" {
            return Ok(false);
        }
        let number = match arguments {
            [] => None,
            [argument] => self.argument(host, argument)?.and_then(|value| value.number()),
            _ => return syntax("SETMS takes the number of one spindle"),
        };
        let has_others = host.is_code_text("SETMS");
        let word = match number {
            None if has_others => "SETMS".to_owned(),
            // The only spindle is the master spindle.
            None => return Ok(true),
            Some(number) if number == 1.0 && !has_others => return Ok(true),
            Some(number) => format!("SC_MASTER{}", super::number_text::shown(number)),
        };
        if !host.is_code_text(&word) {
            let number = number.map_or_else(String::new, super::number_text::shown);
            return wrong_type(format!("the channel has no spindle {number} for SETMS"));
        }
        let limit = number.and_then(|number| self.held.limits.remove(&(number as i64)));
        match limit {
            None => left.add(&word),
            Some(limit) => {
                left.before.push(word);
                left.add(&format!("LIMS={}", Data::Real(limit).word()));
            }
        }
        Ok(true)
    }
}

/// A block with M19 beside SPOS has one oriented stop.
pub(super) fn stop_once(left: &mut SiemensRemainder) {
    if !left.oriented {
        return;
    }
    let mut stops = 0;
    let kept = left.words.split(' ').filter(|word| {
        stops += usize::from(is_stop(word));
        !is_stop(word) || stops == 1
    });
    left.replace(kept.collect::<Vec<_>>().join(" "));
}
