//! The command line.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};

/// Runs NC programs as the control would, block by block, all channels in parallel
#[derive(Debug, Parser)]
#[command(name = "counterpoint", version)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Run programs here and now
    Run(Run),
    /// Hand programs to a server; prints the job's id
    Submit(Submit),
    /// Follow a job to its end
    Watch(OneJob),
    /// Answer the dialogs of a job that was submitted with --attend
    Attend(OneJob),
    /// Wait for the end of a job
    Wait(OneJob),
    /// List the jobs of a server
    Jobs(Jobs),
    /// Ask a job to stop
    Cancel(OneJob),
    /// Remove an ended job with its results
    Delete(OneJob),
    /// Read a result of an ended job
    Result(ResultOf),
    /// Check, list and show machines
    #[command(subcommand)]
    Machine(Machine),
    /// Check, rewrite, run and explain macros
    #[command(subcommand)]
    Macro(crate::macros::arguments::Macro),
    /// Print a completion script for a shell
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
}

/// What a job is made of.
#[derive(Debug, Args)]
pub(crate) struct Inputs {
    /// Programs, one per channel from left to right; FILE#2102 means program O2102 of FILE
    #[arg(required = true, value_name = "PROGRAM")]
    pub(crate) programs: Vec<String>,
    /// Machine: a name or a folder with machine.toml. Without it: fanuc-mill for one channel, fanuc-2path-lathe for
    /// two, fanuc-3path-lathe for three; a single file with waiting codes M100-M199 has a channel per O-program
    #[arg(long, value_name = "NAME|DIR")]
    pub(crate) machine: Option<String>,
    /// More files the programs may call; of a folder all files
    #[arg(long = "with", value_name = "FILE|DIR")]
    pub(crate) with: Vec<PathBuf>,
    /// Optional skip: off, on (the level of marks without a digit), or the levels that are on, 1 to 9
    #[arg(long, default_value = "off", value_name = "off|on|LEVELS", value_parser = levels)]
    pub(crate) opskip: Levels,
    /// Optional stop (M1) stops
    #[arg(long)]
    pub(crate) opstop: bool,
    /// Channels that pass every meeting point without waiting
    #[arg(long, value_delimiter = ',', value_name = "CHANNELS")]
    pub(crate) ignore_waits: Vec<u32>,
    /// Kernels that may run at the same time; 0 = one per channel. The result does not depend on it
    #[arg(long, default_value_t = 0, value_name = "N")]
    pub(crate) threads: u32,
    /// Trace these letters, any of IEWCAMHSXZ, or all: input, edited blocks, words, codes and data, actions, code
    /// macros, other macros, messages, MDI and EXEC, files stored with the machine. Without letters: all
    #[arg(
        long,
        value_name = "LETTERS",
        num_args = 0..=1,
        default_value = "",
        default_missing_value = "all",
        hide_default_value = true
    )]
    pub(crate) trace: String,
    /// Parameters for the macros of the machine ($UPARAM), one line
    #[arg(long, value_name = "TEXT", default_value = "", hide_default_value = true, allow_hyphen_values = true)]
    pub(crate) param: String,
    /// Answers to the dialogs of the machine, TOML: [[answers]] with dialog, button, values
    #[arg(long, value_name = "FILE")]
    pub(crate) answers: Option<PathBuf>,
    /// Dialogs without an answer are put to the operator: here by `run` (which does so on a terminal anyway), by
    /// `counterpoint attend` for `submit`. Without it they fail
    #[arg(long)]
    pub(crate) attend: bool,
    /// Simulated seconds after which the run is stopped
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    pub(crate) max_time: Option<f64>,
    /// Blocks of one channel after which the run is stopped
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub(crate) max_blocks: Option<u64>,
    /// Memory of the job in MiB, for variables, texts, files and results, after which the run is stopped
    #[arg(long, value_name = "MIB", value_parser = clap::value_parser!(u64).range(1..))]
    pub(crate) max_memory: Option<u64>,
}

#[derive(Debug, Args)]
pub(crate) struct Run {
    #[command(flatten)]
    pub(crate) inputs: Inputs,
    /// Write listings, events, summary, timeline, toolpath and the files of macros into this folder
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Which of them; all without it
    #[arg(long, value_delimiter = ',', value_name = "RESULTS", requires = "out")]
    pub(crate) write: Vec<What>,
    /// No listing, but the log file (identification, diagnostics, summaries)
    #[arg(long, requires = "out")]
    pub(crate) nolist: bool,
    /// The log file besides the other results
    #[arg(long, requires = "out")]
    pub(crate) ef: bool,
    /// Lines of listings, logs and consoles end with CR and LF
    #[arg(long, requires = "out")]
    pub(crate) crlf: bool,
    /// Print the summary as JSON instead of the report
    #[arg(long)]
    pub(crate) json: bool,
    /// No progress, no report
    #[arg(long, short)]
    pub(crate) quiet: bool,
    /// All meetings and diagnostics in the report, not only the first of them
    #[arg(long, short, conflicts_with = "quiet")]
    pub(crate) verbose: bool,
    /// What the exit code tells: plain (0 to 3), or severity (the highest severity, 100 and up for what kept the run
    /// from starting)
    #[arg(long, value_enum, default_value = "plain", value_name = "FORM")]
    pub(crate) exit_code: ExitCodes,
    /// Macros may start commands of the operating system (SYSTEM) with your rights: only for machines that you trust
    #[arg(long)]
    pub(crate) allow_system: bool,
    /// Draw the timeline in the report (the default)
    #[arg(long, overrides_with = "no_timeline")]
    pub(crate) timeline: bool,
    /// Do not draw the timeline
    #[arg(long)]
    pub(crate) no_timeline: bool,
}

