//! Expressions, evaluated.
//!
//! Facts: reference control-emulator.md 5.4 and 4.3. Decisions: `/` gives REAL, `+ − *` of two INT give INT, AND OR XOR
//! NOT take numbers as true unless 0, texts are compared as they are written; numbers are equal, as on the control,
//! within a part in 10^12. A name that nothing knows is asked of the
//! identification macro, then it is an alarm. Invariant: a REAL that comes out is finite.

use counterpoint_control_api::expression::{Evaluate, Stack};
use counterpoint_control_api::host::{IdentificationAnswer, InterpreterHost};
use counterpoint_control_api::numeric::{NumericFunction, NumericOperator};
use counterpoint_fault as diag;

use super::compiled::{Expression, IndexedName, SiemensArgument, SiemensOp, as_name};
use super::conversions::{bits, number, real, same};
use super::expression::whole;
use super::value::Data;
use super::{Outcome, Siemens, SiemensBlockError, functions, syntax, wrong_type};

/// Most characters of a text.
const LONGEST: usize = 1000;

/// The interpreter and its kernel as the source of values for expressions.
pub(super) struct SiemensEvaluator<'s> {
    pub(super) siemens: &'s mut Siemens,
    pub(super) host: &'s mut dyn InterpreterHost,
}

impl Evaluate<Data, SiemensOp> for SiemensEvaluator<'_> {
    type Stop = SiemensBlockError;

    fn own(&mut self, own: &SiemensOp, _: &mut Stack<Data>) -> Outcome<Data> {
        match own {
            SiemensOp::Name(name) => self.siemens.read(self.host, name),
            SiemensOp::Call(name, arguments) => self.siemens.function(self.host, name, arguments),
        }
    }

    fn apply(&mut self, function: NumericFunction, value: Data) -> Outcome<Data> {
        functions::apply(function, &value)
    }

    fn combine(&mut self, operator: NumericOperator, left: Data, right: Data) -> Outcome<Data> {
        binary(operator, left, right)
    }
}

/// The number of a tool by its name. The macros of the machine know the names that the program has written.
const TOOL_NAME: &str = "$P_TOOLNAME";

impl SiemensEvaluator<'_> {
    /// `GETT("NAME",duplo)`: the number of a tool that the program, a table or a call has named; −1 for other names.
    pub(super) fn named_tool(&mut self, called: &str, duplo: Option<f64>) -> Outcome<Data> {
        let found = match self.siemens.ask(self.host, &format!("{TOOL_NAME}[\"{called}\"]"), None)? {
            IdentificationAnswer::Instead(text) => number(&self.siemens.instead(self.host, &text)?)? as i64,
            _ => self.host.known_tool(called).map_or(-1, i64::from),
        };
        match duplo {
            Some(duplo) if found > 0 && duplo != self.duplo(found)? => Ok(Data::Int(-1)),
            _ => Ok(Data::Int(found)),
        }
    }

    /// `$TC_TP1[t]`, the number of a tool among those of its name; 1 until a program sets it.
    fn duplo(&mut self, tool: i64) -> Outcome<f64> {
        let name = whole(&format!("$TC_TP1[{tool}]")).or_else(syntax)?;
        let value = number(&self.evaluate(&name)?)?;
        Ok(if value == 0.0 { 1.0 } else { value })
    }
}

impl Siemens {
    /// Value of an expression.
    pub(super) fn evaluate(&mut self, host: &mut dyn InterpreterHost, expression: &Expression) -> Outcome<Data> {
        SiemensEvaluator { siemens: self, host }.evaluate(expression)
    }

    /// A condition.
    pub(super) fn is_true(&mut self, host: &mut dyn InterpreterHost, condition: &Expression) -> Outcome<bool> {
        Ok(number(&self.evaluate(host, condition)?)? != 0.0)
    }

    /// A whole number, rounded.
    pub(super) fn whole_number(&mut self, host: &mut dyn InterpreterHost, expression: &Expression) -> Outcome<i64> {
        let value = number(&self.evaluate(host, expression)?)?.round();
        if value.abs() > 1e15 { wrong_type(format!("{value:e} is out of range")) } else { Ok(value as i64) }
    }

    /// Value of an argument; none if it was left out.
    pub(super) fn argument(
        &mut self,
        host: &mut dyn InterpreterHost,
        argument: &SiemensArgument,
    ) -> Outcome<Option<Data>> {
        match &argument.value {
            Ok(None) => Ok(None),
            Ok(Some(expression)) => self.evaluate(host, expression).map(Some),
            Err(text) => syntax(text.clone()),
        }
    }

