//! A block, executed item by item.
//!
//! Facts: reference channel-synchronisation.md 1.7. Decisions: the time of a dwell without an address is that of X.
//! Data that only the machine knows are requested from its identification macro, and without an answer they are an
//! alarm. Invariant: words keep their order and their places in the block.

use counterpoint_fault as diag;
use counterpoint_lang::value::MacroValue;

use super::cursor::IsgCursor;
use super::expr::{Expr, IsgExpressionReader, IsgOp, IsgVariable};
use super::line::IsgItem;
use super::{Isg, IsgBlockError, Outcome, message, no_variable, places};
use counterpoint_control_api::expression::{Evaluate, Stack};
use counterpoint_control_api::host::{IdentificationAnswer, InterpreterHost};
use counterpoint_control_api::interpreter::Remaining;
use counterpoint_control_api::numeric::{NumericFunction, NumericOperator, truth};
use counterpoint_control_api::words::{Valued, part};

/// Most elements that a declaration makes.
const ELEMENTS: f64 = 10_000.0;

/// Evaluates with the variables of a kernel.
struct IsgEvaluator<'e> {
    isg: &'e mut Isg,
    host: &'e mut dyn InterpreterHost,
}

impl Evaluate<f64, IsgOp> for IsgEvaluator<'_> {
    type Stop = IsgBlockError;

    fn own(&mut self, own: &IsgOp, stack: &mut Stack<f64>) -> Outcome<f64> {
        match own {
            IsgOp::Variable(variable) => self.isg.read(self.host, variable),
            IsgOp::PowerOfTen => finite(Some(libm::pow(10.0, stack.pop())), "DEXP"),
        }
    }

    fn apply(&mut self, function: NumericFunction, value: f64) -> Outcome<f64> {
        finite(function.value(value), function.name())
    }

    fn combine(&mut self, operator: NumericOperator, left: f64, right: f64) -> Outcome<f64> {
        match operator.value(left, right) {
            None => Err(IsgBlockError::Alarm(&diag::MACRO_DIVISION, "division by zero".to_owned())),
            value => finite(value, "the operator"),
        }
    }
}

fn finite(value: Option<f64>, name: &str) -> Outcome<f64> {
    match value {
        Some(value) if value.is_finite() => Ok(value),
        _ => Err(IsgBlockError::Alarm(&diag::MACRO_DOMAIN, format!("{name} has no value here"))),
    }
}

impl Isg {
    /// Executes a block; words that remain are added to the block.
    pub(super) fn carry_out(&mut self, host: &mut dyn InterpreterHost, text: &[u8]) -> Outcome<Remaining> {
        let place = host.place();
        if places::is_head(text) {
            return program_head(host).map(|()| Remaining::Nothing);
        }
        let line = self.read_line((place.file, place.line), text, place.as_read);
        let line = match &*line {
            Ok(line) => line,
            Err(mistake) => return Err(mistake.clone().into()),
        };
        // All marks are asked, so that each of them counts as read.
        let mut skipped = false;
        for level in &line.skips {
            skipped |= host.skips(*level);
        }
        if skipped {
            return Ok(Remaining::Nothing);
        }
        let remains = line.items.iter().any(IsgItem::remains);
        if let Some(number) = line.number.filter(|_| remains && host.is_register("N")) {
            host.push_plain(&line.plain, number);
        }
        for item in &line.items {
            self.item(host, item, (&line.plain, text))?;
        }
        Ok(if remains { Remaining::Words } else { Remaining::Nothing })
    }

