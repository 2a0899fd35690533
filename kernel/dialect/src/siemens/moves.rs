//! Statements about how moves are made: G functions by their numbers, axes that F counts for, dynamics of axes.
//!
//! Facts: programming manual of the control (G groups, FGROUP, ACC, VELOLIM, JERKLIM). *Invariant:* what is ignored is told.

use super::expression::{Argument, Expression};
use super::line::Assigned;
use super::run::Left;
use super::{Outcome, Siemens, syntax};
use crate::host::Host;
use counterpoint_fault as diag;

/// A setting of the dynamics of an axis, in per cent of those of the machine, changes nothing.
pub(super) fn ignore_dynamics(host: &mut dyn Host, asked: &str) {
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
        host: &mut dyn Host,
        group: &Expression,
        value: &Assigned,
        left: &mut Left,
    ) -> Outcome<()> {
        let Assigned::One(value, _) = value else { return syntax("G[…] takes the number of a function") };
        let group = super::evaluate::number(&self.evaluate(host, group)?)?;
        let number = super::evaluate::number(&self.evaluate(host, value)?)?;
        match super::groups::written(group as i64, number as i64)
            .filter(|_| group.fract() == 0.0 && number.fract() == 0.0)
        {
            Some(word) => left.add(&word),
            None => return syntax(format!("G group {group} has no function {number} here")),
        }
        Ok(())
    }

    /// FGROUP: the axes that F counts for. The geometry axes, or none, are those that it counts for anyway.
    pub(super) fn feed_group(&mut self, host: &mut dyn Host, arguments: &[Argument]) -> Outcome<()> {
        if Self::groups_of_feed(host, arguments) {
            return Ok(());
        }
        for argument in arguments {
            if !host.is_register(&argument.text.trim().to_ascii_uppercase()) {
                return syntax(format!("FGROUP takes names of axes, not '{}'", argument.text.trim()));
            }
        }
        let text = format!("FGROUP is ignored in '{}': F counts as without it", host.block_text());
        host.diagnose(&diag::SIEMENS_IGNORED, text);
        Ok(())
    }
}
