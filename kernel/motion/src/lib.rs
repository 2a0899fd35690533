//! Geometry and time of machine motion. Knows no programs, macros or channels. All lengths are in one unit of the
//! caller's choice, times in seconds, angles in radians unless a name says otherwise.
