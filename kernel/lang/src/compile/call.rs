//! Calls of functions: those of macros and those of the language.

use super::MacroCompiler;
use super::expression::{Operand, ResolvedVariable};
use crate::ast::{Expr, ExprKind, VariableName};
use crate::bytecode::{CommandCode, Instruction, NO_SLOT, Slot};
use crate::diag::DiagnosticNumber;
use crate::func::{self, EvaluationMethod};
use crate::ident;
use crate::source::Span;
use crate::value::{MacroValue, ValueType};

impl MacroCompiler<'_> {
    pub(super) fn user_call(&mut self, name: &str, arguments: &[Expr], span: Span, wanted: Option<Slot>) -> Operand {
        let slots: Vec<Operand> = arguments.iter().map(|argument| self.expression(argument, None)).collect();
        let Some(symbol) = self.program.functions.get(name).cloned() else {
            let help = self.near_name(name);
            let message = format!("{name} is neither a function nor an array that is declared or assigned");
            if self.locals.contains_key(name) {
                return (0, None);
            }
            self.error_with(span, DiagnosticNumber::UNKNOWN_FUNCTION, message, help);
            return (0, None);
        };
        if symbol.parameters.len() != arguments.len() {
            let message = format!("{name} takes {} arguments, {} are given", symbol.parameters.len(), arguments.len());
            self.error(span, DiagnosticNumber::WRONG_COUNT, message);
        }
        for ((argument, (_, kind)), wanted) in arguments.iter().zip(&slots).zip(&symbol.parameters) {
            if let (Some(found), Some(kind)) = (kind, wanted)
                && found != kind
            {
                self.wrong(argument.span, kind.name(), *found);
            }
        }
        let list = self.list(slots.into_iter().map(|(slot, _)| slot).collect());
        let to = self.goal(wanted);
        self.emit(Instruction::CallMacro { to, callee: symbol.index, list });
        if self.issues {
            self.bare(CommandCode::MatchAgain);
        }
        (to, symbol.result)
    }

    pub(super) fn call(&mut self, name: &str, arguments: &[Expr], span: Span, wanted: Option<Slot>) -> Operand {
        let Some(function) = func::named(name) else {
            let help = ident::nearest(name, func::all().map(|function| function.name));
            let help = help.map(|near| format!("did you mean {near}?"));
            self.error_with(span, DiagnosticNumber::UNKNOWN_FUNCTION, format!("unknown function {name}"), help);
            return (0, None);
        };
        if let EvaluationMethod::Missing(why) = function.way {
            self.error(span, DiagnosticNumber::NOT_HERE, format!("{name} is not available: {why}"));
            return (0, function.result);
        }
        if arguments.len() < function.least() || arguments.len() > function.most() {
            let message = if function.least() == function.most() {
                format!("{name} takes {} arguments, {} are given", function.least(), arguments.len())
            } else {
                format!("{name} takes at least {} arguments, {} are given", function.least(), arguments.len())
            };
            self.error(span, DiagnosticNumber::WRONG_COUNT, message);
        }
        if name == "$FFIND"
            && let Some(found) = self.find_in_system(arguments, wanted)
        {
            return found;
        }
        let mut slots = Vec::new();
        for (position, argument) in arguments.iter().enumerate() {
            if name == "$FFIND" && position == 0 {
                slots.push(self.whole_array(argument));
                continue;
            }
            let (slot, kind) = self.expression(argument, None);
            if let Some(kind) = kind.filter(|kind| !func::fits(function.letter(position), *kind)) {
                let message = format!("argument {} of {name} cannot be of type {}", position + 1, kind.name());
                self.error(argument.span, DiagnosticNumber::WRONG_TYPE, message);
            }
            self.check_literal(function.name, position, argument);
            slots.push(slot);
        }
        let position = self.function(function);
        let to = self.goal(wanted);
        if let (EvaluationMethod::Math(_), [a]) = (&function.way, slots.as_slice()) {
            self.emit(Instruction::Math { to, a: *a, function: position });
        } else {
            let list = self.list(slots);
            self.emit(Instruction::Call { to, function: position, list });
        }
        (to, function.result)
    }

    /// Checks formats and regular expressions that are written as constants.
    fn check_literal(&mut self, name: &str, position: usize, argument: &Expr) {
        let ExprKind::Text(text) = &argument.kind else { return };
        let fault = match (name, position) {
            ("$FSWRIT", 0) => crate::format::StringFormat::output(text).err(),
            ("$FEDIT" | "$FMATCH" | "$FSPLIT", 1) => crate::pattern::TextPattern::new(text).err(),
            _ => None,
        };
        if let Some(fault) = fault {
            self.error(argument.span, fault.number, fault.message);
        }
    }

    fn function(&mut self, function: &'static func::BuiltInFunction) -> u16 {
        let known = self.code.functions.iter().position(|other| other.name == function.name);
        let position = known.unwrap_or_else(|| {
            self.code.functions.push(function);
            self.code.functions.len() - 1
        });
        u16::try_from(position).unwrap_or(u16::MAX)
    }

    /// `$FFIND` from an element of a system variable on; none if its first argument is something else.
    fn find_in_system(&mut self, arguments: &[Expr], wanted: Option<Slot>) -> Option<Operand> {
        let (first, looked_for) = (arguments.first()?, arguments.get(1)?);
        let ExprKind::Element(variable @ VariableName::System(_), indices) = &first.kind else { return None };
        let ResolvedVariable::System { index, indices: known, .. } = self.reach(variable, first.span, false) else {
            return None;
        };
        if known == 0 || known != indices.len() {
            return None;
        }
        let system = self.constant(MacroValue::Real(f64::from(index)));
        let from = self.indices(indices);
        let value = self.expression(looked_for, None).0;
        let limit = match arguments.get(2) {
            Some(limit) => self.typed(limit, ValueType::Real, "a number"),
            None => self.constant(MacroValue::Null),
        };
        let mut slots = vec![system, value, limit];
        slots.extend(from);
        let list = self.list(slots);
        let function = self.function(&func::FIND_IN_SYSTEM);
        let to = self.goal(wanted);
        self.emit(Instruction::Call { to, function, list });
        Some((to, Some(ValueType::Real)))
    }

    /// An array, or the rest of one from an element on, for `$FFIND`.
    fn whole_array(&mut self, argument: &Expr) -> Slot {
        let (variable, indices) = match &argument.kind {
            ExprKind::Variable(variable) => (variable, None),
            ExprKind::Element(variable, indices) => (variable, Some(indices)),
            _ => return self.expression(argument, None).0,
        };
        let (slot, array) = match self.reach(variable, argument.span, false) {
            ResolvedVariable::Local(local) => (local.slot, local.indices > 0 || local.channel),
            ResolvedVariable::Shared { shared, indices, channel, .. } if indices > 0 || channel => {
                let to = self.temporary();
                self.emit(Instruction::ReadShared { to, shared });
                (to, true)
            }
            _ => return self.expression(argument, None).0,
        };
        if !array {
            return self.expression(argument, None).0;
        }
        let Some(indices) = indices else { return slot };
        let mut list = vec![NO_SLOT];
        list.extend(self.indices(indices));
        let list = self.list(list);
        let to = self.temporary();
        self.emit(Instruction::Elements { to, a: slot, list });
        to
    }
}
