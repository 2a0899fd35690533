//! Q parameters: their kinds, names and values.

use std::sync::Arc;

/// Kind of a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) enum ParameterKind {
    Q,
    Local,
    Kept,
    Text,
}

impl ParameterKind {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Q => "Q",
            Self::Local => "QL",
            Self::Kept => "QR",
            Self::Text => "QS",
        }
    }

    /// Largest index.
    pub(super) fn last(self) -> u32 {
        match self {
            Self::Q | Self::Text => 1999,
            Self::Local | Self::Kept => 499,
        }
    }
}

/// A parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) struct QParameter {
    pub(super) kind: ParameterKind,
    pub(super) index: u32,
}

impl std::fmt::Display for QParameter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}{}", self.kind.name(), self.index)
    }
}

/// A value.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum ParameterValue {
    Number(f64),
    Text(Arc<str>),
}

impl Default for ParameterValue {
    fn default() -> Self {
        Self::Number(0.0)
    }
}
