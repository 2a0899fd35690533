//! The settings of lathe auto-programming (Okuma LAP) for a rough cycle besides the common ones.
//!
//! *Invariant:* all lengths are positions or amounts of the plane; the direction of the cut gives amounts their signs.

/// From a place on, levels have another depth, and their number of feed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthChange {
    /// The first level that begins here or deeper: a place across the cut.
    pub from: f64,
    /// Depth, above 0; none for that of before.
    pub depth: Option<f64>,
}

/// How a rough cycle works that is one of LAP.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LapSettings {
    /// The cycle goes along the whole contour, each time nearer, and not level by level.
    pub copies: bool,
    /// Changes of depth and feed.
    pub changes: [Option<DepthChange>; 2],
    /// The tool stays at the end of the contour.
    pub stays: bool,
}
