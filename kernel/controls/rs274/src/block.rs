//! The words of a block with their values, and the checks that the control makes before any part of the block acts.
//!
//! Facts: LinuxCNC documentation, "Modal groups", "Order of execution", the errors of each code; Grbl 1.1, list of
//! errors. *Invariant:* in a block that passes, a code uses each word.

use counterpoint_fault as diag;

use super::codes::{AxisUse, GCode, NO_MOTION, Rs274Kind, g_code, is_cycle, m_code, spelled};
use super::text::Rs274Mistake;
use counterpoint_control_api::words::Span;

/// Letters of axes.
pub(super) const AXES: &[u8] = b"xyzabcuvw";

/// Letters of GRBL other than G and M.
const GRBL_LETTERS: &[u8] = b"fijklnprstxyz";

/// Highest sequence number of GRBL.
const GRBL_NUMBERS: f64 = 10_000_000.0;

/// Highest tool number of GRBL.
const GRBL_TOOLS: f64 = 255.0;

/// A word with its value.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct BlockWord {
    pub(super) letter: u8,
    pub(super) value: f64,
    /// The number as the program writes it.
    pub(super) spelled: Option<Box<str>>,
    pub(super) span: Span,
}

/// The words of a block.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct BlockWords {
    /// Words other than G and M.
    pub(super) words: Vec<BlockWord>,
    /// G codes in tenths, with their places.
    pub(super) g: Vec<(u16, Span)>,
    pub(super) m: Vec<(u16, Span)>,
    /// The motion of the block, if anything moves.
    pub(super) motion: Option<u16>,
    pub(super) whole: Span,
}

/// Modes that affect the meaning of a block.
#[derive(Debug, Clone, Copy)]
pub(super) struct BlockModes {
    pub(super) kind: Rs274Kind,
    /// The active motion.
    pub(super) motion: u16,
    /// G93 is active.
    pub(super) inverse_time: bool,
    /// A feed is active.
    pub(super) has_feed: bool,
    /// Letter of the centre coordinate (I, J or K) perpendicular to the active plane.
    pub(super) off_plane: u8,
}

fn refused(error: u8, text: impl Into<String>) -> Rs274Mistake {
    Rs274Mistake::new(&diag::REFUSED, error, text)
}

impl BlockWords {
    /// Adds a word; GRBL and grblHAL check it before the other words of the block.
    pub(super) fn add(&mut self, word: BlockWord, kind: Rs274Kind) -> Result<(), Rs274Mistake> {
        if self.whole == Span::default() {
            self.whole = word.span;
        }
        if kind.is_firmware() {
            check_firmware(&word, kind)?;
        }
        match word.letter {
            b'g' => {
                let tenths = whole(word.value * 10.0).ok_or_else(|| unknown('G', word.value))?;
                self.g.push((tenths, word.span));
            }
            b'm' => {
                let code = whole(word.value).ok_or_else(|| unknown('M', word.value))?;
                self.m.push((code, word.span));
            }
            letter if self.has(letter) => {
                let name = char::from(letter.to_ascii_uppercase());
                return Err(refused(25, format!("{name} is written twice: remove one of them")));
            }
            _ => self.words.push(word),
        }
        Ok(())
    }

    pub(super) fn word(&self, letter: u8) -> Option<&BlockWord> {
        self.words.iter().find(|word| word.letter == letter)
    }

    pub(super) fn get(&self, letter: u8) -> Option<f64> {
        self.word(letter).map(|word| word.value)
    }

    pub(super) fn has(&self, letter: u8) -> bool {
        self.word(letter).is_some()
    }

    pub(super) fn has_g(&self, code: u16) -> bool {
        self.g.iter().any(|(known, _)| *known == code)
    }

    pub(super) fn has_m(&self, code: u16) -> bool {
        self.m.iter().any(|(known, _)| *known == code)
    }

    pub(super) fn has_axes(&self) -> bool {
        self.words.iter().any(|word| AXES.contains(&word.letter)) || self.has_polar()
    }

