//! The kinds of cycles and how they differ.
//!
//! Invariant: a kind is its number in `$CYTYPE` (reference system-variables.md 8), 1 to 19.

/// A kind of drilling cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct HoleCycle(u8);

/// How the depth is reached.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PeckStyle {
    /// In one go.
    None,
    /// Back to the clearance height after each step.
    Full,
    /// A little back after each step.
    Small,
}

/// How the tool comes out of the hole.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Out {
    /// At rapid.
    Rapid,
    /// At feed.
    Feed,
    /// At feed with the spindle reversed.
    Reversed,
    /// At rapid with the spindle stopped.
    Stopped,
    /// At rapid beside the centre, with the spindle oriented.
    Oriented,
}

impl HoleCycle {
    /// The cycle of a number, 1 to 19.
    pub const fn new(number: u8) -> Self {
        Self(number)
    }

    /// The kind of a number in `$CYTYPE`.
    pub fn numbered(number: f64) -> Option<Self> {
        (1..=19_u8).find(|&kind| f64::from(kind) == number).map(Self)
    }

    /// Its number in `$CYTYPE`.
    pub fn number(self) -> f64 {
        f64::from(self.0)
    }

    /// The kind under rigid tapping: a tap becomes a rigid one, with steps one that breaks chips.
    pub fn rigid(self, steps: bool) -> Self {
        match (self.0, steps) {
            (3, false) => Self(14),
            (4, false) => Self(15),
            (3 | 14, true) => Self(18),
            (4 | 15, true) => Self(19),
            _ => self,
        }
    }

    /// How the depth is reached.
    pub fn steps(self) -> PeckStyle {
        match self.0 {
            11 | 16 | 17 => PeckStyle::Full,
            12 | 18 | 19 => PeckStyle::Small,
            _ => PeckStyle::None,
        }
    }

    /// How the tool comes out of the hole.
    pub fn out(self) -> Out {
        match self.0 {
            3 | 4 | 14..=19 => Out::Reversed,
            5 | 6 => Out::Stopped,
            7 | 8 => Out::Oriented,
            9 | 10 => Out::Feed,
            _ => Out::Rapid,
        }
    }

    /// Feeds upwards from below.
    pub fn bores_back(self) -> bool {
        self.0 == 8
    }

    /// A tap of this type: 0 floating, 1 rigid, 2 deep, 3 breaking chips; none for another type.
    pub fn tap(self, kind: f64) -> Option<Self> {
        let left = u8::from(self.direction() == 2.0);
        let base = [3, 14, 16, 18].into_iter().zip(0_u8..).find(|(_, number)| f64::from(*number) == kind)?.0;
        Some(Self(base + left))
    }

    /// Goes through several webs.
    pub fn has_webs(self) -> bool {
        self.0 == 13
    }

    /// Taps.
    pub fn taps(self) -> bool {
        self.out() == Out::Reversed
    }

    /// A rigid tap.
    pub fn is_rigid(self) -> bool {
        self.0 >= 14
    }

    /// Dwells at depth.
    pub fn dwells(self) -> bool {
        !matches!(self.0, 1 | 5 | 9)
    }

    /// `$CYDIR`: in-feed of a tap clockwise 1, counter-clockwise 2.
    pub fn direction(self) -> f64 {
        match self.0 {
            3 | 14 | 16 | 18 => 1.0,
            4 | 15 | 17 | 19 => 2.0,
            _ => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_are_their_numbers() {
        use super::super::super::codes;
        use super::super::CodeKind;
        assert_eq!(codes::CYCLE_DRILL.kind(), CodeKind::Cycle(HoleCycle(1)));
        assert_eq!(codes::CYCLE_RIGID_BRKCHP_CCLW.kind(), CodeKind::Cycle(HoleCycle(19)));
        assert_eq!(codes::CYCLE_OFF.kind(), CodeKind::Plain);
        assert_eq!([0.0, 20.0, 100.0, -2.0, 1.5, f64::NAN].map(HoleCycle::numbered), [None; 6]);
        assert_eq!(HoleCycle::numbered(11.0).map(HoleCycle::steps), Some(PeckStyle::Full));
    }

    #[test]
    fn a_tap_under_rigid_tapping() {
        let rigid = |number: f64, steps| HoleCycle::numbered(number).map(|kind| kind.rigid(steps).number());
        assert_eq!([rigid(3.0, false), rigid(4.0, false), rigid(3.0, true)], [Some(14.0), Some(15.0), Some(18.0)]);
        assert_eq!([rigid(1.0, false), rigid(16.0, true)], [Some(1.0), Some(16.0)]);
    }

    #[test]
    fn types_of_taps() {
        let tap =
            |number: f64, kind: f64| HoleCycle::numbered(number).and_then(|one| one.tap(kind)).map(HoleCycle::number);
        assert_eq!([tap(3.0, 0.0), tap(4.0, 1.0), tap(14.0, 2.0), tap(19.0, 3.0)], [3.0, 15.0, 16.0, 19.0].map(Some));
        assert_eq!([tap(3.0, 4.0), tap(3.0, -1.0), tap(3.0, f64::NAN), tap(3.0, 0.5)], [None; 4]);
    }
}
