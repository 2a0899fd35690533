//! Expressions, evaluated.
//!
//! Facts: reference control-emulator.md 5.4 and 4.3. Decisions: `/` gives REAL, `+ − *` of two INT give INT, AND OR XOR
//! NOT take numbers as true unless 0, texts are compared as they are written; numbers are equal, as on the control,
//! within a part in 10^12. A name that nothing knows is asked of the
//! identification macro, then it is an alarm. Invariant: a REAL that comes out is finite.

use super::expression::{Argument, Binary, Expression, Name, Unary, whole};
use super::value::Data;
use super::{Fault, Outcome, Siemens, functions, syntax, wrong_type};
use crate::host::{Answer, Host};
use counterpoint_fault as diag;

/// Most characters of a text.
const LONGEST: usize = 1000;

/// A number that comes out of a calculation.
pub(super) fn real(value: f64) -> Outcome<Data> {
    if value.is_finite() {
        Ok(Data::Real(value))
    } else {
        Err(Fault::Alarm(&diag::MACRO_DOMAIN, "a calculation has no result".to_owned()))
    }
}

fn division<T>() -> Outcome<T> {
    Err(Fault::Alarm(&diag::MACRO_DIVISION, "division by zero".to_owned()))
}

/// A number that an operand has to be.
pub(super) fn number(value: &Data) -> Outcome<f64> {
    match value.number() {
        Some(number) => Ok(number),
        None => wrong_type(format!("{} is no number", value.described())),
    }
}

impl Siemens {
    /// Value of an expression.
    pub(super) fn evaluate(&mut self, host: &mut dyn Host, expression: &Expression) -> Outcome<Data> {
        Ok(match expression {
            Expression::Int(value) => Data::Int(*value),
            Expression::Real(value) => Data::Real(*value),
            Expression::Bool(value) => Data::Bool(*value),
            Expression::Char(value) => Data::Char(*value),
            Expression::Text(text) => Data::Text(text.to_string()),
            Expression::Name(name) => return self.read(host, name),
            Expression::Call(name, arguments) => return self.function(host, name, arguments),
            Expression::Unary(operator, inner) => {
                let inner = self.evaluate(host, inner)?;
                return unary(*operator, &inner);
            }
            Expression::Binary(operator, left, right) => {
                let left = self.evaluate(host, left)?;
                let right = self.evaluate(host, right)?;
                return binary(*operator, left, right);
            }
        })
    }

    /// A condition.
    pub(super) fn is_true(&mut self, host: &mut dyn Host, condition: &Expression) -> Outcome<bool> {
        Ok(number(&self.evaluate(host, condition)?)? != 0.0)
    }

    /// A whole number, rounded.
    pub(super) fn whole_number(&mut self, host: &mut dyn Host, expression: &Expression) -> Outcome<i64> {
        let value = number(&self.evaluate(host, expression)?)?.round();
        if value.abs() > 1e15 { wrong_type(format!("{value:e} is no number for this")) } else { Ok(value as i64) }
    }

    /// Value of an argument; none if it was left out.
    pub(super) fn argument(&mut self, host: &mut dyn Host, argument: &Argument) -> Outcome<Option<Data>> {
        match &argument.value {
            Ok(None) => Ok(None),
            Ok(Some(expression)) => self.evaluate(host, expression).map(Some),
            Err(text) => syntax(text.clone()),
        }
    }

    fn read(&mut self, host: &mut dyn Host, name: &Name) -> Outcome<Data> {
        if name.name.starts_with('$') {
            let asked = self.written(host, name)?;
            return match self.ask(host, &asked, None)? {
                Answer::Instead(text) => self.instead(host, &text),
                Answer::Drop => Ok(Data::Int(0)),
                Answer::Keep => Ok(Data::Axis(asked)),
                Answer::Unknown => match self.system(host, name)? {
                    Some(value) => Ok(value),
                    None => Err(unknown(&asked)),
                },
            };
        }
        if name.name == "AX" && name.index.len() == 1 {
            return self.axis_of(host, name);
        }
        let is_local = name.name == "R" || self.variables.knows(&name.name);
        if !is_local && name.index.is_empty() && words_name(host, &name.name) {
            return Ok(Data::Axis(name.name.clone()));
        }
        if let Some(target) = self.locate(host, name)? {
            return self.value_of(host, &target);
        }
        let asked = self.written(host, name)?;
        match self.ask(host, &asked, None)? {
            Answer::Instead(text) => self.instead(host, &text),
            Answer::Drop => Ok(Data::Int(0)),
            Answer::Keep => Ok(Data::Axis(asked)),
            Answer::Unknown => Err(unknown(&asked)),
        }
    }

