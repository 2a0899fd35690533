//! Values of the control and their types.
//!
//! Facts: reference control-emulator.md 5.4; the control's types INT REAL BOOL CHAR STRING AXIS FRAME. Invariant: a
//! REAL is finite, an INT fits into 32 bits once it is stored.

use counterpoint_lang::value::MacroValue;

use super::frame::SiemensFrame;

/// A value.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Data {
    Int(i64),
    Real(f64),
    Bool(bool),
    Char(u8),
    Text(String),
    Axis(String),
    Frame(Box<SiemensFrame>),
}

impl Default for Data {
    fn default() -> Self {
        Self::Int(0)
    }
}

/// A type.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Type {
    Int,
    Real,
    Bool,
    Char,
    /// With the longest text.
    Text(u16),
    Axis,
    Frame,
}

/// Largest INT.
pub(super) const MOST_INT: i64 = 2_147_483_647;

impl Type {
    /// By its name; texts get their length later.
    pub(super) fn named(name: &str) -> Option<Self> {
        Some(match name {
            "INT" => Self::Int,
            "REAL" => Self::Real,
            "BOOL" => Self::Bool,
            "CHAR" => Self::Char,
            "STRING" => Self::Text(0),
            "AXIS" => Self::Axis,
            "FRAME" => Self::Frame,
            _ => return None,
        })
    }

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Int => "INT",
            Self::Real => "REAL",
            Self::Bool => "BOOL",
            Self::Char => "CHAR",
            Self::Text(_) => "STRING",
            Self::Axis => "AXIS",
            Self::Frame => "FRAME",
        }
    }

    /// Value of a variable before any assignment.
    pub(super) fn initial(self) -> Data {
        match self {
            Self::Int => Data::Int(0),
            Self::Real => Data::Real(0.0),
            Self::Bool => Data::Bool(false),
            Self::Char => Data::Char(0),
            Self::Text(_) => Data::Text(String::new()),
            Self::Axis => Data::Axis(String::new()),
            Self::Frame => Data::Frame(Box::default()),
        }
    }

    /// A value as this type holds it.
    pub(super) fn hold(self, value: Data) -> Result<Data, String> {
        let made = match (self, &value) {
            (Self::Frame, Data::Frame(_)) | (Self::Axis, Data::Axis(_)) => Some(value.clone()),
            (Self::Int, _) => value.number().map(|number| number.round() as i64).map(Data::Int),
            (Self::Real, _) => value.number().map(Data::Real),
            (Self::Bool, Data::Text(text)) => Some(Data::Bool(!text.is_empty())),
            (Self::Bool, _) => value.number().map(|number| Data::Bool(number != 0.0)),
            (Self::Char, Data::Text(text)) => match text.as_bytes() {
                [one] => Some(Data::Char(*one)),
                _ => None,
            },
            (Self::Char, _) => {
                value.number().map(f64::round).filter(|n| (0.0..256.0).contains(n)).map(|n| Data::Char(n as u8))
            }
            (Self::Text(longest), Data::Text(text)) => {
                Some(Data::Text(text.chars().take(usize::from(longest)).collect()))
            }
            (Self::Text(_), Data::Bool(_)) => Some(Data::Text(value.text())),
            (Self::Text(_), Data::Char(one)) => Some(Data::Text(char::from(*one).to_string())),
            _ => None,
        };
        match made {
            Some(Data::Int(number)) if number.abs() > MOST_INT => Err(format!("{number} is out of range for INT")),
            Some(made) => Ok(made),
            None => Err(format!("{} cannot be a value of {}", value.described(), self.name())),
        }
    }

    /// A value that comes from a macro or from data shared by channels.
    pub(super) fn taken_from(self, value: &MacroValue) -> Option<Data> {
        let data = match value {
            MacroValue::Real(number) => Data::Real(*number),
            MacroValue::Logical(truth) => Data::Bool(*truth),
            MacroValue::Text(text) if self == Self::Axis => Data::Axis(text.to_string()),
            MacroValue::Text(text) => Data::Text(text.to_string()),
            MacroValue::Sequence(numbers) => Data::Frame(Box::new(SiemensFrame::from_numbers(
                &numbers.iter().filter_map(MacroValue::as_real).collect::<Vec<_>>(),
            )?)),
            _ => return None,
        };
        if matches!(data, Data::Real(number) if !number.is_finite()) {
            return None;
        }
        self.hold(data).ok()
    }
}

