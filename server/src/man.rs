//! `counterpointd man`: man pages, made from the help texts.
//!
//! *Invariant:* each command has a page, named after the command with hyphens: `counterpointd-token-new.8`.

use std::io;
use std::path::Path;

use clap::Command;
use clap_mangen::Man;

/// Section of the manual for programs of administrators.
const SECTION: &str = "8";
/// Environment and paths of a package, after the options of the server.
const SERVER: &str = r#".SH ENVIRONMENT
Each option has a variable: COUNTERPOINT_QUEUE for \-\-queue, COUNTERPOINT_TLS_CERT for \-\-tls\-cert.
Options override variables, and variables override the configuration file. COUNTERPOINT_LOG filters the log.
.SH EXIT STATUS
.TP
.B 0
The server was stopped.
.TP
.B 2
Wrong usage, or the configuration or a file that it names cannot be used.
.TP
.B 3
The data folder, an address or the system cannot be used.
.SH SIGNALS
.TP
.B HUP
Read identities, certificates and the tables of tenants again, and reopen the audit log.
.TP
.BR TERM ", " INT
Refuse new jobs, let running jobs end, queue the others again, and exit. A second signal ends the server at once.
.SH FILES
.TP
.I /etc/counterpoint/counterpointd.toml
Configuration of the packaged server.
.TP
.I /var/lib/counterpoint
Its data folder.
.TP
.I /var/log/counterpoint
Folder for its audit log.
.TP
.I /usr/share/doc/counterpoint/docs/operations.md
The manual of the server; \fIsecurity.md\fR beside it explains identities and encryption.
"#;

/// Writes the pages of a program and its commands into a folder.
///
/// # Errors
/// A page cannot be written.
pub fn write(program: Command, folder: &Path) -> Result<(), String> {
    let failed = |error: io::Error| format!("'{}': {error}", folder.display());
    std::fs::create_dir_all(folder).map_err(failed)?;
    write_all(&built(program), folder, SERVER).map_err(failed)
}

/// The page of a program.
///
/// # Errors
/// The page cannot be made.
pub fn page(program: Command) -> Result<String, String> {
    let page = text(&built(program), SERVER).map_err(|error| error.to_string())?;
    String::from_utf8(page).map_err(|error| error.to_string())
}

fn built(program: Command) -> Command {
    let mut program = program.disable_help_subcommand(true);
    program.build();
    program
}

fn name(command: &Command) -> &str {
    command.get_display_name().unwrap_or_else(|| command.get_name())
}

/// The subcommands that have pages.
fn below(command: &Command) -> impl Iterator<Item = &Command> {
    command.get_subcommands().filter(|command| !command.is_hide_set())
}

fn write_all(command: &Command, folder: &Path, more: &str) -> io::Result<()> {
    std::fs::write(folder.join(format!("{}.{SECTION}", name(command))), text(command, more)?)?;
    below(command).try_for_each(|command| write_all(command, folder, ""))
}

/// The text of a page.
fn text(command: &Command, more: &str) -> io::Result<Vec<u8>> {
    let page = Man::new(command.clone()).title(name(command)).section(SECTION).date("").manual("Counterpoint");
    let page = page.source(concat!("counterpoint ", env!("CARGO_PKG_VERSION")));
    let mut text = Vec::new();
    page.render_title(&mut text)?;
    page.render_name_section(&mut text)?;
    text.extend(synopsis(command).into_bytes());
    page.render_description_section(&mut text)?;
    page.render_options_section(&mut text)?;
    if below(command).next().is_some() {
        page.render_subcommands_section(&mut text)?;
    }
    text.extend(more.as_bytes());
    Ok(text)
}

/// The usage as `--help` prints it: the options of the server in one word.
fn synopsis(command: &Command) -> String {
    let usage = command.clone().render_usage().to_string();
    let usage = usage.trim_start_matches("Usage: ").replace('-', "\\-");
    format!(".SH SYNOPSIS\n{usage}\n")
}
