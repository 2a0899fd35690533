//! The command line.

mod calibrate;
mod elsewhere;
mod filled;
mod inputs;
mod jobs;
mod lint;
mod machines;

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};

use crate::remote::Remote;
pub(crate) use calibrate::Calibrate;
pub(crate) use elsewhere::with_similar_command;
pub(crate) use inputs::{Inputs, On, ProgramFiles, RaceCheck, SkipLevels, Switches, Timing};
pub(crate) use jobs::{
    JobFilter, JobListArgs, JobPriority, Many, NAME, RequestArgs, Rerun, StateFilter, StatusArgs, TimePoint, WaitArgs,
    WatchArgs,
};
pub(crate) use lint::Lint;
pub(crate) use machines::{MachineCommand, MachinePart, RowSelection};

const EXAMPLES: &str = "\
Examples:
  counterpoint run part.nc                      run a program, guess the machine
  counterpoint machine list                     list the machines
  counterpoint explain wait-mismatch            explain a diagnostic";

const RUN_EXAMPLES: &str = "\
Examples:
  counterpoint run --machine fanuc-mill part.nc
  counterpoint run upper.nc lower.nc --out results
  counterpoint run --machine ./my-lathe twin.nc#2101 twin.nc#2102 --json
  counterpoint run part.nc --out out --write summary,toolpath --strict
  post-processor part.cl | counterpoint run - --name part.nc

Default limits: 86400 s (24 h) of simulated time; per channel 10000000 blocks, 1000000 blocks in a row without
time, 40000000 events, and 1000 diagnostics kept.";

const LINT_EXAMPLES: &str = "\
Examples:
  counterpoint lint upper.nc lower.nc
  counterpoint lint --machine siemens-2channel main_1.mpf main_2.mpf --with subprograms --strict --json";

const CALIBRATE_EXAMPLES: &str = "Examples:
  counterpoint calibrate --machine fanuc-mill --measured lines.csv part.nc
  counterpoint calibrate --machine fanuc-mill --measured samples.xml part.nc --out my-mill";

const SUBMIT_EXAMPLES: &str = "\
Examples:
  counterpoint submit --machine fanuc-2path-lathe upper.nc lower.nc
  counterpoint watch $(counterpoint submit --machine fanuc-mill part.nc)
  counterpoint submit --machine fanuc-mill part.nc --label 'bracket 17' --label order=4711
  counterpoint submit --machine fanuc-mill part.nc --priority high --deadline 30m";

const WATCH_EXAMPLES: &str = "\
Examples:
  counterpoint watch 01938f2c
  counterpoint watch --all --label part=17 --state failed";

const CANCEL_EXAMPLES: &str = "\
Examples:
  counterpoint cancel 01938f2c
  counterpoint cancel --state queued --label part=17 --dry-run
  counterpoint cancel --all --yes";

const DELETE_EXAMPLES: &str = "\
Examples:
  counterpoint delete 01938f2c
  counterpoint delete --state failed --machine fanuc-mill --yes";

const JOBS_EXAMPLES: &str = "\
Examples:
  counterpoint jobs --limit 20
  counterpoint jobs --machine fanuc-mill --label part=17 --state failed --since 24h
  counterpoint status 01938f2c";

const EXPLAIN_EXAMPLES: &str = "\
Examples:
  counterpoint explain G76 --machine haas-lathe
  counterpoint explain M98 P --machine fanuc-mill
  counterpoint explain '#5021' --machine ./my-mill
  counterpoint explain CYCLE83 --machine siemens-mill --json
  counterpoint explain G76                      list the machines that have the word
  counterpoint explain no-feed";

const ANALYSE_EXAMPLES: &str = "\
Examples:
  counterpoint run upper.nc lower.nc --out out && counterpoint analyse out
  counterpoint analyse out/summary.json --what-if 2:-2.5s --what-if 1:-2.5s
  counterpoint analyse 01938f2c-5d1e-7c4a-9b1e-3f8d2a6b7c90 --json";

const AT_EXAMPLES: &str = "\
Examples:
  counterpoint run upper.nc lower.nc --law --out out && counterpoint at out 12.5
  counterpoint at out 02:05.300 --channel 2
  counterpoint at 01938f2c 90 --json";

