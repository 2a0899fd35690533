//! POS, POSA, FA and WAITP: axes that go to a position by themselves.
//!
//! Facts: programming manual, fundamentals, chapter "traversing positioning axes": POS[axis] waits at the end of its block, POSA[axis]
//! does not, WAITP waits for such an axis; FA[axis] is its feed per minute, without it the axis moves at the rate of the machine.
//! Decisions: a positioning axis moves before the path of its block and the block waits for it, also with POSA, so that WAITP has
//! nothing to wait for; without FA it is rapid. Under G95 the feed of G94 is forgotten
//! (FA takes its place). *Invariant:* group 1, the type of the feed and F of the path stay as they are.

use super::expression::{Argument, Name, as_name};
use super::line::Assigned;
use super::run::Left;
use super::value::shown;
use super::{Fault, Outcome, Siemens, syntax, wrong_type};
use crate::host::Host;
use counterpoint_fault as diag;
use counterpoint_machine::ident::codes;

/// Words for the machine's tables: a rapid move and a feed move, for their block.
const RAPID: &str = "SC_POS";
const FEED: &str = "SC_POSF";
/// Feed per minute.
const PER_MINUTE: &str = "G94";

impl Siemens {
    /// POS, POSA or FA of an axis; whether it is one.
    pub(super) fn positions(
        &mut self,
        host: &mut dyn Host,
        name: &Name,
        value: &Assigned,
        left: &mut Left,
    ) -> Outcome<bool> {
        let [_] = name.index.as_slice() else { return Ok(false) };
        if !matches!(name.name.as_str(), "POS" | "POSA" | "FA") || !host.is_code_text(RAPID) {
            return Ok(false);
        }
        let axis = self.axis_of(host, name)?.text();
        let Some(letter) = host.axis_letter(&axis).map(str::to_owned) else {
            return wrong_type(format!("the channel has no axis {axis}"));
        };
        if name.name == "FA" {
            let Assigned::One(value, _) = value else { return syntax("FA takes a feed") };
            let feed = super::evaluate::number(&self.evaluate(host, value)?)?;
            if feed < 0.0 {
                return wrong_type(format!("the feed {feed} of axis {axis} is below 0 (alarm 14810)"));
            }
            self.held.axis_feeds.insert(letter, feed);
            return Ok(true);
        }
        if turned(host) && matches!(letter.as_str(), "X" | "Y" | "Z") {
            let text = format!("{} of the geometry axis {axis} in a frame that is turned (alarm 16430)", name.name);
            return Err(Fault::Alarm(&diag::SIEMENS_STATE, text));
        }
        let mut words = Left::counting_as(left);
        self.word(host, &Name { name: letter.clone(), index: Vec::new() }, value, &mut words)?;
        let feed = self.held.axis_feeds.get(&letter).copied().filter(|feed| *feed > 0.0);
        let mode = left.relative.map_or("", |relative| if relative { "G91 " } else { "G90 " });
        let Some(feed) = feed else {
            left.before.push(format!("{mode}{RAPID} {}", words.words));
            return Ok(true);
        };
        let (kind, own) = self.path_feed(host)?;
        let minute = if kind == PER_MINUTE { "" } else { "G94 " };
        left.before.push(format!("{mode}{minute}{FEED} F{} {}", shown(feed), words.words));
        let own = own.filter(|_| kind != "G93").map_or_else(String::new, |own| format!("F{}", shown(own)));
        let back = [if kind == PER_MINUTE { "" } else { kind }, own.as_str()];
        let back = back.into_iter().filter(|word| !word.is_empty()).collect::<Vec<_>>().join(" ");
        if !back.is_empty() {
            left.before.push(back);
        }
        Ok(true)
    }

    /// The G function of the type of the feed, and the feed of the path if it has one.
    fn path_feed(&mut self, host: &mut dyn Host) -> Outcome<(&'static str, Option<f64>)> {
        let kinds = [(codes::FEED_UPR, "G95"), (codes::FEED_1T, "G93"), (codes::FEED_UPM, PER_MINUTE)];
        let modes = host.modes().0;
        let kind = kinds.iter().find(|(kind, _)| modes.iter().any(|(_, code, _)| code == kind));
        let feed = Name { name: "$P_F".to_owned(), index: Vec::new() };
        let own = self.quietly_asked(host, &feed)?;
        Ok((kind.map_or(PER_MINUTE, |(_, text)| text), own.filter(|own| *own > 0.0)))
    }

    fn quietly_asked(&mut self, host: &mut dyn Host, name: &Name) -> Outcome<Option<f64>> {
        match self.read(host, name) {
            Ok(value) => Ok(value.number()),
            Err(Fault::Alarm(..)) => Ok(None),
            Err(halt) => Err(halt),
        }
    }

    /// WAITP(axis, …): the axes are where they were to go.
    pub(super) fn waits_for_axes(&mut self, host: &mut dyn Host, name: &str, arguments: &[Argument]) -> Outcome<bool> {
        if name != "WAITP" || !host.is_code_text(RAPID) {
            return Ok(false);
        }
        for argument in arguments {
            let axis = match &argument.value {
                Ok(Some(expression)) => match as_name(expression) {
                    Some(name) if name.index.is_empty() && !self.variables.knows(&name.name) => name.name.clone(),
                    _ => self.evaluate(host, expression)?.text(),
                },
                _ => argument.text.clone(),
            };
            if host.axis_letter(&axis).is_none() {
                return wrong_type(format!("WAITP waits for axes of the channel, not for {axis}"));
            }
        }
        if arguments.is_empty() {
            return syntax("WAITP needs an axis");
        }
        Ok(true)
    }
}

/// The programmable frame is turned.
fn turned(host: &dyn Host) -> bool {
    let frame = host.local_frame();
    (0..3).any(|row| {
        (0..3).any(|column| row != column && frame.get(row * 4 + column).is_some_and(|cell| cell.abs() > 1e-9))
    })
}
