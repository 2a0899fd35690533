//! Statements about how moves are made: G functions by their numbers, axes that F counts for and their radii, dynamics
//! of axes.
//!
//! Facts: programming manual of the control (G groups, FGROUP, FGREF, ACC, VELOLIM, JERKLIM). *Invariant:* every
//! ignored statement is reported.

use super::compiled::{Expression, IndexedName, SiemensArgument};
use super::item::AssignmentValue;
use super::left::SiemensRemainder;
use super::{Outcome, Siemens, syntax, wrong_type};
use counterpoint_control_api::host::InterpreterHost;
use counterpoint_fault as diag;

/// A setting of the dynamics of an axis, in per cent of those of the machine, changes nothing.
pub(super) fn ignore_dynamics(host: &mut dyn InterpreterHost, asked: &str) {
    let text = format!(
        "{asked} is ignored in '{}': moves take the time that the dynamics of the machine allow",
        host.block_text()
    );
    host.diagnose(&diag::SIEMENS_IGNORED, text);
}

impl Siemens {
    /// `G[group]=n`: the function of a G group with this number.
    pub(super) fn indirect_function(
        &mut self,
        host: &mut dyn InterpreterHost,
        group: &Expression,
        value: &AssignmentValue,
        left: &mut SiemensRemainder,
    ) -> Outcome<()> {
        let AssignmentValue::One(value, _) = value else { return syntax("G[…] takes the number of a function") };
        let group = super::conversions::number(&self.evaluate(host, group)?)?;
        let number = super::conversions::number(&self.evaluate(host, value)?)?;
        match super::groups::written(group as i64, number as i64)
            .filter(|_| group.fract() == 0.0 && number.fract() == 0.0)
        {
            Some(word) => left.add(&word),
            None => return syntax(format!("G group {group} has no function {number} here")),
        }
        Ok(())
    }

    /// FGROUP: the axes that F counts for, by default the geometry axes; all others move along.
    pub(super) fn feed_group(&mut self, host: &mut dyn InterpreterHost, arguments: &[SiemensArgument]) -> Outcome<()> {
        let mut letters = Vec::new();
        for argument in arguments.iter().filter(|argument| !argument.text.trim().is_empty()) {
            let axis = self.axis_argument(host, argument)?;
            let Some(letter) = host.axis_letter(axis.trim()) else {
                return syntax(format!("FGROUP takes names of axes of the channel, not '{}'", argument.text.trim()));
            };
            letters.push(letter.to_owned());
        }
        host.count_feed(&letters);
        Ok(())
    }

    /// FGREF[axis]: the radius at which F counts the travel of a rotary axis.
    pub(super) fn feed_radius(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &IndexedName,
        value: &AssignmentValue,
    ) -> Outcome<bool> {
        let axis = self.axis_of(host, name)?.text();
        let Some(letter) = host.axis_letter(&axis).map(str::to_owned) else {
            return wrong_type(format!("the channel has no axis {axis}"));
        };
        let AssignmentValue::One(value, _) = value else { return syntax("FGREF takes a radius") };
        let radius = super::conversions::number(&self.evaluate(host, value)?)?;
        if radius.is_nan() || radius <= 0.0 {
            return wrong_type(format!("the radius {radius} of FGREF is not above 0"));
        }
        if !host.set_feed_radius(&letter, radius) {
            let text = format!("FGREF is ignored in '{}': axis {axis} does not turn", host.block_text());
            host.diagnose(&diag::SIEMENS_IGNORED, text);
        }
        Ok(true)
    }
}
