//! Kinds of threads and threading cycles, and settings of the cycles.

/// The data of a code about the change of the lead.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LeadChange {
    /// There is none.
    None,
    /// There may be one, by its sign.
    May,
    /// By its sign.
    Signed,
    /// The lead grows.
    Up,
    /// The lead falls.
    Down,
}

/// A kind of threading cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ThreadCycle {
    /// All passes of a thread, not one.
    pub multi: bool,
    /// Along X instead of Z.
    pub face: bool,
}

impl ThreadCycle {
    /// A cycle of one pass or of all, along Z or X.
    pub const fn new(multi: bool, face: bool) -> Self {
        Self { multi, face }
    }

    /// `$THTYPE`
    pub fn number(self) -> f64 {
        match (self.multi, self.face) {
            (false, false) => 101.0,
            (false, true) => 102.0,
            (true, false) => 201.0,
            (true, true) => 202.0,
        }
    }
}

/// A setting of cycles to come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ThreadCycleSetting {
    /// With a chamfer at the end.
    Chamfer(bool),
    /// In-feed along one edge, or along both in turn.
    Zigzag(bool),
    /// The same step each pass instead of the same amount.
    Depth(bool),
}
