//! Values, operators and trees of them, computed here and not by the language.

use counterpoint_lang::format::wildcard_text;
use counterpoint_lang::value::MacroValue;

/// A value as this test knows it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Known {
    Real(f64),
    Text(String),
    Logical(bool),
    Word(&'static str, i32),
    List(Vec<f64>),
}

impl Known {
    /// How it is written in a macro.
    pub(crate) fn written(&self) -> String {
        match self {
            Known::Real(number) => format!("{number}"),
            Known::Text(text) => format!("'{}'", text.replace('\'', "''")),
            Known::Logical(true) => ".TRUE.".into(),
            Known::Logical(false) => ".FALSE.".into(),
            Known::Word(name, _) => (*name).into(),
            Known::List(numbers) => {
                format!("{{{}}}", numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(","))
            }
        }
    }

    /// The output of `!(*)`.
    pub(crate) fn printed(&self) -> String {
        match self {
            Known::Real(number) => wildcard_text(*number),
            Known::Text(text) => text.clone(),
            Known::Logical(truth) => truth.to_string().to_uppercase(),
            Known::Word(name, _) => (*name).into(),
            Known::List(numbers) => {
                format!("<{}>", numbers.iter().map(|n| wildcard_text(*n)).collect::<Vec<_>>().join(","))
            }
        }
    }

    pub(crate) fn type_name(&self) -> &'static str {
        match self {
            Known::Real(_) => "REAL",
            Known::Text(_) => "STRING",
            Known::Logical(_) => "LOGICAL",
            Known::Word(..) => "KEYWORD",
            Known::List(_) => "SEQUENCE",
        }
    }

    /// The value that a caller of a macro passes.
    pub(crate) fn value(&self) -> MacroValue {
        match self {
            Known::Real(number) => MacroValue::Real(*number),
            Known::Text(text) => MacroValue::text(text.as_str()),
            Known::Logical(truth) => MacroValue::Logical(*truth),
            Known::Word(_, code) => MacroValue::Keyword(*code),
            Known::List(numbers) => MacroValue::numbers(numbers),
        }
    }

    /// Another value of the same type.
    pub(crate) fn other(&self) -> Known {
        match self {
            Known::Real(number) => Known::Real(if *number == 7.0 { 8.0 } else { 7.0 }),
            Known::Text(text) => Known::Text(if text == "old" { "older".into() } else { "old".into() }),
            Known::Logical(truth) => Known::Logical(!truth),
            Known::Word(name, _) => {
                if *name == "MIST" {
                    Known::Word("FLOOD", 89)
                } else {
                    Known::Word("MIST", 90)
                }
            }
            Known::List(numbers) => Known::List(if numbers == &[9.0] { vec![8.0] } else { vec![9.0] }),
        }
    }

    pub(crate) fn is_list(&self) -> bool {
        matches!(self, Known::List(_))
    }
}

/// An operator of the language.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Operator {
    Power,
    Negate,
    Positive,
    Times,
    Over,
    Plus,
    Minus,
    PlusText,
    Join,
    Equal,
    NotEqual,
    Less,
    LessEqual,
    Greater,
    GreaterEqual,
    Not,
    And,
    Or,
    Xor,
}

use Operator as O;

pub(crate) const OPERATORS: [Operator; 19] = [
    O::Power,
    O::Negate,
    O::Positive,
    O::Times,
    O::Over,
    O::Plus,
    O::Minus,
    O::PlusText,
    O::Join,
    O::Equal,
    O::NotEqual,
    O::Less,
    O::LessEqual,
    O::Greater,
    O::GreaterEqual,
    O::Not,
    O::And,
    O::Or,
    O::Xor,
];

impl Operator {
    /// Spelling in the standard style and in that of C.
    pub(crate) fn spellings(self) -> [&'static str; 2] {
        match self {
            O::Power => ["**", "**"],
            O::Negate | O::Minus => ["-", "-"],
            O::Positive | O::Plus | O::PlusText => ["+", "+"],
            O::Times => ["*", "*"],
            O::Over => ["/", "/"],
            O::Join => ["//", "//"],
            O::Equal => [".EQ.", "=="],
            O::NotEqual => [".NE.", "!="],
            O::Less => [".LT.", "<"],
            O::LessEqual => [".LE.", "<="],
            O::Greater => [".GT.", ">"],
            O::GreaterEqual => [".GE.", ">="],
            O::Not => [".NOT.", "!"],
            O::And => [".AND.", "&&"],
            O::Or => [".OR.", "||"],
            O::Xor => [".XOR.", "^^"],
        }
    }

    pub(crate) fn is_unary(self) -> bool {
        matches!(self, O::Negate | O::Positive | O::Not)
    }

    /// Row in the table of bindings, the strongest highest.
    pub(crate) fn binding(self) -> u8 {
        match self {
            O::Power => 9,
            O::Negate | O::Positive => 8,
            O::Times | O::Over => 7,
            O::Plus | O::Minus | O::PlusText => 6,
            O::Join => 5,
            O::Equal | O::NotEqual | O::Less | O::LessEqual | O::Greater | O::GreaterEqual => 4,
            O::Not => 3,
            O::And => 2,
            O::Or => 1,
            O::Xor => 0,
        }
    }

