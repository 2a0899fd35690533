//! Contours in a plane and paths beside them.

pub mod area;
pub mod blend;
pub mod closed;
pub mod corner;
mod crossing;
pub mod element;
mod near;
pub mod shifted;
pub mod tangent;
