//! Expressions into registers, conditions into jumps.
//!
//! *Invariant:* an expression returns the register of its value and its type where that is evident.

use super::MacroCompiler;
use crate::ast::{Expr, ExprKind, Variable};
use crate::bytecode::{NO_SLOT, Op, Own, Relation, Shared, Slot};
use crate::diag::Number;
use crate::func;
use crate::ident;
use crate::lex::Sign;
use crate::source::Span;
use crate::value::{Kind, Value};

/// Register and evident type.
pub(super) type Operand = (Slot, Option<Kind>);

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
pub(super) enum Reach {
    Local(super::Local),
    Shared { shared: u16, kind: Option<Kind>, indices: usize, channel: bool },
    System { index: u16, kind: Option<Kind>, indices: usize, writable: bool },
    Own(Own),
    Nowhere,
}

impl MacroCompiler<'_> {
    /// Compiles an expression; the result goes to `wanted` if that is given.
    pub(super) fn expression(&mut self, expression: &Expr, wanted: Option<Slot>) -> Operand {
        let (slot, kind) = match &expression.kind {
            ExprKind::Real(number) => (self.constant(Value::Real(*number)), Some(Kind::Real)),
            ExprKind::Text(text) => (self.constant(Value::text(text.as_str())), Some(Kind::Text)),
            ExprKind::Logical(truth) => (self.constant(Value::Logical(*truth)), Some(Kind::Logical)),
            ExprKind::Null => (self.constant(Value::Null), None),
            ExprKind::Keyword(code) => (self.constant(Value::Keyword(*code)), Some(Kind::Keyword)),
            ExprKind::Record(record) => (self.constant(Value::Record(*record)), Some(Kind::Record)),
            ExprKind::Code(name) => (self.identifier(name, expression.span, true), Some(Kind::Code)),
            ExprKind::Register(name) => (self.identifier(name, expression.span, false), Some(Kind::Register)),
            ExprKind::Variable(variable) => self.read(variable, expression.span, wanted),
            ExprKind::Element(variable, indices) => return self.element(variable, indices, expression.span, wanted),
            ExprKind::Range(variable, from, to) => {
                return self.range(variable, [from.as_deref(), to.as_deref()], expression.span, wanted);
            }
            ExprKind::Sequence(parts) => {
                let slots = parts.iter().map(|part| self.expression(part, None).0).collect();
                let list = self.list(slots);
                let to = self.goal(wanted);
                self.emit(Op::Sequence { to, list });
                return (to, Some(Kind::Sequence));
            }
            ExprKind::Call(name, arguments) => return self.call(name, arguments, expression.span, wanted),
            ExprKind::Unary(sign, operand) => return self.unary(*sign, operand, wanted),
            ExprKind::Binary(sign, left, right) => return self.binary(*sign, left, right, expression.span, wanted),
        };
        match wanted {
            Some(to) if to != slot => {
                self.emit(Op::Move { to, a: slot });
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
            self.error_with(span, Number::UNKNOWN_IDENTIFIER, format!("unknown identifier {name}"), help);
        }
        let index = index.unwrap_or(0);
        self.constant(if code { Value::Code(index) } else { Value::Register(index) })
    }

    pub(super) fn wrong(&mut self, span: Span, wanted: &str, found: Kind) {
        self.error(
            span,
            Number::WRONG_TYPE,
            format!("{wanted} is expected here, but this is of type {}", found.name()),
        );
    }

    /// Compiles an operand that must have a type.
    pub(super) fn typed(&mut self, expression: &Expr, kind: Kind, wanted: &str) -> Slot {
        let (slot, found) = self.expression(expression, None);
        if let Some(found) = found.filter(|found| *found != kind) {
            self.wrong(expression.span, wanted, found);
        }
        slot
    }

    pub(super) fn reach(&mut self, variable: &Variable, span: Span, write: bool) -> Reach {
        let name = match variable {
            Variable::User(name) => {
                if !self.locals.contains_key(name)
                    && let Some(symbol) = self.program.shared.get(name).cloned()
                {
                    let shared = self.shared(symbol.shared, symbol.kind);
                    return Reach::Shared {
                        shared,
                        kind: symbol.kind,
                        indices: symbol.indices,
                        channel: symbol.channel,
                    };
                }
                if !self.locals.contains_key(name) && self.program.functions.contains_key(name) {
                    self.error(span, Number::SYNTAX, format!("{name} is a function and is called with parentheses"));
                    return Reach::Nowhere;
                }
                name.clone()
            }
            Variable::Local(number) => format!("%L{number:02}"),
            Variable::Param(number) => {
                let name = format!("$P{number:02}");
                if !self.locals.contains_key(&name) {
                    let slot = self.new_local(&name, None, None);
                    self.code.signature.arguments.push((*number, slot));
                }
                name
            }
            Variable::Global(number) => {
                let shared = self.shared(Shared::Global(u32::from(*number)), None);
                return Reach::Shared { shared, kind: None, indices: 0, channel: false };
            }
            Variable::System(name) => return self.system(name, span),
        };
        Reach::Local(self.local(&name, span, write))
    }

    fn system(&mut self, name: &str, span: Span) -> Reach {
        let own = match name {
            "$ERRNO" => Some(Own::Status),
            "$MNEST" => Some(Own::Nesting),
            "$CI" => Some(Own::Channel),
            "$CHSIZ" | "$CHMAX" => Some(Own::Channels),
            _ => None,
        };
        if let Some(own) = own {
            return Reach::Own(own);
        }
        let table = self.environment.system();
        if let Some((index, variable)) = table.iter().enumerate().find(|(_, variable)| variable.name == name) {
            return Reach::System {
                index: u16::try_from(index).unwrap_or(u16::MAX),
                kind: variable.kind,
                indices: usize::from(variable.indices),
                writable: variable.writable,
            };
        }
        if let Some(product) = self.environment.foreign(name) {
            let message = format!("{name} belongs to {product}; the control emulator has no such variable");
            self.error(span, Number::UNKNOWN_VARIABLE, message);
            return Reach::Nowhere;
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
        self.error_with(span, Number::UNKNOWN_VARIABLE, format!("unknown system variable {name}"), help);
        Reach::Nowhere
    }

    fn read(&mut self, variable: &Variable, span: Span, wanted: Option<Slot>) -> Operand {
        match self.reach(variable, span, false) {
            Reach::Local(local) if local.indices > 0 => {
                self.error(span, Number::BAD_ARRAY, "an array is read element by element");
                (local.slot, None)
            }
            Reach::Local(local) if local.channel => {
                let to = self.goal(wanted);
                let list = self.list(Vec::new());
                self.emit(Op::Elements { to, a: local.slot, list });
                (to, local.kind)
            }
            Reach::Local(local) => (local.slot, local.kind),
            Reach::Shared { indices, .. } if indices > 0 => {
                self.error(span, Number::BAD_ARRAY, "an array is read element by element");
                (0, None)
            }
            Reach::Shared { shared, kind, channel, .. } => {
                let to = self.goal(wanted);
                let list = self.list(Vec::new());
                self.emit(if channel {
                    Op::SharedElements { to, shared, list }
                } else {
                    Op::ReadShared { to, shared }
                });
                (to, kind)
            }
            Reach::System { index, kind, indices, .. } => {
                if indices > 0 {
                    self.error(span, Number::WRONG_COUNT, format!("this variable takes {indices} indices"));
                }
                let to = self.goal(wanted);
                let list = self.list(Vec::new());
                self.emit(Op::ReadSystem { to, system: index, list });
                (to, kind)
            }
            Reach::Own(own) => {
                let to = self.goal(wanted);
                self.emit(Op::ReadOwn { to, own });
                (to, Some(Kind::Real))
            }
            Reach::Nowhere => (0, None),
        }
    }

    pub(super) fn indices(&mut self, indices: &[Expr]) -> Vec<Slot> {
        indices.iter().map(|index| self.typed(index, Kind::Real, "a number")).collect()
    }

    fn element(&mut self, variable: &Variable, indices: &[Expr], span: Span, wanted: Option<Slot>) -> Operand {
        if let Variable::User(name) = variable
            && self.locals.get(name).is_none_or(|local| local.indices == 0)
            && (self.program.functions.contains_key(name)
                || (!self.locals.contains_key(name)
                    && !self.program.shared.contains_key(name)
                    && !self.assigned.contains(name)))
        {
            return self.user_call(name, indices, span, wanted);
        }
        if indices.is_empty() {
            self.error(span, Number::WRONG_COUNT, "an index is missing between the parentheses");
            return (0, None);
        }
        let slots = self.indices(indices);
        let reach = self.reach(variable, span, false);
        let to = self.goal(wanted);
        match reach {
            Reach::Local(local) => {
                self.check_count(indices.len(), local.indices, local.channel, local.kind, span);
                match slots.as_slice() {
                    [index] => {
                        self.emit(Op::Element { to, a: local.slot, index: *index });
                    }
                    _ => {
                        let list = self.list(slots);
                        self.emit(Op::Elements { to, a: local.slot, list });
                    }
                }
                (to, element_kind(local.indices, local.channel, local.kind))
            }
            Reach::Shared { shared, kind, indices: known, channel } => {
                self.check_count(indices.len(), known, channel, kind, span);
                let list = self.list(slots);
                self.emit(Op::SharedElements { to, shared, list });
                (to, element_kind(known, channel, kind))
            }
            Reach::System { index, kind, indices: known, .. } => {
                let list = self.list(slots);
                if known == 0 && matches!(kind, None | Some(Kind::Text | Kind::Sequence)) && indices.len() == 1 {
                    let whole = self.temporary();
                    let none = self.list(Vec::new());
                    self.emit(Op::ReadSystem { to: whole, system: index, list: none });
                    self.emit(Op::Elements { to, a: whole, list });
                    return (to, if kind == Some(Kind::Text) { kind } else { None });
                }
                if known != indices.len() {
                    self.error(span, Number::WRONG_COUNT, format!("this variable takes {known} indices"));
                }
                self.emit(Op::ReadSystem { to, system: index, list });
                (to, kind)
            }
            Reach::Own(_) => {
                self.error(span, Number::WRONG_COUNT, "this variable takes no index");
                (to, None)
            }
            Reach::Nowhere => (to, None),
        }
    }

    pub(super) fn check_count(&mut self, given: usize, known: usize, channel: bool, kind: Option<Kind>, span: Span) {
        let array = known > 0 || channel;
        if array && given != known && !(channel && given == known + 1) {
            self.error(span, Number::WRONG_COUNT, format!("this array takes {known} indices"));
        } else if !array && given > 1 {
            self.error(span, Number::WRONG_COUNT, "a text or sequence takes one index");
        } else if !array && kind.is_some_and(|kind| kind != Kind::Text && kind != Kind::Sequence) {
            self.error(span, Number::WRONG_TYPE, "only arrays, texts and sequences have elements");
        }
    }

    fn range(&mut self, variable: &Variable, ends: [Option<&Expr>; 2], span: Span, wanted: Option<Slot>) -> Operand {
        let slots = ends.map(|end| end.map_or(NO_SLOT, |end| self.typed(end, Kind::Real, "a number"))).to_vec();
        let (a, kind) = self.read(variable, span, None);
        if let Some(found) = kind.filter(|kind| !matches!(kind, Kind::Text | Kind::Sequence)) {
            self.wrong(span, "a text or sequence", found);
        }
        let list = self.list(slots);
        let to = self.goal(wanted);
        self.emit(Op::Range { to, a, list });
        (to, kind)
    }

    fn unary(&mut self, sign: Sign, operand: &Expr, wanted: Option<Slot>) -> Operand {
        if let (Sign::Minus, ExprKind::Real(number)) = (sign, &operand.kind) {
            let slot = self.constant(Value::Real(-number));
            if let Some(to) = wanted {
                self.emit(Op::Move { to, a: slot });
            }
            return (wanted.unwrap_or(slot), Some(Kind::Real));
        }
        if sign == Sign::Not {
            let a = self.typed(operand, Kind::Logical, "a truth value");
            let to = self.goal(wanted);
            self.emit(Op::Not { to, a });
            return (to, Some(Kind::Logical));
        }
        let a = self.typed(operand, Kind::Real, "a number");
        let to = self.goal(wanted);
        self.emit(if sign == Sign::Minus { Op::Negate { to, a } } else { Op::Number { to, a } });
        (to, Some(Kind::Real))
    }

    fn binary(&mut self, sign: Sign, left: &Expr, right: &Expr, span: Span, wanted: Option<Slot>) -> Operand {
        if matches!(sign, Sign::And | Sign::Or) {
            return self.logic(sign, left, right, wanted);
        }
        if let Some(relation) = relation(sign) {
            let (a, b) = self.compared(left, right, span);
            let to = self.goal(wanted);
            self.emit(Op::Compare { relation, to, a, b });
            return (to, Some(Kind::Logical));
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
        left: (Option<Kind>, Span),
        right: (Option<Kind>, Span),
    ) -> Option<Kind> {
        let wanted = match sign {
            Sign::Join => Kind::Text,
            Sign::Xor => Kind::Logical,
            Sign::Plus if left.0 == Some(Kind::Text) || right.0 == Some(Kind::Text) => Kind::Text,
            _ => Kind::Real,
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
            self.error(span, Number::WRONG_TYPE, message);
        }
        (a, b)
    }

    /// The truth is made in a register of its own: the right side may still read the wanted register.
    fn logic(&mut self, sign: Sign, left: &Expr, right: &Expr, wanted: Option<Slot>) -> Operand {
        let to = self.temporary();
        let a = self.typed(left, Kind::Logical, "a truth value");
        self.emit(Op::Truth { to, a });
        let jump = self.emit(if sign == Sign::And {
            Op::JumpUnless { a: to, target: 0 }
        } else {
            Op::JumpIf { a: to, target: 0 }
        });
        let b = self.typed(right, Kind::Logical, "a truth value");
        self.emit(Op::Truth { to, a: b });
        self.patch(jump);
        if let Some(wanted) = wanted {
            self.emit(Op::Move { to: wanted, a: to });
        }
        (wanted.unwrap_or(to), Some(Kind::Logical))
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
                jumps.push(self.emit(Op::JumpUnlessCompare { relation, a, b, target: 0 }));
            }
            _ => {
                let a = self.typed(condition, Kind::Logical, "a condition");
                jumps.push(self.emit(if when { Op::JumpIf { a, target: 0 } } else { Op::JumpUnless { a, target: 0 } }));
            }
        }
    }
}

fn element_kind(indices: usize, channel: bool, kind: Option<Kind>) -> Option<Kind> {
    if indices > 0 || channel || kind == Some(Kind::Text) { kind } else { None }
}

pub(super) fn arithmetic(sign: Sign, to: Slot, a: Slot, b: Slot) -> Op {
    match sign {
        Sign::Minus | Sign::SubtractAssign => Op::Subtract { to, a, b },
        Sign::Star | Sign::MultiplyAssign => Op::Multiply { to, a, b },
        Sign::Slash | Sign::DivideAssign => Op::Divide { to, a, b },
        Sign::Power => Op::Power { to, a, b },
        Sign::Join => Op::Join { to, a, b },
        Sign::Xor => Op::Xor { to, a, b },
        _ => Op::Add { to, a, b },
    }
}
