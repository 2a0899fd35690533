//! Names of machines that this program knows.
//!
//! *Invariant:* all commands refuse an unknown machine name in the same words.

use std::path::Path;

use counterpoint_kernel::machine::package;
use counterpoint_lang::ident;

use crate::error::Error;

/// Refuses a machine that is neither a folder with a definition nor a known name. The names on a remote server, which
/// is not embedded, are not known here.
pub(crate) fn machine(machine: &str, embedded: bool) -> Result<(), Error> {
    let names = package::shipped_names();
    if names.iter().any(|name| name == machine) {
        return Ok(());
    }
    if Path::new(machine).is_dir() || machine.contains(['/', '\\']) {
        return Err(Error::Usage(format!(
            "'{machine}' has no machine.toml: give the name of a machine, or a folder with machine.toml"
        )));
    }
    if embedded {
        let near = ident::nearest(machine, names.iter().map(String::as_str));
        let near = near.map(|near| format!("did you mean {near}? ")).unwrap_or_default();
        return Err(Error::Usage(format!(
            "machine '{machine}' not found: {near}shipped machines are {}; for your own machine give a folder with \
             machine.toml",
            names.join(", ")
        )));
    }
    Ok(())
}
