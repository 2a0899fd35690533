//! The G and M codes of these controls: their modal groups, their use of axis words, and the letters they take.
//!
//! Facts: LinuxCNC documentation, "Modal groups" and the pages of the codes; Grbl 1.1, README and list of errors.
//! *Invariant:* G codes are in tenths: 382 is G38.2.

/// Motion code that represents no active motion.
pub(super) const NO_MOTION: u16 = 800;

/// The control whose words the interpreter accepts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Rs274Kind {
    LinuxCnc,
    /// GRBL 1.1: no parameters, expressions or O codes.
    Grbl,
    /// grblHAL: the language of LinuxCNC with part of its words, and the error numbers of GRBL.
    GrblHal,
}

impl Rs274Kind {
    /// Whether mistakes have the error numbers of GRBL, and the rules that GRBL and grblHAL share apply.
    pub(super) fn is_firmware(self) -> bool {
        self != Self::LinuxCnc
    }

    /// Whether the control has parameters, expressions and O codes.
    pub(super) fn has_language(self) -> bool {
        self != Self::Grbl
    }

    fn has_g(self, facts: &GCode) -> bool {
        match self {
            Self::LinuxCnc => true,
            Self::Grbl => facts.grbl,
            Self::GrblHal => !NOT_OF_GRBLHAL.contains(&facts.code),
        }
    }
}

/// G codes of LinuxCNC that grblHAL does not have on a router: NURBS, cutter compensation, and words of lathes and of
/// spindles with an encoder.
const NOT_OF_GRBLHAL: &[u16] =
    &[52, 53, 70, 80, 330, 331, 410, 411, 420, 421, 520, 611, 640, 740, 760, 840, 901, 922, 923, 950, 960, 970];

/// How a code uses axis words.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum AxisUse {
    None,
    /// A motion that may have axis words.
    Motion,
    /// A motion that needs axis words.
    MotionNeeds,
    /// Not a motion; takes the axis words, so the active motion does not use them.
    Takes,
    /// Like `Takes`, but needs axis words.
    Needs,
}

/// A G code.
#[derive(Debug)]
pub(super) struct GCode {
    pub(super) code: u16,
    pub(super) group: u8,
    pub(super) axes: AxisUse,
    /// Letters that it takes besides those of axes.
    pub(super) letters: &'static str,
    /// Letters that it needs.
    pub(super) needs: &'static str,
    /// Grbl 1.1 has this code.
    pub(super) grbl: bool,
}

const fn g(code: u16, group: u8, axes: AxisUse, letters: &'static str, needs: &'static str, grbl: bool) -> GCode {
    GCode { code, group, axes, letters, needs, grbl }
}

use AxisUse::{Motion, MotionNeeds, Needs, None as NoAxes, Takes};

/// All G codes.
static G_CODES: &[GCode] = &[
    g(0, 1, Motion, "", "", true),
    g(10, 1, Motion, "", "", true),
    g(20, 1, Motion, "ijkrp", "", true),
    g(30, 1, Motion, "ijkrp", "", true),
    g(40, 0, NoAxes, "p", "p", true),
    g(50, 1, MotionNeeds, "ijpq", "pq", false),
    g(51, 1, MotionNeeds, "ij", "", false),
    g(52, 1, Motion, "pl", "", false),
    g(53, 1, NoAxes, "", "", false),
    g(70, 15, NoAxes, "", "", false),
    g(80, 15, NoAxes, "", "", false),
    g(100, 0, Takes, "lprijq", "l", true),
    g(170, 2, NoAxes, "", "", true),
    g(180, 2, NoAxes, "", "", true),
    g(190, 2, NoAxes, "", "", true),
    g(200, 6, NoAxes, "", "", true),
    g(210, 6, NoAxes, "", "", true),
    g(280, 0, Takes, "", "", true),
    g(281, 0, NoAxes, "", "", true),
    g(300, 0, Takes, "", "", true),
    g(301, 0, NoAxes, "", "", true),
    g(330, 1, MotionNeeds, "k$", "k", false),
    g(331, 1, MotionNeeds, "ki$", "k", false),
    g(382, 1, MotionNeeds, "", "", true),
    g(383, 1, MotionNeeds, "", "", true),
    g(384, 1, MotionNeeds, "", "", true),
    g(385, 1, MotionNeeds, "", "", true),
    g(400, 7, NoAxes, "", "", true),
    g(410, 7, NoAxes, "d", "", false),
    g(411, 7, NoAxes, "dl", "d", false),
    g(420, 7, NoAxes, "d", "", false),
    g(421, 7, NoAxes, "dl", "d", false),
    g(430, 8, NoAxes, "h", "", false),
    g(431, 8, Needs, "", "", true),
    g(432, 8, Takes, "h", "", false),
    g(490, 8, NoAxes, "", "", true),
    g(520, 0, Needs, "", "", false),
    g(530, 0, NoAxes, "", "", true),
    g(540, 12, NoAxes, "", "", true),
    g(550, 12, NoAxes, "", "", true),
    g(560, 12, NoAxes, "", "", true),
    g(570, 12, NoAxes, "", "", true),
    g(580, 12, NoAxes, "", "", true),
    g(590, 12, NoAxes, "", "", true),
    g(591, 12, NoAxes, "", "", false),
    g(592, 12, NoAxes, "", "", false),
    g(593, 12, NoAxes, "", "", false),
    g(610, 13, NoAxes, "", "", true),
    g(611, 13, NoAxes, "", "", false),
    g(640, 13, NoAxes, "pq", "", false),
    g(730, 1, MotionNeeds, "rlqd", "rq", false),
    g(740, 1, MotionNeeds, "rlp$", "r", false),
    g(760, 1, MotionNeeds, "pijkrqhel$", "pijk", false),
    g(800, 1, NoAxes, "", "", true),
    g(810, 1, MotionNeeds, "rl", "r", false),
    g(820, 1, MotionNeeds, "rlp", "rp", false),
    g(830, 1, MotionNeeds, "rlqd", "rq", false),
    g(840, 1, MotionNeeds, "rlp$", "r", false),
    g(850, 1, MotionNeeds, "rl", "r", false),
    g(860, 1, MotionNeeds, "rlp$", "rp", false),
    g(890, 1, MotionNeeds, "rlp", "rp", false),
    g(900, 3, NoAxes, "", "", true),
    g(901, 4, NoAxes, "", "", false),
    g(910, 3, NoAxes, "", "", true),
    g(911, 4, NoAxes, "", "", true),
    g(920, 0, Needs, "", "", true),
    g(921, 0, NoAxes, "", "", true),
    g(922, 0, NoAxes, "", "", false),
    g(923, 0, NoAxes, "", "", false),
    g(930, 5, NoAxes, "", "", true),
    g(940, 5, NoAxes, "", "", true),
    g(950, 5, NoAxes, "", "", false),
    g(960, 14, NoAxes, "d$", "s", false),
    g(970, 14, NoAxes, "$", "", false),
    g(980, 10, NoAxes, "", "", false),
    g(990, 10, NoAxes, "", "", false),
];

