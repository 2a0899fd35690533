//! The chucks of two spindles that transfer parts: open or closed, and the piece in them.
//!
//! *Invariant:* a piece is in both chucks (`joined`) from the closing of the sub-chuck on it until the piece is cut off
//! or leaves one of the chucks.

/// Kind of a piece in a chuck.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WorkPiece {
    /// A bar: it stays in the spindle while the chuck is open.
    Bar,
    /// A part, or the remnant of one.
    Part,
}

/// A chuck.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Chuck {
    /// The chuck is open.
    pub open: bool,
    /// The piece in it.
    pub piece: Option<WorkPiece>,
}

/// The chucks of the main spindle and of the sub-spindle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChuckPair {
    /// Chuck of the main spindle.
    pub main: Chuck,
    /// Chuck of the sub-spindle.
    pub sub: Chuck,
    /// The same piece is in both.
    pub joined: bool,
    /// The sub-spindle is away from its home position, so that its chuck can meet the part.
    pub away: bool,
    /// Distance that the sub-spindle has moved while both chucks were closed on the piece, geometry units.
    pub relief: f64,
}

/// The effect of an opened or closed chuck on the piece.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ChuckEffect {
    /// Nothing happens to the piece.
    None,
    /// Both chucks hold the piece.
    Joined,
    /// The part leaves the chuck.
    Released,
}

impl ChuckPair {
    /// A chuck.
    #[must_use]
    pub fn chuck(&self, sub: bool) -> Chuck {
        if sub { self.sub } else { self.main }
    }

    /// Whether this chuck would close on the piece in the main spindle.
    #[must_use]
    pub fn would_join(&self, sub: bool) -> bool {
        sub && self.away && self.sub.open && self.sub.piece.is_none() && self.main.piece.is_some() && !self.joined
    }

    /// Whether both chucks would hold the same piece after this one closes.
    #[must_use]
    pub fn would_hold_twice(&self, sub: bool) -> bool {
        self.would_join(sub) || self.joined && self.chuck(sub).open && !self.chuck(!sub).open
    }

    /// Whether both chucks are closed on the same piece.
    #[must_use]
    pub fn hold_twice(&self) -> bool {
        self.joined && !self.main.open && !self.sub.open
    }

    /// Closes a chuck; a closed chuck does not change. An empty main chuck closes on a newly loaded part.
    pub fn close(&mut self, sub: bool) -> ChuckEffect {
        let joins = self.would_join(sub);
        if self.would_hold_twice(sub) {
            self.relief = 0.0;
        }
        if sub {
            self.sub.open = false;
        } else {
            self.main.open = false;
            self.main.piece = self.main.piece.or(Some(WorkPiece::Part));
        }
        if !joins {
            return ChuckEffect::None;
        }
        self.sub.piece = self.main.piece;
        self.joined = true;
        ChuckEffect::Joined
    }

    /// Whether no chuck would hold the common piece after this one opens.
    #[must_use]
    pub fn would_drop(&self, sub: bool) -> bool {
        self.joined && !self.chuck(sub).open && self.chuck(!sub).open
    }

    /// Opens a chuck. A piece in both chucks leaves the sub-chuck when that chuck opens.
    pub fn open(&mut self, sub: bool) -> ChuckEffect {
        let joined = self.joined;
        let own = if sub { &mut self.sub } else { &mut self.main };
        own.open = true;
        if joined && sub {
            (self.joined, self.sub.piece) = (false, None);
        } else if !joined && own.piece == Some(WorkPiece::Part) {
            own.piece = None;
            return ChuckEffect::Released;
        }
        ChuckEffect::None
    }

    /// Cuts the part off if both closed chucks hold it. Returns whether the part was cut off.
    pub fn cut_off(&mut self) -> bool {
        let cuts = self.joined && !self.main.open && !self.sub.open;
        if cuts {
            self.joined = false;
            self.sub.piece = Some(WorkPiece::Part);
        }
        cuts
    }

    /// Takes a part out of the open main chuck with the sub-spindle. Returns whether it did: a bar is only pulled.
    pub fn take_out(&mut self) -> bool {
        let takes = self.joined && self.main.open && !self.sub.open && self.main.piece == Some(WorkPiece::Part);
        if takes {
            self.joined = false;
            self.main.piece = None;
        }
        takes
    }
}
