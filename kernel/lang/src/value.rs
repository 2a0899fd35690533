//! Values of the macro language: contents of variables and results of expressions.
//!
//! *Invariant:* a value is two machine words; numbers, truth values and names never allocate, texts and sequences are
//! shared until one of them is changed. Facts: reference macro-language.md 1.2 and 1.4.

use std::sync::Arc;

/// A record name: class and subclass, `-1` standing for `*`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct RecordName {
    /// Class number, 2000 for major words.
    pub class: i32,
    /// Subclass number.
    pub subclass: i32,
}

/// Elements of a sequence. The pointer has no weak ones. So a write of an element, which has to ensure that it is the
/// only owner, needs no locked operation of the processor.
pub type Elements = triomphe::Arc<Vec<MacroValue>>;

/// One value.
#[derive(Clone, Debug, Default)]
pub enum MacroValue {
    /// Never assigned: 0 in arithmetic, false in logic, a blank text where a text is wanted.
    #[default]
    Unset,
    /// `$NULL`, equal only to itself.
    Null,
    /// The only numeric type.
    Real(f64),
    /// Truth value.
    Logical(bool),
    /// Text; the empty text counts as one blank in `$FLEN`.
    Text(Arc<String>),
    /// Sequence; never holds a sequence or an array.
    Sequence(Elements),
    /// Minor word by code.
    Keyword(i32),
    /// Major word or record name.
    Record(RecordName),
    /// Code identifier by the host's index, 0 = `CODE_NONE`.
    Code(u32),
    /// Data identifier by the host's index, 0 = `REG_NONE`.
    Register(u32),
    /// Storage of an array variable; never an operand.
    Array(Box<Array>),
}

/// Storage of an array variable.
#[derive(Clone, Debug)]
pub struct Array {
    /// Sizes, first index first; row-major.
    pub sizes: Vec<u32>,
    /// Type of the elements.
    pub kind: Option<ValueType>,
    /// Last dimension is the hidden channel dimension.
    pub channel: bool,
    /// Elements.
    pub elements: Vec<MacroValue>,
}

impl Array {
    /// Position of `indices` (1-based) in the elements.
    #[must_use]
    pub fn position(&self, indices: &[i64]) -> Option<usize> {
        if indices.len() != self.sizes.len() {
            return None;
        }
        let mut position = 0usize;
        for (&index, &size) in indices.iter().zip(&self.sizes) {
            if index < 1 || index > i64::from(size) {
                return None;
            }
            position = position * size as usize + usize::try_from(index - 1).ok()?;
        }
        Some(position)
    }
}

/// Type of a value as the language names it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ValueType {
    /// `REAL`
    Real,
    /// `LOGICAL`
    Logical,
    /// `STRING`
    Text,
    /// `SEQUENCE`
    Sequence,
    /// `KEYWORD`
    Keyword,
    /// `RECORD`
    Record,
    /// `CODE`
    Code,
    /// `REG`
    Register,
}

impl ValueType {
    /// All types in the order of the reference.
    pub const ALL: [ValueType; 8] = [
        ValueType::Real,
        ValueType::Logical,
        ValueType::Text,
        ValueType::Sequence,
        ValueType::Keyword,
        ValueType::Record,
        ValueType::Code,
        ValueType::Register,
    ];

    /// Name of the type in a declaration.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            ValueType::Real => "REAL",
            ValueType::Logical => "LOGICAL",
            ValueType::Text => "STRING",
            ValueType::Sequence => "SEQUENCE",
            ValueType::Keyword => "KEYWORD",
            ValueType::Record => "RECORD",
            ValueType::Code => "CODE",
            ValueType::Register => "REG",
        }
    }

    /// Type with this name, upper-case.
    #[must_use]
    pub fn named(name: &str) -> Option<ValueType> {
        ValueType::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// Initial value of a declared variable of this type.
    #[must_use]
    pub fn initial(self) -> MacroValue {
        match self {
            ValueType::Real => MacroValue::Real(0.0),
            ValueType::Logical => MacroValue::Logical(false),
            ValueType::Text => MacroValue::text(""),
            ValueType::Sequence => MacroValue::sequence(Vec::new()),
            ValueType::Keyword => MacroValue::Keyword(0),
            ValueType::Record => MacroValue::Record(RecordName { class: 0, subclass: 0 }),
            ValueType::Code => MacroValue::Code(0),
            ValueType::Register => MacroValue::Register(0),
        }
    }
}

impl MacroValue {
    /// A text value.
    #[must_use]
    pub fn text(text: impl Into<String>) -> MacroValue {
        MacroValue::Text(Arc::new(text.into()))
    }

    /// A sequence value; `elements` must hold no sequence.
    #[must_use]
    pub fn sequence(elements: Vec<MacroValue>) -> MacroValue {
        MacroValue::Sequence(Elements::new(elements))
    }

    /// A sequence of numbers.
    #[must_use]
    pub fn numbers(numbers: &[f64]) -> MacroValue {
        MacroValue::sequence(numbers.iter().map(|&n| MacroValue::Real(n)).collect())
    }

    /// Type, none for `$NULL`, unset and arrays.
    #[must_use]
    pub fn kind(&self) -> Option<ValueType> {
        match self {
            MacroValue::Unset | MacroValue::Null | MacroValue::Array(_) => None,
            MacroValue::Real(_) => Some(ValueType::Real),
            MacroValue::Logical(_) => Some(ValueType::Logical),
            MacroValue::Text(_) => Some(ValueType::Text),
            MacroValue::Sequence(_) => Some(ValueType::Sequence),
            MacroValue::Keyword(_) => Some(ValueType::Keyword),
            MacroValue::Record(_) => Some(ValueType::Record),
            MacroValue::Code(_) => Some(ValueType::Code),
            MacroValue::Register(_) => Some(ValueType::Register),
        }
    }

