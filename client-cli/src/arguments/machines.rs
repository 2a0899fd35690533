//! Arguments of `machine`.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};

use super::filled::filled;
use crate::remote::Remote;

const SHOW_EXAMPLES: &str = "\
Examples:
  counterpoint machine show fanuc-mill codes --sort file
  counterpoint machine show fanuc-mill data --filter cycle --json
  counterpoint machine show ./my-mill codes --changed --filter M6
  counterpoint machine show fanuc-mill undefined --filter tilt";

const DIFF_EXAMPLES: &str = "\
Examples:
  counterpoint machine diff fanuc-mill haas-mill
  counterpoint machine diff ./old-mill ./my-mill --json";

const EDIT_EXAMPLES: &str = "\
Examples:
  counterpoint machine edit mitsubishi-mill 'G65P9010L2'
  counterpoint machine edit ./my-mill - < part.nc";

#[derive(Debug, Subcommand)]
pub(crate) enum MachineCommand {
    /// Check a machine and print findings with file, line and column
    Check {
        /// Name of a machine, or a folder with machine.toml
        machine: String,
        /// Print JSON
        #[arg(long)]
        json: bool,
        #[command(flatten)]
        at: MachineSource,
    },
    /// Write a folder for your own machine, based on a shipped machine
    New {
        /// Folder to write, which must not exist; its name is the name of the machine
        folder: PathBuf,
        /// Shipped machine to start from
        #[arg(long, value_name = "NAME", value_parser = filled)]
        from: String,
    },
    /// List the machines
    List {
        /// Print JSON, one object per line
        #[arg(long)]
        json: bool,
        #[command(flatten)]
        at: MachineSource,
    },
    /// Delete a machine of a server with all its revisions; jobs keep the revision with which they were submitted
    Delete {
        /// Name of the machine
        machine: String,
        #[command(flatten)]
        remote: Remote,
    },
    /// Show a machine or a part of it
    #[command(after_help = SHOW_EXAMPLES)]
    Show {
        /// Name of a machine, or a folder with machine.toml
        machine: String,
        /// Show only this part
        #[arg(value_enum, default_value = "all")]
        part: MachinePart,
        #[command(flatten)]
        rows: RowSelection,
        /// Print JSON
        #[arg(long)]
        json: bool,
        #[command(flatten)]
        at: MachineSource,
    },
    /// Compare the definitions of two machines, section by section and row by row
    #[command(after_help = DIFF_EXAMPLES)]
    Diff {
        /// Name of a shipped machine, or a folder with machine.toml
        a: String,
        /// Name or folder of the second machine
        b: String,
        /// Print JSON
        #[arg(long)]
        json: bool,
    },
    /// Apply the tape editor of a machine to lines, and show the line after every rule that changes it
    #[command(after_help = EDIT_EXAMPLES)]
    Edit {
        /// Name of a shipped machine, or a folder with machine.toml
        machine: String,
        /// Lines to edit; - reads lines from standard input
        #[arg(value_name = "LINE", required = true)]
        lines: Vec<String>,
        /// Also apply rules that are off at the start of a program
        #[arg(long)]
        all: bool,
        /// Print JSON
        #[arg(long)]
        json: bool,
    },
}

/// Choice and order of the table rows.
#[derive(Debug, Default, Args)]
pub(crate) struct RowSelection {
    /// Sort the rows by a column of the table, such as word, code, order, group, name or file
    #[arg(long, value_name = "COLUMN", value_parser = filled)]
    pub(crate) sort: Option<String>,
    /// Show only rows that contain this text, ignoring letter case
    #[arg(long, value_name = "TEXT", value_parser = filled)]
    pub(crate) filter: Option<String>,
    /// Show only the keys that differ from the family that the machine extends, with both values (only for shipped
    /// machines and folders)
    #[arg(long)]
    pub(crate) changed: bool,
}

/// A server, or this program itself.
#[derive(Debug, Args)]
pub(crate) struct MachineSource {
    /// Use the machines of this server instead of the shipped machines
    #[arg(long, env = "COUNTERPOINT_SERVER", value_name = "URL")]
    pub(crate) server: Option<String>,
}

impl MachineSource {
    /// The address of the server; an empty variable counts as absent.
    pub(crate) fn address(&self) -> Option<&str> {
        self.server.as_deref().filter(|address| !address.is_empty())
    }
}

/// Parts of a machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum MachinePart {
    All,
    Codes,
    Data,
    Groups,
    Macros,
    Axes,
    Channels,
    Refusals,
    /// Built-in codes and data, and letters, that the machine does not define
    Undefined,
}
