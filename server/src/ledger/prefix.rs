//! Beginnings of identities of jobs: to find a job by one, and the shortest one that names a job.
//!
//! *Invariant:* a prefix has the form of an identity: lower-case hexadecimal digits, hyphens at their places.

use std::ops::RangeInclusive;

/// Hexadecimal digits of an identity.
const DIGITS: usize = 32;
/// Digits before each hyphen.
const HYPHENS: [usize; 4] = [8, 12, 16, 20];
/// Minimum number of characters of the prefix that is returned for a job.
const SHORTEST: usize = 8;

/// The beginning of an identity: its digits, without hyphens.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct IdPrefix(String);

impl IdPrefix {
    /// A prefix with or without hyphens, in any letter case; none if no identity can have it.
    pub(crate) fn read(text: &str) -> Option<Self> {
        let digits: String = text.chars().filter(|c| *c != '-').map(|c| c.to_ascii_lowercase()).collect();
        let all_hexadecimal = digits.bytes().all(|byte| byte.is_ascii_hexdigit());
        let hyphens_only = digits.is_empty() && !text.is_empty();
        let fits = digits.len() <= DIGITS && text.len() <= DIGITS + HYPHENS.len();
        (all_hexadecimal && fits && !hyphens_only).then_some(Self(digits))
    }

    /// Whether an identity has this prefix.
    pub(crate) fn begins(&self, id: &str) -> bool {
        id.starts_with(&hyphenated(&self.0))
    }

    /// The first and the last identity with this prefix.
    pub(crate) fn range(&self) -> RangeInclusive<String> {
        let filled = |with: &str| hyphenated(&(self.0.clone() + &with.repeat(DIGITS.saturating_sub(self.0.len()))));
        filled("0")..=filled("f")
    }
}

fn hyphenated(digits: &str) -> String {
    let mut text = String::with_capacity(DIGITS + HYPHENS.len());
    for (at, digit) in digits.chars().enumerate() {
        if HYPHENS.contains(&at) {
            text.push('-');
        }
        text.push(digit);
    }
    text
}

/// The shortest prefix of an identity that the identities before and after it do not have.
pub(crate) fn shortest<'i>(id: &str, neighbours: impl IntoIterator<Item = &'i str>) -> String {
    let same = |other: &str| id.bytes().zip(other.bytes()).take_while(|(a, b)| a == b).count();
    let length = neighbours.into_iter().map(|other| same(other) + 1).max().unwrap_or(0).max(SHORTEST);
    // An identity is ASCII. A hyphen at the end has no meaning.
    let length = if id.as_bytes().get(length.saturating_sub(1)) == Some(&b'-') { length + 1 } else { length };
    id.get(..length).unwrap_or(id).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    const ID: &str = "01938f2c-5d1e-7c4a-9b1e-3f8d2a6b7c90";

    #[test]
    fn a_prefix_is_read_in_every_spelling() {
        for text in ["", "0", "01938F2C", "01938f2c-", "01938f2c5d1e", "01938f2c-5d1e-7c", ID, &ID.replace('-', "")] {
            assert!(IdPrefix::read(text).unwrap().begins(ID), "{text}");
        }
        for text in ["1", "01938f2d", &format!("{}1", &ID[..35])] {
            assert!(!IdPrefix::read(text).unwrap().begins(ID), "{text}");
        }
        for text in ["-", "x", "0193 8f2c", "part", "01938f2c*", &format!("{ID}0"), &"-0".repeat(20), "ä"] {
            assert_eq!(IdPrefix::read(text), None, "{text}");
        }
    }

    #[test]
    fn a_prefix_has_a_first_and_a_last_identity() {
        let range = IdPrefix::read("01938f2c5").unwrap().range();
        assert_eq!(range.start(), "01938f2c-5000-0000-0000-000000000000");
        assert_eq!(range.end(), "01938f2c-5fff-ffff-ffff-ffffffffffff");
        assert_eq!(IdPrefix::read(ID).unwrap().range(), ID.to_owned()..=ID.to_owned());
        assert!(IdPrefix::default().range().contains(&ID.to_owned()));
    }

    #[test]
    fn the_shortest_prefix_tells_a_job_from_its_neighbours() {
        assert_eq!(shortest(ID, []), "01938f2c");
        assert_eq!(shortest(ID, ["00000000-0000-7000-8000-000000000000"]), "01938f2c");
        assert_eq!(shortest(ID, ["01938f2c-4d1e-7c4a-9b1e-3f8d2a6b7c90"]), "01938f2c-5");
        assert_eq!(shortest(ID, ["01938f2c-5d1d-7000-8000-000000000000", "01938f2c-5d2e-7c4a"]), "01938f2c-5d1e");
        assert_eq!(shortest(ID, ["01938f2c-5d1e-7c4a-9b1e-3f8d2a6b7c91"]), ID);
    }
}
