//! Expressions into registers, conditions into jumps.
//!
//! *Invariant:* an expression returns the register of its value and its type where that is evident.

use super::MacroCompiler;
use crate::ast::{Expr, ExprKind, VariableName};
use crate::bytecode::{BuiltInVariable, Instruction, NO_SLOT, Relation, SharedVariable, Slot};
use crate::diag::DiagnosticNumber;
use crate::func;
use crate::ident;
use crate::lex::Sign;
use crate::source::Span;
use crate::value::{MacroValue, ValueType};

/// Register and evident type.
pub(super) type Operand = (Slot, Option<ValueType>);

pub(super) fn relation(sign: Sign) -> Option<Relation> {
    Some(match sign {
        Sign::Equal => Relation::Equal,
        Sign::NotEqual => Relation::NotEqual,
        Sign::Less => Relation::Less,
        Sign::LessEqual => Relation::LessEqual,
        Sign::Greater => Relation::Greater,
        Sign::GreaterEqual => Relation::GreaterEqual,
        _ => return None,
    })
}

const fn opposite(relation: Relation) -> Relation {
    match relation {
        Relation::Equal => Relation::NotEqual,
        Relation::NotEqual => Relation::Equal,
        Relation::Less => Relation::GreaterEqual,
        Relation::LessEqual => Relation::Greater,
        Relation::Greater => Relation::LessEqual,
        Relation::GreaterEqual => Relation::Less,
    }
}

/// How a variable is reached.
pub(super) enum ResolvedVariable {
    Local(super::LocalSymbol),
    Shared { shared: u16, kind: Option<ValueType>, indices: usize, channel: bool },
    System { index: u16, kind: Option<ValueType>, indices: usize, writable: bool },
    Own(BuiltInVariable),
    Nowhere,
}

