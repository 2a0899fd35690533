//! Arguments of `machine`.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};

use crate::remote::Remote;

#[derive(Debug, Subcommand)]
pub(crate) enum Machine {
    /// Check a machine and print findings with file, line and column
    Check {
        /// Name of a machine, or a folder with machine.toml
        machine: String,
        #[command(flatten)]
        at: At,
    },
    /// Write a folder for a machine of your own, based on a shipped one
    New {
        /// Folder to write, which must not exist; its name is the name of the machine
        folder: PathBuf,
        /// Shipped machine to start from
        #[arg(long, value_name = "NAME")]
        from: String,
    },
    /// List the machines
    List {
        #[command(flatten)]
        at: At,
    },
    /// Delete a machine of a server with all its revisions; jobs keep the revision they were submitted with
    Delete {
        /// Its name
        machine: String,
        #[command(flatten)]
        remote: Remote,
    },
    /// Show a machine or a part of it
    Show {
        /// Name of a machine, or a folder with machine.toml
        machine: String,
        /// Show only this part
        #[arg(value_enum, default_value = "all")]
        part: Part,
        /// Print JSON
        #[arg(long)]
        json: bool,
        #[command(flatten)]
        at: At,
    },
}

/// A server, or this program itself.
#[derive(Debug, Args)]
pub(crate) struct At {
    /// Ask this server instead of using the shipped machines
    #[arg(long, env = "COUNTERPOINT_SERVER", value_name = "URL")]
    pub(crate) server: Option<String>,
}

/// Parts of a machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Part {
    All,
    Codes,
    Data,
    Groups,
    Macros,
    Axes,
    Channels,
    Refusals,
}
