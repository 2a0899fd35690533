//! The command line.

mod jobs;
mod lint;
mod machines;

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};

use crate::remote::Remote;
use crate::settings::Setting;
pub(crate) use jobs::{JobFilter, Jobs, Priority, RequestArgs, Rerun, State, Watch, When};
pub(crate) use lint::Lint;
pub(crate) use machines::{Machine, Part};

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

Default limits: 86400 s (24 h) of simulated time; per channel 10000000 blocks, 1000000 blocks in a row without
time, 40000000 events, and 1000 diagnostics kept.";

const LINT_EXAMPLES: &str = "\
Examples:
  counterpoint lint upper.nc lower.nc
  counterpoint lint --machine siemens-2channel main_1.mpf main_2.mpf --with subprograms --strict --json";

const SUBMIT_EXAMPLES: &str = "\
Examples:
  counterpoint submit --machine fanuc-2path-lathe upper.nc lower.nc
  counterpoint watch $(counterpoint submit --machine fanuc-mill part.nc)
  counterpoint submit --machine fanuc-mill part.nc --label part=17 --priority high --deadline 30m";

const WATCH_EXAMPLES: &str = "\
Examples:
  counterpoint watch 01938f2c-5d1e-7c4a-9b1e-3f8d2a6b7c90
  counterpoint watch --all --label part=17 --state failed";

const JOBS_EXAMPLES: &str = "\
Examples:
  counterpoint jobs --newest --limit 20
  counterpoint jobs --machine fanuc-mill --label part=17 --state failed --since 24h";

const ANALYSE_EXAMPLES: &str = "\
Examples:
  counterpoint run upper.nc lower.nc --out out && counterpoint analyse out
  counterpoint analyse out/summary.json --what-if 2:-2.5s --what-if 1:-2.5s
  counterpoint analyse 01938f2c-5d1e-7c4a-9b1e-3f8d2a6b7c90 --json";

const LOAD_EXAMPLES: &str = "\
Examples:
  counterpoint load --mix examples/load/standard.toml --callers 8 --for 60s --html load.html
  counterpoint load --mix examples/load/standard.toml --rate 50 --max-p99-submit 30ms --max-errors 0";

/// Runs NC programs as the control would, block by block, all channels in parallel
#[derive(Debug, Parser)]
#[command(name = "counterpoint", version, after_help = EXAMPLES)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Run programs in this process and print a report
    #[command(after_help = RUN_EXAMPLES)]
    Run(Run),
    /// Judge the waits, calls and jumps of programs without running them
    #[command(after_help = LINT_EXAMPLES)]
    Lint(Lint),
    /// Submit programs to a server and print the id of the job
    #[command(after_help = SUBMIT_EXAMPLES)]
    Submit(Submit),
    /// Follow a job to its end, or with --all the states of all jobs
    #[command(after_help = WATCH_EXAMPLES)]
    Watch(Watch),
    /// Answer the dialogs of a job that was submitted with --attend
    Attend(Follow),
    /// Step through a job that was submitted with --step; commands as for `run --step`
    Step(Follow),
    /// Wait for the end of a job
    Wait(Follow),
    /// List the jobs of a server
    #[command(after_help = JOBS_EXAMPLES)]
    Jobs(Jobs),
    /// Run a job again with its files, options and machine revision; print the new job's id
    Rerun(Rerun),
    /// Ask a job to stop
    Cancel(JobArgs),
    /// Hold a job back until it is resumed; a run under way is stopped
    Pause(JobArgs),
    /// Let a paused job run, from its start
    Resume(JobArgs),
    /// Remove an ended job with its results
    Delete(JobArgs),
    /// Read a result of an ended job
    Result(ResultArgs),
    /// Look after a server (role admin)
    #[command(subcommand)]
    Admin(Admin),
    /// Put load on a server and report how it copes
    #[command(after_help = LOAD_EXAMPLES)]
    Load(crate::load::arguments::Load),
    /// Check, list, show and delete machines
    #[command(subcommand)]
    Machine(Machine),
    /// Check, rewrite, run and explain macros
    #[command(subcommand)]
    Macro(crate::macros::arguments::Macro),
    /// Show what decides the cycle time: the critical path over the channels, slack, what waits cost, what a change saves
    #[command(after_help = ANALYSE_EXAMPLES)]
    Analyse(Analyse),
    /// Explain a diagnostic by its word or number, an alarm, or a word of the macro language
    Explain {
        /// Explain this word or number, such as no-feed, 2019001, PS0160, $FSIN, DECLAR, $TLTAB or CODE_RAPID
        #[arg(value_name = "WORD|NUMBER")]
        what: String,
    },
    /// Print a completion script for a shell
    Completions {
        /// Print the script for this shell
        shell: clap_complete::Shell,
    },
}