/// A G code, if the control has it.
pub(super) fn g_code(code: u16, kind: Rs274Kind) -> Option<&'static GCode> {
    let at = G_CODES.binary_search_by_key(&code, |facts| facts.code).ok()?;
    G_CODES.get(at).filter(|facts| kind.has_g(facts))
}

/// Whether a motion is a canned cycle.
pub(super) fn is_cycle(motion: u16) -> bool {
    matches!(motion, 730 | 740 | 810..=890)
}

/// The G code as programs write it.
pub(super) fn spelled(code: u16) -> String {
    if code.is_multiple_of(10) { format!("G{}", code / 10) } else { format!("G{}.{}", code / 10, code % 10) }
}

/// An M code: its group, the letters it takes, and the letters it needs.
pub(super) struct MCode {
    pub(super) group: u8,
    pub(super) letters: &'static str,
    pub(super) needs: &'static str,
}

/// An M code, if the control has it.
pub(super) fn m_code(code: u16, kind: Rs274Kind) -> Option<MCode> {
    let facts = |group, letters, needs| Some(MCode { group, letters, needs });
    match code {
        0 | 1 | 2 | 30 => facts(4, "", ""),
        3..=5 => facts(7, "$", ""),
        7 | 8 => facts(8, "", ""),
        9 => facts(12, "", ""),
        _ if kind == Rs274Kind::Grbl => None,
        19 | 98 | 100..=199 if kind == Rs274Kind::GrblHal => None,
        60 => facts(4, "", ""),
        6 => facts(6, "", ""),
        19 => facts(7, "rqp$", ""),
        48 | 49 => facts(9, "", ""),
        50..=53 => facts(9, "p$", ""),
        61 => facts(6, "q", "q"),
        62..=65 => facts(5, "p", "p"),
        66 => facts(5, "pelq", ""),
        67 | 68 => facts(5, "eq", "eq"),
        70..=73 => facts(11, "", ""),
        98 => facts(4, "pl", "p"),
        99 => facts(4, "", ""),
        100..=199 => facts(10, "pq", ""),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_in_order() {
        assert!(G_CODES.is_sorted_by_key(|facts| facts.code));
        assert_eq!((spelled(382), spelled(10)), ("G38.2".to_owned(), "G1".to_owned()));
        let [linuxcnc, grbl, grblhal] = [Rs274Kind::LinuxCnc, Rs274Kind::Grbl, Rs274Kind::GrblHal];
        assert!(g_code(810, grbl).is_none() && g_code(810, linuxcnc).is_some() && g_code(810, grblhal).is_some());
        assert!(g_code(410, grblhal).is_none() && g_code(591, grblhal).is_some());
        assert!(m_code(19, grblhal).is_none() && m_code(6, grblhal).is_some() && m_code(6, grbl).is_none());
        assert!(NOT_OF_GRBLHAL.iter().all(|code| g_code(*code, linuxcnc).is_some()));
    }
}
