//! Contours in a plane and paths beside them.

pub mod area;
pub mod blend;
pub mod closed;
pub mod corner;
pub mod element;
pub mod shifted;
pub mod tangent;