    pub(super) fn has_polar(&self) -> bool {
        self.has(b'@') || self.has(b'^')
    }

    fn has_offsets(&self) -> bool {
        self.has(b'i') || self.has(b'j') || self.has(b'k')
    }

    /// Refuses the blocks that the control refuses, and determines the motion of the block.
    pub(super) fn check(&mut self, modes: BlockModes) -> Result<(), Rs274Mistake> {
        let codes = self.codes(modes.kind)?;
        self.check_m(modes.kind)?;
        let taker = codes.iter().find(|code| matches!(code.axes, AxisUse::Takes | AxisUse::Needs));
        let explicit = codes.iter().find(|code| code.group == 1);
        let takes = taker.is_some() && self.has_axes();
        if let (Some(taker), Some(motion)) = (taker, explicit)
            && takes
            && motion.code != NO_MOTION
        {
            let text = format!("{} and {} both use the axis words", spelled(taker.code), spelled(motion.code));
            return Err(refused(24, format!("{text}: write them in two blocks")));
        }
        if self.has_polar() && (takes || self.has(b'x') || self.has(b'y')) {
            let other = if takes { "a code that is not a motion" } else { "X or Y" };
            return Err(refused(20, format!("polar words cannot be in one block with {other}: write two blocks")));
        }
        let implied = || (self.has_axes() || self.has_offsets() && matches!(modes.motion, 20 | 30)) && !takes;
        self.motion = match explicit {
            Some(motion) => Some(motion.code),
            None if taker.is_none() && implied() => Some(modes.motion),
            None => None,
        };
        if self.has_axes() && !takes && matches!(self.motion, None | Some(NO_MOTION)) {
            return Err(refused(31, "no motion is active that uses the axis words: write G0 or G1"));
        }
        for code in &codes {
            self.check_words(code)?;
        }
        if let Some(motion) = self.motion.filter(|motion| *motion != NO_MOTION) {
            self.check_motion(motion, modes, explicit.is_some())?;
        }
        self.check_unused(&codes, modes.kind)?;
        self.check_signs()
    }

