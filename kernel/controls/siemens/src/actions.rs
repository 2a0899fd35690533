//! Synchronised actions: `ID=1 WHEN condition DO action`, with WHENEVER, EVERY, FROM or no condition, and CANCEL.
//!
//! Facts: programming manual, synchronised actions: the control tests conditions in its interpolation cycle, a WHEN
//! acts once, a WHENEVER in each cycle while it is true, an EVERY when it becomes true, a FROM in each cycle after it
//! was true once; an action without ID holds for the next block, with ID to the end of the program, with IDS beyond it.
//! Decisions: conditions are tested at the start of a block, so one that is true only within a move is missed; actions
//! set variables and outputs, give M codes to the starting block, set alarms (SETAL), and set and clear marks of
//! channels (SETM, CLEARM). *Invariant:* an action that is not possible here is refused where it is written, so no axis
//! moves differently from the control without a report.

use counterpoint_control_api::host::InterpreterHost;
use counterpoint_fault as diag;

use super::compiled::SiemensArgument;
use super::cursor::SiemensCursor;
use super::expression::{expression, unexpected};
use super::item::{SiemensItem, SynchronisedAction, Trigger};
use super::left::SiemensRemainder;
use super::{Outcome, Siemens, SiemensBlockError, syntax};

/// Most actions that wait.
const MOST: usize = 255;
/// Tests of an action without a number: where the next block begins, and the block after it.
const TESTS: u8 = 2;
/// Variables that actions set.
const SET: [&str; 7] = ["$AC_MARKER", "$AC_PARAM", "$AC_TIMER", "$A_OUT", "$A_OUTA", "$A_DB", "R"];

/// An action that waits.
#[derive(Debug)]
pub(super) struct ArmedAction {
    number: Option<i64>,
    stays: bool,
    action: std::sync::Arc<SynchronisedAction>,
    was: bool,
    tests: u8,
}

impl ArmedAction {
    pub(super) fn stays(&self) -> bool {
        self.stays
    }
}

fn trigger(name: &str) -> Option<Trigger> {
    Some(match name {
        "WHEN" => Trigger::Once,
        "WHENEVER" => Trigger::While,
        "EVERY" => Trigger::Edge,
        "FROM" => Trigger::Since,
        "DO" => Trigger::Always,
        _ => return None,
    })
}

/// Whether a word begins an action.
pub(super) fn begins(name: &str, cursor: &SiemensCursor<'_>) -> bool {
    trigger(name).is_some() || matches!(name, "ID" | "IDS") && cursor.rest().trim_start().starts_with('=')
}

