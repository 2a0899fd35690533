//! POS, POSA, FA and WAITP: axes that go to a position by themselves. ACC, VELOLIM, JERKLIM, ATOL: limits of single axes. FGROUP: axes of the feed.
//!
//! Facts: programming manual, fundamentals, chapter "traversing positioning axes": POS[axis] waits at the end of its block, POSA[axis]
//! does not, WAITP waits for such an axis; FA[axis] is its feed per minute, without it the axis moves at the rate of the machine.
//! Decisions: a positioning axis moves before the path of its block and the block waits for it, also with POSA, so that WAITP has
//! nothing to wait for; without FA it is rapid. Under G95 the feed of G94 is forgotten
//! (FA takes its place). Limits of single axes change nothing, which is told of those that change times; FGROUP of the geometry axes, or of none, is what is in force anyway, of others it is
//! ignored with a warning. *Invariant:* group 1, the type of the feed and F of the path stay as they are.

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
/// Limits of an axis or spindle that change nothing here.
const LIMITS: [&str; 4] = ["ACC", "VELOLIM", "JERKLIM", "ATOL"];
/// Axes of the path.
const GEOMETRY: [&str; 3] = ["X", "Y", "Z"];
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
        if LIMITS.contains(&name.name.as_str()) && host.is_code_text(RAPID) {
            return self.limit(host, name, value);
        }
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

    /// A limit of an axis or a spindle.
    fn limit(&mut self, host: &mut dyn Host, name: &Name, value: &Assigned) -> Outcome<bool> {
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
        let Assigned::One(value, _) = value else { return syntax(format!("{} takes a number", name.name)) };
        super::evaluate::number(&self.evaluate(host, value)?)?;
        if name.name != "ATOL" {
            let asked = self.written(host, name)?;
            super::moves::ignore_dynamics(host, &asked);
        }
        Ok(true)
    }

    /// FGROUP of the geometry axes, or of none.
    pub(super) fn groups_of_feed(host: &dyn Host, arguments: &[Argument]) -> bool {
        let mut left: Vec<&str> = GEOMETRY.into_iter().filter(|name| host.axis_letter(name).is_some()).collect();
        for argument in arguments {
            let Some(letter) = host.axis_letter(argument.text.trim()) else { return false };
            let Some(at) = left.iter().position(|name| name.eq_ignore_ascii_case(letter)) else { return false };
            left.remove(at);
        }
        arguments.is_empty() || left.is_empty()
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

    /// WAITP(axis, …): the axes are where they were to go. Whether it is one.
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
