//! Dimensions of values.

/// Dimension of a value: decides whether a switch between mm and inch scales the value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dimension {
    /// A number.
    None,
    /// Length.
    Length,
    /// Length in least increments: 0.001 mm or 0.0001 inch, which the factor of the row brings in.
    Increments,
    /// Degrees.
    Angle,
    /// Length per minute or per revolution.
    Feed,
    /// The same, in tenths of an inch where the program counts in inches.
    FeedTenths,
    /// m/min or ft/min.
    SurfaceSpeed,
    /// Seconds.
    Time,
}

impl Dimension {
    /// Dimension of a value that is given without the factor of its row.
    pub fn plain(self) -> Self {
        if self == Self::Increments { Self::Length } else { self }
    }
}
