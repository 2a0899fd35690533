//! Conditions in a block for a code or data macro to run.
//!
//! Invariant: a condition is compiled once; testing it allocates nothing. Facts: reference control-emulator.md 4.2: a
//! list of which any one fires, lists that must and must not be present, or a hand-written condition in which AND binds
//! tighter than OR.

use crate::ident::{CodeId, DataId};

/// An identifier that may be in a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Item {
    /// A code.
    Code(CodeId),
    /// Data.
    Data(DataId),
}

/// Step of a hand-written condition, in postfix order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Step {
    /// The identifier is in the block.
    Present(Item),
    /// Both of the last two hold.
    And,
    /// One of the last two holds.
    Or,
}

/// Conditions besides the triggering identifier.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Condition {
    /// All of these are in the block.
    pub present: Vec<Item>,
    /// None of these is in the block.
    pub absent: Vec<Item>,
    /// Hand-written condition, empty for none.
    pub steps: Vec<Step>,
}

/// Most names in a hand-written condition.
const MOST: usize = 60;

impl Condition {
    /// Whether nothing is asked.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.present.is_empty() && self.absent.is_empty() && self.steps.is_empty()
    }

    /// Tests it in a block.
    pub fn holds(&self, mut on_block: impl FnMut(Item) -> bool) -> bool {
        self.present.iter().all(|&item| on_block(item))
            && !self.absent.iter().any(|&item| on_block(item))
            && (self.steps.is_empty() || self.evaluate(&mut on_block))
    }

    /// The stack is one bit for each value.
    fn evaluate(&self, on_block: &mut impl FnMut(Item) -> bool) -> bool {
        let mut stack = 0_u64;
        for step in &self.steps {
            match step {
                Step::Present(item) => stack = stack << 1 | u64::from(on_block(*item)),
                Step::And => stack = stack >> 1 & (stack & 1 | !1),
                Step::Or => stack = stack >> 1 | stack & 1,
            }
        }
        stack & 1 == 1
    }
}

/// Compiles a hand-written condition; `find` knows the identifiers and reports those it does not know.
///
/// # Errors
/// The text cannot be read; contains the expected input.
pub fn parse(text: &str, find: impl FnMut(&str) -> Option<Item>) -> Result<Vec<Step>, String> {
    let mut parser = Parser { tokens: tokens(text)?, at: 0, steps: Vec::new(), names: 0, depth: 0, find };
    parser.either()?;
    match parser.tokens.get(parser.at) {
        None => Ok(parser.steps),
        Some(token) => Err(format!("AND or OR is expected before `{}`", token.text())),
    }
}

#[derive(Debug, Clone, PartialEq, Eq)]
enum Token {
    Open,
    Close,
    And,
    Or,
    Name(String),
}

impl Token {
    fn text(&self) -> &str {
        match self {
            Token::Open => "(",
            Token::Close => ")",
            Token::And => "AND",
            Token::Or => "OR",
            Token::Name(name) => name,
        }
    }
}

fn tokens(text: &str) -> Result<Vec<Token>, String> {
    let upper = text.to_ascii_uppercase();
    let mut rest = upper.as_str();
    let mut tokens = Vec::new();
    loop {
        rest = rest.trim_start();
        let Some(first) = rest.chars().next() else { return Ok(tokens) };
        let signs = [
            ("(", Token::Open),
            (")", Token::Close),
            ("&&", Token::And),
            ("||", Token::Or),
            (".AND.", Token::And),
            (".OR.", Token::Or),
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
            "AND" => Token::And,
            "OR" => Token::Or,
            name => Token::Name(name.to_owned()),
        });
        rest = after;
    }
}

struct Parser<F> {
    tokens: Vec<Token>,
    at: usize,
    steps: Vec<Step>,
    names: usize,
    depth: usize,
    find: F,
}

impl<F: FnMut(&str) -> Option<Item>> Parser<F> {
    fn next_is(&mut self, token: &Token) -> bool {
        let found = self.tokens.get(self.at) == Some(token);
        self.at += usize::from(found);
        found
    }

    fn either(&mut self) -> Result<(), String> {
        self.both()?;
        while self.next_is(&Token::Or) {
            self.both()?;
            self.steps.push(Step::Or);
        }
        Ok(())
    }

    fn both(&mut self) -> Result<(), String> {
        self.one()?;
        while self.next_is(&Token::And) {
            self.one()?;
            self.steps.push(Step::And);
        }
        Ok(())
    }

    fn one(&mut self) -> Result<(), String> {
        let token = self.tokens.get(self.at).cloned();
        self.at += 1;
        match token {
            Some(Token::Open) => {
                self.depth += 1;
                if self.depth > MOST {
                    return Err(format!("more than {MOST} parentheses are open"));
                }
                self.either()?;
                self.depth -= 1;
                if self.next_is(&Token::Close) { Ok(()) } else { Err("a parenthesis is not closed".to_owned()) }
            }
            Some(Token::Name(name)) => {
                self.names += 1;
                if self.names > MOST {
                    return Err(format!("more than {MOST} identifiers"));
                }
                if let Some(item) = (self.find)(&name) {
                    self.steps.push(Step::Present(item));
                } else {
                    // Reported already; any identifier keeps the rest readable.
                    self.steps.push(Step::Present(Item::Code(crate::ident::codes::COMMENT)));
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

    fn steps(text: &str) -> Result<Vec<Step>, String> {
        parse(text, |name| Some(Item::Data(DataId::built_in(u16::from(name.as_bytes()[0] - b'A')))))
    }

    fn holds(text: &str, present: &str) -> bool {
        let condition = Condition { steps: steps(text).unwrap(), ..Condition::default() };
        condition.holds(|item| match item {
            Item::Data(id) => present.contains(char::from(b'A' + id.index() as u8)),
            Item::Code(_) => false,
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
        let item = |at| Item::Data(DataId::built_in(at));
        let condition = Condition { present: vec![item(0), item(1)], absent: vec![item(2)], steps: vec![] };
        let test = |on: &[usize]| condition.holds(|i| matches!(i, Item::Data(id) if on.contains(&id.index())));
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
