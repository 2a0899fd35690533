//! Evaluating compiled expressions.
//!
//! *Invariant:* evaluating allocates nothing except for more than [`INLINE`] pending operands.

use arrayvec::ArrayVec;

use super::code::{CompiledExpression, ExpressionOp};
use crate::numeric::{NumericFunction, NumericOperator};

/// Operands that wait for their operator without room from the heap.
const INLINE: usize = 16;

/// Values that wait for their operator.
///
/// *Invariant:* there are more only while the first ones fill their room.
#[derive(Debug)]
pub struct Stack<V> {
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
    pub fn pop(&mut self) -> V {
        match self.more.pop() {
            Some(value) => value,
            None => self.first.pop().unwrap_or_default(),
        }
    }
}

/// The source of values for expressions of a dialect.
pub trait Evaluate<V: Clone + Default, X> {
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
    fn apply(&mut self, function: NumericFunction, value: V) -> Result<V, Self::Stop>;

    /// Value of an operator.
    ///
    /// # Errors
    /// It has no value.
    fn combine(&mut self, operator: NumericOperator, left: V, right: V) -> Result<V, Self::Stop>;

    /// Value of an expression.
    ///
    /// # Errors
    /// That of the first operation without a value.
    #[inline]
    fn evaluate(&mut self, code: &CompiledExpression<V, X>) -> Result<V, Self::Stop> {
        // The top value stays out of the stack until another value waits above it.
        let mut stack = Stack::new();
        let Some((first, ops)) = code.ops().split_first() else { return Ok(V::default()) };
        let mut top = match first {
            ExpressionOp::Value(value) => value.clone(),
            ExpressionOp::Own(own) => self.own(own, &mut stack)?,
            // Nothing that is compiled begins with an operator.
            _ => V::default(),
        };
        for op in ops {
            match op {
                ExpressionOp::Value(value) => stack.push(std::mem::replace(&mut top, value.clone())),
                ExpressionOp::Apply(function) => top = self.apply(*function, std::mem::take(&mut top))?,
                ExpressionOp::Combine(operator) => {
                    top = self.combine(*operator, stack.pop(), std::mem::take(&mut top))?
                }
                ExpressionOp::CombineWith(operator, right) => {
                    top = self.combine(*operator, std::mem::take(&mut top), right.clone())?;
                }
                ExpressionOp::Own(own) => {
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

        fn apply(&mut self, function: NumericFunction, value: f64) -> Result<f64, ()> {
            function.value(value).ok_or(())
        }

        fn combine(&mut self, operator: NumericOperator, left: f64, right: f64) -> Result<f64, ()> {
            operator.value(left, right).ok_or(())
        }
    }

    #[test]
    fn operations_take_their_operands_in_the_order_of_the_text() {
        let ops = vec![
            ExpressionOp::Value(7.0),
            ExpressionOp::Value(2.0),
            ExpressionOp::Combine(NumericOperator::Sub),
            ExpressionOp::Own(()),
        ];
        assert_eq!(Numbers.evaluate(&CompiledExpression::new(ops)), Ok(105.0));
        // A constant on the right, and an operand that is not constant.
        let ops = vec![
            ExpressionOp::Value(7.0),
            ExpressionOp::Value(2.0),
            ExpressionOp::Own(()),
            ExpressionOp::Combine(NumericOperator::Sub),
        ];
        assert_eq!(Numbers.evaluate(&CompiledExpression::new(ops)), Ok(-95.0));
        let ops = vec![
            ExpressionOp::Value(1.0),
            ExpressionOp::Value(0.0),
            ExpressionOp::Combine(NumericOperator::Div),
            ExpressionOp::Own(()),
        ];
        assert_eq!(Numbers.evaluate(&CompiledExpression::new(ops)), Err(()));
    }

    #[test]
    fn any_number_of_operands_may_wait() {
        let mut ops: Vec<ExpressionOp<f64, ()>> = (0..100).map(|value| ExpressionOp::Value(f64::from(value))).collect();
        ops.extend((0..99).map(|_| ExpressionOp::Combine(NumericOperator::Sub)));
        let expected = (0..100).rev().fold(0.0, |right, left| f64::from(left) - right);
        assert_eq!(Numbers.evaluate(&CompiledExpression::new(ops)), Ok(expected));
    }
}