    /// `AX[…]`: the axis that a variable names.
    pub(super) fn axis_of(&mut self, host: &mut dyn Host, name: &Name) -> Outcome<Data> {
        let Some(index) = name.index.first() else { return syntax("AX needs an axis") };
        match self.evaluate(host, index)? {
            Data::Axis(axis) => Ok(Data::Axis(axis)),
            other => wrong_type(format!("{} is no axis", other.described())),
        }
    }

    /// Asks the identification macro, if that may be asked now.
    pub(super) fn ask(
        &mut self,
        host: &mut dyn Host,
        text: &str,
        assigned: Option<&counterpoint_lang::value::Value>,
    ) -> Outcome<Answer> {
        if self.quiet { Ok(Answer::Unknown) } else { Ok(host.identify(text, assigned)?.unless(text)) }
    }

    /// What a macro gave in place of a text; it is not asked about what stands in it.
    pub(super) fn instead(&mut self, host: &mut dyn Host, text: &str) -> Outcome<Data> {
        let expression = whole(text).or_else(syntax)?;
        let before = std::mem::replace(&mut self.quiet, true);
        let value = self.evaluate(host, &expression);
        self.quiet = before;
        value
    }

    /// A name with the values of its indices, as macros and texts see it.
    pub(super) fn written(&mut self, host: &mut dyn Host, name: &Name) -> Outcome<String> {
        if name.index.is_empty() {
            return Ok(name.name.clone());
        }
        let mut texts = Vec::new();
        for index in &name.index {
            let text = match index {
                // Parts of frames and names of data are texts.
                Expression::Name(name) if name.index.is_empty() && !self.variables.knows(&name.name) => {
                    name.name.clone()
                }
                _ => match self.evaluate(host, index)? {
                    Data::Text(text) => format!("\"{text}\""),
                    other => other.text(),
                },
            };
            texts.push(text);
        }
        Ok(format!("{}[{}]", name.name, texts.join(",")))
    }

    fn function(&mut self, host: &mut dyn Host, name: &str, arguments: &[Argument]) -> Outcome<Data> {
        if let Some(value) = self.frame_function(host, name, arguments)? {
            return Ok(value);
        }
        if !functions::is_function(name) {
            let texts: Vec<&str> = arguments.iter().map(|argument| argument.text.as_str()).collect();
            let asked = format!("{name}({})", texts.join(","));
            return match self.ask(host, &asked, None)? {
                Answer::Instead(text) => self.instead(host, &text),
                Answer::Drop => Ok(Data::Int(0)),
                Answer::Keep => Ok(Data::Axis(asked)),
                Answer::Unknown => Err(Fault::Alarm(&diag::MACRO_VARIABLE, format!("there is no function {name}"))),
            };
        }
        let mut values = Vec::new();
        for argument in arguments {
            match self.argument(host, argument)? {
                Some(value) => values.push(value),
                None => return syntax(format!("an argument of {name} is missing")),
            }
        }
        match functions::number_function(name, &values)? {
            Some(value) => Ok(value),
            None => self.text_function(host, name, &values),
        }
    }
}

/// A register or an axis has this name.
pub(super) fn words_name(host: &dyn Host, name: &str) -> bool {
    host.is_register(name)
        || host.is_register(&format!("{name}="))
        || host.axes().iter().any(|axis| axis.name.eq_ignore_ascii_case(name) || axis.letter.eq_ignore_ascii_case(name))
}

fn unknown(name: &str) -> Fault {
    Fault::Alarm(&diag::MACRO_VARIABLE, format!("there is no variable {name}"))
}

fn unary(operator: Unary, inner: &Data) -> Outcome<Data> {
    let value = number(inner)?;
    Ok(match (operator, inner) {
        (Unary::Minus, Data::Int(value)) => value.checked_neg().map_or(Data::Real(-(*value as f64)), Data::Int),
        (Unary::Minus, _) => Data::Real(-value),
        (Unary::Not, _) => Data::Bool(value == 0.0),
        (Unary::BitNot, _) => Data::Int(i64::from(!(bits(inner)?))),
    })
}

