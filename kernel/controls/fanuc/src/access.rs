//! Variables of the kernel as expressions see them.
//!
//! Facts: reference control-emulator.md 4.3, 5.4. Order for system variables: the machine's identification macro, then
//! the kernel's own knowledge. *Invariant:* the macro is not asked about the content of its own answer.

use counterpoint_fault as diag;
use counterpoint_fault::Halt;
use counterpoint_lang::value::MacroValue;

use super::compile::compile;
use super::expr::{self, Expr, FanucValueError, VariableAccess, is_vacant, number};
use super::statement::FanucStatement;
use counterpoint_control_api::host::{IdentificationAnswer, InterpreterHost, NotThere};
use counterpoint_program::key_words::StatementVocabulary;

/// The first variable of the system.
const SYSTEM: u32 = 1000;

/// A host as the variables of expressions.
pub(super) struct HostVariables<'h> {
    host: &'h mut dyn InterpreterHost,
    /// Steps of one unit that ROUND rounds to.
    steps: f64,
    /// An answer of the identification macro is being evaluated.
    answering: bool,
}

impl<'h> HostVariables<'h> {
    /// In a statement.
    pub(super) fn new(host: &'h mut dyn InterpreterHost) -> Self {
        Self { host, steps: 1.0, answering: false }
    }

    /// At an address whose values have this many steps of one unit.
    pub(super) fn at_address(host: &'h mut dyn InterpreterHost, steps: f64) -> Self {
        Self { steps, ..Self::new(host) }
    }

    #[inline]
    fn known(&mut self, index: u32) -> Result<f64, FanucValueError> {
        match self.host.number(index) {
            Ok(value) => Ok(value),
            Err(why) => Err(fault(index, why)),
        }
    }

    /// A variable that is not local, or has no value.
    #[inline(never)]
    fn look_up(&mut self, index: u32) -> Result<f64, FanucValueError> {
        let system = index >= SYSTEM && !self.host.is_common(index);
        let value = if system && self.asks() { self.identified(index) } else { self.known(index) };
        match value {
            Ok(value) => Ok(value),
            Err(fault) => self.missing(fault),
        }
    }

    /// Value of a variable that cannot be read.
    #[cold]
    fn missing(&mut self, fault: FanucValueError) -> Result<f64, FanucValueError> {
        if !matches!(fault, FanucValueError::NoVariable(_)) || !self.host.continues_after(&diag::MACRO_VARIABLE) {
            return Err(fault);
        }
        alarm(self.host, &fault);
        Ok(0.0)
    }

    fn asks(&self) -> bool {
        !self.answering && self.host.identifies()
    }

    #[inline(never)]
    fn identified(&mut self, index: u32) -> Result<f64, FanucValueError> {
        match self.ask_variable(index, None)? {
            IdentificationAnswer::Unknown => self.known(index),
            IdentificationAnswer::Drop => Ok(0.0),
            IdentificationAnswer::Keep => Err(FanucValueError::Kept(index)),
            IdentificationAnswer::Instead(text) => self.value_of(&text, FanucValueError::NoVariable(f64::from(index))),
        }
    }

    /// Asks about a variable; a text that is not changed is an error.
    fn ask_variable(
        &mut self,
        index: u32,
        assigned: Option<&MacroValue>,
    ) -> Result<IdentificationAnswer, FanucValueError> {
        let asked = format!("#{index}");
        match self.host.identify(&asked, assigned)? {
            // Evaluating the same text again would ask forever.
            IdentificationAnswer::Instead(text) if text.trim() == asked => {
                Err(FanucValueError::NoVariable(f64::from(index)))
            }
            answer => Ok(answer),
        }
    }

    /// Value of an expression that the macro gave in place of an unknown name.
    fn value_of(&mut self, text: &str, unknown: FanucValueError) -> Result<f64, FanucValueError> {
        let Ok(line) = compile(format!("#1=[{text}]").as_bytes(), StatementVocabulary::default()) else {
            return Err(unknown);
        };
        let FanucStatement::Assign(list) = line.statement else { return Err(unknown) };
        let [(_, value)] = list.as_slice() else { return Err(unknown) };
        let outer = std::mem::replace(&mut self.answering, true);
        let value = expr::value(value, self);
        self.answering = outer;
        if let Err(FanucValueError::NoFunction(_)) = value { Err(unknown) } else { value }
    }