impl Run {
    /// A result is to be written.
    pub(crate) fn wants(&self, what: What) -> bool {
        match what {
            What::Listing if self.nolist => false,
            What::Log => self.ef || self.nolist || self.write.contains(&what),
            What::Console => self.write.contains(&what),
            _ => self.write.is_empty() || self.write.contains(&what),
        }
    }

    /// Something is asked for that is read off the event log after the run.
    pub(crate) fn needs_log(&self) -> bool {
        let trace = self.wants(What::Trace) && !self.inputs.trace.is_empty();
        let read = [What::Listing, What::Events, What::Log, What::Console].into_iter().any(|what| self.wants(what));
        self.out.is_some() && (read || trace)
    }
}

/// Optional-skip levels of the command line, 0 = that of marks without a digit.
#[derive(Debug, Clone, Default)]
pub(crate) struct Levels(pub(crate) Vec<u32>);

fn levels(text: &str) -> Result<Levels, String> {
    match text {
        "off" => return Ok(Levels::default()),
        "on" => return Ok(Levels(vec![0])),
        _ => {}
    }
    let level = |part: &str| part.trim().parse().ok().filter(|level| (1..=9).contains(level));
    let all: Option<Vec<u32>> = text.split(',').map(level).collect();
    all.map(Levels).ok_or_else(|| "expected off, on, or levels from 1 to 9 with commas between".to_owned())
}

/// What the exit code of a run tells.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ExitCodes {
    Plain,
    Severity,
}

/// Where the server is.
#[derive(Debug, Args, Clone)]
pub(crate) struct Remote {
    /// Address of the server
    #[arg(long, env = "COUNTERPOINT_SERVER", default_value = "http://127.0.0.1:7878", value_name = "URL")]
    pub(crate) server: String,
}

#[derive(Debug, Args)]
pub(crate) struct Submit {
    #[command(flatten)]
    pub(crate) inputs: Inputs,
    #[command(flatten)]
    pub(crate) remote: Remote,
    /// Identity of the request: the same id gives the same job
    #[arg(long, value_name = "ID")]
    pub(crate) request_id: Option<String>,
}

#[derive(Debug, Args)]
pub(crate) struct OneJob {
    /// The job
    pub(crate) job: String,
    #[command(flatten)]
    pub(crate) remote: Remote,
    /// No progress
    #[arg(long, short)]
    pub(crate) quiet: bool,
}

#[derive(Debug, Args)]
pub(crate) struct Jobs {
    #[command(flatten)]
    pub(crate) remote: Remote,
    /// Only jobs in these states
    #[arg(long, value_enum, value_delimiter = ',')]
    pub(crate) state: Vec<State>,
    /// Print JSON, one object per line
    #[arg(long)]
    pub(crate) json: bool,
}

/// States to filter by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum State {
    Queued,
    Running,
    Succeeded,
    Failed,
    Cancelled,
}

#[derive(Debug, Args)]
pub(crate) struct ResultOf {
    /// The job
    pub(crate) job: String,
    /// Which result
    #[arg(value_enum)]
    pub(crate) what: What,
    /// Channel of the listing; 0: the merged listing of all, the console of all
    #[arg(long, default_value_t = 1, value_name = "N")]
    pub(crate) channel: u32,
    /// Lines of a listing, log or console end with CR and LF
    #[arg(long)]
    pub(crate) crlf: bool,
    /// Form of timeline and toolpath
    #[arg(long, value_enum, default_value = "svg")]
    pub(crate) format: Format,
    /// Write to this file instead of standard output; a folder for files
    #[arg(long, short, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) remote: Remote,
}

/// Results.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum What {
    Summary,
    Listing,
    Trace,
    Log,
    /// Messages and diagnostics, a line each
    Console,
    Timeline,
    Toolpath,
    Events,
    /// Files that the macros of the machine have written: with an output folder themselves, else their sizes and paths
    Files,
}

/// Forms of drawings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Format {
    Svg,
    Json,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Machine {
    /// Check a machine; findings with file, line and column
    Check {
        /// A name or a folder with machine.toml
        machine: String,
        #[command(flatten)]
        at: At,
    },
    /// List the machines
    List {
        #[command(flatten)]
        at: At,
    },
    /// Show a machine, or a part of it
    Show {
        /// A name or a folder with machine.toml
        machine: String,
        /// Which part
        #[arg(value_enum, default_value = "all")]
        part: Part,
        /// As JSON
        #[arg(long)]
        json: bool,
        #[command(flatten)]
        at: At,
    },
}

/// A server, or this program itself.
#[derive(Debug, Args)]
pub(crate) struct At {
    /// Ask this server instead of the machines built in
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
}

/// A time in seconds above zero.
fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value < 9e9 => Ok(value),
        _ => Err("expected seconds above 0 and below 9000000000".to_owned()),
    }
}