    /// The G codes of the block. Refuses unknown codes and two codes of one group.
    fn codes(&self, kind: Rs274Kind) -> Result<Vec<&'static GCode>, Rs274Mistake> {
        let mut codes: Vec<&'static GCode> = Vec::with_capacity(self.g.len());
        let moves = |code: u16| code != NO_MOTION && g_code(code, kind).is_some_and(|facts| facts.group == 1);
        let has_motion = self.g.iter().any(|(code, _)| moves(*code));
        for (code, _) in &self.g {
            // LinuxCNC ignores G80 beside a motion.
            if *code == NO_MOTION && has_motion && !kind.is_firmware() {
                continue;
            }
            let Some(facts) = g_code(*code, kind) else {
                let text = format!("{} is not a code of this control", spelled(*code));
                return Err(Rs274Mistake::new(&diag::UNKNOWN_CODE, error_of_unknown(*code, kind), text));
            };
            // G53 may accompany a motion, G4 any code.
            let beside = |code: u16| matches!(code, 40 | 530);
            let same = |other: &&&GCode| {
                other.group == facts.group && !(facts.group == 0 && (beside(other.code) || beside(facts.code)))
            };
            if let Some(other) = codes.iter().find(same) {
                let text = format!("{} and {} belong to the same modal group", spelled(other.code), spelled(*code));
                return Err(refused(21, format!("{text}: write them in two blocks")));
            }
            codes.push(facts);
        }
        Ok(codes)
    }

    fn check_m(&self, kind: Rs274Kind) -> Result<(), Rs274Mistake> {
        let mut groups: Vec<u8> = Vec::new();
        for (code, _) in &self.m {
            let Some(facts) = m_code(*code, kind) else {
                let text = format!("M{code} is not a code of this control");
                return Err(Rs274Mistake::new(&diag::UNKNOWN_CODE, 20, text));
            };
            // Mist and flood coolant may be in the same block.
            if groups.contains(&facts.group) && facts.group != 8 {
                let text = format!("M{code} is of the same modal group as another M code: write them in two blocks");
                return Err(refused(21, text));
            }
            groups.push(facts.group);
            if let Some(missing) = facts.needs.bytes().find(|letter| !self.has(*letter)) {
                return Err(missing_word(&format!("M{code}"), missing));
            }
        }
        Ok(())
    }

    fn check_words(&self, code: &GCode) -> Result<(), Rs274Mistake> {
        let sticky = is_cycle(code.code);
        if let Some(missing) = code.needs.bytes().find(|letter| !self.has(*letter)).filter(|_| !sticky) {
            return Err(missing_word(&spelled(code.code), missing));
        }
        if matches!(code.axes, AxisUse::MotionNeeds | AxisUse::Needs) && !self.has_axes() {
            return Err(refused(26, format!("{} has no axis word", spelled(code.code))));
        }
        Ok(())
    }

    fn check_motion(&self, motion: u16, modes: BlockModes, explicit: bool) -> Result<(), Rs274Mistake> {
        let name = spelled(motion);
        if self.has_g(530) && !matches!(motion, 0 | 10) {
            return Err(refused(30, format!("G53 needs G0 or G1, but {name} is active")));
        }
        let firmware = modes.kind.is_firmware();
        let inverse = (modes.inverse_time || self.has_g(930)) && !self.has_g(940) && !self.has_g(950);
        let has_feed = self.get(b'f').map_or(modes.has_feed, |feed| feed != 0.0);
        let feeds = matches!(motion, 10 | 20 | 30) || firmware && motion != 0;
        if explicit && !self.has_axes() && feeds && !has_feed && !inverse {
            return Err(refused(22, format!("no feed rate is programmed for {name}")));
        }
        if matches!(motion, 20 | 30) && (explicit || self.has_axes() || self.has_offsets() || self.has(b'r')) {
            // A full circle of grblHAL needs no end point.
            if firmware && !self.has_axes() && (modes.kind == Rs274Kind::Grbl || self.has(b'r')) {
                return Err(refused(26, format!("{name} has no axis word")));
            }
            if !self.has_offsets() && !self.has(b'r') {
                return Err(refused(35, format!("{name} has neither a centre (I, J, K) nor a radius (R)")));
            }
            if self.has(b'r') && self.has_offsets() {
                return Err(refused(36, format!("{name} has a centre and a radius: remove one of them")));
            }
            let planes = [(170, b'k'), (180, b'j'), (190, b'i')];
            let own = planes.iter().find(|(code, _)| self.has_g(*code)).map_or(modes.off_plane, |(_, letter)| *letter);
            if !firmware && self.has(own) {
                let letter = char::from(own.to_ascii_uppercase());
                return Err(refused(20, format!("{letter} is not in the plane of {name}: remove it, even {letter}0")));
            }
        }
        let cuts = matches!(motion, 10 | 20 | 30) && (self.has_axes() || self.has_offsets() || explicit);
        if cuts && inverse && !self.has(b'f') && (self.has_axes() || self.has_offsets()) {
            return Err(refused(22, format!("{name} under G93 needs F in its block")));
        }
        let rotary = |word: &&BlockWord| matches!(word.letter, b'a' | b'b' | b'c');
        if is_cycle(motion)
            && let Some(word) = self.words.iter().find(rotary)
        {
            let letter = char::from(word.letter.to_ascii_uppercase());
            return Err(refused(20, format!("{name} takes no rotary axis {letter}: turn it in a block of its own")));
        }
        if matches!(motion, 330 | 331) && self.has(b'f') {
            return Err(refused(20, format!("{name} takes its feed from K: remove F")));
        }
        if inverse && is_cycle(motion) {
            return Err(refused(22, format!("{name} is not possible under G93: write G94 before it")));
        }
        Ok(())
    }

    fn check_unused(&self, codes: &[&'static GCode], kind: Rs274Kind) -> Result<(), Rs274Mistake> {
        let motion = self.motion.and_then(|motion| g_code(motion, kind));
        let of_codes =
            |letter| codes.iter().chain(&motion).any(|code| code.letters.bytes().any(|known| known == letter));
        let of_m = |letter: u8| {
            let mut facts = self.m.iter().filter_map(|(code, _)| m_code(*code, kind));
            facts.any(|facts| facts.letters.bytes().any(|known| known == letter))
        };
        for word in &self.words {
            let letter = word.letter;
            let always = matches!(letter, b'f' | b'n' | b's' | b't' | b'@' | b'^') || AXES.contains(&letter);
            if !always && !of_codes(letter) && !of_m(letter) {
                let name = char::from(letter.to_ascii_uppercase());
                return Err(refused(36, format!("{name} is not used by a code of the block: remove it")));
            }
        }
        Ok(())
    }

    fn check_signs(&self) -> Result<(), Rs274Mistake> {
        self.check_turns()?;
        let dwells = self.has_g(40);
        let negative = |word: &&BlockWord| {
            word.value < 0.0 && (matches!(word.letter, b'f' | b's' | b't') || word.letter == b'p' && dwells)
        };
        match self.words.iter().find(negative) {
            Some(word) => {
                let name = char::from(word.letter.to_ascii_uppercase());
                Err(refused(4, format!("{name} is negative: write a positive number")))
            }
            None => Ok(()),
        }
    }

    /// Checks P of a circle, and the words of M19.
    fn check_turns(&self) -> Result<(), Rs274Mistake> {
        if matches!(self.motion, Some(20 | 30))
            && let Some(turns) = self.get(b'p')
        {
            if self.has_g(40) {
                return Err(refused(20, "P would apply to G4 and to the circle: write two blocks"));
            }
            if whole(turns).is_none_or(|turns| turns == 0) {
                return Err(refused(23, "P of a circle, the number of turns, must be a whole number of at least 1"));
            }
        }
        if !self.has_m(19) {
            return Ok(());
        }
        if self.get(b'r').is_some_and(|angle| !(0.0..=360.0).contains(&angle)) {
            return Err(refused(20, "R of M19, the angle, must be 0 to 360"));
        }
        if self.get(b'p').is_some_and(|way| whole(way).is_none_or(|way| way > 2)) {
            return Err(refused(20, "P of M19, the direction of rotation, must be 0, 1 or 2"));
        }
        if self.get(b'q').is_some_and(|seconds| seconds <= 0.0) {
            return Err(refused(20, "Q of M19, the seconds to wait, must be above 0"));
        }
        Ok(())
    }
}