impl Data {
    /// Number of a value that has one.
    pub(super) fn number(&self) -> Option<f64> {
        match self {
            Self::Int(value) => Some(*value as f64),
            Self::Real(value) => Some(*value),
            Self::Bool(value) => Some(f64::from(u8::from(*value))),
            Self::Char(value) => Some(f64::from(*value)),
            Self::Text(_) | Self::Axis(_) | Self::Frame(_) => None,
        }
    }

    /// Bytes that it holds besides itself.
    pub(super) fn bytes(&self) -> usize {
        match self {
            Self::Text(text) | Self::Axis(text) => text.len(),
            Self::Frame(_) => std::mem::size_of::<super::frame::SiemensFrame>(),
            _ => 0,
        }
    }

    /// As texts show it.
    pub(super) fn text(&self) -> String {
        match self {
            Self::Int(value) => value.to_string(),
            Self::Real(value) => shown(*value),
            Self::Bool(value) => if *value { "TRUE" } else { "FALSE" }.to_owned(),
            Self::Char(value) => char::from(*value).to_string(),
            Self::Text(text) | Self::Axis(text) => text.clone(),
            Self::Frame(frame) => frame.text(),
        }
    }

    /// As a word of a block has it: REAL with a point.
    pub(super) fn word(&self) -> String {
        match self {
            Self::Real(value) => {
                let text = shown(*value);
                if text.contains('.') { text } else { format!("{text}.") }
            }
            Self::Bool(value) => u8::from(*value).to_string(),
            Self::Text(text) => format!("\"{text}\""),
            _ => self.text(),
        }
    }

    /// For messages.
    pub(super) fn described(&self) -> String {
        match self {
            Self::Text(text) => format!("\"{text}\""),
            Self::Frame(_) => "a frame".to_owned(),
            Self::Axis(name) => format!("axis {name}"),
            _ => self.text(),
        }
    }

    /// For macros.
    pub(super) fn value(&self) -> MacroValue {
        match self {
            Self::Int(_) | Self::Real(_) | Self::Char(_) => MacroValue::Real(self.number().unwrap_or(0.0)),
            Self::Bool(truth) => MacroValue::Logical(*truth),
            Self::Text(text) | Self::Axis(text) => MacroValue::text(text.as_str()),
            Self::Frame(frame) => MacroValue::numbers(&frame.numbers()),
        }
    }
}

/// A number in decimal digits, at most nine after the point, without zeros at their end.
pub(super) fn shown(value: f64) -> String {
    few_decimals(value).unwrap_or_else(|| nine_decimals(value))
}

fn nine_decimals(value: f64) -> String {
    let text = format!("{value:.9}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// The same for a number with at most three decimals, as nearly all numbers have. Below 4,000,000 the decimals after
/// them are 0, because a number differs from its text by less than half a step of the ninth decimal.
fn few_decimals(value: f64) -> Option<String> {
    let thousandths = (value * 1000.0).round();
    if thousandths.abs() >= 4e9 || thousandths / 1000.0 != value {
        return None;
    }
    let (sign, count) = if thousandths < 0.0 { ("-", -thousandths as u64) } else { ("", thousandths as u64) };
    let (whole, rest) = (count / 1000, count % 1000);
    let mut text = [sign, &whole.to_string()].concat();
    if rest > 0 {
        text.push('.');
        text.push_str((1000 + rest).to_string().get(1..).unwrap_or_default());
        text.truncate(text.trim_end_matches('0').len());
    }
    Some(text)
}

/// Whether this is a number as written in a program.
pub(super) fn is_number(text: &str) -> bool {
    let digits = text.strip_prefix(['+', '-']).unwrap_or(text);
    let plain = digits.bytes().all(|byte| byte.is_ascii_digit() || byte == b'.');
    plain && digits.bytes().filter(|byte| *byte == b'.').count() < 2 && digits.bytes().any(|byte| byte.is_ascii_digit())
}

#[cfg(test)]
mod tests {
    use super::{few_decimals, nine_decimals, shown};

    #[test]
    fn both_ways_of_writing_a_number_agree() {
        for (value, text) in
            [(0.0, "0"), (-0.0, "0"), (5.0, "5"), (-0.001, "-0.001"), (12.5, "12.5"), (0.1 + 0.2, "0.3")]
        {
            assert_eq!(shown(value), text);
        }
        for step in (0..4_000_000_000_u64).step_by(1_234_567) {
            let value = step as f64 / 1000.0;
            for value in [value, -value] {
                assert_eq!(few_decimals(value), Some(nine_decimals(value)), "{value:?}");
            }
        }
        assert_eq!((few_decimals(0.000_5), few_decimals(4_000_000.0), few_decimals(f64::NAN)), (None, None, None));
    }
}
