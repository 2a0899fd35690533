//! Assignments to variables and elements, and declarations.

use super::MacroCompiler;
use super::expression::{ResolvedVariable, arithmetic};
use crate::ast::{DeclaredName, Expr, ExprKind, MacroVariableScope, VariableName};
use crate::bytecode::{Instruction, RuntimeDeclaration, Slot};
use crate::diag::DiagnosticNumber;
use crate::lex::Sign;
use crate::source::Span;
use crate::value::ValueType;

impl MacroCompiler<'_> {
    pub(super) fn assign(&mut self, target: &Expr, sign: Sign, value: &Expr) {
        match &target.kind {
            ExprKind::Variable(variable) => self.assign_variable(variable, target.span, sign, value),
            ExprKind::Element(variable, indices) => self.assign_element(variable, indices, target, sign, value),
            _ => {}
        }
    }

    fn assign_variable(&mut self, variable: &VariableName, span: Span, sign: Sign, value: &Expr) {
        let reach = self.reach(variable, span, true);
        if let ResolvedVariable::Local(local) = &reach
            && local.indices == 0
            && !local.channel
        {
            return self.assign_local(local.slot, local.kind, (sign, span), value);
        }
        if self.is_array(&reach) {
            self.error(span, DiagnosticNumber::BAD_ARRAY, "an array is assigned element by element");
            return;
        }
        if sign == Sign::Assign {
            let (slot, kind) = self.expression(value, None);
            self.store(&reach, span, None, slot, (kind, value.span));
            return;
        }
        let read = Expr::new(ExprKind::Variable(variable.clone()), span);
        self.compound(&reach, &read, None, sign, value);
    }

    fn is_array(&self, reach: &ResolvedVariable) -> bool {
        match reach {
            ResolvedVariable::Local(local) => local.indices > 0,
            ResolvedVariable::Shared { indices, .. } => *indices > 0,
            _ => false,
        }
    }

    fn assign_local(&mut self, slot: Slot, declared: Option<ValueType>, (sign, span): (Sign, Span), value: &Expr) {
        if sign == Sign::Assign {
            let Some(declared) = declared else {
                self.expression(value, Some(slot));
                return;
            };
            let known = self.evident(value);
            if known == Some(declared) {
                self.expression(value, Some(slot));
                return;
            }
            let (a, kind) = self.expression(value, None);
            if let Some(found) = kind.filter(|found| *found != declared) {
                self.wrong(value.span, declared.name(), found);
            }
            self.emit(Instruction::Typed { to: slot, a, kind: declared });
            return;
        }
        let (a, kind) = self.expression(value, None);
        if sign == Sign::AddAssign {
            if let (Some(x), Some(y)) = (declared, kind)
                && x != y
                && x != ValueType::Sequence
            {
                self.wrong(value.span, x.name(), y);
            }
            self.emit(Instruction::AddTo { to: slot, a });
        } else {
            self.operands(sign, (declared, span), (kind, value.span));
            self.emit(arithmetic(sign, slot, slot, a));
        }
    }

    /// Type of an expression that is known without compiling it.
    fn evident(&self, value: &Expr) -> Option<ValueType> {
        match &value.kind {
            ExprKind::Real(_) => Some(ValueType::Real),
            ExprKind::Text(_) => Some(ValueType::Text),
            ExprKind::Logical(_) => Some(ValueType::Logical),
            ExprKind::Sequence(_) => Some(ValueType::Sequence),
            ExprKind::Unary(Sign::Not, _) => Some(ValueType::Logical),
            ExprKind::Unary(..) => Some(ValueType::Real),
            ExprKind::Binary(Sign::Minus | Sign::Star | Sign::Slash | Sign::Power, ..) => Some(ValueType::Real),
            ExprKind::Binary(Sign::Plus, left, right) => match (self.evident(left), self.evident(right)) {
                (Some(ValueType::Real), Some(ValueType::Real)) => Some(ValueType::Real),
                _ => None,
            },
            ExprKind::Variable(VariableName::User(name)) => {
                self.locals.get(name).filter(|local| local.indices == 0 && !local.channel).and_then(|local| local.kind)
            }
            ExprKind::Call(name, _) => crate::func::named(name)
                .filter(|function| matches!(function.way, crate::func::EvaluationMethod::Math(_)))
                .and_then(|function| function.result),
            _ => None,
        }
    }

    fn assign_element(&mut self, variable: &VariableName, indices: &[Expr], target: &Expr, sign: Sign, value: &Expr) {
        if indices.is_empty() {
            self.error(target.span, DiagnosticNumber::WRONG_COUNT, "an index is missing between the parentheses");
            return;
        }
        let reach = self.reach(variable, target.span, true);
        match &reach {
            ResolvedVariable::Local(local) => {
                self.check_count(indices.len(), local.indices, local.channel, local.kind, target.span);
                if local.kind == Some(ValueType::Text) && local.indices == 0 && !local.channel {
                    self.error(target.span, DiagnosticNumber::BAD_TARGET, "a part of a text cannot be assigned to");
                }
            }
            ResolvedVariable::Shared { indices: known, channel, kind, .. } => {
                self.check_count(indices.len(), *known, *channel, *kind, target.span);
                if *kind == Some(ValueType::Text) && *known == 0 && !*channel {
                    self.error(target.span, DiagnosticNumber::BAD_TARGET, "a part of a text cannot be assigned to");
                }
            }
            ResolvedVariable::System { indices: known, .. } if *known != indices.len() => {
                self.error(target.span, DiagnosticNumber::WRONG_COUNT, format!("this variable takes {known} indices"));
                return;
            }
            _ => {}
        }
        if sign != Sign::Assign {
            self.compound(&reach, target, Some(indices), sign, value);
            return;
        }
        let (slot, kind) = self.expression(value, None);
        let slots = self.indices(indices);
        self.store(&reach, target.span, Some(slots), slot, (kind, value.span));
    }

    fn compound(&mut self, reach: &ResolvedVariable, read: &Expr, indices: Option<&[Expr]>, sign: Sign, value: &Expr) {
        let to = self.temporary();
        let (_, kind) = self.expression(read, Some(to));
        let (a, found) = self.expression(value, None);
        if sign == Sign::AddAssign {
            self.emit(Instruction::AddTo { to, a });
        } else {
            self.operands(sign, (kind, read.span), (found, value.span));
            self.emit(arithmetic(sign, to, to, a));
        }
        let slots = indices.map(|indices| self.indices(indices));
        self.store(reach, read.span, slots, to, (None, value.span));
    }

    /// Type that a store must have, if it must have one.
    pub(super) fn declared_kind(reach: &ResolvedVariable, element: bool) -> Option<ValueType> {
        match reach {
            ResolvedVariable::Local(local) if !element || local.indices > 0 || local.channel => local.kind,
            ResolvedVariable::Shared { kind, indices, channel, .. } if !element || *indices > 0 || *channel => *kind,
            ResolvedVariable::System { kind, .. } => *kind,
            _ => None,
        }
    }

    /// Emits the store of a register; no indices for a single value.
    pub(super) fn store(
        &mut self,
        reach: &ResolvedVariable,
        span: Span,
        indices: Option<Vec<Slot>>,
        a: Slot,
        (kind, value_span): (Option<ValueType>, Span),
    ) {
        let declared = Self::declared_kind(reach, indices.is_some());
        if let (Some(declared), Some(found)) = (declared, kind)
            && declared != found
        {
            self.wrong(value_span, declared.name(), found);
        }
        match reach {
            ResolvedVariable::Local(local) => match indices.as_deref() {
                Some([index]) => {
                    self.emit(Instruction::SetElement { to: local.slot, index: *index, a });
                }
                None if !local.channel => {
                    let op = match local.kind {
                        Some(kind) => Instruction::Typed { to: local.slot, a, kind },
                        None => Instruction::Move { to: local.slot, a },
                    };
                    self.emit(op);
                }
                _ => {
                    let list = self.list(indices.unwrap_or_default());
                    self.emit(Instruction::SetElements { to: local.slot, list, a });
                }
            },
            ResolvedVariable::Shared { shared, channel, .. } => match indices {
                None if !channel => {
                    self.emit(Instruction::WriteShared { shared: *shared, a });
                }
                indices => {
                    let list = self.list(indices.unwrap_or_default());
                    self.emit(Instruction::SetSharedElements { shared: *shared, list, a });
                }
            },
            ResolvedVariable::System { index, writable, indices: known, .. } => {
                if !writable {
                    self.error(span, DiagnosticNumber::READ_ONLY, "this system variable can only be read");
                } else if indices.is_none() && *known > 0 {
                    self.error(span, DiagnosticNumber::WRONG_COUNT, format!("this variable takes {known} indices"));
                }
                let list = self.list(indices.unwrap_or_default());
                self.emit(Instruction::WriteSystem { system: *index, list, a });
            }
            ResolvedVariable::Own(_) => {
                self.error(span, DiagnosticNumber::READ_ONLY, "this system variable can only be read")
            }
            ResolvedVariable::Nowhere => {}
        }
    }

    pub(super) fn declare(
        &mut self,
        scope: MacroVariableScope,
        kind: Option<ValueType>,
        channel: bool,
        names: &[DeclaredName],
    ) {
        for declared in names {
            let sizes = self.indices(&declared.sizes);
            let most = if channel { 3 } else { 4 };
            if sizes.len() > most {
                self.error(
                    declared.span,
                    DiagnosticNumber::BAD_ARRAY,
                    format!("an array has at most {most} dimensions here"),
                );
            }
            if kind == Some(ValueType::Sequence) && (!sizes.is_empty() || channel) {
                self.error(declared.span, DiagnosticNumber::BAD_ARRAY, "sequences cannot be elements of an array");
            }
            if !sizes.is_empty() && declared.value.is_some() {
                self.error(
                    declared.span,
                    DiagnosticNumber::BAD_ARRAY,
                    "an array cannot be initialised in its declaration",
                );
            }
            let value = declared.value.as_ref().map(|value| {
                let (slot, found) = self.expression(value, None);
                if let (Some(kind), Some(found)) = (kind, found)
                    && kind != found
                {
                    self.wrong(value.span, kind.name(), found);
                }
                slot
            });
            let declaration = self.declaration(RuntimeDeclaration { kind, sizes, channel, value });
            let local = self.locals.get(&declared.name).map(|local| local.slot);
            match (scope, local, self.program.shared.get(&declared.name).cloned()) {
                (MacroVariableScope::Local, Some(to), _) => {
                    self.emit(Instruction::Declare { to, declaration });
                }
                (MacroVariableScope::Object | MacroVariableScope::Global, _, Some(symbol)) => {
                    let shared = self.shared(symbol.shared, symbol.kind);
                    self.emit(Instruction::DeclareShared { shared, declaration });
                }
                _ => {}
            }
        }
    }
}