/// The error number for a G code that the control does not have. GRBL first reads the number before the point.
fn error_of_unknown(code: u16, kind: Rs274Kind) -> u8 {
    let known = !code.is_multiple_of(10) && g_code(code / 10 * 10, kind).is_some();
    let has_own = matches!(code / 10, 28 | 30 | 38 | 43 | 61 | 90 | 91 | 92);
    if kind == Rs274Kind::Grbl && known && !has_own { 23 } else { 20 }
}

/// Refuses words that GRBL or grblHAL refuses without regard to the rest of the block.
fn check_firmware(word: &BlockWord, kind: Rs274Kind) -> Result<(), Rs274Mistake> {
    let name = char::from(word.letter.to_ascii_uppercase());
    let known = match kind {
        Rs274Kind::GrblHal => word.letter.is_ascii_lowercase(),
        _ => matches!(word.letter, b'g' | b'm') || GRBL_LETTERS.contains(&word.letter),
    };
    if !word.letter.is_ascii_lowercase() {
        let text = format!("expected a letter, found '{name}'");
        return Err(Rs274Mistake::new(&diag::UNKNOWN_TEXT, 1, text));
    }
    if !known {
        let text = format!("{name} is not a word of this control: remove it");
        return Err(Rs274Mistake::new(&diag::UNKNOWN_TEXT, 20, text));
    }
    if matches!(word.letter, b'f' | b'n' | b'p' | b's' | b't') && word.value < 0.0 {
        return Err(refused(4, format!("{name} is negative: write a positive number")));
    }
    if word.letter == b'n' && word.value > GRBL_NUMBERS {
        return Err(refused(27, format!("{name} is at most {GRBL_NUMBERS}")));
    }
    if kind == Rs274Kind::Grbl && word.letter == b't' && word.value > GRBL_TOOLS {
        return Err(refused(38, format!("{name} is at most {GRBL_TOOLS}")));
    }
    Ok(())
}

