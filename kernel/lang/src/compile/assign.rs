//! Assignments to variables and elements, and declarations.

use super::MacroCompiler;
use super::expression::{Reach, arithmetic};
use crate::ast::{Declared, Expr, ExprKind, Scope, Variable};
use crate::bytecode::{Declaration, Op, Slot};
use crate::diag::Number;
use crate::lex::Sign;
use crate::source::Span;
use crate::value::Kind;

impl MacroCompiler<'_> {
    pub(super) fn assign(&mut self, target: &Expr, sign: Sign, value: &Expr) {
        match &target.kind {
            ExprKind::Variable(variable) => self.assign_variable(variable, target.span, sign, value),
            ExprKind::Element(variable, indices) => self.assign_element(variable, indices, target, sign, value),
            _ => {}
        }
    }

    fn assign_variable(&mut self, variable: &Variable, span: Span, sign: Sign, value: &Expr) {
        let reach = self.reach(variable, span, true);
        if let Reach::Local(local) = &reach
            && local.indices == 0
            && !local.channel
        {
            return self.assign_local(local.slot, local.kind, (sign, span), value);
        }
        if self.is_array(&reach) {
            self.error(span, Number::BAD_ARRAY, "an array is assigned element by element");
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

    fn is_array(&self, reach: &Reach) -> bool {
        match reach {
            Reach::Local(local) => local.indices > 0,
            Reach::Shared { indices, .. } => *indices > 0,
            _ => false,
        }
    }

    fn assign_local(&mut self, slot: Slot, declared: Option<Kind>, (sign, span): (Sign, Span), value: &Expr) {
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
            self.emit(Op::Typed { to: slot, a, kind: declared });
            return;
        }
        let (a, kind) = self.expression(value, None);
        if sign == Sign::AddAssign {
            if let (Some(x), Some(y)) = (declared, kind)
                && x != y
                && x != Kind::Sequence
            {
                self.wrong(value.span, x.name(), y);
            }
            self.emit(Op::AddTo { to: slot, a });
        } else {
            self.operands(sign, (declared, span), (kind, value.span));
            self.emit(arithmetic(sign, slot, slot, a));
        }
    }

    /// Type of an expression that is known without compiling it.
    fn evident(&self, value: &Expr) -> Option<Kind> {
        match &value.kind {
            ExprKind::Real(_) => Some(Kind::Real),
            ExprKind::Text(_) => Some(Kind::Text),
            ExprKind::Logical(_) => Some(Kind::Logical),
            ExprKind::Sequence(_) => Some(Kind::Sequence),
            ExprKind::Unary(Sign::Not, _) => Some(Kind::Logical),
            ExprKind::Unary(..) => Some(Kind::Real),
            ExprKind::Binary(Sign::Minus | Sign::Star | Sign::Slash | Sign::Power, ..) => Some(Kind::Real),
            ExprKind::Binary(Sign::Plus, left, right) => match (self.evident(left), self.evident(right)) {
                (Some(Kind::Real), Some(Kind::Real)) => Some(Kind::Real),
                _ => None,
            },
            ExprKind::Variable(Variable::User(name)) => {
                self.locals.get(name).filter(|local| local.indices == 0 && !local.channel).and_then(|local| local.kind)
            }
            ExprKind::Call(name, _) => crate::func::named(name)
                .filter(|function| matches!(function.way, crate::func::Way::Math(_)))
                .and_then(|function| function.result),
            _ => None,
        }
    }

    fn assign_element(&mut self, variable: &Variable, indices: &[Expr], target: &Expr, sign: Sign, value: &Expr) {
        if indices.is_empty() {
            self.error(target.span, Number::WRONG_COUNT, "an index is missing between the parentheses");
            return;
        }
        let reach = self.reach(variable, target.span, true);
        match &reach {
            Reach::Local(local) => {
                self.check_count(indices.len(), local.indices, local.channel, local.kind, target.span);
                if local.kind == Some(Kind::Text) && local.indices == 0 && !local.channel {
                    self.error(target.span, Number::BAD_TARGET, "a part of a text cannot be assigned to");
                }
            }
            Reach::Shared { indices: known, channel, kind, .. } => {
                self.check_count(indices.len(), *known, *channel, *kind, target.span);
                if *kind == Some(Kind::Text) && *known == 0 && !*channel {
                    self.error(target.span, Number::BAD_TARGET, "a part of a text cannot be assigned to");
                }
            }
            Reach::System { indices: known, .. } if *known != indices.len() => {
                self.error(target.span, Number::WRONG_COUNT, format!("this variable takes {known} indices"));
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

    fn compound(&mut self, reach: &Reach, read: &Expr, indices: Option<&[Expr]>, sign: Sign, value: &Expr) {
        let to = self.temporary();
        let (_, kind) = self.expression(read, Some(to));
        let (a, found) = self.expression(value, None);
        if sign == Sign::AddAssign {
            self.emit(Op::AddTo { to, a });
        } else {
            self.operands(sign, (kind, read.span), (found, value.span));
            self.emit(arithmetic(sign, to, to, a));
        }
        let slots = indices.map(|indices| self.indices(indices));
        self.store(reach, read.span, slots, to, (None, value.span));
    }

    /// Type that a store must have, if it must have one.
    pub(super) fn declared_kind(reach: &Reach, element: bool) -> Option<Kind> {
        match reach {
            Reach::Local(local) if !element || local.indices > 0 || local.channel => local.kind,
            Reach::Shared { kind, indices, channel, .. } if !element || *indices > 0 || *channel => *kind,
            Reach::System { kind, .. } => *kind,
            _ => None,
        }
    }

    /// Emits the store of a register; no indices for a single value.
    pub(super) fn store(
        &mut self,
        reach: &Reach,
        span: Span,
        indices: Option<Vec<Slot>>,
        a: Slot,
        (kind, value_span): (Option<Kind>, Span),
    ) {
        let declared = Self::declared_kind(reach, indices.is_some());
        if let (Some(declared), Some(found)) = (declared, kind)
            && declared != found
        {
            self.wrong(value_span, declared.name(), found);
        }
        match reach {
            Reach::Local(local) => match indices.as_deref() {
                Some([index]) => {
                    self.emit(Op::SetElement { to: local.slot, index: *index, a });
                }
                None if !local.channel => {
                    let op = match local.kind {
                        Some(kind) => Op::Typed { to: local.slot, a, kind },
                        None => Op::Move { to: local.slot, a },
                    };
                    self.emit(op);
                }
                _ => {
                    let list = self.list(indices.unwrap_or_default());
                    self.emit(Op::SetElements { to: local.slot, list, a });
                }
            },
            Reach::Shared { shared, channel, .. } => match indices {
                None if !channel => {
                    self.emit(Op::WriteShared { shared: *shared, a });
                }
                indices => {
                    let list = self.list(indices.unwrap_or_default());
                    self.emit(Op::SetSharedElements { shared: *shared, list, a });
                }
            },
            Reach::System { index, writable, indices: known, .. } => {
                if !writable {
                    self.error(span, Number::READ_ONLY, "this system variable can only be read");
                } else if indices.is_none() && *known > 0 {
                    self.error(span, Number::WRONG_COUNT, format!("this variable takes {known} indices"));
                }
                let list = self.list(indices.unwrap_or_default());
                self.emit(Op::WriteSystem { system: *index, list, a });
            }
            Reach::Own(_) => self.error(span, Number::READ_ONLY, "this system variable can only be read"),
            Reach::Nowhere => {}
        }
    }

    pub(super) fn declare(&mut self, scope: Scope, kind: Option<Kind>, channel: bool, names: &[Declared]) {
        for declared in names {
            let sizes = self.indices(&declared.sizes);
            let most = if channel { 3 } else { 4 };
            if sizes.len() > most {
                self.error(declared.span, Number::BAD_ARRAY, format!("an array has at most {most} dimensions here"));
            }
            if kind == Some(Kind::Sequence) && (!sizes.is_empty() || channel) {
                self.error(declared.span, Number::BAD_ARRAY, "sequences cannot be elements of an array");
            }
            if !sizes.is_empty() && declared.value.is_some() {
                self.error(declared.span, Number::BAD_ARRAY, "an array cannot be initialised in its declaration");
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
            let declaration = self.declaration(Declaration { kind, sizes, channel, value });
            let local = self.locals.get(&declared.name).map(|local| local.slot);
            match (scope, local, self.program.shared.get(&declared.name).cloned()) {
                (Scope::Local, Some(to), _) => {
                    self.emit(Op::Declare { to, declaration });
                }
                (Scope::Object | Scope::Global, _, Some(symbol)) => {
                    let shared = self.shared(symbol.shared, symbol.kind);
                    self.emit(Op::DeclareShared { shared, declaration });
                }
                _ => {}
            }
        }
    }
}
