//! M functions without an effect on this machine, for one message at the end of the program.
//!
//! *Invariant:* ascending numbers, each once; only a new number takes memory.

use std::fmt;

/// Maximum number of listed functions; the list says if there are others.
const MOST: usize = 100;

/// Numbers of the functions that a program has commanded without effect.
#[derive(Debug, Default)]
pub struct Swallowed {
    numbers: Vec<u32>,
    /// Functions beyond [`MOST`] were commanded.
    more: bool,
}

impl Swallowed {
    /// Records a function. Numbers that no function can have are left out.
    pub fn note(&mut self, number: f64) {
        if number.fract() != 0.0 || !(0.0..=f64::from(u32::MAX)).contains(&number) {
            return;
        }
        let number = number as u32;
        let Err(at) = self.numbers.binary_search(&number) else { return };
        if self.numbers.len() < MOST {
            self.numbers.insert(at, number);
        } else {
            self.more = true;
        }
    }

    /// Whether no function was recorded.
    pub fn is_empty(&self) -> bool {
        self.numbers.is_empty()
    }
}

/// The list: three or more neighbours are a range.
impl fmt::Display for Swallowed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut separator = "";
        for run in self.numbers.chunk_by(|one, next| one + 1 == *next) {
            match *run {
                [first, .., last] if run.len() > 2 => write!(f, "{separator}M{first} to M{last}")?,
                _ => {
                    for number in run {
                        write!(f, "{separator}M{number}")?;
                        separator = ", ";
                    }
                }
            }
            separator = ", ";
        }
        if self.more { f.write_str(" and others") } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::{MOST, Swallowed};

    fn list(numbers: impl IntoIterator<Item = f64>) -> String {
        let mut swallowed = Swallowed::default();
        numbers.into_iter().for_each(|number| swallowed.note(number));
        swallowed.to_string()
    }

    #[test]
    fn numbers_come_once_in_order_and_neighbours_as_ranges() {
        assert_eq!(list([68.0, 10.0, 11.0, 68.0]), "M10, M11, M68");
        assert_eq!(list([65.0, 63.0, 64.0, 90.0]), "M63 to M65, M90");
        assert_eq!(list([0.5, -1.0, 1e12, f64::NAN]), "");
    }

    #[test]
    fn a_long_list_is_cut() {
        let list = list((0..=MOST).map(|number| number as f64 * 2.0));
        assert!(list.ends_with("M196, M198 and others"), "{list}");
    }
}
