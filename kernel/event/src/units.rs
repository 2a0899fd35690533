//! Positions and their units.

/// Most axes one channel can command. Positions are arrays of this length in the axis order of the channel.
pub const MAX_AXES: usize = 8;

/// One position: values by axis index of the channel, in machine units (mm or inch, degrees), diameters on
/// diameter axes.
pub type Position = [f64; MAX_AXES];

/// Unit of length of a machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MachineUnit {
    /// Millimetres.
    Mm,
    /// Inches.
    Inch,
}

impl MachineUnit {
    /// `mm` or `inch`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Mm => "mm",
            Self::Inch => "inch",
        }
    }
}