/// What a job is made of.
#[derive(Debug, Args)]
pub(crate) struct Inputs {
    /// Run these programs, one per channel from left to right; FILE#2102 is program O2102 of FILE,
    /// FILE#NAME the program or section of that name (`PART_1`, `$2`, `G14`)
    #[arg(required = true, value_name = "PROGRAM")]
    pub(crate) programs: Vec<String>,
    #[command(flatten)]
    pub(crate) on: On,
    /// Add files that the programs may call (a folder adds all its files)
    #[arg(long = "with", value_name = "FILE|DIR")]
    pub(crate) with: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) switches: Switches,
    /// Let these channels pass every sync point without waiting
    #[arg(long, value_delimiter = ',', value_name = "CHANNELS")]
    pub(crate) ignore_waits: Vec<u32>,
    /// Report variables that two channels reach in an order that only timing decides: as a warning, or as an alarm that
    /// stops the channel
    #[arg(long, value_enum, default_value_t = RaceCheck::Off, value_name = "off|warn|alarm", hide_possible_values = true)]
    pub(crate) races: RaceCheck,
    /// Time moves at feed as the machine makes them, with acceleration, corners and look-ahead where its definition gives
    /// them, or simply as length by feed
    #[arg(long, value_enum, default_value_t = Timing::Full, value_name = "full|simple", hide_possible_values = true)]
    pub(crate) time: Timing,
    /// Run at most this many channels in parallel (0 = all); results are identical for any value
    #[arg(long, default_value_t = 0, value_name = "N")]
    pub(crate) threads: u32,
    /// Trace the steps of these letters: I input blocks, E edited blocks, W words, C codes and data, A actions, M code and
    /// data macros, H other macros, S messages, X MDI and EXEC, Z files stored with the machine [without letters: all]
    #[arg(
        long,
        value_name = "LETTERS",
        num_args = 0..=1,
        default_value = "",
        default_missing_value = "all",
        hide_default_value = true
    )]
    pub(crate) trace: String,
    /// Pass this line of parameters to the macros of the machine, which read it in $UPARAM
    #[arg(long, value_name = "TEXT", default_value = "", hide_default_value = true, allow_hyphen_values = true)]
    pub(crate) param: String,
    /// Answer the dialogs of the machine from this TOML file: `[[answers]]` with dialog, button, values
    #[arg(long, value_name = "FILE")]
    pub(crate) answers: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) operator: Attended,
    /// Stop the run at this simulated time, in seconds [default: 86400]
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    pub(crate) max_time: Option<f64>,
    /// Stop the run when a channel has executed this many blocks [default: 10000000]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub(crate) max_blocks: Option<u64>,
    /// Stop the run when the variables, texts, files and results of the job need more than this memory, in MiB
    #[arg(long, value_name = "MIB", value_parser = clap::value_parser!(u64).range(1..))]
    pub(crate) max_memory: Option<u64>,
}

/// The machine of a job.
#[derive(Debug, Clone, Default, Args)]
pub(crate) struct On {
    /// Run on this machine: a name, or a folder with machine.toml [default: guessed from the programs, or refused if they
    /// do not show it]
    #[arg(long, value_name = "NAME|DIR")]
    pub(crate) machine: Option<String>,
    /// Set a datum of the machine for this run: `waits=FIRST-LAST`, the M codes that are waiting codes
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<Setting>,
    /// Take tools, tool offsets and work offsets from this table: TOML rows as in a machine definition, or a CSV file with a
    /// column `number`
    #[arg(long, value_name = "FILE")]
    pub(crate) tools: Option<PathBuf>,
}

/// What the operator does while the job runs.
#[derive(Debug, Clone, Copy, Default, Args)]
pub(crate) struct Attended {
    /// Ask the operator when a dialog has no prepared answer: `run` asks on this terminal (the default there), `submit`
    /// leaves the question to `counterpoint attend`. Without this flag such a dialog fails
    #[arg(long)]
    pub(crate) attend: bool,
    /// Step through the job: `run` reads commands from standard input (`help` lists them) and writes stops to standard output,
    /// `submit` leaves the job to `counterpoint step`
    #[arg(long)]
    pub(crate) step: bool,
}

/// Switches of the operator's panel.
#[derive(Debug, Clone, Default, Args)]
pub(crate) struct Switches {
    /// Switch optional block skip: off, on (for marks without a digit), or a list of levels such as 1,3
    #[arg(long, default_value = "off", value_name = "off|on|LEVELS", value_parser = levels)]
    pub(crate) opskip: Levels,
    /// Stop at optional stops (M1)
    #[arg(long)]
    pub(crate) opstop: bool,
}

