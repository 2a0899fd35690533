//! Evaluating compiled expressions.
//!
//! *Invariant:* evaluating allocates nothing except for more than [`INLINE`] pending operands.

use arrayvec::ArrayVec;

use super::code::{Code, Op};
use crate::numeric::{Function, Operator};

/// Operands that wait for their operator without room from the heap.
const INLINE: usize = 16;

/// Values that wait for their operator.
///
/// *Invariant:* there are more only while the first ones fill their room.
#[derive(Debug)]
pub(crate) struct Stack<V> {
    first: ArrayVec<V, INLINE>,
    more: Vec<V>,
}

impl<V: Default> Stack<V> {
    fn new() -> Self {
        Self { first: ArrayVec::new(), more: Vec::new() }
    }

    #[inline]
    fn push(&mut self, value: V) {
        if let Err(full) = self.first.try_push(value) {
            self.more.push(full.element());
        }
    }

    /// Takes the value on top.
    #[inline]
    pub(crate) fn pop(&mut self) -> V {
        match self.more.pop() {
            Some(value) => value,
            None => self.first.pop().unwrap_or_default(),
        }
    }
}

/// The source of values for expressions of a dialect.
pub(crate) trait Evaluate<V: Clone + Default, X> {
    /// Why there is no value.
    type Stop;

    /// Value of an operation of the dialect, which takes its operands off the stack.
    ///
    /// # Errors
    /// It has no value.
    fn own(&mut self, own: &X, stack: &mut Stack<V>) -> Result<V, Self::Stop>;

    /// Value of a function.
    ///
    /// # Errors
    /// It has no value.
    fn apply(&mut self, function: Function, value: V) -> Result<V, Self::Stop>;

    /// Value of an operator.
    ///
    /// # Errors
    /// It has no value.
    fn combine(&mut self, operator: Operator, left: V, right: V) -> Result<V, Self::Stop>;

    /// Value of an expression.
    ///
    /// # Errors
    /// That of the first operation without a value.
    #[inline]
    fn evaluate(&mut self, code: &Code<V, X>) -> Result<V, Self::Stop> {
        // The top value stays out of the stack until another value waits above it.
        let mut stack = Stack::new();
        let Some((first, ops)) = code.ops().split_first() else { return Ok(V::default()) };
        let mut top = match first {
            Op::Value(value) => value.clone(),
            Op::Own(own) => self.own(own, &mut stack)?,
            // Nothing that is compiled begins with an operator.
            _ => V::default(),
        };
        for op in ops {
            match op {
                Op::Value(value) => stack.push(std::mem::replace(&mut top, value.clone())),
                Op::Apply(function) => top = self.apply(*function, std::mem::take(&mut top))?,
                Op::Combine(operator) => top = self.combine(*operator, stack.pop(), std::mem::take(&mut top))?,
                Op::CombineWith(operator, right) => {
                    top = self.combine(*operator, std::mem::take(&mut top), right.clone())?;
                }
                Op::Own(own) => {
                    stack.push(std::mem::take(&mut top));
                    top = self.own(own, &mut stack)?;
                }
            }
        }
        Ok(top)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Numbers;

    impl Evaluate<f64, ()> for Numbers {
        type Stop = ();

        fn own(&mut self, (): &(), stack: &mut Stack<f64>) -> Result<f64, ()> {
            Ok(stack.pop() + 100.0)
        }

        fn apply(&mut self, function: Function, value: f64) -> Result<f64, ()> {
            function.value(value).ok_or(())
        }

        fn combine(&mut self, operator: Operator, left: f64, right: f64) -> Result<f64, ()> {
            operator.value(left, right).ok_or(())
        }
    }

    #[test]
    fn operations_take_their_operands_in_the_order_of_the_text() {
        let ops = vec![Op::Value(7.0), Op::Value(2.0), Op::Combine(Operator::Sub), Op::Own(())];
        assert_eq!(Numbers.evaluate(&Code::new(ops)), Ok(105.0));
        // A constant on the right, and an operand that is not constant.
        let ops = vec![Op::Value(7.0), Op::Value(2.0), Op::Own(()), Op::Combine(Operator::Sub)];
        assert_eq!(Numbers.evaluate(&Code::new(ops)), Ok(-95.0));
        let ops = vec![Op::Value(1.0), Op::Value(0.0), Op::Combine(Operator::Div), Op::Own(())];
        assert_eq!(Numbers.evaluate(&Code::new(ops)), Err(()));
    }

    #[test]
    fn any_number_of_operands_may_wait() {
        let mut ops: Vec<Op<f64, ()>> = (0..100).map(|value| Op::Value(f64::from(value))).collect();
        ops.extend((0..99).map(|_| Op::Combine(Operator::Sub)));
        let expected = (0..100).rev().fold(0.0, |right, left| f64::from(left) - right);
        assert_eq!(Numbers.evaluate(&Code::new(ops)), Ok(expected));
    }
}
