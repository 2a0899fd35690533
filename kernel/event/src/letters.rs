//! The letters that select the lines of a trace.
//!
//! Invariant: a set of the ten documented letters. Facts: reference listing-and-trace.md 4.

/// All letters: input, edited blocks, words, codes and data, actions, code and data macros, other macros, messages,
/// MDI and EXEC, blocks of stored files.
pub const ALL: &str = "IEWCAMHSXZ";

/// A set of letters.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Letters(u16);

impl Letters {
    /// Reads letters; letter case does not matter, `all` is all of them.
    ///
    /// # Errors
    /// The first character that is not a letter of a trace.
    pub fn parse(text: &str) -> Result<Self, char> {
        if text.eq_ignore_ascii_case("all") {
            return Self::parse(ALL);
        }
        text.chars().try_fold(Self::default(), |letters, c| {
            let bit = ALL.find(c.to_ascii_uppercase()).ok_or(c)?;
            Ok(Self(letters.0 | 1 << bit))
        })
    }

    /// Whether a letter is in the set.
    #[must_use]
    pub fn has(self, letter: char) -> bool {
        ALL.find(letter).is_some_and(|bit| self.0 & 1 << bit != 0)
    }

    /// No letter.
    #[must_use]
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_in_any_case() {
        let letters = Letters::parse("iWz").unwrap();
        assert!(letters.has('I') && letters.has('W') && letters.has('Z') && !letters.has('A'));
        assert_eq!(Letters::parse("IQ"), Err('Q'));
        assert_eq!(Letters::parse("all"), Letters::parse(ALL));
        assert!(Letters::parse("").unwrap().is_empty());
    }
}