/// What follows from a race over a shared variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum RaceCheck {
    /// Races are not looked for.
    Off,
    /// A warning.
    Warn,
    /// An alarm that stops the channel.
    Alarm,
}

/// How moves at feed are timed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Timing {
    /// As the machine makes them.
    Full,
    /// Length by feed.
    Simple,
}

#[derive(Debug, Args)]
pub(crate) struct Run {
    #[command(flatten)]
    pub(crate) inputs: Inputs,
    /// Write listings, events, summary, timeline, toolpath and the files of macros into this folder
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Write only these results to --out [default: all but log and console]
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
    /// Exit with code 1 after warnings, too
    #[arg(long)]
    pub(crate) strict: bool,
    /// Choose the exit codes: plain (0 to 3), or severity (the highest severity of the run; 100 and above if the run
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

impl Run {
    /// Whether a result is to be written.
    pub(crate) fn wants(&self, what: ResultKind) -> bool {
        match what {
            ResultKind::Listing if self.nolist => false,
            ResultKind::Log => self.ef || self.nolist || self.write.contains(&what),
            ResultKind::Console => self.write.contains(&what),
            _ => self.write.is_empty() || self.write.contains(&what),
        }
    }

    /// Whether a result is wanted that is made from the event log after the run.
    pub(crate) fn needs_log(&self) -> bool {
        let trace = self.wants(ResultKind::Trace) && !self.inputs.trace.is_empty();
        let read = [ResultKind::Listing, ResultKind::Events, ResultKind::Log, ResultKind::Console]
            .into_iter()
            .any(|what| self.wants(what));
        self.out.is_some() && (read || trace)
    }
}

/// Levels of optional block skip, 0 for marks without a digit.
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
    all.map(Levels).ok_or_else(|| "expected off, on, or a list of levels from 1 to 9 such as 1,3".to_owned())
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
}

#[derive(Debug, Args)]
pub(crate) struct JobArgs {
    /// Id of the job
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
    /// Exit with code 1 after warnings, too
    #[arg(long)]
    pub(crate) strict: bool,
}

#[derive(Debug, Args)]
pub(crate) struct ResultArgs {
    /// Id of the job
    pub(crate) job: String,
    /// Read this result
    #[arg(value_enum)]
    pub(crate) what: ResultKind,
    /// Choose the channel of a listing, log, console or trace (0 = the merged listing or the console of all channels)
    #[arg(long, default_value_t = 1, value_name = "N")]
    pub(crate) channel: u32,
    /// End the lines of a listing, log or console with CR and LF
    #[arg(long)]
    pub(crate) crlf: bool,
    /// Choose the format of timeline and toolpath
    #[arg(long, value_enum, default_value = "svg")]
    pub(crate) format: Format,
    /// Write to this file instead of standard output; for `files`, to this folder
    #[arg(long, short, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) remote: Remote,
}

/// What to analyse.
#[derive(Debug, Args)]
pub(crate) struct Analyse {
    /// Analyse this job of the server, summary.json, or the output folder of a run
    #[arg(value_name = "JOB|FILE|DIR")]
    pub(crate) of: String,
    /// Compute the end of the job if a channel works this much faster (or slower, with +), such as 2:-2.5s; repeat for
    /// other questions
    #[arg(long, value_name = "CHANNEL:TIME")]
    pub(crate) what_if: Vec<String>,
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
    /// The files that macros have written; without --output only their sizes and paths
    Files,
}

/// Forms of drawings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Format {
    Svg,
    Json,
}

/// What an administrator asks for.
#[derive(Debug, Subcommand)]
pub(crate) enum Admin {
    /// List the connections of the server
    Connections(AdminArgs),
    /// List the watches and how far they are behind
    Streams(AdminArgs),
    /// List the jobs that run
    Workers(AdminArgs),
    /// Ask the server to shut down: running jobs end or are queued again
    Drain(AdminArgs),
    /// Ask the server to remove expired jobs and unneeded blobs now
    Collect(AdminArgs),
}

#[derive(Debug, Args)]
pub(crate) struct AdminArgs {
    #[command(flatten)]
    pub(crate) remote: Remote,
}

/// A time in seconds above zero.
fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value < 9e9 => Ok(value),
        _ => Err("expected seconds above 0 and below 9000000000".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_help_names_the_limits_of_the_kernel() {
        let limits = counterpoint_kernel::options::Limits::default();
        let seconds = limits.simulated_ns / 1_000_000_000;
        for number in [seconds as u64, limits.blocks, limits.zero_time_blocks, limits.events, limits.diagnostics.into()]
        {
            assert!(RUN_EXAMPLES.contains(&format!(" {number} ")), "{number}");
        }
    }
}
