//! Finds the short forms of finished code.
//!
//! *Invariant:* a form that leaves out the store into a temporary register is only chosen when nothing after it in the
//! statement reads that register; temporaries do not live longer than their statement.

use crate::bytecode::fast::{Fast, FusedOperator, Near};
use crate::bytecode::{CompiledMacro, Instruction, Relation, Slot};
use crate::func::EvaluationMethod;
use crate::value::ValueType;

/// The short form of every instruction of `code`.
pub(super) fn forms(code: &CompiledMacro, temporaries: &[Slot]) -> Vec<Fast> {
    let finder = Finder { code, temporaries };
    (0..code.ops.len()).map(|at| finder.form(at).unwrap_or_default()).collect()
}

struct Finder<'a> {
    code: &'a CompiledMacro,
    temporaries: &'a [Slot],
}

/// Shared variables of a macro that have a home for short forms.
const HOMES: u8 = 64;

/// An element of an array: register and one or two indices.
#[derive(Clone, Copy, PartialEq, Eq)]
struct ArrayElement {
    array: Near,
    indices: (Near, Option<Near>),
}

/// Two operands, the operation and the destination.
struct Arithmetic {
    operation: FusedOperator,
    to: Slot,
    a: Slot,
    b: Slot,
}

fn near(slot: Slot) -> Option<Near> {
    Near::try_from(slot).ok()
}

fn arithmetic(op: Instruction) -> Option<Arithmetic> {
    let (operation, to, a, b) = match op {
        Instruction::Add { to, a, b } => (FusedOperator::Add, to, a, b),
        Instruction::AddTo { to, a } => (FusedOperator::Add, to, to, a),
        Instruction::Subtract { to, a, b } => (FusedOperator::Subtract, to, a, b),
        Instruction::Multiply { to, a, b } => (FusedOperator::Multiply, to, a, b),
        Instruction::Divide { to, a, b } => (FusedOperator::Divide, to, a, b),
        _ => return None,
    };
    Some(Arithmetic { operation, to, a, b })
}

impl Arithmetic {
    /// The operation as one of the value in `slot` and the other operand.
    fn with(&self, slot: Slot) -> Option<(FusedOperator, Slot)> {
        match (self.a == slot, self.b == slot, self.operation) {
            (true, false, operation) => Some((operation, self.b)),
            (false, true, FusedOperator::Subtract) => Some((FusedOperator::From, self.a)),
            (false, true, FusedOperator::Divide) => Some((FusedOperator::Under, self.a)),
            (false, true, operation) => Some((operation, self.a)),
            _ => None,
        }
    }
}

