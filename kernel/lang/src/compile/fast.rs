//! Finds the short forms of finished code.
//!
//! Invariant: a form that leaves out the store into a temporary register is only chosen when nothing behind it in the
//! statement reads that register; temporaries do not live longer than their statement.

use crate::bytecode::fast::{Fast, Near, Then};
use crate::bytecode::{Code, Op, Relation, Slot};
use crate::func::Way;
use crate::value::Kind;

/// The short form of every instruction of `code`.
pub(super) fn forms(code: &Code, temporaries: &[Slot]) -> Vec<Fast> {
    let finder = Finder { code, temporaries };
    (0..code.ops.len()).map(|at| finder.form(at).unwrap_or_default()).collect()
}

struct Finder<'a> {
    code: &'a Code,
    temporaries: &'a [Slot],
}

/// Two operands, the operation and the destination.
struct Arithmetic {
    operation: Then,
    to: Slot,
    a: Slot,
    b: Slot,
}

fn near(slot: Slot) -> Option<Near> {
    Near::try_from(slot).ok()
}

fn arithmetic(op: Op) -> Option<Arithmetic> {
    let (operation, to, a, b) = match op {
        Op::Add { to, a, b } => (Then::Add, to, a, b),
        Op::AddTo { to, a } => (Then::Add, to, to, a),
        Op::Subtract { to, a, b } => (Then::Subtract, to, a, b),
        Op::Multiply { to, a, b } => (Then::Multiply, to, a, b),
        Op::Divide { to, a, b } => (Then::Divide, to, a, b),
        _ => return None,
    };
    Some(Arithmetic { operation, to, a, b })
}

impl Arithmetic {
    /// The operation as one of the value in `slot` and the other operand.
    fn with(&self, slot: Slot) -> Option<(Then, Slot)> {
        match (self.a == slot, self.b == slot, self.operation) {
            (true, false, operation) => Some((operation, self.b)),
            (false, true, Then::Subtract) => Some((Then::From, self.a)),
            (false, true, Then::Divide) => Some((Then::Under, self.a)),
            (false, true, operation) => Some((operation, self.a)),
            _ => None,
        }
    }
}