impl MacroCompiler<'_> {
    /// Compiles an expression; the result goes to `wanted` if that is given.
    pub(super) fn expression(&mut self, expression: &Expr, wanted: Option<Slot>) -> Operand {
        let (slot, kind) = match &expression.kind {
            ExprKind::Real(number) => (self.constant(MacroValue::Real(*number)), Some(ValueType::Real)),
            ExprKind::Text(text) => (self.constant(MacroValue::text(text.as_str())), Some(ValueType::Text)),
            ExprKind::Logical(truth) => (self.constant(MacroValue::Logical(*truth)), Some(ValueType::Logical)),
            ExprKind::Null => (self.constant(MacroValue::Null), None),
            ExprKind::Keyword(code) => (self.constant(MacroValue::Keyword(*code)), Some(ValueType::Keyword)),
            ExprKind::Record(record) => (self.constant(MacroValue::Record(*record)), Some(ValueType::Record)),
            ExprKind::Code(name) => (self.identifier(name, expression.span, true), Some(ValueType::Code)),
            ExprKind::Register(name) => (self.identifier(name, expression.span, false), Some(ValueType::Register)),
            ExprKind::Variable(variable) => self.read(variable, expression.span, wanted),
            ExprKind::Element(variable, indices) => return self.element(variable, indices, expression.span, wanted),
            ExprKind::Range(variable, from, to) => {
                return self.range(variable, [from.as_deref(), to.as_deref()], expression.span, wanted);
            }
            ExprKind::Sequence(parts) => {
                let slots = parts.iter().map(|part| self.expression(part, None).0).collect();
                let list = self.list(slots);
                let to = self.goal(wanted);
                self.emit(Instruction::Sequence { to, list });
                return (to, Some(ValueType::Sequence));
            }
            ExprKind::Call(name, arguments) => return self.call(name, arguments, expression.span, wanted),
            ExprKind::Unary(sign, operand) => return self.unary(*sign, operand, wanted),
            ExprKind::Binary(sign, left, right) => return self.binary(*sign, left, right, expression.span, wanted),
        };
        match wanted {
            Some(to) if to != slot => {
                self.emit(Instruction::Move { to, a: slot });
                (to, kind)
            }
            _ => (slot, kind),
        }
    }

    pub(super) fn goal(&mut self, wanted: Option<Slot>) -> Slot {
        match wanted {
            Some(slot) => slot,
            None => self.temporary(),
        }
    }

    fn identifier(&mut self, name: &str, span: Span, code: bool) -> Slot {
        let index = match (name, code) {
            ("CODE_NONE" | "REG_NONE", _) => Some(0),
            (_, true) => self.environment.code(name),
            (_, false) => self.environment.register(name),
        };
        if index.is_none() {
            let all = self.environment.identifiers();
            let help = ident::nearest(name, all.iter().map(String::as_str)).map(|near| format!("did you mean {near}?"));
            self.error_with(span, DiagnosticNumber::UNKNOWN_IDENTIFIER, format!("unknown identifier {name}"), help);
        }
        let index = index.unwrap_or(0);
        self.constant(if code { MacroValue::Code(index) } else { MacroValue::Register(index) })
    }

    pub(super) fn wrong(&mut self, span: Span, wanted: &str, found: ValueType) {
        self.error(
            span,
            DiagnosticNumber::WRONG_TYPE,
            format!("{wanted} is expected here, but this is of type {}", found.name()),
        );
    }

    /// Compiles an operand that must have a type.
    pub(super) fn typed(&mut self, expression: &Expr, kind: ValueType, wanted: &str) -> Slot {
        let (slot, found) = self.expression(expression, None);
        if let Some(found) = found.filter(|found| *found != kind) {
            self.wrong(expression.span, wanted, found);
        }
        slot
    }

    pub(super) fn reach(&mut self, variable: &VariableName, span: Span, write: bool) -> ResolvedVariable {
        let name = match variable {
            VariableName::User(name) => {
                if !self.locals.contains_key(name)
                    && let Some(symbol) = self.program.shared.get(name).cloned()
                {
                    let shared = self.shared(symbol.shared, symbol.kind);
                    return ResolvedVariable::Shared {
                        shared,
                        kind: symbol.kind,
                        indices: symbol.indices,
                        channel: symbol.channel,
                    };
                }
                if !self.locals.contains_key(name) && self.program.functions.contains_key(name) {
                    self.error(
                        span,
                        DiagnosticNumber::SYNTAX,
                        format!("{name} is a function and is called with parentheses"),
                    );
                    return ResolvedVariable::Nowhere;
                }
                name.clone()
            }
            VariableName::Local(number) => format!("%L{number:02}"),
            VariableName::Param(number) => {
                let name = format!("$P{number:02}");
                if !self.locals.contains_key(&name) {
                    let slot = self.new_local(&name, None, None);
                    self.code.signature.arguments.push((*number, slot));
                }
                name
            }
            VariableName::Global(number) => {
                let shared = self.shared(SharedVariable::Global(u32::from(*number)), None);
                return ResolvedVariable::Shared { shared, kind: None, indices: 0, channel: false };
            }
            VariableName::System(name) => return self.system(name, span),
        };
        ResolvedVariable::Local(self.local(&name, span, write))
    }

    fn system(&mut self, name: &str, span: Span) -> ResolvedVariable {
        let own = match name {
            "$ERRNO" => Some(BuiltInVariable::Status),
            "$MNEST" => Some(BuiltInVariable::Nesting),
            "$CI" => Some(BuiltInVariable::Channel),
            "$CHSIZ" | "$CHMAX" => Some(BuiltInVariable::Channels),
            _ => None,
        };
        if let Some(own) = own {
            return ResolvedVariable::Own(own);
        }
        let table = self.environment.system();
        if let Some((index, variable)) = table.iter().enumerate().find(|(_, variable)| variable.name == name) {
            return ResolvedVariable::System {
                index: u16::try_from(index).unwrap_or(u16::MAX),
                kind: variable.kind,
                indices: usize::from(variable.indices),
                writable: variable.writable,
            };
        }
        if let Some(product) = self.environment.foreign(name) {
            let message = format!("{name} belongs to {product}; the control emulator has no such variable");
            self.error(span, DiagnosticNumber::UNKNOWN_VARIABLE, message);
            return ResolvedVariable::Nowhere;
        }
        let names = table.iter().map(|variable| variable.name.as_str());
        let near = ident::nearest(name, names.chain(["$TRUE", "$FALSE", "$NULL", "$PI", "$ERRNO"]));
        let help = match near {
            Some(near) => Some(format!("did you mean {near}?")),
            None if func::named(name).is_some() => {
                Some("a function is called with parentheses, even empty ones".into())
            }
            None => None,
        };
        self.error_with(span, DiagnosticNumber::UNKNOWN_VARIABLE, format!("unknown system variable {name}"), help);
        ResolvedVariable::Nowhere
    }

    fn read(&mut self, variable: &VariableName, span: Span, wanted: Option<Slot>) -> Operand {
        match self.reach(variable, span, false) {
            ResolvedVariable::Local(local) if local.indices > 0 => {
                self.error(span, DiagnosticNumber::BAD_ARRAY, "an array is read element by element");
                (local.slot, None)
            }
            ResolvedVariable::Local(local) if local.channel => {
                let to = self.goal(wanted);
                let list = self.list(Vec::new());
                self.emit(Instruction::Elements { to, a: local.slot, list });
                (to, local.kind)
            }
            ResolvedVariable::Local(local) => (local.slot, local.kind),
            ResolvedVariable::Shared { indices, .. } if indices > 0 => {
                self.error(span, DiagnosticNumber::BAD_ARRAY, "an array is read element by element");
                (0, None)
            }
            ResolvedVariable::Shared { shared, kind, channel, .. } => {
                let to = self.goal(wanted);
                let list = self.list(Vec::new());
                self.emit(if channel {
                    Instruction::SharedElements { to, shared, list }
                } else {
                    Instruction::ReadShared { to, shared }
                });
                (to, kind)
            }
            ResolvedVariable::System { index, kind, indices, .. } => {
                if indices > 0 {
                    self.error(span, DiagnosticNumber::WRONG_COUNT, format!("this variable takes {indices} indices"));
                }
                let to = self.goal(wanted);
                let list = self.list(Vec::new());
                self.emit(Instruction::ReadSystem { to, system: index, list });
                (to, kind)
            }
            ResolvedVariable::Own(own) => {
                let to = self.goal(wanted);
                self.emit(Instruction::ReadOwn { to, own });
                (to, Some(ValueType::Real))
            }
            ResolvedVariable::Nowhere => (0, None),
        }
    }

    pub(super) fn indices(&mut self, indices: &[Expr]) -> Vec<Slot> {
        indices.iter().map(|index| self.typed(index, ValueType::Real, "a number")).collect()
    }

    fn element(&mut self, variable: &VariableName, indices: &[Expr], span: Span, wanted: Option<Slot>) -> Operand {
        if let VariableName::User(name) = variable
            && self.locals.get(name).is_none_or(|local| local.indices == 0)
            && (self.program.functions.contains_key(name)
                || (!self.locals.contains_key(name)
                    && !self.program.shared.contains_key(name)
                    && !self.assigned.contains(name)))
        {
            return self.user_call(name, indices, span, wanted);
        }
        if indices.is_empty() {
            self.error(span, DiagnosticNumber::WRONG_COUNT, "an index is missing between the parentheses");
            return (0, None);
        }
        let slots = self.indices(indices);
        let reach = self.reach(variable, span, false);
        let to = self.goal(wanted);
        match reach {
            ResolvedVariable::Local(local) => {
                self.check_count(indices.len(), local.indices, local.channel, local.kind, span);
                match slots.as_slice() {
                    [index] => {
                        self.emit(Instruction::Element { to, a: local.slot, index: *index });
                    }
                    _ => {
                        let list = self.list(slots);
                        self.emit(Instruction::Elements { to, a: local.slot, list });
                    }
                }
                (to, element_kind(local.indices, local.channel, local.kind))
            }
            ResolvedVariable::Shared { shared, kind, indices: known, channel } => {
                self.check_count(indices.len(), known, channel, kind, span);
                let list = self.list(slots);
                self.emit(Instruction::SharedElements { to, shared, list });
                (to, element_kind(known, channel, kind))
            }
            ResolvedVariable::System { index, kind, indices: known, .. } => {
                let list = self.list(slots);
                if known == 0
                    && matches!(kind, None | Some(ValueType::Text | ValueType::Sequence))
                    && indices.len() == 1
                {
                    let whole = self.temporary();
                    let none = self.list(Vec::new());
                    self.emit(Instruction::ReadSystem { to: whole, system: index, list: none });
                    self.emit(Instruction::Elements { to, a: whole, list });
                    return (to, if kind == Some(ValueType::Text) { kind } else { None });
                }
                if known != indices.len() {
                    self.error(span, DiagnosticNumber::WRONG_COUNT, format!("this variable takes {known} indices"));
                }
                self.emit(Instruction::ReadSystem { to, system: index, list });
                (to, kind)
            }
            ResolvedVariable::Own(_) => {
                self.error(span, DiagnosticNumber::WRONG_COUNT, "this variable takes no index");
                (to, None)
            }
            ResolvedVariable::Nowhere => (to, None),
        }
    }

    pub(super) fn check_count(
        &mut self,
        given: usize,
        known: usize,
        channel: bool,
        kind: Option<ValueType>,
        span: Span,
    ) {
        let array = known > 0 || channel;
        if array && given != known && !(channel && given == known + 1) {
            self.error(span, DiagnosticNumber::WRONG_COUNT, format!("this array takes {known} indices"));
        } else if !array && given > 1 {
            self.error(span, DiagnosticNumber::WRONG_COUNT, "a text or sequence takes one index");
        } else if !array && kind.is_some_and(|kind| kind != ValueType::Text && kind != ValueType::Sequence) {
            self.error(span, DiagnosticNumber::WRONG_TYPE, "only arrays, texts and sequences have elements");
        }
    }

    fn range(
        &mut self,
        variable: &VariableName,
        ends: [Option<&Expr>; 2],
        span: Span,
        wanted: Option<Slot>,
    ) -> Operand {
        let slots = ends.map(|end| end.map_or(NO_SLOT, |end| self.typed(end, ValueType::Real, "a number"))).to_vec();
        let (a, kind) = self.read(variable, span, None);
        if let Some(found) = kind.filter(|kind| !matches!(kind, ValueType::Text | ValueType::Sequence)) {
            self.wrong(span, "a text or sequence", found);
        }
        let list = self.list(slots);
        let to = self.goal(wanted);
        self.emit(Instruction::Range { to, a, list });
        (to, kind)
    }

    fn unary(&mut self, sign: Sign, operand: &Expr, wanted: Option<Slot>) -> Operand {
        if let (Sign::Minus, ExprKind::Real(number)) = (sign, &operand.kind) {
            let slot = self.constant(MacroValue::Real(-number));
            if let Some(to) = wanted {
                self.emit(Instruction::Move { to, a: slot });
            }
            return (wanted.unwrap_or(slot), Some(ValueType::Real));
        }
        if sign == Sign::Not {
            let a = self.typed(operand, ValueType::Logical, "a truth value");
            let to = self.goal(wanted);
            self.emit(Instruction::Not { to, a });
            return (to, Some(ValueType::Logical));
        }
        let a = self.typed(operand, ValueType::Real, "a number");
        let to = self.goal(wanted);
        self.emit(if sign == Sign::Minus { Instruction::Negate { to, a } } else { Instruction::Number { to, a } });
        (to, Some(ValueType::Real))
    }

    fn binary(&mut self, sign: Sign, left: &Expr, right: &Expr, span: Span, wanted: Option<Slot>) -> Operand {
        if matches!(sign, Sign::And | Sign::Or) {
            return self.logic(sign, left, right, wanted);
        }
        if let Some(relation) = relation(sign) {
            let (a, b) = self.compared(left, right, span);
            let to = self.goal(wanted);
            self.emit(Instruction::Compare { relation, to, a, b });
            return (to, Some(ValueType::Logical));
        }
        let (a, left_kind) = self.expression(left, None);
        let (b, right_kind) = self.expression(right, None);
        let result = self.operands(sign, (left_kind, left.span), (right_kind, right.span));
        let to = self.goal(wanted);
        self.emit(arithmetic(sign, to, a, b));
        (to, result)
    }

    /// Checks the types of two operands; returns the type of the result.
    pub(super) fn operands(
        &mut self,
        sign: Sign,
        left: (Option<ValueType>, Span),
        right: (Option<ValueType>, Span),
    ) -> Option<ValueType> {
        let wanted = match sign {
            Sign::Join => ValueType::Text,
            Sign::Xor => ValueType::Logical,
            Sign::Plus if left.0 == Some(ValueType::Text) || right.0 == Some(ValueType::Text) => ValueType::Text,
            _ => ValueType::Real,
        };
        for (kind, span) in [left, right] {
            if let Some(found) = kind.filter(|found| *found != wanted) {
                self.wrong(span, wanted.name(), found);
            }
        }
        let open = sign == Sign::Plus && left.0.is_none() && right.0.is_none();
        if open { None } else { Some(wanted) }
    }

    fn compared(&mut self, left: &Expr, right: &Expr, span: Span) -> (Slot, Slot) {
        let (a, left_kind) = self.expression(left, None);
        let (b, right_kind) = self.expression(right, None);
        if let (Some(x), Some(y)) = (left_kind, right_kind)
            && x != y
        {
            let message = format!("{} and {} cannot be compared", x.name(), y.name());
            self.error(span, DiagnosticNumber::WRONG_TYPE, message);
        }
        (a, b)
    }

    /// The truth is made in a register of its own: the right side may still read the wanted register.
    fn logic(&mut self, sign: Sign, left: &Expr, right: &Expr, wanted: Option<Slot>) -> Operand {
        let to = self.temporary();
        let a = self.typed(left, ValueType::Logical, "a truth value");
        self.emit(Instruction::Truth { to, a });
        let jump = self.emit(if sign == Sign::And {
            Instruction::JumpUnless { a: to, target: 0 }
        } else {
            Instruction::JumpIf { a: to, target: 0 }
        });
        let b = self.typed(right, ValueType::Logical, "a truth value");
        self.emit(Instruction::Truth { to, a: b });
        self.patch(jump);
        if let Some(wanted) = wanted {
            self.emit(Instruction::Move { to: wanted, a: to });
        }
        (wanted.unwrap_or(to), Some(ValueType::Logical))
    }

    /// Emits jumps taken when the condition is `when`; they are collected in `jumps`.
    pub(super) fn branch(&mut self, condition: &Expr, when: bool, jumps: &mut Vec<usize>) {
        match &condition.kind {
            ExprKind::Unary(Sign::Not, operand) => self.branch(operand, !when, jumps),
            ExprKind::Binary(sign @ (Sign::And | Sign::Or), left, right) => {
                let decides = (*sign == Sign::Or) == when;
                if decides {
                    self.branch(left, when, jumps);
                    self.branch(right, when, jumps);
                } else {
                    let mut skip = Vec::new();
                    self.branch(left, !when, &mut skip);
                    self.branch(right, when, jumps);
                    skip.into_iter().for_each(|jump| self.patch(jump));
                }
            }
            ExprKind::Binary(sign, left, right) if relation(*sign).is_some() => {
                let (a, b) = self.compared(left, right, condition.span);
                let found = relation(*sign).unwrap_or(Relation::Equal);
                let relation = if when { opposite(found) } else { found };
                jumps.push(self.emit(Instruction::JumpUnlessCompare { relation, a, b, target: 0 }));
            }
            _ => {
                let a = self.typed(condition, ValueType::Logical, "a condition");
                jumps.push(self.emit(if when {
                    Instruction::JumpIf { a, target: 0 }
                } else {
                    Instruction::JumpUnless { a, target: 0 }
                }));
            }
        }
    }
}

fn element_kind(indices: usize, channel: bool, kind: Option<ValueType>) -> Option<ValueType> {
    if indices > 0 || channel || kind == Some(ValueType::Text) { kind } else { None }
}

pub(super) fn arithmetic(sign: Sign, to: Slot, a: Slot, b: Slot) -> Instruction {
    match sign {
        Sign::Minus | Sign::SubtractAssign => Instruction::Subtract { to, a, b },
        Sign::Star | Sign::MultiplyAssign => Instruction::Multiply { to, a, b },
        Sign::Slash | Sign::DivideAssign => Instruction::Divide { to, a, b },
        Sign::Power => Instruction::Power { to, a, b },
        Sign::Join => Instruction::Join { to, a, b },
        Sign::Xor => Instruction::Xor { to, a, b },
        _ => Instruction::Add { to, a, b },
    }
}