/// Reads an action whose first word is `name`; it takes the rest of the block. `read_item` reads a word or statement.
pub(super) fn action(
    cursor: &mut SiemensCursor<'_>,
    name: &str,
    read_item: impl Fn(&mut SiemensCursor<'_>) -> Result<SiemensItem, String>,
) -> Result<SiemensItem, String> {
    // Values of the main run are those of the block here.
    let text = cursor.rest().replace("$$", "$").replace("$R", "R");
    let mut inner = SiemensCursor::new(&text);
    while !cursor.is_at_end() {
        cursor.step();
    }
    let mut number = None;
    let mut key = name.to_owned();
    if matches!(name, "ID" | "IDS") {
        inner.takes("=");
        number = Some((expression(&mut inner)?, name == "IDS"));
        key = inner.name().unwrap_or_default().to_ascii_uppercase();
    }
    let Some(trigger) = trigger(&key) else {
        return Err(format!("{name}= needs WHEN, WHENEVER, EVERY, FROM or DO, not '{key}'"));
    };
    let mut condition = None;
    if trigger != Trigger::Always {
        condition = Some(expression(&mut inner)?);
        if !inner.word("DO") {
            return Err(format!("DO is missing, {}", unexpected(&inner)));
        }
    }
    let mut does = Vec::new();
    loop {
        inner.blanks();
        if inner.is_at_end() {
            break;
        }
        does.push(read_item(&mut inner)?);
    }
    Ok(SiemensItem::Synchronised(std::sync::Arc::new(SynchronisedAction {
        number,
        trigger,
        condition,
        does,
        text: text.trim().to_owned(),
    })))
}

impl Siemens {
    /// An action is written: it waits from now on.
    pub(super) fn synchronise(
        &mut self,
        host: &mut dyn InterpreterHost,
        action: &std::sync::Arc<SynchronisedAction>,
    ) -> Outcome<()> {
        for item in &action.does {
            self.check_action(item, &action.text)?;
        }
        let number = match &action.number {
            Some((number, _)) => Some(self.whole_number(host, number)?),
            None => None,
        };
        if number.is_some_and(|number| !(1..=MOST as i64).contains(&number)) {
            return super::wrong_type(format!("a synchronised action has a number from 1 to {MOST}"));
        }
        self.held.actions.retain(|waiting| number.is_none() || waiting.number != number);
        if self.held.actions.len() >= MOST {
            return super::wrong_type(format!("more than {MOST} synchronised actions wait"));
        }
        let stays = action.number.as_ref().is_some_and(|(_, stays)| *stays);
        self.held.actions.push(ArmedAction { number, stays, action: action.clone(), was: false, tests: TESTS });
        self.watch(host);
        Ok(())
    }

    /// Refuses actions that are not possible here.
    fn check_action(&self, item: &SiemensItem, text: &str) -> Outcome<()> {
        let fits = match item {
            SiemensItem::Set { name, .. } => {
                SET.iter().any(|set| name.name == *set || *set == "$A_DB" && name.name.starts_with(set))
                    || self.variables.knows(&name.name)
            }
            SiemensItem::Function(name, _) => matches!(name.as_str(), "SETAL" | "SETM" | "CLEARM"),
            SiemensItem::Text(word) => word.starts_with(['M', 'm']) || word.starts_with(['H', 'h']),
            _ => false,
        };
        if fits {
            return Ok(());
        }
        Err(SiemensBlockError::Alarm(
            &diag::SIEMENS_STATE,
            format!(
                "'{text}' is not supported in a synchronised action: it may set variables, outputs, marks and alarms (SETAL) and \
                 execute M and H codes"
            ),
        ))
    }

    /// Tests the actions that wait, where a block begins.
    pub(super) fn test_actions(&mut self, host: &mut dyn InterpreterHost, left: &mut SiemensRemainder) -> Outcome<()> {
        if self.held.actions.is_empty() || host.reads_contour() {
            return Ok(());
        }
        let mut waiting = std::mem::take(&mut self.held.actions);
        let mut done = Ok(());
        waiting.retain_mut(|one| {
            done.is_err() || {
                let kept = self.test_action(host, one, left);
                kept.unwrap_or_else(|fault| {
                    done = Err(fault);
                    true
                })
            }
        });
        // Actions do not write actions.
        self.held.actions = waiting;
        self.watch(host);
        done
    }

    /// Tests an action; whether it keeps waiting.
    fn test_action(
        &mut self,
        host: &mut dyn InterpreterHost,
        one: &mut ArmedAction,
        left: &mut SiemensRemainder,
    ) -> Outcome<bool> {
        let action = one.action.clone();
        let holds = match &action.condition {
            Some(condition) => self.is_true(host, condition)?,
            None => true,
        };
        let acts = match action.trigger {
            Trigger::Once | Trigger::While | Trigger::Always => holds,
            Trigger::Edge => holds && !one.was,
            Trigger::Since => holds || one.was,
        };
        one.was = holds || action.trigger == Trigger::Since && one.was;
        if acts {
            let mut own = SiemensRemainder::default();
            for item in &action.does {
                self.item(host, item, &mut own)?;
            }
            if !own.words.is_empty() {
                left.before.push(own.words);
            }
        }
        one.tests = one.tests.saturating_sub(1);
        let ends = acts && action.trigger == Trigger::Once || one.number.is_none() && one.tests == 0;
        Ok(!ends)
    }

    /// CANCEL(n, …): these actions wait no longer.
    pub(super) fn cancel(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &str,
        arguments: &[SiemensArgument],
    ) -> Outcome<bool> {
        if name != "CANCEL" {
            return Ok(false);
        }
        if arguments.is_empty() {
            return syntax("CANCEL needs the number of a synchronised action");
        }
        for argument in arguments {
            let number = self.argument(host, argument)?.and_then(|value| value.number());
            self.held.actions.retain(|waiting| waiting.number.map(|number| number as f64) != number);
        }
        self.watch(host);
        Ok(true)
    }
}
