//! Texts that are looked for at a place, by their first byte.
//!
//! *Invariant:* texts of one byte stay in the order in which they came; an empty text is found nowhere.

use counterpoint_machine::index::CodeRowId;

/// Things with a text, by the first byte of the text.
#[derive(Debug)]
pub struct ByFirst<T> {
    all: Vec<T>,
    /// Where those of a byte begin; one more at the end.
    starts: Vec<u16>,
}

/// Literal texts with their rows.
pub type Literals = ByFirst<(Vec<u8>, CodeRowId)>;

impl<T> ByFirst<T> {
    /// Sorts them.
    pub(super) fn new(mut all: Vec<T>, text: impl Fn(&T) -> &[u8]) -> Self {
        let first = |one: &T| text(one).first().copied();
        all.retain(|one| first(one).is_some());
        all.sort_by_key(first);
        let before = |byte: u16| all.partition_point(|one| first(one).is_some_and(|first| u16::from(first) < byte));
        let starts = (0..=256).map(|byte| before(byte) as u16).collect();
        Self { all, starts }
    }

    /// Those whose text begins with a byte.
    #[inline]
    pub fn of(&self, byte: u8) -> &[T] {
        let bounds = self.starts.get(usize::from(byte)).zip(self.starts.get(usize::from(byte) + 1));
        bounds.and_then(|(&from, &to)| self.all.get(usize::from(from)..usize::from(to))).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::ByFirst;

    #[test]
    fn texts_of_a_byte_stay_in_order() {
        let texts = ByFirst::new(vec!["BC", "A", "BB", "", "\u{ff}", "BCD"], |text| text.as_bytes());
        assert_eq!((texts.of(b'B'), texts.of(b'A')), (&["BC", "BB", "BCD"][..], &["A"][..]));
        assert_eq!((texts.of(b'C'), texts.of(0), texts.of(0xc3)), (&[][..], &[][..], &["\u{ff}"][..]));
        assert!(texts.of(255).is_empty());
    }
}