const WHERE_EXAMPLES: &str = "\
Examples:
  counterpoint where out upper.nc:120
  counterpoint where 01938f2c upper.nc:120 --json";

const LOAD_EXAMPLES: &str = "\
Examples:
  counterpoint load --mix examples/load/standard.toml --callers 8 --for 60s --html load.html
  counterpoint load --mix examples/load/standard.toml --rate 50 --max-p99-submit 30ms --max-errors 0";

/// Runs NC programs as the control would, block by block, all channels in parallel
#[derive(Debug, Parser)]
#[command(name = "counterpoint", version, after_help = EXAMPLES)]
pub(crate) struct CliArgs {
    #[command(subcommand)]
    pub(crate) command: CliCommand,
}

#[derive(Debug, Subcommand)]
pub(crate) enum CliCommand {
    /// Run programs in this process and print a report
    #[command(after_help = RUN_EXAMPLES)]
    Run(RunArgs),
    /// Check the waits, calls and jumps of programs without running them
    #[command(after_help = LINT_EXAMPLES)]
    Lint(Lint),
    /// Submit programs to a server and print the id of the job
    #[command(after_help = SUBMIT_EXAMPLES)]
    Submit(Submit),
    /// Follow a job to its end, or with --all the states of all jobs
    #[command(after_help = WATCH_EXAMPLES)]
    Watch(WatchArgs),
    /// Answer the dialogs of a job submitted with --attend
    Attend(Follow),
    /// Step through a job submitted with --step, with the commands of `run --step`
    Step(Follow),
    /// Wait until jobs have ended: the named jobs, or all that a filter selects
    Wait(WaitArgs),
    /// List the jobs of a server
    #[command(after_help = JOBS_EXAMPLES)]
    Jobs(JobListArgs),
    /// Show the known data of a job: state, machine, labels, times, verdict
    Status(StatusArgs),
    /// Run a job again with its files, options and machine revision; print the new job's id
    Rerun(Rerun),
    /// Cancel a job, or all jobs that a filter selects
    #[command(after_help = CANCEL_EXAMPLES)]
    Cancel(Many),
    /// Pause a job until it is resumed; a run in progress is stopped
    Pause(JobArgs),
    /// Resume a paused job; it runs from its start
    Resume(JobArgs),
    /// Delete an ended job with its results, or all ended jobs that a filter selects
    #[command(after_help = DELETE_EXAMPLES)]
    Delete(Many),
    /// Read a result of an ended job
    Result(ResultArgs),
    /// Administer a server (needs the role admin)
    #[command(subcommand)]
    Admin(AdminCommand),
    /// Put load on a server and report rates, latencies and errors
    #[command(after_help = LOAD_EXAMPLES)]
    Load(crate::load::arguments::LoadArgs),
    /// Check, list, show and compare machines, create your own machine, try its tape editor
    #[command(subcommand)]
    Machine(MachineCommand),
    /// Check, reformat, run and explain macros
    #[command(subcommand)]
    Macro(crate::macros::arguments::MacroCommand),
    /// Show the causes of the cycle time: critical path over the channels, slack, cost of waits, gain of a change
    #[command(after_help = ANALYSE_EXAMPLES)]
    Analyse(Analyse),
    /// Show each channel at an instant: its block, position, tool, spindles, wait
    #[command(after_help = AT_EXAMPLES)]
    At(At),
    /// Show when a block was executed, and how long it took
    #[command(after_help = WHERE_EXAMPLES)]
    Where(Where),
    /// Fit the times of a machine to measured times of program lines, and report the quality of the fit
    #[command(after_help = CALIBRATE_EXAMPLES)]
    Calibrate(Calibrate),
    /// Explain a word of a program on a machine, a diagnostic, an alarm, or a word of the macro language
    #[command(after_help = EXPLAIN_EXAMPLES)]
    Explain(Explain),
    /// Write man pages of all commands into a folder, or print the page of the program
    Man {
        /// Folder for the pages, such as /usr/local/share/man/man1 [default: print one page, for `man -l -`]
        #[arg(value_name = "DIR")]
        folder: Option<PathBuf>,
    },
    /// Print a completion script for a shell
    Completions {
        /// Print the script for this shell
        shell: clap_complete::Shell,
    },
}