    /// Sets a variable; the macro is asked for the target of a system variable.
    pub(super) fn set(&mut self, index: u32, value: f64) -> Result<(), FanucValueError> {
        let why = match self.host.set_number(index, value) {
            Ok(()) => return Ok(()),
            Err(NotThere::Halt(halt)) => return Err(FanucValueError::Halt(halt)),
            Err(why) => why,
        };
        if index < SYSTEM || !self.host.identifies() {
            return Err(fault(index, why));
        }
        match self.ask_variable(index, Some(&MacroValue::Real(number(value))))? {
            IdentificationAnswer::Unknown => Err(fault(index, why)),
            IdentificationAnswer::Drop => Ok(()),
            IdentificationAnswer::Keep => Err(FanucValueError::Kept(index)),
            IdentificationAnswer::Instead(text) => {
                let wanted = text.trim().strip_prefix('#').and_then(|text| text.trim().parse::<u32>().ok());
                match wanted.filter(|wanted| *wanted != index && (*wanted < SYSTEM || self.host.is_common(*wanted))) {
                    Some(wanted) => self.set(wanted, value),
                    None => Err(FanucValueError::NoVariable(f64::from(index))),
                }
            }
        }
    }
}

impl VariableAccess for HostVariables<'_> {
    #[inline]
    fn get(&mut self, index: u32) -> Result<f64, FanucValueError> {
        let local = self.host.local_number(index);
        if is_vacant(local) { self.look_up(index) } else { Ok(local) }
    }

    fn unknown_function(&mut self, span: (u32, u32)) -> Result<f64, FanucValueError> {
        let text = self.host.part(span).to_ascii_uppercase();
        let unknown = FanucValueError::NoFunction(text.clone());
        if !self.asks() {
            return Err(unknown);
        }
        match self.host.identify(&text, None)? {
            IdentificationAnswer::Unknown => Err(unknown),
            IdentificationAnswer::Drop => Ok(0.0),
            IdentificationAnswer::Keep => Err(FanucValueError::KeptFunction(text)),
            IdentificationAnswer::Instead(text) => self.value_of(&text, unknown),
        }
    }

    fn steps(&self) -> f64 {
        self.steps
    }
}

/// Why a statement was abandoned.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Abandoned {
    /// The kernel leaves its program.
    Halt(Halt),
    /// The identification macro keeps the text with an unknown variable in the block.
    Text,
}

impl From<Halt> for Abandoned {
    fn from(halt: Halt) -> Self {
        Self::Halt(halt)
    }
}

/// Value of an expression in a statement.
#[inline]
pub(super) fn eval(host: &mut dyn InterpreterHost, expr: &Expr) -> Result<f64, Abandoned> {
    eval_at(host, expr, 1.0)
}

/// Value of an expression at an address whose values have this many steps of one unit.
pub(super) fn eval_at(host: &mut dyn InterpreterHost, expr: &Expr, steps: f64) -> Result<f64, Abandoned> {
    if let Some(value) = expr.as_constant() {
        return Ok(*value);
    }
    match expr::value(expr, &mut HostVariables::at_address(host, steps)) {
        Ok(value) => Ok(value),
        // A result without a value counts as 0 where the machine continues.
        Err(fault) => abandons(host, &fault).map(|()| 0.0),
    }
}

/// A fault ends its statement, unless the machine continues after it.
pub(super) fn abandons(host: &mut dyn InterpreterHost, fault: &FanucValueError) -> Result<(), Abandoned> {
    if matches!(fault, FanucValueError::Kept(_) | FanucValueError::KeptFunction(_)) {
        return Err(Abandoned::Text);
    }
    match alarm(host, fault) {
        Halt::Dropped => Ok(()),
        halt => Err(Abandoned::Halt(halt)),
    }
}

/// Alarm of a fault.
fn alarm(host: &mut dyn InterpreterHost, fault: &FanucValueError) -> Halt {
    let facts = match fault {
        FanucValueError::Halt(halt) => return *halt,
        FanucValueError::Division => &diag::MACRO_DIVISION,
        FanucValueError::Overflow => &diag::MACRO_OVERFLOW,
        FanucValueError::Domain(..) => &diag::MACRO_DOMAIN,
        FanucValueError::NoFunction(_) | FanucValueError::KeptFunction(_) => &diag::MACRO_SYNTAX,
        FanucValueError::TooBig(_) => &diag::VARIABLE_VALUE,
        FanucValueError::NoVariable(_) | FanucValueError::ReadOnly(_) | FanucValueError::Kept(_) => {
            &diag::MACRO_VARIABLE
        }
    };
    let text = format!("{fault} in '{}'", host.block_text());
    host.alarm(facts, text)
}

fn fault(index: u32, why: NotThere) -> FanucValueError {
    match why {
        NotThere::Missing => FanucValueError::NoVariable(f64::from(index)),
        NotThere::ReadOnly => FanucValueError::ReadOnly(index),
        NotThere::TooBig => FanucValueError::TooBig(index),
        NotThere::Halt(halt) => FanucValueError::Halt(halt),
    }
}
