//! Properties that codes of circles determine by themselves.

/// Words that define a circle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ArcDefinition {
    /// A radius if there is one, otherwise a centre.
    #[default]
    Any,
    /// A centre.
    Center,
    /// A radius.
    Radius,
}

/// A property that a code of circles determines by itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ArcForm {
    /// Direction, if the code has one.
    pub clockwise: Option<bool>,
    /// Words that describe the circle.
    pub by: ArcDefinition,
    /// A code of helices.
    pub helix: bool,
}

impl ArcForm {
    /// A form.
    pub const fn new(clockwise: Option<bool>, by: ArcDefinition, helix: bool) -> Self {
        Self { clockwise, by, helix }
    }
}
