//! Where a block begins: most files have one block a line, but a character that ends blocks may put several on it.
//!
//! Invariant: a mark inside a comment, a message or embedded code ends no block.

/// The first byte of a block. Ordered as blocks are in their file.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct BlockStart {
    /// Line, from 1.
    pub line: u32,
    /// Byte in the line, from 0.
    pub offset: u32,
}

impl BlockStart {
    /// The first block of a line.
    pub fn line(line: u32) -> Self {
        Self { line, offset: 0 }
    }
}

/// How comments and messages start and end.
pub type Remark = (Vec<u8>, Vec<u8>);

/// Place of the first `eob` that ends a block.
pub fn block_end<'r>(line: &[u8], eob: Option<u8>, remarks: impl Iterator<Item = &'r Remark> + Clone) -> Option<usize> {
    // Most lines have none.
    memchr::memchr(eob?, line)?;
    let mut at = 0;
    while let Some(&byte) = line.get(at) {
        if Some(byte) == eob {
            return Some(at);
        }
        at = match byte {
            // Embedded code is a text of its own.
            b'{' => closing_brace(line, at).map_or(at + 1, |close| close + 1),
            _ => remark_end(line, at, remarks.clone()).unwrap_or(at + 1),
        };
    }
    None
}

/// Position after the comment or message that begins at `at`.
pub fn remark_end<'r>(line: &[u8], at: usize, mut remarks: impl Iterator<Item = &'r Remark>) -> Option<usize> {
    let rest = line.get(at..)?;
    let (start, end) = remarks.find(|(start, _)| !start.is_empty() && rest.starts_with(start))?;
    let inside = rest.get(start.len()..).unwrap_or_default();
    let close = memchr::memmem::find(inside, end).filter(|_| !end.is_empty());
    Some(close.map_or(line.len(), |close| at + start.len() + close + end.len()))
}

/// The brace that closes the one at `at`.
fn closing_brace(line: &[u8], at: usize) -> Option<usize> {
    let mut depth = 0_usize;
    for (offset, byte) in line.get(at..)?.iter().enumerate() {
        match byte {
            b'{' => depth += 1,
            b'}' if depth <= 1 => return Some(at + offset),
            b'}' => depth -= 1,
            _ => {}
        }
    }
    None
}

/// Where the blocks of a line with several begin that have text: bytes from 0. One that ends at the line's end is the
/// last.
pub fn starts<'r>(
    line: &[u8],
    eob: Option<u8>,
    remarks: impl Iterator<Item = &'r Remark> + Clone,
) -> impl Iterator<Item = usize> {
    let mut next = Some(0);
    std::iter::from_fn(move || {
        let from = next?;
        let rest = line.get(from..).unwrap_or_default();
        next = block_end(rest, eob, remarks.clone())
            .map(|end| from + end + 1)
            .filter(|&after| !line.get(after..).unwrap_or_default().trim_ascii().is_empty());
        Some(from)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_of_a_line() {
        let remarks: [Remark; 1] = [(b"(".to_vec(), b")".to_vec())];
        let of = |line: &str| starts(line.as_bytes(), Some(b';'), remarks.iter()).collect::<Vec<_>>();
        assert_eq!(of(""), [0]);
        assert_eq!(of("G1 X1;"), [0]);
        assert_eq!(of("G1 X1;  "), [0]);
        assert_eq!(of("G1;N5 (a;b) G2;{x=';'}G3"), [0, 3, 15]);
        assert_eq!(of("(open ; comment"), [0]);
        assert!(BlockStart { line: 2, offset: 9 } < BlockStart::line(3));
    }
}
