//! Arguments of `counterpoint calibrate`.

use std::path::PathBuf;

use clap::Args;

use super::{Inputs, ProgramFiles};

#[derive(Debug, Args)]
pub(crate) struct Calibrate {
    /// Run these programs, one per channel from left to right; the measured lines belong to the first program; - reads
    /// standard input, once
    #[arg(required = true, value_name = "PROGRAM")]
    programs: Vec<String>,
    /// Start from the data of this machine: a name, or a folder with machine.toml
    #[arg(long, value_name = "NAME|DIR")]
    pub(crate) machine: String,
    /// Read measured times from this file: a table with the columns `line` and `seconds`, a table of samples with the
    /// columns `line` and `time`, or an MTConnect document
    #[arg(long, value_name = "FILE")]
    pub(crate) measured: PathBuf,
    /// Use the lines of this channel
    #[arg(long, default_value_t = 1, value_name = "N")]
    pub(crate) channel: u16,
    #[command(flatten)]
    files: ProgramFiles,
    /// Write a machine with the fitted data into this new folder
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print the result as JSON instead of the report
    #[arg(long)]
    pub(crate) json: bool,
    /// Show all lines in the report, not only the ten largest differences
    #[arg(long, short)]
    pub(crate) verbose: bool,
}

impl Calibrate {
    /// The inputs of the job.
    pub(crate) fn inputs(&self) -> Inputs {
        Inputs { files: self.files.clone(), ..Inputs::plain(&self.programs) }
    }
}
