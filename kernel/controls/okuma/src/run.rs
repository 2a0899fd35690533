//! Execution of a block of the pre-processor.
//!
//! Facts: reference control-emulator.md 5.4, 5.5, 5.7. Decisions: `Qn` repeats a call n times, so it runs n + 1 times,
//! unless a setting says that it counts executions. A modal call calls after every block that moves in the program that
//! contains it, with the values that its arguments had at the modal call, and ends with that program. Invariant: words
//! keep their order and their places in the block.

use counterpoint_fault::{Acted, Halt};
use std::borrow::Cow;
use std::sync::Arc;

use counterpoint_lang::value::MacroValue;

use super::eval::{EvaluationStop, OkumaEvaluator};
use super::expr::{Expr, OkumaVariable};
use super::lap::LapRole;
use super::line::{BlockPrefix, OkumaCall, OkumaItem, OkumaJumpTarget, OkumaLine, OkumaStatement};
use super::names::normal;
use super::store::Arguments;
use super::{ALARM_TEXTS, Okuma};
use counterpoint_control_api::host;
use counterpoint_control_api::host::{IdentificationAnswer, InterpreterHost};
use counterpoint_control_api::interpreter::Remaining;
use counterpoint_control_api::words::{Span, Valued, part};
use counterpoint_fault as diag;

/// Modal calls at the same time.
const MODAL: usize = 8;

/// Names of which is kept whether they are words.
const WORDS: usize = 1000;

/// Outputs that set an alarm of the user, with its class: A, B and C stop the program, D is only shown.
const USER_ALARMS: [(f64, char); 4] = [(990.0, 'D'), (991.0, 'C'), (992.0, 'B'), (993.0, 'A')];

/// Largest number of repeats.
const REPEATS: f64 = 9999.0;

/// A modal call.
#[derive(Debug, Clone)]
pub(super) struct OkumaModalCall {
    call: host::SubprogramCall,
    arguments: Arguments,
    /// Subprograms that were running when it was programmed.
    level: usize,
}

/// The words that a block leaves.
struct OkumaRemainder<'a> {
    /// The block without comments and messages.
    plain: &'a [u8],
    /// Whether the block leaves any words.
    any: bool,
}

impl OkumaRemainder<'_> {
    /// Leaves a part of the block unchanged.
    fn keep(&mut self, host: &mut dyn InterpreterHost, span: Span) {
        host.push_plain(self.plain, span);
        self.any = true;
    }

    /// Adds a word if a register of the machine has its name.
    fn add(&mut self, host: &mut dyn InterpreterHost, word: &Valued<'_>) -> bool {
        let is_word = word.push(host);
        self.any |= is_word;
        is_word
    }

    fn made(&self) -> Remaining {
        if self.any { Remaining::Words } else { Remaining::Nothing }
    }
}

impl Okuma {
    pub(super) fn run(
        &mut self,
        host: &mut dyn InterpreterHost,
        line: &OkumaLine,
        text: &[u8],
    ) -> Result<Remaining, Halt> {
        if line.open {
            let text = format!("a comment or message is not closed in '{}'", host.block_text());
            host.diagnose(&diag::COMMENT_OPEN, text);
        }
        let mut left = OkumaRemainder { plain: &line.plain, any: false };
        if !self.head(host, line, &mut left) {
            return Ok(left.made());
        }
        if !line.messages.is_empty() && !host.handles_messages(text) {
            line.messages.iter().for_each(|message| host.show(message));
        }
        match &line.lap {
            Some(LapRole::Begins) => return self.skip_contour(host).map(|()| Remaining::Nothing),
            Some(LapRole::Cuts(name)) => self.cut_along(host, name)?,
            None => {}
        }
        match &line.statement {
            OkumaStatement::Nothing => {}
            OkumaStatement::Drawing => {
                if !std::mem::replace(&mut self.drawing.reported, true) {
                    let text = format!(
                        "'{}' changes neither path nor time; statements like it are ignored",
                        host.block_text()
                    );
                    host.diagnose(&diag::OKUMA_DRAWING, text);
                }
            }
            OkumaStatement::Continued => {
                let text = format!("'{}' continues a block, but there is none above it; ignored", host.block_text());
                host.diagnose(&diag::OKUMA_CONTINUED, text);
                return Ok(Remaining::Nothing);
            }
            OkumaStatement::Goto(condition, target) => self.go_to(host, condition.as_ref(), target)?,
            OkumaStatement::Loop(condition, _) => self.enter_loop(host, condition.as_ref())?,
            OkumaStatement::EndLoop(_) => self.end_loop(host)?,
            OkumaStatement::Call(call) => {
                let (call, arguments) = self.made(host, call)?;
                self.call(host, call, arguments);
            }
            OkumaStatement::ModIn(call) => self.mod_in(host, call)?,
            OkumaStatement::ModOut => self.mod_out(host),
            OkumaStatement::Shared(shared, operands) => {
                shared.execute(host, operands, |host, operand| self.value(host, operand))?;
            }
            OkumaStatement::Items(items) => {
                self.check_names(host, items)?;
                items.iter().try_for_each(|item| self.item(host, item, &mut left))?;
            }
        }
        Ok(left.made())
    }

