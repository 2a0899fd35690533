//! Status on standard error in colours by meaning, data on standard output.
//!
//! *Invariant:* a closed pipe ends the command quietly.

use std::io::{self, IsTerminal as _, Write as _};

use anstyle::{AnsiColor, Color, Style};

use crate::error::Error;
use crate::visible::visible;

const fn colour(colour: AnsiColor) -> Style {
    Style::new().fg_color(Some(Color::Ansi(colour)))
}

/// Something went wrong.
pub(crate) const BAD: Style = colour(AnsiColor::Red).bold();
/// Something to look at.
pub(crate) const WARN: Style = colour(AnsiColor::Yellow);
/// All is well.
pub(crate) const GOOD: Style = colour(AnsiColor::Green).bold();
/// Of lesser weight.
pub(crate) const DIM: Style = Style::new().dimmed();

/// A text in a style.
pub(crate) fn styled(style: Style, text: impl std::fmt::Display) -> String {
    format!("{style}{text}{style:#}")
}

/// Prints a line of status.
pub(crate) fn status_line(text: impl std::fmt::Display) {
    let _ = writeln!(anstream::stderr(), "{}", visible(&text.to_string()));
}

/// An error.
pub(crate) fn error(error: &Error) {
    status_line(format_args!("{} {error}", styled(BAD, "error:")));
}

/// Writes data unchanged, except that a terminal gets escapes in place of deceptive characters.
pub(crate) fn data(bytes: &[u8]) -> Result<(), Error> {
    let text = std::str::from_utf8(bytes).ok().filter(|_| io::stdout().is_terminal()).map(visible);
    let bytes = text.as_ref().map_or(bytes, |text| text.as_bytes());
    let mut out = anstream::stdout();
    out.write_all(bytes).and_then(|()| out.flush()).map_err(broken)
}

/// Data of a command whose exit code tells the result: a reader that has closed the pipe does not change that code.
pub(crate) fn verdict(bytes: &[u8]) -> Result<(), Error> {
    match data(bytes) {
        Err(Error::Closed) => Ok(()),
        done => done,
    }
}

/// A text without colours, for files.
pub(crate) fn plain(text: &str) -> String {
    anstream::adapter::strip_str(text).to_string()
}

/// A line of data as it is, escape codes too.
pub(crate) fn line(text: &str) -> Result<(), Error> {
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes()).and_then(|()| out.write_all(b"\n")).and_then(|()| out.flush()).map_err(broken)
}

/// The meaning of a failed write to standard output.
fn broken(error: io::Error) -> Error {
    match error.kind() {
        io::ErrorKind::BrokenPipe => Error::Closed,
        _ => Error::File { path: "standard output".to_owned(), error },
    }
}