fn bits(value: &Data) -> Outcome<i32> {
    let number = number(value)?.round();
    if number.abs() <= f64::from(u32::MAX) {
        Ok(number as i64 as i32)
    } else {
        wrong_type(format!("{} has more than 32 bits", value.described()))
    }
}

fn binary(operator: Binary, left: Data, right: Data) -> Outcome<Data> {
    use Binary as B;
    match operator {
        B::Join => {
            let text = left.text() + &right.text();
            if text.len() > LONGEST {
                return wrong_type(format!("a text is longer than {LONGEST} characters"));
            }
            Ok(Data::Text(text))
        }
        B::Chain => {
            let (outer, inner) = (super::variables::as_frame(left)?, super::variables::as_frame(right)?);
            match outer.chain(&inner) {
                Some(frame) => Ok(Data::Frame(Box::new(frame))),
                None => wrong_type("the frame is out of all bounds"),
            }
        }
        B::Equal | B::NotEqual | B::Less | B::LessEqual | B::Greater | B::GreaterEqual => {
            compare(operator, left, right)
        }
        B::Or | B::Xor | B::And => {
            let (left, right) = (number(&left)? != 0.0, number(&right)? != 0.0);
            Ok(Data::Bool(match operator {
                B::Or => left || right,
                B::And => left && right,
                _ => left != right,
            }))
        }
        B::BitOr => Ok(Data::Int(i64::from(bits(&left)? | bits(&right)?))),
        B::BitXor => Ok(Data::Int(i64::from(bits(&left)? ^ bits(&right)?))),
        B::BitAnd => Ok(Data::Int(i64::from(bits(&left)? & bits(&right)?))),
        _ => calculate(operator, &left, &right),
    }
}

fn calculate(operator: Binary, left: &Data, right: &Data) -> Outcome<Data> {
    if let (Data::Int(a), Data::Int(b)) = (left, right) {
        let exact = match operator {
            Binary::Add => a.checked_add(*b),
            Binary::Subtract => a.checked_sub(*b),
            Binary::Multiply => a.checked_mul(*b),
            Binary::IntegerDivide | Binary::Modulo if *b == 0 => return division(),
            Binary::IntegerDivide => a.checked_div(*b),
            Binary::Modulo => a.checked_rem(*b),
            _ => None,
        };
        if let Some(value) = exact {
            return Ok(Data::Int(value));
        }
    }
    let (a, b) = (number(left)?, number(right)?);
    match operator {
        Binary::Add => real(a + b),
        Binary::Subtract => real(a - b),
        Binary::Multiply => real(a * b),
        _ if b == 0.0 => division(),
        Binary::Divide => real(a / b),
        Binary::IntegerDivide => real((a / b).trunc()),
        _ => real(a % b),
    }
}

/// Numbers that differ by no more than rounding are equal.
pub(super) fn same(left: f64, right: f64) -> bool {
    left == right || (left - right).abs() <= 1e-12 * left.abs().max(right.abs())
}

fn compare(operator: Binary, left: Data, right: Data) -> Outcome<Data> {
    use std::cmp::Ordering;
    let order = match (&left, &right) {
        (Data::Text(a) | Data::Axis(a), Data::Text(b) | Data::Axis(b)) => Some(a.cmp(b)),
        (Data::Text(a), Data::Char(b)) => Some(a.as_str().cmp(char::from(*b).to_string().as_str())),
        (Data::Char(a), Data::Text(b)) => Some(char::from(*a).to_string().as_str().cmp(b)),
        (Data::Frame(a), Data::Frame(b)) => Some(if a == b { Ordering::Equal } else { Ordering::Less }),
        _ => {
            let (left, right) = (number(&left)?, number(&right)?);
            if same(left, right) { Some(Ordering::Equal) } else { left.partial_cmp(&right) }
        }
    };
    let Some(order) = order else { return wrong_type("values cannot be compared") };
    let no_order = matches!(left, Data::Axis(_) | Data::Frame(_));
    if no_order && !matches!(operator, Binary::Equal | Binary::NotEqual) {
        return wrong_type(format!("{} has no order", left.described()));
    }
    Ok(Data::Bool(match operator {
        Binary::Equal => order.is_eq(),
        Binary::NotEqual => order.is_ne(),
        Binary::Less => order.is_lt(),
        Binary::LessEqual => order.is_le(),
        Binary::Greater => order.is_gt(),
        _ => order.is_ge(),
    }))
}
