//! How expressions with operators are read, whatever the operators are.
//!
//! Every dialect has its own operators, as a table by level, its own operands, and its own form of what was read: a tree, or
//! operations in postfix order. What they share is how operators bind. *Invariant:* operators of one level bind from left to
//! right; reading recurses once a level and operand, so what bounds the nesting of operands bounds the stack.

/// The expressions of a dialect.
pub(super) trait Grammar {
    /// What stands between two operands.
    type Operator: Copy;
    /// An expression, or a part of one.
    type Part;
    /// Why a text is not an expression.
    type Mistake;

    /// Reads an operand with its signs.
    ///
    /// # Errors
    /// There is none.
    fn operand(&mut self) -> Result<Self::Part, Self::Mistake>;

    /// Takes the operator that follows, if its level is at least `loosest`: level and operator.
    fn operator(&mut self, loosest: usize) -> Option<(usize, Self::Operator)>;

    /// Whether the operator that was taken is allowed here; `chained` after another operator of its level.
    ///
    /// # Errors
    /// It is not.
    fn check(&mut self, _level: usize, _chained: bool) -> Result<(), Self::Mistake> {
        Ok(())
    }

    /// An operator with its operands.
    fn join(&mut self, operator: Self::Operator, left: Self::Part, right: Self::Part) -> Self::Part;
}

/// Reads operands and operators of this level and tighter ones, as far as they go.
///
/// # Errors
/// An operand is missing, or an operator is not allowed.
pub(super) fn read<G: Grammar + ?Sized>(grammar: &mut G, loosest: usize) -> Result<G::Part, G::Mistake> {
    let mut left = grammar.operand()?;
    let mut before = None;
    while let Some((level, operator)) = grammar.operator(loosest) {
        grammar.check(level, before == Some(level))?;
        let right = read(grammar, level + 1)?;
        left = grammar.join(operator, left, right);
        before = Some(level);
    }
    Ok(left)
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Letters<'t>(std::iter::Peekable<std::str::Chars<'t>>);

    impl Grammar for Letters<'_> {
        type Operator = char;
        type Part = String;
        type Mistake = String;

        fn operand(&mut self) -> Result<String, String> {
            self.0.next().map(String::from).ok_or_else(|| "the end".to_owned())
        }

        fn operator(&mut self, loosest: usize) -> Option<(usize, char)> {
            let level = ["<", "+-", "*/"].iter().position(|level| self.0.peek().is_some_and(|c| level.contains(*c)))?;
            (level >= loosest).then(|| (level, self.0.next().unwrap_or(' ')))
        }

        fn check(&mut self, level: usize, chained: bool) -> Result<(), String> {
            if level == 0 && chained { Err("a second comparison".to_owned()) } else { Ok(()) }
        }

        fn join(&mut self, operator: char, left: String, right: String) -> String {
            format!("({left}{operator}{right})")
        }
    }

    #[test]
    fn tighter_operators_bind_first_and_equal_ones_from_left_to_right() {
        let of = |text: &str| read(&mut Letters(text.chars().peekable()), 0);
        for (text, bound) in [
            ("a-b-c", "((a-b)-c)"),
            ("a+b*c-d", "((a+(b*c))-d)"),
            ("a*b/c<d+e", "(((a*b)/c)<(d+e))"),
            ("a<b*c", "(a<(b*c))"),
        ] {
            assert_eq!(of(text).as_deref(), Ok(bound));
        }
        assert_eq!(of("a<b<c"), Err("a second comparison".to_owned()));
        assert_eq!(of("a+"), Err("the end".to_owned()));
    }
}