    /// Marks, sequence number and name of a program: whether the rest of the block is executed.
    fn head(&mut self, host: &mut dyn InterpreterHost, line: &OkumaLine, left: &mut OkumaRemainder<'_>) -> bool {
        let mut skipped = false;
        for head in &line.head {
            match head {
                BlockPrefix::Mark(level) => skipped = host.skips(*level),
                _ if skipped => {}
                BlockPrefix::Number(span) => left.keep(host, *span),
                BlockPrefix::Name(span) if !self.takes_names => left.keep(host, *span),
                BlockPrefix::Name(_) => {}
                // A number may be a word of the machine.
                BlockPrefix::Program(span) => {
                    let (start, end) = *span;
                    let is_number = part(left.plain, (start + 1, end)).bytes().all(|byte| byte.is_ascii_digit());
                    if is_number && host.is_register("O") {
                        left.keep(host, *span);
                    }
                }
            }
        }
        !skipped
    }

    pub(super) fn value(&mut self, host: &mut dyn InterpreterHost, expr: &Expr) -> Result<f64, Halt> {
        match OkumaEvaluator::new(&mut self.store, host).value(expr) {
            Ok(value) => Ok(value),
            // There is no text here that could stay.
            Err(EvaluationStop::Keep) => Ok(0.0),
            Err(EvaluationStop::Halt(halt)) => Err(halt),
        }
    }

    fn go_to(&mut self, host: &mut dyn InterpreterHost, condition: Option<&Expr>, target: &OkumaJumpTarget) -> Acted {
        if let Some(condition) = condition
            && self.value(host, condition)? == 0.0
        {
            return Ok(());
        }
        let name = match target {
            OkumaJumpTarget::Named(name) => Cow::Borrowed(name),
            OkumaJumpTarget::Computed(number) => Cow::Owned(normal(&self.value(host, number)?.to_string())),
        };
        let place = host.place();
        let index = self.index(host, place.file);
        match index.label(&name, place.line, place.range) {
            Some(line) => {
                self.caching = true;
                host.go_to(line)
            }
            None => {
                let text = format!("block N{name} not found in the program for '{}'", host.block_text());
                Err(host.alarm(&diag::JUMP_TARGET, text))
            }
        }
    }

    /// A call with the values of its arguments.
    fn made(
        &mut self,
        host: &mut dyn InterpreterHost,
        call: &OkumaCall,
    ) -> Result<(host::SubprogramCall, Arguments), Halt> {
        let (least, more) = if self.counts_executions { (1.0, 0) } else { (0.0, 1) };
        let count = match &call.repeats {
            Some(count) => self.value(host, count)?,
            None => least,
        };
        if !(least..=REPEATS).contains(&count) || count.fract() != 0.0 {
            let text = match self.counts_executions {
                true => format!("a call cannot be executed {count} times in '{}'", host.block_text()),
                false => format!("a call cannot be repeated {count} times in '{}'", host.block_text()),
            };
            return Err(host.alarm(&diag::MACRO_CALL, text));
        }
        let mut arguments = Vec::with_capacity(call.arguments.len());
        for (name, value) in &call.arguments {
            let value = match OkumaEvaluator::new(&mut self.store, host).assigned(value) {
                Ok(value) => value,
                Err(EvaluationStop::Keep) => Some(0.0),
                Err(EvaluationStop::Halt(halt)) => return Err(halt),
            };
            arguments.extend(value.map(|value| (*name, value)));
        }
        let place = self.find(host, normal(call.name.get(1..).unwrap_or_default()))?;
        let name = Arc::from(call.name.as_str());
        Ok((host::SubprogramCall { name, place, passes: count as u32 + more, closes: false }, arguments.into()))
    }