fn missing_word(code: &str, letter: u8) -> Rs274Mistake {
    let name = char::from(letter.to_ascii_uppercase());
    refused(28, format!("{code} needs {name}: add the word"))
}

fn unknown(letter: char, value: f64) -> Rs274Mistake {
    Rs274Mistake::new(&diag::UNKNOWN_CODE, 23, format!("{letter}{value} is not a code of this control"))
}

/// The whole number that a value is close to.
pub(super) fn whole(value: f64) -> Option<u16> {
    let near = value.round();
    ((value - near).abs() < 0.001 && (0.0..=9999.0).contains(&near)).then_some(near as u16)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checked(text: &str, grbl: bool, motion: u16) -> Result<Option<u16>, u8> {
        let kind = if grbl { Rs274Kind::Grbl } else { Rs274Kind::LinuxCnc };
        let mut block = BlockWords::default();
        for word in text.split(' ') {
            let (letter, value) = word.split_at(1);
            let word =
                BlockWord { letter: letter.as_bytes()[0], value: value.parse().unwrap(), spelled: None, span: (0, 1) };
            block.add(word, kind).map_err(|mistake| mistake.error)?;
        }
        block
            .check(BlockModes { kind, motion, inverse_time: false, has_feed: true, off_plane: b'k' })
            .map_err(|mistake| mistake.error)?;
        Ok(block.motion)
    }

    #[test]
    fn errors_have_the_numbers_of_grbl() {
        for (text, error) in [
            ("g81 x1 z1 r2", 20),
            ("m6", 20),
            ("g0 x1 a1", 20),
            ("o1", 20),
            ("x1 x2 e1", 25),
            ("e1 g0 g1", 20),
            ("t256", 38),
            ("g10 l2 p-1 x0", 4),
            ("g59.1", 23),
            ("g1.5 x1", 23),
            ("g28.2", 20),
            ("g2", 26),
            ("g2 i1", 26),
            ("h1", 20),
            ("@1", 1),
            ("n-1 x1", 4),
            ("n10000001", 27),
            ("x1 n5 n6", 25),
            ("g0 g1", 21),
            ("g20 g21", 21),
            ("g0 g92 x1", 24),
            ("x1 x2", 25),
            ("g38.2", 26),
            ("g4", 28),
            ("g10 x1", 28),
            ("g53 g2 x1 i1", 30),
            ("g2 x1", 35),
            ("g1 x1 r2", 36),
        ] {
            assert_eq!(checked(text, true, 0), Err(error), "{text}");
        }
        assert_eq!(checked("x1", true, NO_MOTION), Err(31));
        for text in ["g33 z1 k1 f1", "m19 r361", "m19 p3", "m19 q0", "g4 p1 g2 x1 i1", "g2 x1 i1 k0", "g18 g3 x1 i1 j0"]
        {
            assert_eq!(checked(text, false, 0), Err(20), "{text}");
        }
        assert_eq!(checked("g2 x1 i1 p0", false, 0), Err(23));
        assert_eq!(checked("g92 x1", true, 10), Ok(None));
        assert_eq!(checked("g53 x1", true, 10), Ok(Some(10)));
        assert_eq!(checked("g80 g28", true, 10), Ok(Some(NO_MOTION)));
        assert_eq!(checked("g80 g0 z1", false, 10), Ok(Some(0)));
        assert_eq!(checked("g0 g80", true, 10), Err(21));
        assert_eq!(checked("g81 x1 z1 r2 a1", false, 10), Err(20));
        assert_eq!(checked("i1", false, 20), Ok(Some(20)));
        assert_eq!(checked("f100 s5 t1", false, 10), Ok(None));
    }
}
