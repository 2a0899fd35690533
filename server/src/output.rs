//! Standard output and standard error of the server: the log, and texts of its commands.
//!
//! Invariant: an output that is full or closed loses text. It never ends a thread, as `println!` and `eprintln!` do.

use std::fmt::Arguments;
use std::io::{self, Write};

/// Writes a line of a command to standard output.
///
/// # Errors
/// The line could not be written.
pub fn line(text: Arguments<'_>) -> Result<(), String> {
    write_line(&mut io::stdout().lock(), text).map_err(|error| format!("the output cannot be written: {error}"))
}

/// Writes a line of a server that runs to standard output, or loses it.
pub fn announce(text: Arguments<'_>) {
    let _ = write_line(&mut io::stdout().lock(), text);
}

/// Writes why the program ends to standard error, or loses it.
pub fn failure(text: Arguments<'_>) {
    let _ = write_line(&mut io::stderr().lock(), text);
}

fn write_line(out: &mut dyn Write, text: Arguments<'_>) -> io::Result<()> {
    out.write_fmt(text)?;
    out.write_all(b"\n")?;
    out.flush()
}

/// An output that takes everything, and loses it where it cannot be written.
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
