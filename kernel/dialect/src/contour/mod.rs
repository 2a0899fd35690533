//! Contours in the working plane: corners, circles by radius or about a pole, ways to and from a contour.
//!
//! Pure geometry for any dialect: what the words of a control mean is the dialect's. *Invariant:* what does not exist is
//! none, never a number that is not finite.

mod circle;
mod corner;
mod plane;
mod ways;

pub(super) use circle::{angle_between, pieces};
pub(super) use corner::{Corner, corner};
pub(super) use plane::{Point, along, center_by_radius, direction, left, minus, times, turned};
pub(super) use ways::{Approach, Departure, Side, Way, approach, depart};
