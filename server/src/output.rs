//! Standard output and standard error of the server: the log, and the output of its commands.
//!
//! Invariant: if an output is full or closed, text is lost, but no thread panics (`println!` and `eprintln!` panic).

use std::fmt::Arguments;
use std::io::{self, IsTerminal as _, Write};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Shortest time between two steps of a command that are shown.
const STEP_EVERY: Duration = Duration::from_secs(3);

/// When a step was last shown; `None` = none are shown.
static STEPS: Mutex<Option<Instant>> = Mutex::new(None);

/// Shows the steps of a long command from now on, if standard error is a terminal.
pub fn show_steps() {
    if io::stderr().is_terminal() {
        *STEPS.lock().unwrap_or_else(PoisonError::into_inner) = Some(Instant::now());
    }
}

/// The current step of a long command, shown every few seconds.
pub(crate) fn step(text: Arguments<'_>) {
    if is_due(&mut STEPS.lock().unwrap_or_else(PoisonError::into_inner), Instant::now()) {
        remark(text);
    }
}

/// Whether a step is to be shown now.
fn is_due(shown: &mut Option<Instant>, now: Instant) -> bool {
    let due = shown.is_some_and(|last| now.saturating_duration_since(last) >= STEP_EVERY);
    if due {
        *shown = Some(now);
    }
    due
}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_shown_every_few_seconds_and_only_if_wanted() {
        let begin = Instant::now();
        let (mut shown, mut silent) = (Some(begin), None);
        let due: Vec<u64> = (0..12).filter(|s| is_due(&mut shown, begin + Duration::from_secs(*s))).collect();
        assert_eq!(due, [3, 6, 9]);
        assert!(!is_due(&mut silent, begin + Duration::from_secs(60)));
    }
}
