//! What codes of circles say by themselves.

use super::super::{CodeId, codes};

/// Words that tell a circle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum By {
    /// A radius if there is one, else a centre.
    #[default]
    Any,
    /// By the centre.
    Center,
    /// By the radius.
    Radius,
}

/// What a code of circles tells by itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Form {
    /// Direction, if the code has one.
    pub clockwise: Option<bool>,
    /// What gives the circle.
    pub by: By,
    /// A code of helices.
    pub helix: bool,
}

impl Form {
    /// The form of a code.
    pub fn of(id: CodeId) -> Option<Self> {
        let form = |clockwise, by, helix| Self { clockwise, by, helix };
        Some(match id {
            codes::INTERP_ARC_CLW => form(Some(true), By::Any, false),
            codes::INTERP_ARC_CCLW => form(Some(false), By::Any, false),
            codes::INTERP_HELIX_CLW => form(Some(true), By::Any, true),
            codes::INTERP_HELIX_CCLW => form(Some(false), By::Any, true),
            codes::INTERP_HELIX => form(None, By::Any, true),
            codes::INTERP_ARC_CENTER => form(None, By::Center, false),
            codes::INTERP_ARC_RADIUS => form(None, By::Radius, false),
            _ => return None,
        })
    }
}
