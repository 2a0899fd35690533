//! Names of machines that this program knows.
//!
//! *Invariant:* all commands refuse an unknown machine name in the same words.

use std::path::Path;

use counterpoint_kernel::machine::{package, similar};

use crate::error::Error;

/// Maximum number of similar names in a message, as on the server.
const SUGGESTED: usize = 3;

/// Refuses a machine that is neither a folder with a definition nor a known name. The names on a remote server, which
/// is not embedded, are not known here.
pub(crate) fn machine(machine: &str, embedded: bool) -> Result<(), Error> {
    if machine.is_empty() {
        let text = "the name of the machine is empty: give the name of a machine, or a folder with machine.toml";
        return Err(Error::Usage(text.to_owned()));
    }
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
        let known: Vec<&str> = names.iter().map(String::as_str).collect();
        let near = similar(machine, &known, SUGGESTED).join(" or ");
        let near = if near.is_empty() { near } else { format!("did you mean {near}? ") };
        return Err(Error::Usage(format!(
            "machine '{machine}' not found: {near}shipped machines are {}; for your own machine give a folder with \
             machine.toml",
            names.join(", ")
        )));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn similar_names_are_suggested_in_any_letter_case() {
        let text = |name: &str| machine(name, true).unwrap_err().to_string();
        assert!(text("FANUC-MILL").contains("did you mean fanuc-mill"), "{}", text("FANUC-MILL"));
        assert!(text("fanuc-mil").contains("did you mean fanuc-mill"), "{}", text("fanuc-mil"));
        assert!(!text("banana").contains("did you mean"), "{}", text("banana"));
        assert_eq!(
            text(""),
            "the name of the machine is empty: give the name of a machine, or a folder with machine.toml"
        );
        assert!(machine("my-mill", false).is_ok(), "a server may have it");
    }
}
