//! `counterpoint man`: man pages, made from the help texts.
//!
//! *Invariant:* each command has a page, named as the command with hyphens: `counterpoint-machine-new.1`.

use std::path::Path;

use clap::CommandFactory as _;

use crate::arguments::Arguments;
use crate::error::Error;
use crate::say;

/// Writes the pages into a folder.
pub(crate) fn write(folder: &Path) -> Result<u8, Error> {
    std::fs::create_dir_all(folder).map_err(Error::file(folder))?;
    clap_mangen::generate_to(Arguments::command(), folder).map_err(Error::file(folder))?;
    say::data(
        format!("man pages written to {}: `man -l {0}/counterpoint.1` shows one\n", folder.display()).as_bytes(),
    )?;
    Ok(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The pages of a command and its subcommands.
    fn pages(command: &clap::Command, before: &str) -> Vec<(String, String)> {
        let name = format!("{before}{}", command.get_name());
        let about = command.get_about().map(ToString::to_string).unwrap_or_default();
        let below = command.get_subcommands().filter(|command| !command.is_hide_set() && command.get_name() != "help");
        let below: Vec<_> = below.flat_map(|command| pages(command, &format!("{name}-"))).collect();
        std::iter::once((name, about)).chain(below).collect()
    }

    #[test]
    fn each_command_has_a_page() {
        let folder = tempfile::tempdir().unwrap();
        write(folder.path()).unwrap();
        let pages = pages(&Arguments::command(), "");
        assert!(pages.len() > 35 && pages.iter().any(|(name, _)| name == "counterpoint-machine-new"), "{pages:?}");
        for (name, about) in &pages {
            let page = std::fs::read_to_string(folder.path().join(format!("{name}.1"))).unwrap();
            assert!(!about.is_empty() && page.starts_with(".ie"), "{name}: {page}");
            let head = about.split(['-', '`', '\'']).next().unwrap_or_default();
            assert!(page.contains(&format!(".TH {name} 1")) && page.contains(head), "{name}: {page}");
            assert!(page.contains(".SH SYNOPSIS"), "{name}: {page}");
        }
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), pages.len());
    }
}
