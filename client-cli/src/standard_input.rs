//! `-`: standard input in place of a file.
//!
//! *Invariant:* a command reads standard input at most once, to its end, and no more than the largest file that a
//! server takes.

use std::io::{IsTerminal as _, Read as _};
use std::path::Path;

use crate::error::Error;
use crate::say::{self, DIM, styled};

/// Name of standard input in messages.
pub(crate) const NAME: &str = "<standard input>";

/// Maximum number of bytes that are read: the default size limit of a server for one file.
const MOST: u64 = 256 << 20;

/// Whether a path means standard input; a file of this name is `./-`.
pub(crate) fn is(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// Refuses `-` for an option whose file must have a name.
pub(crate) fn refuse(option: &str, path: &Path) -> Result<(), Error> {
    if is(path) {
        return Err(Error::Usage(format!("{option} needs a file: only a program can be standard input (-)")));
    }
    Ok(())
}

/// Reads all of standard input.
pub(crate) fn read() -> Result<Vec<u8>, Error> {
    if std::io::stdin().is_terminal() {
        say::status_line(styled(DIM, "reading from standard input; Ctrl-D (Windows: Ctrl-Z and Enter) ends it"));
    }
    let mut bytes = Vec::new();
    std::io::stdin().lock().take(MOST + 1).read_to_end(&mut bytes).map_err(Error::file("standard input"))?;
    if bytes.len() as u64 > MOST {
        return Err(Error::Usage(format!("standard input has more than {} MiB", MOST >> 20)));
    }
    Ok(bytes)
}
