//! Arguments of `counterpoint lint`.

use clap::Args;

use super::inputs::levels;
use super::{Inputs, On, ProgramFiles, SkipLevels, Switches};

#[derive(Debug, Args)]
pub(crate) struct Lint {
    /// Check these programs, one per channel from left to right; FILE#2102 is program O2102 of FILE,
    /// FILE#NAME the program or section of that name (`PART_1`, `$2`, `G14`); - reads standard input, once
    #[arg(required = true, value_name = "PROGRAM")]
    programs: Vec<String>,
    #[command(flatten)]
    on: On,
    #[command(flatten)]
    files: ProgramFiles,
    /// Set optional block skip: off, on (for marks without a digit), or a list of levels such as 1,3
    #[arg(long, default_value = "off", value_name = "off|on|LEVELS", value_parser = levels)]
    opskip: SkipLevels,
    /// Let these channels pass every sync point without waiting
    #[arg(long, value_delimiter = ',', value_name = "CHANNELS")]
    ignore_waits: Vec<u32>,
    /// Print the summary as JSON instead of the report
    #[arg(long)]
    pub(crate) json: bool,
    /// Print only errors: no progress, no report
    #[arg(long, short)]
    pub(crate) quiet: bool,
    /// Show all sync points and diagnostics in the report, not only the first 20
    #[arg(long, short, conflicts_with = "quiet")]
    pub(crate) verbose: bool,
    /// Exit with code 1 even if there are only warnings; this includes a channel that cannot be checked to its end
    #[arg(long)]
    pub(crate) strict: bool,
}

impl Lint {
    /// The inputs of the job.
    pub(crate) fn inputs(&self) -> Inputs {
        Inputs {
            on: self.on.clone(),
            files: self.files.clone(),
            switches: Switches { opskip: self.opskip.clone(), opstop: false },
            ignore_waits: self.ignore_waits.clone(),
            ..Inputs::plain(&self.programs)
        }
    }
}
