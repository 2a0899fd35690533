//! Kinds of turning cycles.

/// A kind of turning cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TurningCycle {
    /// Runs the blocks of a contour once (Fanuc G70).
    Finish,
    /// Roughs a contour level by level (G71), along X where `face` (G72).
    Rough {
        /// The cut runs along X.
        face: bool,
    },
    /// Runs along a contour several times, each time nearer (G73).
    Pattern,
    /// Pecks column by column along Z (G74), along X where `along_x` (G75).
    Peck {
        /// The pecks are along X.
        along_x: bool,
    },
    /// One cut and back (G90), along X where `face` (G94).
    Single {
        /// The cut runs along X.
        face: bool,
    },
    /// Along a contour with a name (Okuma LAP).
    Lap(LapCycle),
}

/// A cycle along a contour with a name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LapCycle {
    /// Level by level (G85).
    Bar,
    /// Along the whole contour, each time nearer (G86).
    Copy,
    /// Once (G87).
    Finish,
    /// A thread (G88).
    Thread,
}