    fn call(&mut self, host: &mut dyn InterpreterHost, call: host::SubprogramCall, arguments: Arguments) {
        let place = host.place();
        self.caching = true;
        if let Some((file, _)) = call.place {
            self.watch(host, file);
        }
        self.arguments = Some((place.file, place.line, arguments));
        host.call(call);
    }

    fn mod_in(&mut self, host: &mut dyn InterpreterHost, call: &OkumaCall) -> Acted {
        let (call, arguments) = self.made(host, call)?;
        if self.modal.len() >= MODAL {
            let text = format!("more than {MODAL} modal calls at the same time in '{}'", host.block_text());
            return Err(host.alarm(&diag::MACRO_CALL, text));
        }
        let level = host.level();
        self.modal.push(OkumaModalCall { call, arguments, level });
        host.effect();
        host.calls_modally(true);
        Ok(())
    }

    fn mod_out(&mut self, host: &mut dyn InterpreterHost) {
        if self.modal.pop().is_none() {
            let text = format!("no modal call is active in '{}'; ignored", host.block_text());
            host.diagnose(&diag::OKUMA_NO_MODAL, text);
        }
        host.effect();
        host.calls_modally(!self.modal.is_empty());
    }

    /// Modal calls of programs that have ended are over.
    pub(super) fn end_modal(&mut self, host: &mut dyn InterpreterHost) {
        let level = host.level();
        self.report_open_modal(host, Some(level));
        self.modal.retain(|modal| modal.level <= level);
        host.calls_modally(!self.modal.is_empty());
    }

    /// Programs above this level (or all of them) have ended: reports the modal calls that each left active.
    pub(super) fn report_open_modal(&self, host: &mut dyn InterpreterHost, level: Option<usize>) {
        if self.modal.iter().any(|modal| level.is_none_or(|level| modal.level > level)) {
            let text = format!("the program ends in '{}' with a MODIN that no MODOUT has cancelled", host.block_text());
            host.diagnose(&diag::MODAL_CALL_OPEN, text);
        }
    }

    /// A block has moved.
    pub(super) fn call_modally(&mut self, host: &mut dyn InterpreterHost) {
        let level = host.level();
        if let Some(modal) = self.modal.last().filter(|modal| modal.level == level).cloned() {
            self.call(host, modal.call, modal.arguments);
        }
    }