    /// Operand types that it takes.
    pub(crate) fn takes(self) -> &'static [&'static str] {
        match self {
            O::Join | O::PlusText => &["STRING"],
            O::Not | O::And | O::Or | O::Xor => &["LOGICAL"],
            O::Equal | O::NotEqual => &["REAL", "STRING", "LOGICAL", "KEYWORD", "SEQUENCE"],
            O::Less | O::LessEqual | O::Greater | O::GreaterEqual => &["REAL", "STRING", "KEYWORD"],
            _ => &["REAL"],
        }
    }

    /// Type of its result.
    pub(crate) fn gives(self) -> &'static str {
        match self.binding() {
            0..=4 => "LOGICAL",
            5 => "STRING",
            _ if self == O::PlusText => "STRING",
            _ => "REAL",
        }
    }

    /// The result; none where the test does not know it exactly.
    pub(crate) fn result(self, a: &Known, b: &Known) -> Option<Known> {
        let relation = |order: std::cmp::Ordering| match self {
            O::Equal => order.is_eq(),
            O::NotEqual => order.is_ne(),
            O::Less => order.is_lt(),
            O::LessEqual => order.is_le(),
            O::Greater => order.is_gt(),
            _ => order.is_ge(),
        };
        Some(match (a, b) {
            (Known::Real(a), Known::Real(b)) => {
                let number = match self {
                    O::Power => whole_power(*a, *b)?,
                    O::Negate => -a,
                    O::Positive => *a,
                    O::Times => a * b,
                    O::Over if *b == 0.0 => return None,
                    O::Over => a / b,
                    O::Plus => a + b,
                    O::Minus => a - b,
                    _ => return Some(Known::Logical(relation(a.partial_cmp(b)?))),
                };
                if number.abs() > 1e6 || (number != 0.0 && number.abs() < 1e-3) {
                    return None;
                }
                Known::Real(number)
            }
            (Known::Text(a), Known::Text(b)) => match self {
                O::Join | O::PlusText => Known::Text(format!("{a}{b}")),
                _ => {
                    let width = a.len().max(b.len());
                    Known::Logical(relation(format!("{a:width$}").cmp(&format!("{b:width$}"))))
                }
            },
            (Known::Logical(a), Known::Logical(b)) => Known::Logical(match self {
                O::Not => !a,
                O::And => *a && *b,
                O::Or => *a || *b,
                O::Xor | O::NotEqual => a != b,
                _ => a == b,
            }),
            (Known::Word(_, a), Known::Word(_, b)) => Known::Logical(relation(a.cmp(b))),
            (Known::List(a), Known::List(b)) => Known::Logical((a == b) == (self == O::Equal)),
            _ => return None,
        })
    }
}

/// A power that is exact: small whole exponents of multiples of a half.
fn whole_power(base: f64, exponent: f64) -> Option<f64> {
    if exponent.fract() != 0.0 || exponent.abs() > 3.0 || (base * 2.0).fract() != 0.0 || base.abs() > 50.0 {
        return None;
    }
    let product = (0..exponent.abs() as usize).fold(1.0, |product, _| product * base);
    if exponent >= 0.0 { Some(product) } else { (product.abs().log2().fract() == 0.0).then(|| 1.0 / product) }
}

/// An expression over leaves whose place is chosen later.
#[derive(Clone, Debug)]
pub(crate) enum Tree {
    Leaf(Known),
    Node(Operator, Vec<Tree>, Known),
}

impl Tree {
    /// A node; none where the result is not known.
    pub(crate) fn node(operator: Operator, parts: Vec<Tree>) -> Option<Tree> {
        let first = parts.first()?.value().clone();
        let second = parts.get(1).map_or(first.clone(), |part| part.value().clone());
        let result = operator.result(&first, &second)?;
        Some(Tree::Node(operator, parts, result))
    }

    pub(crate) fn value(&self) -> &Known {
        match self {
            Tree::Leaf(value) | Tree::Node(_, _, value) => value,
        }
    }

    /// The text with as few parentheses as the table of bindings allows; `leaf` writes a leaf, `style` chooses a
    /// spelling.
    pub(crate) fn written(&self, leaf: &mut dyn FnMut(&Known) -> String, style: &mut dyn FnMut() -> usize) -> String {
        let (operator, parts) = match self {
            Tree::Leaf(value) => return leaf(value),
            Tree::Node(operator, parts, _) => (*operator, parts),
        };
        let sign = operator.spellings()[style()];
        let mine = operator.binding();
        let mut texts = Vec::new();
        for (at, part) in parts.iter().enumerate() {
            let text = part.written(leaf, style);
            let theirs = match part {
                Tree::Leaf(_) if text.starts_with('-') => O::Negate.binding(),
                Tree::Leaf(_) => u8::MAX,
                Tree::Node(operator, ..) => operator.binding(),
            };
            // `**` binds to the right, comparisons do not chain, all others bind to the left.
            let equal_needs = match operator {
                O::Power => at == 0,
                _ if mine == 4 => true,
                _ => at == 1,
            };
            let needs = theirs < mine || (theirs == mine && equal_needs && !operator.is_unary());
            texts.push(if needs { format!("({text})") } else { text });
        }
        match texts.as_slice() {
            [only] => format!("{sign}{only}"),
            [left, right] => format!("{left}{sign}{right}"),
            _ => String::new(),
        }
    }
}