impl Finder<'_> {
    fn op(&self, at: usize) -> Option<Instruction> {
        self.code.ops.get(at).copied()
    }

    fn form(&self, at: usize) -> Option<Fast> {
        let longer = self.update(at).or_else(|| self.element_then(at)).or_else(|| self.unless_element(at));
        let longer = longer.or_else(|| self.unless_shared(at));
        longer.or_else(|| self.two(at)).or_else(|| self.element(at)).or_else(|| self.single(at))
    }

    /// Tells whether `slot` is a temporary that the statement does not read from `from` on.
    fn dead(&self, slot: Slot, from: usize) -> bool {
        let place = from.checked_sub(1).and_then(|at| self.code.places.get(at));
        let after = self.code.ops.iter().zip(&self.code.places).skip(from);
        self.temporaries.contains(&slot)
            && !after.take_while(|(_, other)| Some(*other) == place).any(|(op, _)| self.reads(*op, slot))
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

    fn reads(&self, op: Instruction, slot: Slot) -> bool {
        match op {
            Instruction::Move { a, .. }
            | Instruction::Typed { a, .. }
            | Instruction::Negate { a, .. }
            | Instruction::Number { a, .. }
            | Instruction::Not { a, .. }
            | Instruction::Truth { a, .. }
            | Instruction::JumpIf { a, .. }
            | Instruction::JumpUnless { a, .. }
            | Instruction::WriteShared { a, .. }
            | Instruction::Math { a, .. } => a == slot,
            Instruction::Add { a, b, .. }
            | Instruction::Subtract { a, b, .. }
            | Instruction::Multiply { a, b, .. }
            | Instruction::Divide { a, b, .. }
            | Instruction::Power { a, b, .. }
            | Instruction::Join { a, b, .. }
            | Instruction::Xor { a, b, .. }
            | Instruction::Compare { a, b, .. }
            | Instruction::JumpUnlessCompare { a, b, .. }
            | Instruction::JumpIfWhen { a, b, .. } => a == slot || b == slot,
            Instruction::AddTo { to, a } => to == slot || a == slot,
            Instruction::JumpIfThru { a, low, .. } => a == slot || low == slot || low + 1 == slot,
            Instruction::DoStart { variable, end, .. } | Instruction::DoNext { variable, end, .. } => {
                variable == slot || end == slot || end + 1 == slot
            }
            Instruction::Element { a, index, .. } => a == slot || index == slot,
            Instruction::SetElement { to, index, a } => to == slot || index == slot || a == slot,
            Instruction::Elements { a, list, .. } | Instruction::Range { a, list, .. } => {
                a == slot || self.listed(list, slot)
            }
            Instruction::SetElements { to, list, a } => to == slot || a == slot || self.listed(list, slot),
            Instruction::SetSharedElements { list, a, .. } | Instruction::WriteSystem { list, a, .. } => {
                a == slot || self.listed(list, slot)
            }
            Instruction::Sequence { list, .. }
            | Instruction::SharedElements { list, .. }
            | Instruction::ReadSystem { list, .. }
            | Instruction::Call { list, .. }
            | Instruction::CallMacro { list, .. }
            | Instruction::Command { list, .. }
            | Instruction::Read { list, .. } => self.listed(list, slot),
            Instruction::Declare { declaration, .. } | Instruction::DeclareShared { declaration, .. } => {
                self.declared(declaration, slot)
            }
            Instruction::Jump { .. }
            | Instruction::ReadShared { .. }
            | Instruction::ReadOwn { .. }
            | Instruction::Trace { .. }
            | Instruction::Return => false,
        }
    }

    /// Register and number of a shared variable in short forms.
    fn home(&self, shared: u16) -> Option<(Near, u8)> {
        let number = u8::try_from(shared).ok().filter(|number| *number < HOMES)?;
        Some((near(*self.code.homes.get(usize::from(shared))?)?, number))
    }

    /// One or two indices of a list.
    fn indices(&self, list: u16) -> Option<(Near, Option<Near>)> {
        match self.code.lists.get(usize::from(list))?.as_slice() {
            [index] => Some((near(*index)?, None)),
            [row, column] => Some((near(*row)?, Some(near(*column)?))),
            _ => None,
        }
    }

    /// The element that an instruction reads, and where it goes.
    fn element_read(&self, op: Instruction) -> Option<(Slot, ArrayElement)> {
        let (to, array, indices) = match op {
            Instruction::Element { to, a, index } => (to, near(a)?, (near(index)?, None)),
            Instruction::Elements { to, a, list } => (to, near(a)?, self.indices(list)?),
            Instruction::SharedElements { to, shared, list } => (to, self.home(shared)?.0, self.indices(list)?),
            _ => return None,
        };
        Some((to, ArrayElement { array, indices }))
    }

    /// The element that an instruction writes, and the register of the value.
    fn element_written(&self, op: Instruction) -> Option<(ArrayElement, Slot)> {
        let (array, indices, a) = match op {
            Instruction::SetElement { to, index, a } => (near(to)?, (near(index)?, None), a),
            Instruction::SetElements { to, list, a } => (near(to)?, self.indices(list)?, a),
            Instruction::SetSharedElements { shared, list, a } => (self.home(shared)?.0, self.indices(list)?, a),
            _ => return None,
        };
        Some((ArrayElement { array, indices }, a))
    }

    /// `A(I)=A(I)+C` and `A(I)+=C`.
    fn update(&self, at: usize) -> Option<Fast> {
        let (to, place) = self.element_read(self.op(at)?)?;
        let (target, a) = self.element_written(self.op(at + 2)?)?;
        let step = arithmetic(self.op(at + 1)?)?;
        let (then, c) = step.with(to)?;
        let c = near(c)?;
        if place != target || step.to != a || !self.dead(to, at + 3) || !self.dead(a, at + 3) || c == place.array {
            return None;
        }
        let array = place.array;
        Some(match (place.indices, then) {
            ((index, None), FusedOperator::Add) => Fast::UpdateAdd { array, index, c },
            ((index, None), then) => Fast::Update { then, array, index, c },
            ((row, Some(column)), then) => Fast::UpdateCell { then, array, row, column, c },
        })
    }

    fn element_then(&self, at: usize) -> Option<Fast> {
        let (value, ArrayElement { array, indices: (index, None) }) = self.element_read(self.op(at)?)? else {
            return None;
        };
        let step = arithmetic(self.op(at + 1)?)?;
        let (then, c) = step.with(value)?;
        if step.to != value && !self.dead(value, at + 2) {
            return None;
        }
        Some(Fast::ElementThen { then, to: near(step.to)?, array, index, c: near(c)? })
    }

    /// `IF/A(I).EQ.B`.
    fn unless_element(&self, at: usize) -> Option<Fast> {
        let (value, ArrayElement { array, indices }) = self.element_read(self.op(at)?)?;
        let Instruction::JumpUnlessCompare { relation, a, b, target } = self.op(at + 1)? else { return None };
        if a != value || b == value || !self.dead(value, at + 2) {
            return None;
        }
        let b = near(b)?;
        Some(match indices {
            (index, None) => Fast::UnlessElement { relation, array, index, b, target },
            (row, Some(column)) => Fast::UnlessCell { relation, array, row, column, b, target },
        })
    }

    /// `IF/V.EQ.B` of a shared variable.
    fn unless_shared(&self, at: usize) -> Option<Fast> {
        let Instruction::ReadShared { to, shared } = self.op(at)? else { return None };
        let Instruction::JumpUnlessCompare { relation, a, b, target } = self.op(at + 1)? else { return None };
        if a != to || b == to || !self.dead(to, at + 2) {
            return None;
        }
        let (home, shared) = self.home(shared)?;
        Some(Fast::UnlessShared { relation, home, shared, b: near(b)?, target })
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
            (FusedOperator::Multiply, FusedOperator::Add) => Fast::MultiplyAdd { to, a, b, c },
            (FusedOperator::Divide, FusedOperator::From) => Fast::DivideFrom { to, a, b, c },
            (first, then) => Fast::Two { first, then, to, a, b, c },
        })
    }

    /// One element read or written.
    fn element(&self, at: usize) -> Option<Fast> {
        let op = self.op(at)?;
        if let Some((to, ArrayElement { array, indices })) = self.element_read(op) {
            let to = near(to)?;
            return Some(match indices {
                (index, None) => Fast::Element { to, array, index },
                (row, Some(column)) => Fast::Cell { to, array, row, column },
            });
        }
        let (ArrayElement { array, indices }, a) = self.element_written(op)?;
        let a = near(a)?;
        Some(match indices {
            (index, None) => Fast::SetElement { array, index, a },
            (row, Some(column)) => Fast::SetCell { array, row, column, a },
        })
    }

    fn single(&self, at: usize) -> Option<Fast> {
        Some(match self.op(at)? {
            Instruction::Move { to, a } => Fast::Move { to: near(to)?, a: near(a)? },
            Instruction::Typed { to, a, kind: ValueType::Real } => Fast::MoveNumber { to: near(to)?, a: near(a)? },
            Instruction::Typed { to, a, kind } => Fast::MoveTyped { to: near(to)?, a: near(a)?, kind },
            Instruction::ReadShared { to, shared } => {
                let (home, shared) = self.home(shared)?;
                Fast::Read { to: near(to)?, home, shared }
            }
            Instruction::WriteShared { shared: place, a } => {
                let ((home, shared), a) = (self.home(place)?, near(a)?);
                match self.code.shared.get(usize::from(place))?.1 {
                    Some(ValueType::Real) => Fast::WriteNumber { home, shared, a },
                    Some(kind) => Fast::WriteTyped { home, shared, a, kind },
                    None => Fast::Write { home, shared, a },
                }
            }
            Instruction::Power { to, a, b } => Fast::Power { to: near(to)?, a: near(a)?, b: near(b)? },
            Instruction::Join { to, a, b } => Fast::Join { to: near(to)?, a: near(a)?, b: near(b)? },
            Instruction::Not { to, a } => Fast::Not { to: near(to)?, a: near(a)? },
            Instruction::Truth { to, a } => Fast::Truth { to: near(to)?, a: near(a)? },
            Instruction::Compare { relation, to, a, b } => {
                Fast::Compare { relation, to: near(to)?, a: near(a)?, b: near(b)? }
            }
            Instruction::Math { to, a, function } => Fast::Math { to: near(to)?, a: near(a)?, function },
            Instruction::Sequence { to, list } => Fast::Sequence { to: near(to)?, list },
            Instruction::JumpIfWhen { a, b, target } => Fast::IfWhen { a: near(a)?, b: near(b)?, target },
            Instruction::JumpIfThru { a, low, target } => {
                Fast::IfThru { a: near(a)?, low: near(low)?, high: near(low + 1)?, target }
            }
            Instruction::DoStart { variable, end, target } => {
                Fast::DoStart { variable: near(variable)?, end: near(end)?, step: near(end + 1)?, target }
            }
            Instruction::Negate { to, a } => Fast::Negate { to: near(to)?, a: near(a)? },
            Instruction::Add { to, a, b } => Fast::Add { to: near(to)?, a: near(a)?, b: near(b)? },
            Instruction::Subtract { to, a, b } => Fast::Subtract { to: near(to)?, a: near(a)?, b: near(b)? },
            Instruction::Multiply { to, a, b } => Fast::Multiply { to: near(to)?, a: near(a)?, b: near(b)? },
            Instruction::Divide { to, a, b } => Fast::Divide { to: near(to)?, a: near(a)?, b: near(b)? },
            Instruction::AddTo { to, a } => Fast::AddTo { to: near(to)?, a: near(a)? },
            Instruction::Call { to, function, list } => self.call(to, function, list)?,
            Instruction::CallMacro { to, callee, list } => Fast::Call { to: near(to)?, callee, list },
            Instruction::Return => Fast::Return,
            Instruction::Jump { target } => Fast::Jump { target },
            Instruction::JumpIf { a, target } => Fast::JumpIf { a: near(a)?, target },
            Instruction::JumpUnless { a, target } => Fast::JumpUnless { a: near(a)?, target },
            Instruction::JumpUnlessCompare { relation, a, b, target } => unless(relation, near(a)?, near(b)?, target),
            Instruction::DoNext { variable, end, target } => {
                Fast::DoNext { variable: near(variable)?, end: near(end)?, step: near(end + 1)?, target }
            }
            _ => return None,
        })
    }

    /// A call of a function of two numbers.
    fn call(&self, to: Slot, function: u16, list: u16) -> Option<Fast> {
        let way = &self.code.functions.get(usize::from(function))?.way;
        match (way, self.code.lists.get(usize::from(list))?.as_slice()) {
            (EvaluationMethod::Pair(..), [a, b]) => {
                Some(Fast::Pair { to: near(to)?, a: near(*a)?, b: near(*b)?, function })
            }
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
