//! The short forms of instructions, for values in the first registers.
//!
//! *Invariant:* a short form has the position of the instruction it replaces. It does exactly the same as that
//! instruction, or as that instruction and the ones after it, or nothing at all. If an operand has another type or a
//! result does not exist, the machine executes the instruction itself. So a short form never has to fail. Forms take a
//! shared variable from its home, a register that holds it while short forms run.

use super::{Relation, Target};
use crate::value::ValueType;

/// Registers that a short form can name.
pub const WINDOW: usize = 256;
/// A register of the window.
pub type Near = u8;

/// One short form. `a`, `b`, `c` are operands in the order in which they are written, `to` is the destination.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(align(8))]
#[allow(missing_docs, reason = "the operands are named the same way throughout")]
pub enum Fast {
    /// There is none: take the instruction.
    #[default]
    None,
    Move {
        to: Near,
        a: Near,
    },
    /// Moves a number.
    MoveNumber {
        to: Near,
        a: Near,
    },
    /// Moves a value of a type.
    MoveTyped {
        to: Near,
        a: Near,
        kind: ValueType,
    },
    /// Reads a shared variable.
    Read {
        to: Near,
        home: Near,
        shared: u8,
    },
    /// Writes a shared variable of any type.
    Write {
        home: Near,
        shared: u8,
        a: Near,
    },
    /// Writes a shared variable of numbers.
    WriteNumber {
        home: Near,
        shared: u8,
        a: Near,
    },
    /// Writes a shared variable of another type.
    WriteTyped {
        home: Near,
        shared: u8,
        a: Near,
        kind: ValueType,
    },
    Negate {
        to: Near,
        a: Near,
    },
    Add {
        to: Near,
        a: Near,
        b: Near,
    },
    Subtract {
        to: Near,
        a: Near,
        b: Near,
    },
    Multiply {
        to: Near,
        a: Near,
        b: Near,
    },
    Divide {
        to: Near,
        a: Near,
        b: Near,
    },
    Power {
        to: Near,
        a: Near,
        b: Near,
    },
    /// Joins two texts.
    Join {
        to: Near,
        a: Near,
        b: Near,
    },
    Not {
        to: Near,
        a: Near,
    },
    Truth {
        to: Near,
        a: Near,
    },
    Compare {
        relation: Relation,
        to: Near,
        a: Near,
        b: Near,
    },
    /// A function of one number.
    Math {
        to: Near,
        a: Near,
        function: u16,
    },
    /// Makes a sequence of single values.
    Sequence {
        to: Near,
        list: u16,
    },
    /// Adds to a number or a text, or appends a single value to a sequence.
    AddTo {
        to: Near,
        a: Near,
    },
    /// A function of two numbers.
    Pair {
        to: Near,
        a: Near,
        b: Near,
        function: u16,
    },
    /// An operation of `a` and `b`, then one of the result and `c`.
    Two {
        first: FusedOperator,
        then: FusedOperator,
        to: Near,
        a: Near,
        b: Near,
        c: Near,
    },
    /// [`Fast::Two`]: a product is added to `c`.
    MultiplyAdd {
        to: Near,
        a: Near,
        b: Near,
        c: Near,
    },
    /// [`Fast::Two`]: a quotient is subtracted from `c`.
    DivideFrom {
        to: Near,
        a: Near,
        b: Near,
        c: Near,
    },
    Element {
        to: Near,
        array: Near,
        index: Near,
    },
    /// An element and `c`.
    ElementThen {
        then: FusedOperator,
        to: Near,
        array: Near,
        index: Near,
        c: Near,
    },
    SetElement {
        array: Near,
        index: Near,
        a: Near,
    },
    /// An element and `c`, back into the element.
    Update {
        then: FusedOperator,
        array: Near,
        index: Near,
        c: Near,
    },
    /// [`Fast::Update`] with a sum.
    UpdateAdd {
        array: Near,
        index: Near,
        c: Near,
    },
    /// Element of an array with two indices.
    Cell {
        to: Near,
        array: Near,
        row: Near,
        column: Near,
    },
    SetCell {
        array: Near,
        row: Near,
        column: Near,
        a: Near,
    },
    /// [`Fast::Update`] with two indices.
    UpdateCell {
        then: FusedOperator,
        array: Near,
        row: Near,
        column: Near,
        c: Near,
    },
    /// Compares an element with `b` and jumps unless that holds.
    UnlessElement {
        relation: Relation,
        array: Near,
        index: Near,
        b: Near,
        target: Target,
    },
    /// [`Fast::UnlessElement`] with two indices.
    UnlessCell {
        relation: Relation,
        array: Near,
        row: Near,
        column: Near,
        b: Near,
        target: Target,
    },
    /// Compares a shared variable with `b` and jumps unless that holds.
    UnlessShared {
        relation: Relation,
        home: Near,
        shared: u8,
        b: Near,
        target: Target,
    },
    /// Calls a function.
    Call {
        to: Near,
        callee: u16,
        list: u16,
    },
    /// Calls a small function, whose forms run in registers of the caller: position in
    /// [`ShortForms::bodies`](super::ShortForms::bodies).
    Inline {
        to: Near,
        body: u16,
    },
    /// Ends such a function.
    Leave,
    /// Ends a function.
    Return,
    Jump {
        target: Target,
    },
    JumpIf {
        a: Near,
        target: Target,
    },
    JumpUnless {
        a: Near,
        target: Target,
    },
    UnlessEqual {
        a: Near,
        b: Near,
        target: Target,
    },
    UnlessNotEqual {
        a: Near,
        b: Near,
        target: Target,
    },
    UnlessLess {
        a: Near,
        b: Near,
        target: Target,
    },
    UnlessLessEqual {
        a: Near,
        b: Near,
        target: Target,
    },
    UnlessGreater {
        a: Near,
        b: Near,
        target: Target,
    },
    UnlessGreaterEqual {
        a: Near,
        b: Near,
        target: Target,
    },
    /// Jumps if the values are equal.
    IfWhen {
        a: Near,
        b: Near,
        target: Target,
    },
    /// Jumps if `a` lies between the registers `low` and `high`.
    IfThru {
        a: Near,
        low: Near,
        high: Near,
        target: Target,
    },
    /// End in `end`, step in `step`.
    DoStart {
        variable: Near,
        end: Near,
        step: Near,
        target: Target,
    },
    /// End in `end`, step in `step`.
    DoNext {
        variable: Near,
        end: Near,
        step: Near,
        target: Target,
    },
}

/// An operation of a value and a second operand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "they are named as the operators")]
pub enum FusedOperator {
    Add,
    Subtract,
    /// The value is subtracted from the operand.
    From,
    Multiply,
    Divide,
    /// The operand is divided by the value.
    Under,
}

impl FusedOperator {
    /// The result for a value and an operand.
    #[inline(always)]
    #[must_use]
    pub fn of(self, value: f64, operand: f64) -> f64 {
        match self {
            FusedOperator::Add => value + operand,
            FusedOperator::Subtract => value - operand,
            FusedOperator::From => operand - value,
            FusedOperator::Multiply => value * operand,
            FusedOperator::Divide => value / operand,
            FusedOperator::Under => operand / value,
        }
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_short_form_is_one_word() {
        assert_eq!(std::mem::size_of::<super::Fast>(), 8);
    }
}
