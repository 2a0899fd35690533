//! Outside corners of compensated paths whose kind depends on the turn.
//!
//! Invariant: the angles are at most 150 degrees.

/// Limits of sharp and round outside corners.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CornerShape {
    /// Largest turn of a sharp corner, degrees.
    pub sharp: f64,
    /// Largest turn at which a corner of the round kind is sharp, degrees.
    pub flat: f64,
    /// Largest distortion of a round corner, percent.
    pub distortion: f64,
}
