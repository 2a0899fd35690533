//! Contours in the working plane: chamfers and roundings of corners, circles by radius, about a pole or tangent to the
//! previous element, points by polar coordinates, paths to and from a contour.
//!
//! Pure geometry for any dialect; the dialect defines the meaning of the words of its control. *Invariant:* a result
//! that does not exist is none, never a number that is not finite.

mod circle;
mod corner;
mod plane;
mod polar;
mod tangent;
mod ways;

pub use circle::{angle_between, pieces};
pub use corner::{CornerGeometry, arc, corner, line};
pub use plane::{Point, along, center_by_radius, direction, left, length, minus, times, touch, turn, turned};
pub use polar::{PolarPoint, towards};
pub use tangent::{Tangent, heading_on, tangent};
pub use ways::{ApproachPath, Departure, PathDimensions, PathShape, approach, depart};