    fn item(&mut self, host: &mut dyn InterpreterHost, item: &OkumaItem, left: &mut OkumaRemainder<'_>) -> Acted {
        let (name, variable, value, number, span) = match item {
            OkumaItem::Plain(span) => {
                left.keep(host, *span);
                return Ok(());
            }
            OkumaItem::OfTool(name, span) => {
                let tool = f64::from(host.tool());
                if !left.add(host, &Valued { name, value: tool, spelled: None, span: *span }) {
                    left.keep(host, *span);
                }
                return Ok(());
            }
            OkumaItem::Text { variable, text, span } => return self.text(host, (variable, text, *span), left),
            OkumaItem::Set { name, variable, value, number, span } => (name, variable, value, *number, *span),
        };
        if let Some(OkumaVariable::System(name, index)) = variable
            && let ("VDOUT", [index]) = (&**name, &**index)
        {
            let output = self.value(host, index)?;
            if let Some(class) = USER_ALARMS.iter().find(|(of, _)| *of == output) {
                return self.user_alarm(host, *class, value, (span, left));
            }
        }
        let is_word = self.is_word(host, name);
        let mut eval = OkumaEvaluator::new(&mut self.store, host);
        let done = eval.assigned(value).and_then(|assigned| {
            let spelled = number.map(|number| part(left.plain, number));
            let word = Valued { name, value: assigned.unwrap_or(0.0), spelled: spelled.as_deref(), span };
            if is_word && left.add(eval.host, &word) {
                if assigned.is_none() {
                    let raw = part(left.plain, span);
                    let text = format!("EMPTY is not a valid value for {name} in '{raw}'; 0 is used");
                    eval.host.diagnose(&diag::OKUMA_UNKNOWN, text);
                }
                return Ok(());
            }
            match variable {
                Some(variable) => eval.assign(variable, assigned),
                None => eval.assign_unknown(name, assigned),
            }
        });
        match done {
            Ok(()) => Ok(()),
            Err(EvaluationStop::Keep) => {
                left.keep(host, span);
                Ok(())
            }
            Err(EvaluationStop::Halt(halt)) => Err(halt),
        }
    }
}

impl Okuma {
    /// Whether a register of the machine has this name.
    pub(super) fn is_word(&mut self, host: &dyn InterpreterHost, name: &str) -> bool {
        if let Some(known) = self.names.words.get(name) {
            return *known;
        }
        let is = host.register_named(name).is_some();
        if self.names.words.len() >= WORDS {
            self.names.words.clear();
        }
        self.names.words.insert(name.into(), is);
        is
    }

    /// Assigns a text to a variable: the text of an alarm, or of a variable of the machine.
    fn text(
        &mut self,
        host: &mut dyn InterpreterHost,
        (variable, text, span): (&OkumaVariable, &str, Span),
        left: &mut OkumaRemainder<'_>,
    ) -> Acted {
        let asked = match OkumaEvaluator::new(&mut self.store, host).asked_name(variable) {
            Ok(asked) => asked,
            Err(EvaluationStop::Keep) => part(left.plain, span).into_owned(),
            Err(EvaluationStop::Halt(halt)) => return Err(halt),
        };
        match host.identify(&asked, Some(&MacroValue::text(text)))?.unless(&asked) {
            IdentificationAnswer::Drop => return Ok(()),
            IdentificationAnswer::Keep => {
                left.keep(host, span);
                return Ok(());
            }
            IdentificationAnswer::Instead(_) | IdentificationAnswer::Unknown => {}
        }
        let number = asked.strip_prefix("VUACM[").and_then(|rest| rest.strip_suffix(']')?.parse().ok());
        match number {
            Some(number) if self.alarm_texts.len() < ALARM_TEXTS => {
                self.alarm_texts.insert(number, text.to_owned());
            }
            _ => {
                let text = format!("{asked} cannot be set to a text in '{}'; ignored", host.block_text());
                host.diagnose(&diag::OKUMA_UNKNOWN, text);
            }
        }
        Ok(())
    }

    /// `VDOUT[992]=n` and the like: the alarm of the user with that number, unless the machine sees to it.
    fn user_alarm(
        &mut self,
        host: &mut dyn InterpreterHost,
        (output, class): (f64, char),
        value: &Expr,
        (span, left): (Span, &mut OkumaRemainder<'_>),
    ) -> Acted {
        let number = self.value(host, value)?;
        let asked = format!("VDOUT[{output}]");
        match host.identify(&asked, Some(&MacroValue::Real(number)))?.unless(&asked) {
            IdentificationAnswer::Drop => return Ok(()),
            IdentificationAnswer::Keep => {
                left.keep(host, span);
                return Ok(());
            }
            IdentificationAnswer::Instead(_) | IdentificationAnswer::Unknown => {}
        }
        let text = self.alarm_texts.get(&1).map_or(String::new(), |text| format!(": {text}"));
        let text = format!("the program sets alarm {class} {number}{text} in '{}'", host.block_text());
        if class == 'D' {
            host.log_message(&text);
            return Ok(());
        }
        Err(host.alarm(&diag::OKUMA_ALARM, text))
    }
}
