//! Conditions in a block for a code or data macro to run.
//!
//! Invariant: a condition is compiled once; testing it allocates nothing. Facts: reference control-emulator.md 4.2: a
//! list of which any one fires, lists that must and must not be present, or a hand-written condition in which AND binds
//! tighter than OR.

use crate::ident::{CodeId, DataId};

/// An identifier that may be in a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BlockIdentifier {
    /// A code.
    Code(CodeId),
    /// Data.
    Data(DataId),
}

/// Step of a hand-written condition, in postfix order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ConditionStep {
    /// The identifier is in the block.
    Present(BlockIdentifier),
    /// Both of the last two hold.
    And,
    /// One of the last two holds.
    Or,
}

/// Conditions besides the triggering identifier.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct MacroCondition {
    /// All of these are in the block.
    pub present: Vec<BlockIdentifier>,
    /// None of these is in the block.
    pub absent: Vec<BlockIdentifier>,
    /// Hand-written condition, empty for none.
    pub steps: Vec<ConditionStep>,
}

/// Most names in a hand-written condition.
const MOST: usize = 60;

impl MacroCondition {
    /// Whether nothing is asked.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.present.is_empty() && self.absent.is_empty() && self.steps.is_empty()
    }

    /// Tests it in a block.
    pub fn holds(&self, mut on_block: impl FnMut(BlockIdentifier) -> bool) -> bool {
        self.present.iter().all(|&item| on_block(item))
            && !self.absent.iter().any(|&item| on_block(item))
            && (self.steps.is_empty() || self.evaluate(&mut on_block))
    }

    /// The stack is one bit for each value.
    fn evaluate(&self, on_block: &mut impl FnMut(BlockIdentifier) -> bool) -> bool {
        let mut stack = 0_u64;
        for step in &self.steps {
            match step {
                ConditionStep::Present(item) => stack = stack << 1 | u64::from(on_block(*item)),
                ConditionStep::And => stack = stack >> 1 & (stack & 1 | !1),
                ConditionStep::Or => stack = stack >> 1 | stack & 1,
            }
        }
        stack & 1 == 1
    }
}

/// Compiles a hand-written condition; `find` knows the identifiers and reports those it does not know.
///
/// # Errors
/// The text cannot be read; contains the expected input.
pub fn parse(text: &str, find: impl FnMut(&str) -> Option<BlockIdentifier>) -> Result<Vec<ConditionStep>, String> {
    let mut parser = ConditionParser { tokens: tokens(text)?, at: 0, steps: Vec::new(), names: 0, depth: 0, find };
    parser.either()?;
    match parser.tokens.get(parser.at) {
        None => Ok(parser.steps),
        Some(token) => Err(format!("AND or OR is expected before `{}`", token.text())),
    }
}

#[derive(Debug, Clone, PartialEq, Eq)]
enum ConditionToken {
    Open,
    Close,
    And,
    Or,
    Name(String),
}

impl ConditionToken {
    fn text(&self) -> &str {
        match self {
            ConditionToken::Open => "(",
            ConditionToken::Close => ")",
            ConditionToken::And => "AND",
            ConditionToken::Or => "OR",
            ConditionToken::Name(name) => name,
        }
    }
}

fn tokens(text: &str) -> Result<Vec<ConditionToken>, String> {
    let upper = text.to_ascii_uppercase();
    let mut rest = upper.as_str();
    let mut tokens = Vec::new();
    loop {
        rest = rest.trim_start();
        let Some(first) = rest.chars().next() else { return Ok(tokens) };
        let signs = [
            ("(", ConditionToken::Open),
            (")", ConditionToken::Close),
            ("&&", ConditionToken::And),
            ("||", ConditionToken::Or),
            (".AND.", ConditionToken::And),
            (".OR.", ConditionToken::Or),
        ];
        if let Some((sign, token)) = signs.into_iter().find(|(sign, _)| rest.starts_with(sign)) {
            tokens.push(token);
            rest = rest.get(sign.len()..).unwrap_or("");
            continue;
        }
        let length = rest.find(|c: char| !c.is_ascii_alphanumeric() && c != '_').unwrap_or(rest.len());
        let (name, after) = rest.split_at_checked(length).unwrap_or((rest, ""));
        tokens.push(match name {
            "" => return Err(format!("`{}` has no meaning in a condition", first.escape_debug())),
            "AND" => ConditionToken::And,
            "OR" => ConditionToken::Or,
            name => ConditionToken::Name(name.to_owned()),
        });
        rest = after;
    }
}