impl Finder<'_> {
    fn op(&self, at: usize) -> Option<Op> {
        self.code.ops.get(at).copied()
    }

    fn form(&self, at: usize) -> Option<Fast> {
        self.update(at).or_else(|| self.element_then(at)).or_else(|| self.two(at)).or_else(|| self.single(at))
    }

    /// Tells whether `slot` is a temporary that the statement does not read from `from` on.
    fn dead(&self, slot: Slot, from: usize) -> bool {
        let place = from.checked_sub(1).and_then(|at| self.code.places.get(at));
        let behind = self.code.ops.iter().zip(&self.code.places).skip(from);
        self.temporaries.contains(&slot)
            && !behind.take_while(|(_, other)| Some(*other) == place).any(|(op, _)| self.reads(*op, slot))
    }

    fn listed(&self, list: u16, slot: Slot) -> bool {
        self.code.lists.get(usize::from(list)).is_some_and(|slots| slots.contains(&slot))
    }

    fn declared(&self, declaration: u16, slot: Slot) -> bool {
        self.code
            .declarations
            .get(usize::from(declaration))
            .is_some_and(|one| one.sizes.contains(&slot) || one.value == Some(slot))
    }

    fn reads(&self, op: Op, slot: Slot) -> bool {
        match op {
            Op::Move { a, .. }
            | Op::Typed { a, .. }
            | Op::Negate { a, .. }
            | Op::Number { a, .. }
            | Op::Not { a, .. }
            | Op::Truth { a, .. }
            | Op::JumpIf { a, .. }
            | Op::JumpUnless { a, .. }
            | Op::WriteShared { a, .. }
            | Op::Math { a, .. } => a == slot,
            Op::Add { a, b, .. }
            | Op::Subtract { a, b, .. }
            | Op::Multiply { a, b, .. }
            | Op::Divide { a, b, .. }
            | Op::Power { a, b, .. }
            | Op::Join { a, b, .. }
            | Op::Xor { a, b, .. }
            | Op::Compare { a, b, .. }
            | Op::JumpUnlessCompare { a, b, .. }
            | Op::JumpIfWhen { a, b, .. } => a == slot || b == slot,
            Op::AddTo { to, a } => to == slot || a == slot,
            Op::JumpIfThru { a, low, .. } => a == slot || low == slot || low + 1 == slot,
            Op::DoStart { variable, end, .. } | Op::DoNext { variable, end, .. } => {
                variable == slot || end == slot || end + 1 == slot
            }
            Op::Element { a, index, .. } => a == slot || index == slot,
            Op::SetElement { to, index, a } => to == slot || index == slot || a == slot,
            Op::Elements { a, list, .. } | Op::Range { a, list, .. } => a == slot || self.listed(list, slot),
            Op::SetElements { to, list, a } => to == slot || a == slot || self.listed(list, slot),
            Op::SetSharedElements { list, a, .. } | Op::WriteSystem { list, a, .. } => {
                a == slot || self.listed(list, slot)
            }
            Op::Sequence { list, .. }
            | Op::SharedElements { list, .. }
            | Op::ReadSystem { list, .. }
            | Op::Call { list, .. }
            | Op::CallMacro { list, .. }
            | Op::Command { list, .. }
            | Op::Read { list, .. } => self.listed(list, slot),
            Op::Declare { declaration, .. } | Op::DeclareShared { declaration, .. } => self.declared(declaration, slot),
            Op::Jump { .. } | Op::ReadShared { .. } | Op::ReadOwn { .. } | Op::Trace { .. } | Op::Return => false,
        }
    }

    /// `A(I)=A(I)+C` and `A(I)+=C`.
    fn update(&self, at: usize) -> Option<Fast> {
        let Op::Element { to, a: array, index } = self.op(at)? else { return None };
        let Op::SetElement { to: target, index: place, a } = self.op(at + 2)? else { return None };
        let step = arithmetic(self.op(at + 1)?)?;
        let (then, c) = step.with(to)?;
        let same = array == target && index == place && step.to == a;
        if !same || !self.dead(to, at + 3) || !self.dead(a, at + 3) || c == array {
            return None;
        }
        let (array, index, c) = (near(array)?, near(index)?, near(c)?);
        Some(match then {
            Then::Add => Fast::UpdateAdd { array, index, c },
            then => Fast::Update { then, array, index, c },
        })
    }

    fn element_then(&self, at: usize) -> Option<Fast> {
        let Op::Element { to: value, a: array, index } = self.op(at)? else { return None };
        let step = arithmetic(self.op(at + 1)?)?;
        let (then, c) = step.with(value)?;
        if step.to != value && !self.dead(value, at + 2) {
            return None;
        }
        Some(Fast::ElementThen { then, to: near(step.to)?, array: near(array)?, index: near(index)?, c: near(c)? })
    }

    fn two(&self, at: usize) -> Option<Fast> {
        let first = arithmetic(self.op(at)?)?;
        let second = arithmetic(self.op(at + 1)?)?;
        let (then, c) = second.with(first.to)?;
        if first.to != second.to && !self.dead(first.to, at + 2) {
            return None;
        }
        let (to, a, b, c) = (near(second.to)?, near(first.a)?, near(first.b)?, near(c)?);
        Some(match (first.operation, then) {
            (Then::Multiply, Then::Add) => Fast::MultiplyAdd { to, a, b, c },
            (Then::Divide, Then::From) => Fast::DivideFrom { to, a, b, c },
            (first, then) => Fast::Two { first, then, to, a, b, c },
        })
    }

    fn single(&self, at: usize) -> Option<Fast> {
        Some(match self.op(at)? {
            Op::Move { to, a } | Op::Typed { to, a, kind: Kind::Real } => Fast::Move { to: near(to)?, a: near(a)? },
            Op::Negate { to, a } => Fast::Negate { to: near(to)?, a: near(a)? },
            Op::Add { to, a, b } => Fast::Add { to: near(to)?, a: near(a)?, b: near(b)? },
            Op::Subtract { to, a, b } => Fast::Subtract { to: near(to)?, a: near(a)?, b: near(b)? },
            Op::Multiply { to, a, b } => Fast::Multiply { to: near(to)?, a: near(a)?, b: near(b)? },
            Op::Divide { to, a, b } => Fast::Divide { to: near(to)?, a: near(a)?, b: near(b)? },
            Op::AddTo { to, a } => Fast::AddTo { to: near(to)?, a: near(a)? },
            Op::Element { to, a, index } => Fast::Element { to: near(to)?, array: near(a)?, index: near(index)? },
            Op::SetElement { to, index, a } => Fast::SetElement { array: near(to)?, index: near(index)?, a: near(a)? },
            Op::Call { to, function, list } => self.call(to, function, list)?,
            Op::CallMacro { to, callee, list } => Fast::Call { to: near(to)?, callee, list },
            Op::Return => Fast::Return,
            Op::Jump { target } => Fast::Jump { target },
            Op::JumpIf { a, target } => Fast::JumpIf { a: near(a)?, target },
            Op::JumpUnless { a, target } => Fast::JumpUnless { a: near(a)?, target },
            Op::JumpUnlessCompare { relation, a, b, target } => unless(relation, near(a)?, near(b)?, target),
            Op::DoNext { variable, end, target } => {
                Fast::DoNext { variable: near(variable)?, end: near(end)?, step: near(end + 1)?, target }
            }
            _ => return None,
        })
    }

    /// A call of a function of two numbers.
    fn call(&self, to: Slot, function: u16, list: u16) -> Option<Fast> {
        let way = &self.code.functions.get(usize::from(function))?.way;
        match (way, self.code.lists.get(usize::from(list))?.as_slice()) {
            (Way::Pair(..), [a, b]) => Some(Fast::Pair { to: near(to)?, a: near(*a)?, b: near(*b)?, function }),
            _ => None,
        }
    }
}

fn unless(relation: Relation, a: Near, b: Near, target: u16) -> Fast {
    match relation {
        Relation::Equal => Fast::UnlessEqual { a, b, target },
        Relation::NotEqual => Fast::UnlessNotEqual { a, b, target },
        Relation::Less => Fast::UnlessLess { a, b, target },
        Relation::LessEqual => Fast::UnlessLessEqual { a, b, target },
        Relation::Greater => Fast::UnlessGreater { a, b, target },
        Relation::GreaterEqual => Fast::UnlessGreaterEqual { a, b, target },
    }
}