#[derive(Debug, Args)]
pub(crate) struct RunArgs {
    #[command(flatten)]
    pub(crate) inputs: Inputs,
    /// Write listings, events, summary, timeline, toolpath and the files of macros into this folder
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Write only these results to --out [default: all but log, console and report]
    #[arg(long, value_delimiter = ',', value_name = "RESULTS", requires = "out")]
    pub(crate) write: Vec<ResultKind>,
    /// Write the log file (identification, diagnostics, summaries) instead of the listing
    #[arg(long, requires = "out")]
    pub(crate) nolist: bool,
    /// Also write the log file
    #[arg(long, requires = "out")]
    pub(crate) ef: bool,
    /// End the lines of listings, logs and consoles with CR and LF
    #[arg(long, requires = "out")]
    pub(crate) crlf: bool,
    /// Print the summary as JSON instead of the report
    #[arg(long)]
    pub(crate) json: bool,
    /// Print only errors: no progress, no report
    #[arg(long, short)]
    pub(crate) quiet: bool,
    /// Show all sync points and diagnostics in the report, not only the first 20
    #[arg(long, short, conflicts_with = "quiet")]
    pub(crate) verbose: bool,
    /// Exit with code 1 even if there are only warnings
    #[arg(long)]
    pub(crate) strict: bool,
    /// Select the exit codes: plain (0 to 3), or severity (the highest severity of the run; 100 and above if the run
    /// could not start)
    #[arg(long, value_enum, default_value = "plain", value_name = "FORM")]
    pub(crate) exit_code: ExitCodes,
    /// Allow macros to run operating system commands (SYSTEM) with your rights; use only with machines that you trust
    #[arg(long)]
    pub(crate) allow_system: bool,
    /// Draw the timeline in the report (the default)
    #[arg(long, overrides_with = "no_timeline")]
    pub(crate) timeline: bool,
    /// Do not draw the timeline
    #[arg(long)]
    pub(crate) no_timeline: bool,
}

impl RunArgs {
    /// Whether a result is to be written.
    pub(crate) fn wants(&self, what: ResultKind) -> bool {
        let named = self.write.contains(&what) || self.write.contains(&ResultKind::All);
        match what {
            ResultKind::Listing if self.nolist => false,
            ResultKind::Log => self.ef || self.nolist || named,
            ResultKind::Console | ResultKind::Report => named,
            _ => self.write.is_empty() || named,
        }
    }
}

/// Meaning of the exit code of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ExitCodes {
    Plain,
    Severity,
}

#[derive(Debug, Args)]
pub(crate) struct Submit {
    #[command(flatten)]
    pub(crate) inputs: Inputs,
    #[command(flatten)]
    pub(crate) remote: Remote,
    #[command(flatten)]
    pub(crate) request: RequestArgs,
    /// Submit each program as a separate job, instead of one job with a channel for each program; prints one id per
    /// line, in the order of the programs. With --request-id ID the request ids are ID-1, ID-2 and so on in this order
    #[arg(long)]
    pub(crate) each: bool,
    /// With --each, report a program as not submitted if the server has no room for it, instead of waiting
    #[arg(long, requires = "each")]
    pub(crate) no_wait: bool,
    /// Run the job even if the server keeps the results of an equal one
    #[arg(long)]
    pub(crate) no_cache: bool,
    /// Print the id as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct JobArgs {
    /// Id of the job, or a prefix of it
    pub(crate) job: String,
    #[command(flatten)]
    pub(crate) remote: Remote,
    /// Print no progress
    #[arg(long, short)]
    pub(crate) quiet: bool,
}

/// A job that is followed to its end.
#[derive(Debug, Args)]
pub(crate) struct Follow {
    #[command(flatten)]
    pub(crate) of: JobArgs,
    /// Exit with code 1 even if there are only warnings
    #[arg(long)]
    pub(crate) strict: bool,
}