    /// Name of the type for messages.
    #[must_use]
    pub fn kind_name(&self) -> &'static str {
        match (self, self.kind()) {
            (_, Some(kind)) => kind.name(),
            (MacroValue::Null, _) => "$NULL",
            (MacroValue::Array(_), _) => "an array",
            _ => "an unset value",
        }
    }

    /// Number, an unset value counting as 0.
    #[must_use]
    pub fn as_real(&self) -> Option<f64> {
        match self {
            MacroValue::Real(number) => Some(*number),
            MacroValue::Unset => Some(0.0),
            _ => None,
        }
    }

    /// Truth value, an unset value counting as false.
    #[must_use]
    pub fn as_logical(&self) -> Option<bool> {
        match self {
            MacroValue::Logical(truth) => Some(*truth),
            MacroValue::Unset => Some(false),
            _ => None,
        }
    }

    /// Text, an unset value counting as the empty text.
    #[must_use]
    pub fn as_text(&self) -> Option<&str> {
        match self {
            MacroValue::Text(text) => Some(text),
            MacroValue::Unset => Some(""),
            _ => None,
        }
    }

    /// Elements of a sequence.
    #[must_use]
    pub fn as_sequence(&self) -> Option<&[MacroValue]> {
        match self {
            MacroValue::Sequence(elements) => Some(elements),
            _ => None,
        }
    }

    /// Equality inside one type; none when the types differ (`$NULL` may be compared with anything).
    #[must_use]
    pub fn equals(&self, other: &MacroValue) -> Option<bool> {
        Some(match (self, other) {
            (MacroValue::Null, MacroValue::Null) => true,
            (MacroValue::Null, _) | (_, MacroValue::Null) => false,
            (MacroValue::Unset, MacroValue::Unset) => true,
            (MacroValue::Real(a), MacroValue::Real(b)) => a == b,
            (MacroValue::Logical(a), MacroValue::Logical(b)) => a == b,
            (MacroValue::Text(a), MacroValue::Text(b)) => padded(a, b).is_eq(),
            (MacroValue::Sequence(a), MacroValue::Sequence(b)) => {
                a.len() == b.len() && a.iter().zip(b.iter()).all(|(x, y)| x.equals(y) == Some(true))
            }
            (MacroValue::Keyword(a), MacroValue::Keyword(b)) => a == b,
            (MacroValue::Record(a), MacroValue::Record(b)) => a == b,
            (MacroValue::Code(a), MacroValue::Code(b)) | (MacroValue::Register(a), MacroValue::Register(b)) => a == b,
            (MacroValue::Unset, known) | (known, MacroValue::Unset) => known.equals(&known.kind()?.initial())?,
            _ => return None,
        })
    }

    /// Order inside one type that has an order (numbers, texts, keywords).
    #[must_use]
    pub fn order(&self, other: &MacroValue) -> Option<std::cmp::Ordering> {
        match (self, other) {
            (MacroValue::Text(a), MacroValue::Text(b)) => Some(padded(a, b)),
            (MacroValue::Text(a), MacroValue::Unset) => Some(padded(a, "")),
            (MacroValue::Unset, MacroValue::Text(b)) => Some(padded("", b)),
            (MacroValue::Keyword(a), MacroValue::Keyword(b)) => Some(a.cmp(b)),
            _ => self.as_real()?.partial_cmp(&other.as_real()?),
        }
    }
}

/// Compares two texts as if the shorter were filled up with blanks.
#[must_use]
pub fn padded(a: &str, b: &str) -> std::cmp::Ordering {
    if a.len() == b.len() {
        return a.cmp(b);
    }
    let (mut a, mut b) = (a.chars(), b.chars());
    loop {
        match (a.next(), b.next()) {
            (None, None) => return std::cmp::Ordering::Equal,
            (x, y) => match x.unwrap_or(' ').cmp(&y.unwrap_or(' ')) {
                std::cmp::Ordering::Equal => {}
                other => return other,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_is_two_words() {
        assert_eq!(std::mem::size_of::<MacroValue>(), 16);
    }

    #[test]
    fn null_equals_nothing_but_itself_and_unset_acts_as_the_other_side() {
        assert_eq!(MacroValue::Null.equals(&MacroValue::Real(0.0)), Some(false));
        assert_eq!(MacroValue::Null.equals(&MacroValue::Null), Some(true));
        assert_eq!(MacroValue::Unset.equals(&MacroValue::Real(0.0)), Some(true));
        assert_eq!(MacroValue::Unset.equals(&MacroValue::Logical(true)), Some(false));
        assert_eq!(MacroValue::text("a").equals(&MacroValue::Real(0.0)), None);
    }

    #[test]
    fn texts_compare_as_if_padded() {
        assert_eq!(MacroValue::text("").equals(&MacroValue::text(" ")), Some(true));
        assert!(padded("A", "A B").is_lt());
        assert!(padded("a", "A").is_gt());
    }

    #[test]
    fn arrays_are_row_major_and_checked() {
        let array = Array { sizes: vec![2, 3], kind: None, channel: false, elements: vec![MacroValue::Null; 6] };
        assert_eq!(array.position(&[1, 3]), Some(2));
        assert_eq!(array.position(&[2, 1]), Some(3));
        assert_eq!(array.position(&[0, 1]), None);
        assert_eq!(array.position(&[1, 4]), None);
        assert_eq!(array.position(&[1]), None);
    }
}
