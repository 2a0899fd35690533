//! POS, POSA, FA and WAITP: axes that move to a position independently. ACC, VELOLIM, JERKLIM, ATOL, FL: data of single
//! axes.
//!
//! Facts: programming manual, fundamentals, chapter "traversing positioning axes": positioning axes move independently
//! of the path, each with its own feed; POS[axis] waits at the end of its block, POSA[axis] does not, WAITP waits for
//! such an axis; FA[axis] is its feed per minute, without it the axis moves at the rate of the machine. Decisions: the
//! block also waits with POSA, so WAITP never waits; without FA an axis is rapid; all axes move together with the first
//! move of the block. Limits of single axes have no effect, with a warning if they would change times. *Invariant:*
//! group 1, the type of the feed and F of the path do not change.

use super::compiled::{IndexedName, SiemensArgument, as_name};
use super::item::AssignmentValue;
use super::left::SiemensRemainder;
use super::{Outcome, Siemens, SiemensBlockError, syntax, wrong_type};
use counterpoint_control_api::host::InterpreterHost;
use counterpoint_fault as diag;

/// The word for the machine's tables that ends blocks with POS.
const ARRIVE: &str = "SC_POS";
/// Data of an axis or spindle that have no effect here.
const LIMITS: [&str; 5] = ["ACC", "VELOLIM", "JERKLIM", "ATOL", "FL"];

/// Whether this is a word of an axis, as `X5`, `X-1` or `X=5`.
fn is_word_of(word: &str, letter: &str) -> bool {
    let rest = word.strip_prefix(letter);
    rest.is_some_and(|rest| rest.starts_with(|next: char| next.is_ascii_digit() || "+-.=".contains(next)))
}

impl Siemens {
    /// POS, POSA or FA of an axis; whether it is one.
    pub(super) fn positions(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &IndexedName,
        value: &AssignmentValue,
        left: &mut SiemensRemainder,
    ) -> Outcome<bool> {
        let [_] = name.index.as_slice() else { return Ok(false) };
        if name.name == "FGREF" {
            return self.feed_radius(host, name, value);
        }
        if name.name.starts_with("FXS") {
            return super::fixed_stop::assign(self, host, name, value);
        }
        if LIMITS.contains(&name.name.as_str()) && host.is_code_text(ARRIVE) {
            return self.limit(host, name, value);
        }
        if !matches!(name.name.as_str(), "POS" | "POSA" | "FA") || !host.is_code_text(ARRIVE) {
            return Ok(false);
        }
        let axis = self.axis_of(host, name)?.text();
        let Some(letter) = host.axis_letter(&axis).map(str::to_owned) else {
            return wrong_type(format!("the channel has no axis {axis}"));
        };
        if name.name == "FA" {
            let AssignmentValue::One(value, _) = value else { return syntax("FA takes a feed") };
            let feed = super::conversions::number(&self.evaluate(host, value)?)?;
            if feed < 0.0 {
                return wrong_type(format!("the feed {feed} of axis {axis} is below 0 (alarm 14810)"));
            }
            self.held.axis_feeds.insert(letter, feed);
            return Ok(true);
        }
        if turned(host) && matches!(letter.as_str(), "X" | "Y" | "Z") {
            let text = format!("{} of the geometry axis {axis} in a frame that is turned (alarm 16430)", name.name);
            return Err(SiemensBlockError::Alarm(&diag::SIEMENS_STATE, text));
        }
        let mut words = SiemensRemainder::counting_as(left);
        self.word(host, &IndexedName { name: letter.clone(), index: Vec::new() }, value, &mut words)?;
        let written = words.words.strip_prefix(letter.as_str()).map(|value| value.trim_start_matches('='));
        let Some(value) = written.and_then(|value| value.parse::<f64>().ok()) else {
            return wrong_type(format!("{} is not a position of axis {axis}", words.words));
        };
        let relative = left.relative.unwrap_or_else(|| host.relative());
        let axes = host.axes();
        let place = axes.iter().find(|place| place.letter == letter).filter(|_| relative);
        let to = place.map_or(value, |place| {
            let step = if place.diameter && host.steps_are_radii() { 2.0 } else { 1.0 };
            place.from + value * step
        });
        if left.beside.iter().any(|(other, _)| *other == letter) {
            let text = format!("{} of axis {axis} is there twice in the block (alarm 16420)", name.name);
            return Err(SiemensBlockError::Alarm(&diag::SIEMENS_STATE, text));
        }
        left.beside.push((letter, to));
        Ok(true)
    }