struct ConditionParser<F> {
    tokens: Vec<ConditionToken>,
    at: usize,
    steps: Vec<ConditionStep>,
    names: usize,
    depth: usize,
    find: F,
}

impl<F: FnMut(&str) -> Option<BlockIdentifier>> ConditionParser<F> {
    fn next_is(&mut self, token: &ConditionToken) -> bool {
        let found = self.tokens.get(self.at) == Some(token);
        self.at += usize::from(found);
        found
    }

    fn either(&mut self) -> Result<(), String> {
        self.both()?;
        while self.next_is(&ConditionToken::Or) {
            self.both()?;
            self.steps.push(ConditionStep::Or);
        }
        Ok(())
    }

    fn both(&mut self) -> Result<(), String> {
        self.one()?;
        while self.next_is(&ConditionToken::And) {
            self.one()?;
            self.steps.push(ConditionStep::And);
        }
        Ok(())
    }

    fn one(&mut self) -> Result<(), String> {
        let token = self.tokens.get(self.at).cloned();
        self.at += 1;
        match token {
            Some(ConditionToken::Open) => {
                self.depth += 1;
                if self.depth > MOST {
                    return Err(format!("more than {MOST} parentheses are open"));
                }
                self.either()?;
                self.depth -= 1;
                if self.next_is(&ConditionToken::Close) {
                    Ok(())
                } else {
                    Err("a parenthesis is not closed".to_owned())
                }
            }
            Some(ConditionToken::Name(name)) => {
                self.names += 1;
                if self.names > MOST {
                    return Err(format!("more than {MOST} identifiers"));
                }
                if let Some(item) = (self.find)(&name) {
                    self.steps.push(ConditionStep::Present(item));
                } else {
                    // Reported already; any identifier keeps the rest readable.
                    self.steps.push(ConditionStep::Present(BlockIdentifier::Code(crate::ident::codes::COMMENT)));
                }
                Ok(())
            }
            Some(other) => Err(format!("an identifier is expected, not `{}`", other.text())),
            None => Err("an identifier is expected at the end".to_owned()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steps(text: &str) -> Result<Vec<ConditionStep>, String> {
        parse(text, |name| Some(BlockIdentifier::Data(DataId::built_in(u16::from(name.as_bytes()[0] - b'A')))))
    }

    fn holds(text: &str, present: &str) -> bool {
        let condition = MacroCondition { steps: steps(text).unwrap(), ..MacroCondition::default() };
        condition.holds(|item| match item {
            BlockIdentifier::Data(id) => present.contains(char::from(b'A' + id.index() as u8)),
            BlockIdentifier::Code(_) => false,
        })
    }

    #[test]
    fn and_binds_tighter_than_or() {
        for (text, present, expected) in [
            ("A AND B OR C", "C", true),
            ("A && (B || C)", "C", false),
            ("A.AND.(B.OR.C)", "AC", true),
            ("a or b and c", "B", false),
            ("A", "", false),
        ] {
            assert_eq!(holds(text, present), expected, "{text} with {present}");
        }
    }

    #[test]
    fn lists_must_all_hold() {
        let item = |at| BlockIdentifier::Data(DataId::built_in(at));
        let condition = MacroCondition { present: vec![item(0), item(1)], absent: vec![item(2)], steps: vec![] };
        let test =
            |on: &[usize]| condition.holds(|i| matches!(i, BlockIdentifier::Data(id) if on.contains(&id.index())));
        assert_eq!([test(&[0, 1]), test(&[0]), test(&[0, 1, 2])], [true, false, false]);
    }

    #[test]
    fn what_cannot_be_read_is_told() {
        for text in ["", "A B", "A AND", "(A", "A)", "A ? B", "AND", "A OR OR B", &"(".repeat(99), &"A OR ".repeat(99)]
        {
            assert!(steps(text).is_err(), "{text}");
        }
    }
}
