//! Subjects of coolant codes.

use counterpoint_event::event::Outlet;

/// Device that a coolant code switches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CoolantTarget {
    /// Coolant of the main or the side head.
    Fluid(CoolantFluid, Outlet),
    /// An auxiliary device.
    Device(u8, bool),
    /// The pressure that a word gives.
    Pressure,
    /// A pressure of the machine's list.
    Level(u8),
}

/// The fluid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CoolantFluid {
    /// Nothing.
    Off,
    /// The last fluid.
    Again,
    /// By the numbers of `$COOLTYP`.
    Fluid(u8),
}
