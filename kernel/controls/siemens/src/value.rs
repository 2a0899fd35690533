//! Values of the control and their types.
//!
//! Facts: reference control-emulator.md 5.4; the control's types INT REAL BOOL CHAR STRING AXIS FRAME. Invariant: a
//! REAL is finite, an INT fits into 32 bits once it is stored.

use counterpoint_lang::value::MacroValue;

use super::frame::SiemensFrame;
use super::number_text::shown;

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
