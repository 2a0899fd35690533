//! `counterpoint man`: man pages, made from the help texts.
//!
//! *Invariant:* each command has a page, named as the command with hyphens: `counterpoint-machine-new.1`.

use std::fmt::Write as _;
use std::io;
use std::path::Path;

use clap::{Command, CommandFactory as _};
use clap_mangen::Man;

use crate::arguments::CliArgs;
use crate::error::Error;
use crate::say;

/// Beginning of the help text with examples.
const EXAMPLES: &str = "Examples:";

/// Writes the pages into a folder.
pub(crate) fn write(folder: &Path) -> Result<u8, Error> {
    std::fs::create_dir_all(folder).map_err(Error::file(folder))?;
    for (name, text) in pages(&built(), None).map_err(Error::file(folder))? {
        let path = folder.join(format!("{name}.1"));
        std::fs::write(&path, text).map_err(Error::file(&path))?;
    }
    say::data(
        format!("man pages written to {}: `man -l {0}/counterpoint.1` shows one\n", folder.display()).as_bytes(),
    )?;
    Ok(0)
}

/// Prints the page of the program.
pub(crate) fn print() -> Result<u8, Error> {
    let all = pages(&built(), None).map_err(Error::file("standard output"))?;
    all.first().map_or(Ok(()), |(_, page)| say::data(page.as_bytes()))?;
    Ok(0)
}

fn built() -> Command {
    let mut command = CliArgs::command().disable_help_subcommand(true);
    command.build();
    command
}

/// The pages of a command and its subcommands by name.
fn pages(command: &Command, above: Option<&str>) -> io::Result<Vec<(String, String)>> {
    let name = command.get_display_name().unwrap_or_else(|| command.get_name()).to_owned();
    let below: Vec<&Command> = command.get_subcommands().filter(|command| !command.is_hide_set()).collect();
    let mut all = vec![(name.clone(), page(command, (&name, above), &below)?)];
    for command in below {
        all.extend(pages(command, Some(&name))?);
    }
    Ok(all)
}

fn page(command: &Command, (name, above): (&str, Option<&str>), below: &[&Command]) -> io::Result<String> {
    let version = concat!("counterpoint ", env!("CARGO_PKG_VERSION"));
    let man = Man::new(command.clone()).title(name).section("1");
    // An empty date: the footer has the version, and the heading fits between long names.
    let title = format!(".TH \"{}\" \"1\" \"\" \"{version}\" \"Counterpoint\"\n", escaped(name));
    let mut out: Vec<u8> = title.into_bytes();
    man.render_name_section(&mut out)?;
    out.extend(synopsis(command).into_bytes());
    man.render_description_section(&mut out)?;
    if command.get_arguments().any(|argument| !argument.is_hide_set()) {
        man.render_options_section(&mut out)?;
    }
    if !below.is_empty() {
        man.render_subcommands_section(&mut out)?;
    }
    let mut text = String::from_utf8_lossy(&out).into_owned();
    if let Some(after) = command.get_after_long_help().or_else(|| command.get_after_help()) {
        let after = after.to_string();
        let (title, lines) = match after.strip_prefix(EXAMPLES) {
            Some(lines) => ("EXAMPLES", lines),
            None => ("NOTES", after.as_str()),
        };
        // Keep the line breaks and columns.
        let _ = writeln!(text, ".SH {title}\n.nf");
        lines.trim_matches('\n').lines().for_each(|line| text.push_str(&format!("{}\n", escaped(line))));
        text.push_str(".fi\n");
    }
    let names = below.iter().map(|command| command.get_display_name().unwrap_or_else(|| command.get_name()));
    let others: Vec<String> = above.into_iter().chain(names).map(|name| format!(".BR {} (1)", escaped(name))).collect();
    if !others.is_empty() {
        let _ = writeln!(text, ".SH \"SEE ALSO\"\n{}", others.join(",\n"));
    }
    Ok(ascii(&text))
}

/// The usage as `--help` prints it: options in one word, all values and repeats of the arguments.
fn synopsis(command: &Command) -> String {
    let usage = command.clone().render_usage().to_string();
    let usage = usage.trim().strip_prefix("Usage:").unwrap_or(&usage);
    let lines: Vec<String> = usage.lines().map(|line| escaped(line.trim())).filter(|line| !line.is_empty()).collect();
    format!(".SH SYNOPSIS\n.nf\n{}\n.fi\n", lines.join("\n"))
}

/// A line as text, not as a request.
fn escaped(line: &str) -> String {
    let text = line.replace('\\', "\\(rs").replace('-', "\\-");
    if text.starts_with(['.', '\'']) { format!("\\&{text}") } else { text }
}

/// Characters beyond ASCII by their numbers, which groff reads in any encoding.
fn ascii(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        if c.is_ascii() {
            out.push(c);
        } else if c == '…' {
            out.push_str("...");
        } else {
            let _ = write!(out, "\\[u{:04X}]", u32::from(c));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The commands with their descriptions.
    fn all(command: &clap::Command, before: &str) -> Vec<(String, String)> {
        let name = format!("{before}{}", command.get_name());
        let about = command.get_about().map(ToString::to_string).unwrap_or_default();
        let below = command.get_subcommands().filter(|command| !command.is_hide_set() && command.get_name() != "help");
        let below: Vec<_> = below.flat_map(|command| all(command, &format!("{name}-"))).collect();
        std::iter::once((name, about)).chain(below).collect()
    }

    #[test]
    fn each_command_has_a_page() {
        let folder = tempfile::tempdir().unwrap();
        write(folder.path()).unwrap();
        let pages = all(&CliArgs::command(), "");
        assert!(pages.len() > 35 && pages.iter().any(|(name, _)| name == "counterpoint-machine-new"), "{pages:?}");
        for (name, about) in &pages {
            let page = std::fs::read_to_string(folder.path().join(format!("{name}.1"))).unwrap();
            assert!(!about.is_empty() && page.starts_with(".TH"), "{name}: {page}");
            let head = about.split(['-', '`', '\'']).next().unwrap_or_default();
            assert!(
                page.contains(&format!(".TH \"{} \"1\"", escaped(name) + "\"")) && page.contains(head),
                "{name}: {page}"
            );
            assert!(page.contains(".SH SYNOPSIS\n.nf\ncounterpoint"), "{name}: {page}");
            assert!(page.is_ascii() && page.contains(".SH \"SEE ALSO\""), "{name}: {page}");
            assert!(page.contains(concat!("counterpoint ", env!("CARGO_PKG_VERSION"))), "{name}: {page}");
        }
        let run = std::fs::read_to_string(folder.path().join("counterpoint-run.1")).unwrap();
        assert!(run.contains("<PROGRAM>...") && run.contains(".SH EXAMPLES\n.nf\n"), "{run}");
        assert!(run.contains(".BR counterpoint (1)"), "{run}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), pages.len());
    }
}
