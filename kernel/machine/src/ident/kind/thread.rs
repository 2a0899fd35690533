//! Kinds of threads and threading cycles, and settings of the cycles.

use super::super::{CodeId, codes};

/// What a code says about the change of the lead.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Change {
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
pub struct Kind {
    /// The cycle makes several passes.
    pub multi: bool,
    /// Along X instead of Z.
    pub face: bool,
}

impl Kind {
    /// The kind of a code.
    pub fn of(id: CodeId) -> Option<Self> {
        let kind = |multi, face| Self { multi, face };
        Some(match id {
            codes::THREAD_SINGLE => kind(false, false),
            codes::THREAD_SINGLE_FACE => kind(false, true),
            codes::THREAD_MULTI => kind(true, false),
            codes::THREAD_MULTI_FACE => kind(true, true),
            _ => return None,
        })
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
pub enum Setting {
    /// The chamfer at the end of the thread is on or off.
    Chamfer(bool),
    /// In-feed along one edge, or along both in turn.
    Zigzag(bool),
    /// The same step each pass instead of the same amount.
    Depth(bool),
}

impl Setting {
    /// The setting of a code.
    pub fn of(id: CodeId) -> Option<Self> {
        Some(match id {
            codes::THREAD_CHAMFER_ON => Self::Chamfer(true),
            codes::THREAD_CHAMFER_OFF => Self::Chamfer(false),
            codes::THREAD_EDGE_SINGLE => Self::Zigzag(false),
            codes::THREAD_EDGE_ZIGZAG => Self::Zigzag(true),
            codes::THREAD_STEP_AMOUNT => Self::Depth(false),
            codes::THREAD_STEP_DEPTH => Self::Depth(true),
            _ => return None,
        })
    }
}