    /// Moves the positioning axes of the block; FA may be anywhere in the block. Moves that compensation holds back are
    /// made without them.
    pub(super) fn go_to_positions(&self, host: &mut dyn InterpreterHost, left: &mut SiemensRemainder) -> Outcome<()> {
        if left.beside.is_empty() {
            return Ok(());
        }
        for (letter, to) in &left.beside {
            if left.words.split(' ').any(|word| is_word_of(word, letter)) {
                let text =
                    format!("axis {letter} has a word and POS in the same block; program one of them (alarm 16420)");
                return Err(SiemensBlockError::Alarm(&diag::SIEMENS_STATE, text));
            }
            let feed = self.held.axis_feeds.get(letter).copied().filter(|feed| *feed > 0.0);
            host.go_beside(letter, *to, feed);
        }
        if host.keeps_moves_back() {
            left.before.push(ARRIVE.to_owned());
        } else {
            left.add(ARRIVE);
        }
        Ok(())
    }

    /// A limit of an axis or a spindle.
    fn limit(&mut self, host: &mut dyn InterpreterHost, name: &IndexedName, value: &AssignmentValue) -> Outcome<bool> {
        let is_spindle = name.index.first().and_then(as_name).is_some_and(|index| {
            let number = index.name.strip_prefix('S');
            number.is_some_and(|number| number.bytes().all(|byte| byte.is_ascii_digit()))
                && !self.variables.knows(&index.name)
        });
        if !is_spindle {
            let axis = self.axis_of(host, name)?.text();
            if host.axis_letter(&axis).is_none() {
                return wrong_type(format!("the channel has no axis {axis}"));
            }
        }
        let AssignmentValue::One(value, _) = value else { return syntax(format!("{} takes a number", name.name)) };
        super::conversions::number(&self.evaluate(host, value)?)?;
        if name.name != "ATOL" {
            let asked = self.written(host, name)?;
            super::moves::ignore_dynamics(host, &asked);
        }
        Ok(true)
    }

    /// WAITP(axis, …): the axes are where they were to go. Whether it is one.
    pub(super) fn waits_for_axes(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &str,
        arguments: &[SiemensArgument],
    ) -> Outcome<bool> {
        if name != "WAITP" || !host.is_code_text(ARRIVE) {
            return Ok(false);
        }
        for argument in arguments {
            let axis = self.axis_argument(host, argument)?;
            if host.axis_letter(&axis).is_none() {
                return wrong_type(format!("WAITP waits for axes of the channel, not for {axis}"));
            }
        }
        if arguments.is_empty() {
            return syntax("WAITP needs an axis");
        }
        Ok(true)
    }

    /// The name of the axis that an argument gives, by itself or as a value.
    pub(super) fn axis_argument(
        &mut self,
        host: &mut dyn InterpreterHost,
        argument: &SiemensArgument,
    ) -> Outcome<String> {
        Ok(match &argument.value {
            Ok(Some(expression)) => match as_name(expression) {
                Some(name) if name.index.is_empty() && !self.variables.knows(&name.name) => name.name.clone(),
                _ => self.evaluate(host, expression)?.text(),
            },
            _ => argument.text.clone(),
        })
    }
}

/// Whether the programmable frame is turned.
fn turned(host: &dyn InterpreterHost) -> bool {
    let frame = host.local_frame();
    (0..3).any(|row| {
        (0..3).any(|column| row != column && frame.get(row * 4 + column).is_some_and(|cell| cell.abs() > 1e-9))
    })
}
