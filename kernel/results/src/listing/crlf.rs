//! Line ends of CR and LF on request.
//!
//! Facts: reference listing-and-trace.md 1 (LF, with a switch). *Invariant:* nothing but line ends changes.

use std::io::{Result, Write};

/// Writes CR LF wherever LF is written.
pub struct Crlf<'a>(pub &'a mut dyn Write);

impl std::fmt::Debug for Crlf<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Crlf").finish_non_exhaustive()
    }
}

impl Write for Crlf<'_> {
    fn write(&mut self, data: &[u8]) -> Result<usize> {
        for line in data.split_inclusive(|byte| *byte == b'\n') {
            match line.strip_suffix(b"\n") {
                Some(text) => {
                    self.0.write_all(text)?;
                    self.0.write_all(b"\r\n")?;
                }
                None => self.0.write_all(line)?,
            }
        }
        Ok(data.len())
    }

    fn flush(&mut self) -> Result<()> {
        self.0.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_with_both() {
        let mut out = Vec::new();
        Crlf(&mut out).write_all(b"a\n\nb").unwrap();
        Crlf(&mut out).write_all(b"c\n").unwrap();
        assert_eq!(out, b"a\r\n\r\nbc\r\n");
    }
}