    /// Executes an item of a block; `plain` is the block in capitals without comments.
    fn item(&mut self, host: &mut dyn InterpreterHost, item: &IsgItem, (plain, text): (&[u8], &[u8])) -> Outcome<()> {
        match item {
            IsgItem::Word(word) if word.is_plain() && host.register(word.letter).is_some() => {
                host.push_plain(plain, word.span);
            }
            IsgItem::Word(word) => {
                let value = self.value(host, &word.value)?;
                let letter = [word.letter];
                let name = std::str::from_utf8(&letter).unwrap_or_default();
                let number = word.number.map(|number| part(plain, number));
                put(host, &Valued { name, value, spelled: number.as_deref(), span: word.span }, text);
            }
            IsgItem::Time(time, span) => {
                let time = self.value(host, time)?;
                put(host, &Valued { name: "X", value: time, spelled: None, span: *span }, text);
            }
            IsgItem::Dwell(time, span) => {
                let time = self.value(host, time)?;
                put(host, &Valued { name: "G", value: 4.0, spelled: Some("4"), span: *span }, text);
                put(host, &Valued { name: "X", value: time, spelled: None, span: *span }, text);
            }
            IsgItem::Set(variable, value) => {
                let value = self.value(host, value)?;
                self.assign(host, variable, value)?;
            }
            IsgItem::Declare(variable) => self.declare(host, variable)?,
            IsgItem::Control(control) => self.control(host, control)?,
            IsgItem::Signal(statement) => {
                if host.coordinates(statement.row()).is_none() {
                    let text = format!("the machine has no statement #{}", statement.row());
                    return Err(IsgBlockError::Alarm(&diag::SIGNAL_STATEMENT, text));
                }
                self.signal(host, statement)?;
            }
            IsgItem::Message(text, values) => {
                let values = values.iter().map(|value| self.value(host, value)).collect::<Outcome<Vec<f64>>>()?;
                host.show(&message::filled(text, &values)?);
            }
            IsgItem::Call { local, name } => self.call(host, *local, name)?,
            IsgItem::Return => host.return_from(),
            IsgItem::Idle => {}
            IsgItem::Text(span) => host.push_plain(text, *span),
        }
        Ok(())
    }

    /// Value of an expression.
    pub(super) fn value(&mut self, host: &mut dyn InterpreterHost, expr: &Expr) -> Outcome<f64> {
        if let Some(value) = expr.as_constant() {
            return Ok(*value);
        }
        IsgEvaluator { isg: self, host }.evaluate(expr)
    }

    /// The number of a parameter.
    fn number(&mut self, host: &mut dyn InterpreterHost, number: &Expr) -> Outcome<u32> {
        let number = self.value(host, number)?;
        if number.fract() == 0.0 && (0.0..=1e9).contains(&number) {
            return Ok(number as u32);
        }
        no_variable(format!("P{number} is no parameter"))
    }

    /// A name with the values of its indices.
    fn full_name(&mut self, host: &mut dyn InterpreterHost, name: &str, indices: &[Expr]) -> Outcome<String> {
        let mut full = name.to_owned();
        for index in indices {
            full.push_str(&format!("[{}]", self.value(host, index)?));
        }
        Ok(full)
    }

    /// The only index of an external variable.
    fn index(&mut self, host: &mut dyn InterpreterHost, name: &str, indices: &[Expr]) -> Outcome<Option<f64>> {
        match indices {
            [] => Ok(None),
            [index] => self.value(host, index).map(Some),
            _ => no_variable(format!("{name} has one index at the most")),
        }
    }

    /// Value of a variable.
    pub(super) fn read(&mut self, host: &mut dyn InterpreterHost, variable: &IsgVariable) -> Outcome<f64> {
        let (full, value) = match variable {
            IsgVariable::Parameter(number, indices) if indices.is_empty() => {
                let number = self.number(host, number)?;
                match self.store.parameter(number) {
                    Some(value) => return Ok(value),
                    None => (format!("P{number}"), None),
                }
            }
            IsgVariable::Parameter(number, indices) => {
                let name = format!("P{}", self.number(host, number)?);
                let full = self.full_name(host, &name, indices)?;
                let value = self.store.named(&full);
                (full, value)
            }
            IsgVariable::Named(name, indices) => {
                if name.starts_with("V.E.") {
                    let index = self.index(host, name, indices)?;
                    return self.store.read_external(host, name, index);
                }
                let full = self.full_name(host, name, indices)?;
                let value = match self.store.named(&full) {
                    None => self.system(host, &full),
                    value => value,
                };
                (full, value)
            }
        };
        match value {
            Some(value) => Ok(value),
            None => self.asked(host, &full),
        }
    }

