//! A part of a frame, by its name in an index.

/// A part of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FrameComponent {
    Translation,
    Fine,
    Rotation,
    Scale,
    Mirror,
}

impl FrameComponent {
    /// By its name in an index.
    pub(super) fn named(name: &str) -> Option<Self> {
        Some(match name {
            "TR" => Self::Translation,
            "FI" => Self::Fine,
            "RT" => Self::Rotation,
            "SC" => Self::Scale,
            "MI" => Self::Mirror,
            _ => return None,
        })
    }
}