    /// Value of a name.
    pub(super) fn read(&mut self, host: &mut dyn InterpreterHost, name: &IndexedName) -> Outcome<Data> {
        if let Some(number) = name.parameter() {
            return Ok(Data::Real(self.variables.parameter(number)));
        }
        if name.name.starts_with('$') {
            let asked = self.written(host, name)?;
            if name.name == TOOL_NAME {
                return self.tool_number(host, &asked);
            }
            return match self.ask(host, &asked, None)? {
                IdentificationAnswer::Instead(text) => {
                    let value = self.instead(host, &text)?;
                    self.worn(host, name, value)
                }
                IdentificationAnswer::Drop => Ok(Data::Int(0)),
                IdentificationAnswer::Keep => Ok(Data::Axis(asked)),
                IdentificationAnswer::Unknown => match self.system(host, name)? {
                    Some(value) => Ok(value),
                    None => Err(unknown(&asked)),
                },
            };
        }
        if let Some(value) = self.variables.scalar(&name.name).filter(|_| name.index.is_empty()) {
            return Ok(value.clone());
        }
        if let Some(number) = self.r_parameter(host, name)? {
            return Ok(Data::Real(self.variables.parameter(number)));
        }
        if ("RG", 1) == (name.name.as_str(), name.index.len())
            && !self.variables.knows("RG")
            && let Some(value) = self.stored_value(host, name)?
        {
            return Ok(value);
        }
        if name.name == "AX" && name.index.len() == 1 {
            return self.axis_of(host, name);
        }
        let is_local = name.name == "R" || self.variables.knows(&name.name);
        if !is_local && name.index.is_empty() && (name.name == NO_AXIS || words_name(host, &name.name)) {
            return Ok(Data::Axis(name.name.clone()));
        }
        if let Some(target) = self.locate(host, name)? {
            return self.value_of(host, &target);
        }
        let asked = self.written(host, name)?;
        match self.ask(host, &asked, None)? {
            IdentificationAnswer::Instead(text) => self.instead(host, &text),
            IdentificationAnswer::Drop => Ok(Data::Int(0)),
            IdentificationAnswer::Keep => Ok(Data::Axis(asked)),
            IdentificationAnswer::Unknown => match MACHINING.iter().find(|(text, _)| *text == asked) {
                Some((_, value)) => Ok(Data::Int(*value)),
                None => Err(unknown(&asked)),
            },
        }
    }

    /// `$P_TOOLNAME["NAME"]`: the number that the program has given to the name, or that of the tables of tools, or a new one.
    fn tool_number(&mut self, host: &mut dyn InterpreterHost, asked: &str) -> Outcome<Data> {
        let called = asked.split('"').nth(1).unwrap_or_default();
        let value = match self.ask(host, asked, None)? {
            IdentificationAnswer::Instead(text) => self.instead(host, &text)?,
            _ => match host.tool_number(called) {
                Some(number) => Data::Int(number.into()),
                None => return Err(unknown(asked)),
            },
        };
        if let Some(number) = number(&value).ok().filter(|number| (1.0..=99_999_999.0).contains(number)) {
            host.name_tool(number as u32, called);
        }
        Ok(value)
    }

    /// `AX[…]`: the axis that a variable names.
    pub(super) fn axis_of(&mut self, host: &mut dyn InterpreterHost, name: &IndexedName) -> Outcome<Data> {
        let Some(index) = name.index.first() else { return syntax("AX needs an axis") };
        match self.evaluate(host, index)? {
            Data::Axis(axis) => Ok(Data::Axis(axis)),
            other => wrong_type(format!("{} is not an axis", other.described())),
        }
    }

    /// Asks the identification macro, if that may be asked now.
    pub(super) fn ask(
        &mut self,
        host: &mut dyn InterpreterHost,
        text: &str,
        assigned: Option<&counterpoint_lang::value::MacroValue>,
    ) -> Outcome<IdentificationAnswer> {
        if self.quiet { Ok(IdentificationAnswer::Unknown) } else { Ok(host.identify(text, assigned)?.unless(text)) }
    }

    /// Text that a macro gives in place of a text; the macro is not asked about the content of its answer.
    pub(super) fn instead(&mut self, host: &mut dyn InterpreterHost, text: &str) -> Outcome<Data> {
        let expression = whole(text).or_else(syntax)?;
        let before = std::mem::replace(&mut self.quiet, true);
        let value = self.evaluate(host, &expression);
        self.quiet = before;
        value
    }