#[derive(Debug, Args)]
pub(crate) struct ResultArgs {
    /// Id of the job, or a prefix of it
    pub(crate) job: String,
    /// Read this result
    #[arg(value_enum)]
    pub(crate) what: ResultKind,
    /// Select the channel of a listing, log, console or trace (0 = the merged listing or the console of all channels)
    #[arg(long, default_value_t = 1, value_name = "N")]
    pub(crate) channel: u32,
    /// End the lines of a listing, log or console with CR and LF
    #[arg(long)]
    pub(crate) crlf: bool,
    /// Select the format of timeline and toolpath
    #[arg(long, value_enum, default_value = "svg")]
    pub(crate) format: OutputFormat,
    /// Write to this file instead of standard output; for `files` and `all`, to this folder
    #[arg(long, short, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) remote: Remote,
}

/// Subject to explain.
#[derive(Debug, Args)]
pub(crate) struct Explain {
    /// Explain this word or number, such as G76, 'M98 P', '#5021', no-feed, 2019001, PS0160, $FSIN, DECLAR or
    /// CODE_RAPID
    #[arg(value_name = "WORD|NUMBER", required = true)]
    pub(crate) words: Vec<String>,
    /// Explain its meaning on this machine: the name of a shipped machine, or a folder with machine.toml
    #[arg(long, value_name = "NAME|DIR")]
    pub(crate) machine: Option<String>,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// Subject of the analysis.
#[derive(Debug, Args)]
pub(crate) struct Analyse {
    /// Analyse this job of the server, summary.json, or the output folder of a run; - reads the summary from standard
    /// input
    #[arg(value_name = "JOB|FILE|DIR|-")]
    pub(crate) of: String,
    /// Compute the end of the job if a channel works this much faster (or slower, with +), such as 2:-2.5s; can be
    /// repeated
    #[arg(long, value_name = "CHANNEL:TIME")]
    pub(crate) what_if: Vec<String>,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) remote: Remote,
}

/// An instant of a job.
#[derive(Debug, Args)]
pub(crate) struct At {
    /// Read this job of the server, or the output folder of a run
    #[arg(value_name = "JOB|DIR")]
    pub(crate) of: String,
    /// Show this instant of simulated time: seconds such as 12.5, or 300ms, 2min, 02:05.300
    #[arg(value_name = "TIME")]
    pub(crate) time: String,
    /// Show only this channel
    #[arg(long, value_name = "N")]
    pub(crate) channel: Option<u16>,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) remote: Remote,
}

/// A block of a job.
#[derive(Debug, Args)]
pub(crate) struct Where {
    /// Read this job of the server, or the output folder of a run
    #[arg(value_name = "JOB|DIR")]
    pub(crate) of: String,
    /// Show the times of this block, such as part.nc:120
    #[arg(value_name = "FILE:LINE")]
    pub(crate) place: String,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) remote: Remote,
}

/// Results.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ResultKind {
    Summary,
    Listing,
    Trace,
    Log,
    /// Messages and diagnostics, one per line
    Console,
    Timeline,
    Toolpath,
    Events,
    /// Files that macros have written; without -o, only their sizes and paths
    Files,
    /// Report that `run` prints
    Report,
    /// All results, written to a folder
    All,
}

/// Forms of drawings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum OutputFormat {
    Svg,
    Json,
}

/// Requests of an administrator.
#[derive(Debug, Subcommand)]
pub(crate) enum AdminCommand {
    /// List the connections of the server
    Connections(AdminArgs),
    /// List the watches and their lag behind the logs
    Streams(AdminArgs),
    /// List the running jobs
    Workers(AdminArgs),
    /// Shut the server down: running jobs end or are queued again
    Drain(AdminArgs),
    /// Remove expired jobs and unneeded blobs at once
    Collect(AdminArgs),
    /// Rewrite the ledger without its free space; submits wait until this is done
    Compact(AdminArgs),
}

#[derive(Debug, Args)]
pub(crate) struct AdminArgs {
    #[command(flatten)]
    pub(crate) remote: Remote,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_help_names_the_limits_of_the_kernel() {
        let limits = counterpoint_kernel::options::JobLimits::default();
        let seconds = limits.simulated_ns / 1_000_000_000;
        for number in [seconds as u64, limits.blocks, limits.zero_time_blocks, limits.events, limits.diagnostics.into()]
        {
            assert!(RUN_EXAMPLES.contains(&format!(" {number} ")), "{number}");
        }
    }
}