    /// Variables of the control that the kernel knows.
    fn system(&self, host: &dyn InterpreterHost, name: &str) -> Option<f64> {
        if name == "V.G.SIGNAL_READ" {
            return Some(truth(self.signal_read));
        }
        let axis = name.strip_prefix("V.A.ABS.")?;
        host.axes().into_iter().find(|place| place.is(axis)).map(|place| place.work)
    }

    /// Data that only the machine has.
    fn asked(&mut self, host: &mut dyn InterpreterHost, name: &str) -> Outcome<f64> {
        match host.identify(name, None)?.unless(name) {
            IdentificationAnswer::Drop | IdentificationAnswer::Keep => Ok(0.0),
            IdentificationAnswer::Instead(answer) => {
                let upper = answer.to_ascii_uppercase();
                let mut cursor = IsgCursor::new(upper.as_bytes());
                let expr = IsgExpressionReader::new(&mut cursor).expression()?;
                cursor.end()?;
                self.value(host, &expr)
            }
            IdentificationAnswer::Unknown => no_variable(format!("{name} has no value")),
        }
    }

    /// Sets a variable.
    pub(super) fn assign(&mut self, host: &mut dyn InterpreterHost, variable: &IsgVariable, value: f64) -> Outcome<()> {
        let changed = match variable {
            IsgVariable::Parameter(number, indices) => {
                let number = self.number(host, number)?;
                if indices.is_empty() {
                    self.store.set_parameter(number, value)?
                } else {
                    let full = self.full_name(host, &format!("P{number}"), indices)?;
                    self.store.set_named(&full, value)?
                }
            }
            IsgVariable::Named(name, indices) => {
                if name.starts_with("V.E.") {
                    let index = self.index(host, name, indices)?;
                    return self.store.write_external(host, (name, index), value);
                }
                let full = self.full_name(host, name, indices)?;
                if ["V.P.", "V.L.", "V.S."].iter().any(|family| full.starts_with(family)) {
                    self.store.set_named(&full, value)?
                } else {
                    return match host.identify(&full, Some(&MacroValue::Real(value)))?.unless(&full) {
                        IdentificationAnswer::Drop | IdentificationAnswer::Keep | IdentificationAnswer::Instead(_) => {
                            Ok(())
                        }
                        IdentificationAnswer::Unknown => no_variable(format!("{full} cannot be set")),
                    };
                }
            }
        };
        if changed {
            host.effect();
        }
        Ok(())
    }

    /// A variable alone: it begins with 0, an array with this many elements, unless it has a value.
    fn declare(&mut self, host: &mut dyn InterpreterHost, variable: &IsgVariable) -> Outcome<()> {
        let (name, indices) = match variable {
            IsgVariable::Named(name, indices) if !name.starts_with("V.E.") => (name.to_string(), indices),
            _ => return Err(IsgBlockError::Alarm(&diag::MACRO_SYNTAX, "expected '=' after the variable".to_owned())),
        };
        let mut sizes = Vec::new();
        for index in indices {
            sizes.push(self.value(host, index)?);
        }
        let count: f64 = sizes.iter().product();
        if sizes.iter().any(|size| size.fract() != 0.0 || *size < 1.0) || count > ELEMENTS {
            return no_variable(format!("{name} cannot have so many elements"));
        }
        for at in 0..count as usize {
            let (mut rest, mut index) = (at, String::new());
            for size in sizes.iter().rev() {
                index = format!("[{}]{index}", rest % *size as usize);
                rest /= *size as usize;
            }
            let full = format!("{name}{index}");
            if self.store.named(&full).is_none() {
                self.store.set_named(&full, 0.0)?;
            }
        }
        Ok(())
    }
}

/// Adds a word to the block; if the machine does not have the word, its text stays unchanged.
fn put(host: &mut dyn InterpreterHost, word: &Valued<'_>, text: &[u8]) {
    if !word.push(host) {
        host.push_unknown(text, word.span);
    }
}

/// At the head of a second program, goes to the end: execution does not run into the next program.
fn program_head(host: &mut dyn InterpreterHost) -> Outcome<()> {
    let place = host.place();
    let source = host.source(place.file);
    let is_first =
        source.is_none_or(|source| (place.range.first..place.line).all(|line| !places::is_head(source.line(line))));
    if is_first { Ok(()) } else { Ok(host.go_to(place.range.last.saturating_add(1))?) }
}
