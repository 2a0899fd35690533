//! A path whose time is requested, and the factor by which a rate may exceed its limit.
//!
//! *Invariant:* plain data.

use counterpoint_event::event::Position;
use counterpoint_motion::arc::PlaneArc;

/// Rates with a smaller difference are equal: a rapid move has exactly the rate.
pub(crate) const EVEN: f64 = 1.0 + 1e-6;

/// A path whose time is requested.
pub(crate) struct TimedPath<'a> {
    pub(crate) from: &'a Position,
    pub(crate) to: &'a Position,
    /// Length that the feed applies to, geometry units.
    pub(crate) length: f64,
    /// Arc and index of its radial coordinate (0, 1), when it is one and X is in its plane.
    pub(crate) arc: Option<(&'a PlaneArc, Option<usize>)>,
}
