//! Standard output and standard error of the server: the log, and the output of its commands.
//!
//! Invariant: if an output is full or closed, text is lost, but no thread panics (`println!` and `eprintln!` panic).

use std::fmt::Arguments;
use std::io::{self, Write};

/// Writes a line of a command to standard output.
///
/// # Errors
/// The line could not be written.
pub fn line(text: Arguments<'_>) -> Result<(), String> {
    write_line(&mut io::stdout().lock(), text).map_err(|error| format!("the output cannot be written: {error}"))
}

/// Writes a line of the running server to standard output; drops the line if that fails.
pub fn announce(text: Arguments<'_>) {
    let _ = write_line(&mut io::stdout().lock(), text);
}

/// Writes a remark of a command to standard error; ignores a failure to write.
pub fn remark(text: Arguments<'_>) {
    let _ = write_line(&mut io::stderr().lock(), text);
}

/// Writes the reason for which the program ends to standard error; drops it if that fails.
pub fn failure(text: Arguments<'_>) {
    let _ = write_line(&mut io::stderr().lock(), text);
}

fn write_line(out: &mut dyn Write, text: Arguments<'_>) -> io::Result<()> {
    out.write_fmt(text)?;
    out.write_all(b"\n")?;
    out.flush()
}

/// An output that accepts all bytes, and drops those that cannot be written.
#[derive(Debug)]
pub struct Lossy<W>(pub W);

impl<W: Write> Write for Lossy<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let _ = self.0.write_all(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        let _ = self.0.flush();
        Ok(())
    }
}
