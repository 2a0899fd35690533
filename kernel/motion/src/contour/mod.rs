//! Contours in a plane and paths beside them.

pub mod area;
pub mod blend;
pub mod clearing;
pub mod closed;
pub mod combine;
pub mod corner;
mod crossing;
pub mod element;
pub mod heights;
mod meet;
mod near;
pub mod reach;
pub mod shifted;
pub mod tangent;
pub mod trochoid;
