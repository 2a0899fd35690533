//! Words of Mitsubishi and Citizen at which systems line up: `!2L1`, `!12L1`, `!1!2L1`, `!L1`, `!2`.
//!
//! Facts: reference channel-synchronisation.md 1.6. Decision: a number without L is the list of systems, and the label
//! 0, when the machine has each of them; otherwise it is the label. *Invariant:* one pass over the text finds the same
//! as the scanner.

/// A word at which systems line up, as written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LineUp {
    /// The first list of systems read as a number; none without any digit.
    number: Option<u32>,
    /// Systems, bit `n − 1` for system `n`; bit 31 for a system 0.
    systems: u32,
    /// Label after L.
    label: Option<u32>,
}

impl LineUp {
    /// The word that begins at `at`, and where it ends.
    #[must_use]
    pub fn parse(line: &[u8], at: usize, mark: u8) -> Option<(Self, usize)> {
        let mut found = Self::default();
        let mut end = at;
        while line.get(end) == Some(&mark) {
            let (digits, next) = number(line, end + 1);
            for byte in line.get(end + 1..next).unwrap_or_default() {
                found.systems |= 1 << u32::from(byte.wrapping_sub(b'1')).min(31);
            }
            found.number = found.number.or(digits);
            end = next;
            let blanks = line.get(end..)?.iter().take_while(|byte| **byte == b' ').count();
            if matches!(line.get(end + blanks), Some(byte) if *byte == mark || byte.eq_ignore_ascii_case(&b'L')) {
                end += blanks;
            }
        }
        if matches!(line.get(end), Some(b'L' | b'l')) {
            let (label, next) = number(line, end + 1);
            found.label = Some(label?);
            end = next;
        }
        (found.number.is_some() || found.label.is_some()).then_some((found, end))
    }

    /// Systems of the list, bit `n − 1` for system `n`, and the label, on a machine with these systems.
    #[must_use]
    pub fn resolve(self, all: u32) -> (u32, u32) {
        match (self.label, self.number) {
            (Some(label), _) => (self.systems, label),
            (None, Some(number)) if self.systems & !all != 0 => (0, number),
            (None, _) => (self.systems, 0),
        }
    }
}

/// Digits from a place on as a number, and where they end.
fn number(line: &[u8], at: usize) -> (Option<u32>, usize) {
    let rest = line.get(at..).unwrap_or_default();
    let digits = rest.iter().take_while(|byte| byte.is_ascii_digit()).count();
    let text = std::str::from_utf8(rest.get(..digits).unwrap_or_default()).unwrap_or_default();
    (text.parse().ok(), at + digits)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_spelling() {
        let read = |text: &str| LineUp::parse(text.as_bytes(), 0, b'!').map(|(word, end)| (word.resolve(0b111), end));
        for (text, systems, label) in [
            ("!2L1", 0b10, 1),
            ("!12L1", 0b11, 1),
            ("!1!2L2", 0b11, 2),
            ("!1 !2 L2", 0b11, 2),
            ("!L20", 0, 20),
            ("!2", 0b10, 0),
            ("!13", 0b101, 0),
            ("!5", 0, 5),
            ("!14", 0, 14),
        ] {
            assert_eq!(read(text), Some(((systems, label), text.len())), "{text}");
        }
        assert_eq!(read("!2L1 G0"), Some(((0b10, 1), 4)));
        for text in ["!", "!L", "! 2", "!LA", "!99999999999L"] {
            assert_eq!(read(text), None, "{text}");
        }
    }
}