    /// A name with the values of its indices, as macros and texts see it.
    pub(super) fn written(&mut self, host: &mut dyn InterpreterHost, name: &IndexedName) -> Outcome<String> {
        if name.index.is_empty() {
            return Ok(name.name.clone());
        }
        let mut texts = Vec::new();
        for index in &name.index {
            let text = match as_name(index) {
                // Parts of frames and names of data are texts, other variables have values.
                Some(name)
                    if name.index.is_empty() && !name.name.starts_with('$') && !self.variables.knows(&name.name) =>
                {
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

    fn function(&mut self, host: &mut dyn InterpreterHost, name: &str, arguments: &[SiemensArgument]) -> Outcome<Data> {
        if let Some(value) = self.frame_function(host, name, arguments)? {
            return Ok(value);
        }
        if !functions::is_function(name) {
            let texts: Vec<&str> = arguments.iter().map(|argument| argument.text.as_str()).collect();
            let asked = format!("{name}({})", texts.join(","));
            return match self.ask(host, &asked, None)? {
                IdentificationAnswer::Instead(text) => self.instead(host, &text),
                IdentificationAnswer::Drop => Ok(Data::Int(0)),
                IdentificationAnswer::Keep => Ok(Data::Axis(asked)),
                IdentificationAnswer::Unknown => {
                    Err(SiemensBlockError::Alarm(&diag::MACRO_VARIABLE, format!("function {name} does not exist")))
                }
            };
        }
        let mut values = Vec::new();
        for argument in arguments {
            match self.argument(host, argument)? {
                Some(value) => values.push(value),
                None => return syntax(format!("an argument of {name} is missing")),
            }
        }
        functions::check(name, values.len())?;
        if let Some(function) = functions::of_one(name) {
            return functions::apply(function, &values.pop().unwrap_or_default());
        }
        match functions::number_function(name, &values)? {
            Some(value) => Ok(value),
            None => self.text_function(host, name, &values),
        }
    }
}

/// The value of a variable of type AXIS that names none.
const NO_AXIS: &str = "NO_AXIS";

/// Types of machining of CYCLE832 by their names: units 0 off, 1 finishing, 2 semi-finishing, 3 roughing, 4 precision;
/// tens 1 with a tolerance of the orientation.
const MACHINING: [(&str, i64); 10] = [
    ("_OFF", 0),
    ("_FINISH", 1),
    ("_SEMIFIN", 2),
    ("_ROUGH", 3),
    ("_PRECISION", 4),
    ("_ORI_OFF", 10),
    ("_ORI_FINISH", 11),
    ("_ORI_SEMIFIN", 12),
    ("_ORI_ROUGH", 13),
    ("_ORI_PRECISION", 14),
];

/// Whether a register or an axis has this name.
pub(super) fn words_name(host: &dyn InterpreterHost, name: &str) -> bool {
    host.is_register(name) || host.is_register(&format!("{name}=")) || host.axis_letter(name).is_some()
}

fn unknown(name: &str) -> SiemensBlockError {
    SiemensBlockError::Alarm(&diag::MACRO_VARIABLE, format!("variable {name} does not exist"))
}

fn binary(operator: NumericOperator, left: Data, right: Data) -> Outcome<Data> {
    use NumericOperator as B;
    match operator {
        B::Join => {
            let text = left.text() + &right.text();
            if text.len() > LONGEST {
                return wrong_type(format!("a text is longer than {LONGEST} characters"));
            }
            Ok(Data::Text(text))
        }
        B::Chain => {
            let (outer, inner) = (super::conversions::as_frame(left)?, super::conversions::as_frame(right)?);
            match outer.chain(&inner) {
                Some(frame) => Ok(Data::Frame(Box::new(frame))),
                None => wrong_type("the frame is out of range"),
            }
        }
        operator if operator.compares() => compare(operator, left, right),
        B::Or | B::Xor | B::And => {
            let value = operator.value(number(&left)?, number(&right)?);
            Ok(Data::Bool(value == Some(1.0)))
        }
        B::BitOr => Ok(Data::Int(i64::from(bits(&left)? | bits(&right)?))),
        B::BitXor => Ok(Data::Int(i64::from(bits(&left)? ^ bits(&right)?))),
        B::BitAnd => Ok(Data::Int(i64::from(bits(&left)? & bits(&right)?))),
        _ => calculate(operator, &left, &right),
    }
}

fn calculate(operator: NumericOperator, left: &Data, right: &Data) -> Outcome<Data> {
    if let (Data::Int(a), Data::Int(b)) = (left, right) {
        let exact = match operator {
            NumericOperator::Add => a.checked_add(*b),
            NumericOperator::Sub => a.checked_sub(*b),
            NumericOperator::Mul => a.checked_mul(*b),
            NumericOperator::WholeDiv => a.checked_div(*b),
            NumericOperator::Rem => a.checked_rem(*b),
            _ => None,
        };
        if let Some(value) = exact {
            return Ok(Data::Int(value));
        }
    }
    match operator.value(number(left)?, number(right)?) {
        Some(value) => real(value),
        None => Err(SiemensBlockError::Alarm(&diag::MACRO_DIVISION, "division by zero".to_owned())),
    }
}

fn compare(operator: NumericOperator, left: Data, right: Data) -> Outcome<Data> {
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
    if no_order && !matches!(operator, NumericOperator::Eq | NumericOperator::Ne) {
        return wrong_type(format!("{} has no order", left.described()));
    }
    Ok(Data::Bool(match operator {
        NumericOperator::Eq => order.is_eq(),
        NumericOperator::Ne => order.is_ne(),
        NumericOperator::Lt => order.is_lt(),
        NumericOperator::Le => order.is_le(),
        NumericOperator::Gt => order.is_gt(),
        _ => order.is_ge(),
    }))
}
