//! Geometry and time of machine motion. Knows no programs, macros or channels. Lengths are in one unit of the
//! caller's choice, times in seconds, angles in radians unless a name says otherwise.
//!
//! Facts: reference channel-synchronisation.md 3 (time model) and control-emulator.md 6.1 (arc rules).

pub mod arc;
pub mod contour;
pub mod direction;
pub mod driven_speed;
pub mod frame;
pub mod law;
pub mod lettering;
pub mod lookahead;
pub mod profile;
pub mod space;
pub mod surface_speed;
pub mod thread;
pub mod turning;
