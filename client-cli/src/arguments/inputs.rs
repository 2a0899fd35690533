//! The inputs of a job: programs, a machine, options.

use std::path::PathBuf;

use clap::Args;

use crate::encoding::Encoding;
use crate::settings::MachineSetting;

/// Inputs of a job.
#[derive(Debug, Args)]
pub(crate) struct Inputs {
    /// Run these programs, one per channel from left to right; FILE#2102 is program O2102 of FILE,
    /// FILE#NAME the program or section of that name (`PART_1`, `$2`, `G14`); - reads standard input, once
    #[arg(required = true, value_name = "PROGRAM")]
    pub(crate) programs: Vec<String>,
    #[command(flatten)]
    pub(crate) on: On,
    #[command(flatten)]
    pub(crate) files: ProgramFiles,
    #[command(flatten)]
    pub(crate) switches: Switches,
    /// Let these channels pass every sync point without waiting
    #[arg(long, value_delimiter = ',', value_name = "CHANNELS")]
    pub(crate) ignore_waits: Vec<u32>,
    /// Report variables that two channels access in an order that only timing decides: as a warning, or as an alarm
    /// that stops the later channel
    #[arg(long, value_enum, default_value_t = RaceCheck::Warn, value_name = "off|warn|alarm", hide_possible_values = true)]
    pub(crate) races: RaceCheck,
    #[command(flatten)]
    pub(crate) timing: TimingArgs,
    /// Run at most this many channels in parallel (0 = all); results are identical for any value
    #[arg(long, default_value_t = 0, value_name = "N")]
    pub(crate) threads: u32,
    /// Trace the steps selected by these letters: I input blocks, E edited blocks, W words, C codes and data, A
    /// actions, M code and data macros, H other macros, S messages, X MDI and EXEC, Z files stored with the machine
    /// [without letters: all]
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
    pub(crate) operator: OperatorFlags,
    /// Stop the run at the end of the block in which this simulated time, in seconds, is exceeded [default: 86400]
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    pub(crate) max_time: Option<f64>,
    /// Stop the run after a channel has executed this many blocks [default: 10000000]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub(crate) max_blocks: Option<u64>,
    /// Stop the run when the variables, texts, files and results of the job need more than this memory, in MiB
    #[arg(long, value_name = "MIB", value_parser = clap::value_parser!(u64).range(1..))]
    pub(crate) max_memory: Option<u64>,
}

/// The files of a job besides its programs, and the encoding of the programs.
#[derive(Debug, Clone, Default, Args)]
pub(crate) struct ProgramFiles {
    /// Add files that the programs may call (a folder adds all its files)
    #[arg(long = "with", value_name = "FILE|DIR")]
    pub(crate) with: Vec<PathBuf>,
    /// Add no files from the folders of the programs, only those named by --with
    #[arg(long)]
    pub(crate) no_neighbours: bool,
    /// Read the programs in this code page: windows-1252, iso-8859-2, cp850, shift_jis, utf-16le, … [default: UTF-8, or
    /// UTF-16]
    #[arg(long, value_name = "NAME")]
    pub(crate) encoding: Option<Encoding>,
    /// Name the program from standard input (-), for messages, results and the guess of the machine [default: standard
    /// input]
    #[arg(long, value_name = "FILE", value_parser = file_name)]
    pub(crate) name: Option<String>,
}

/// The name of a file without folders.
fn file_name(text: &str) -> Result<String, String> {
    const LONGEST: usize = 200;
    let strange = |c: char| c.is_control() || "/\\:#".contains(c);
    if text.is_empty() || text.len() > LONGEST || text.contains(strange) || [".", "..", "-"].contains(&text) {
        return Err(format!("expected the name of a file, without folders, ':' and '#', of at most {LONGEST} bytes"));
    }
    Ok(text.to_owned())
}

/// The machine of a job.
#[derive(Debug, Clone, Default, Args)]
pub(crate) struct On {
    /// Run on this machine: a name, or a folder with machine.toml [default: guessed from the programs; the job is
    /// refused if no machine can be guessed]
    #[arg(long, value_name = "NAME|DIR", value_parser = super::filled::filled)]
    pub(crate) machine: Option<String>,
    /// Set a datum of the machine for this run; can be repeated: `waits=900-999`, the M codes that are waiting codes;
    /// `numbers=increments`, coordinates without a decimal point count least increments; `units=inch`, the unit in
    /// which programs begin (inch or mm); `system=B`, the G-code system of a lathe (A, B or C); `shared=500-549`,
    /// common variables that all channels share; `stop.B=-408`, the position at which axis B meets a part or a stop;
    /// `warn.2900680=off`, a warning by number or word, off or on
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<MachineSetting>,
    /// Read tools, tool offsets and work offsets from this table: TOML rows as in a machine definition, or a CSV file
    /// with a column `number`
    #[arg(long, value_name = "FILE")]
    pub(crate) tools: Option<PathBuf>,
}

impl Inputs {
    /// Programs and nothing else, one channel after the other.
    pub(crate) fn plain(programs: &[String]) -> Self {
        Self {
            programs: programs.to_vec(),
            on: On::default(),
            files: ProgramFiles::default(),
            switches: Switches::default(),
            ignore_waits: Vec::new(),
            races: RaceCheck::Off,
            timing: TimingArgs { time: Timing::Full, law: false },
            threads: 1,
            trace: String::new(),
            param: String::new(),
            answers: None,
            operator: OperatorFlags::default(),
            max_time: None,
            max_blocks: None,
            max_memory: None,
        }
    }
}

/// How moves are timed.
#[derive(Debug, Clone, Args)]
pub(crate) struct TimingArgs {
    /// Compute the time of moves at feed in full, with the acceleration, corners and look-ahead of the machine
    /// definition, or simply as length divided by feed
    #[arg(long, value_enum, default_value_t = Timing::Full, value_name = "full|simple", hide_possible_values = true)]
    pub(crate) time: Timing,
    /// Record the law of each motion in the events: the positions of its axes between its ends
    #[arg(long)]
    pub(crate) law: bool,
}

/// Actions of the operator while the job runs.
#[derive(Debug, Clone, Copy, Default, Args)]
pub(crate) struct OperatorFlags {
    /// Ask the operator when a dialog has no prepared answer: `run` asks on this terminal (the default there), `submit`
    /// leaves the question to `counterpoint attend`. Without this flag such a dialog fails
    #[arg(long)]
    pub(crate) attend: bool,
    /// Step through the job: `run` reads commands from standard input (`help` lists them) and writes stops to standard
    /// output, `submit` leaves the job to `counterpoint step`
    #[arg(long)]
    pub(crate) step: bool,
}

/// Switches of the operator's panel.
#[derive(Debug, Clone, Default, Args)]
pub(crate) struct Switches {
    /// Set optional block skip: off, on (for marks without a digit), or a list of levels such as 1,3
    #[arg(long, default_value = "off", value_name = "off|on|LEVELS", value_parser = levels)]
    pub(crate) opskip: SkipLevels,
    /// Stop at optional stops (M1)
    #[arg(long)]
    pub(crate) opstop: bool,
}

/// Consequence of a race over a shared variable.
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

/// Levels of optional block skip, 0 for marks without a digit.
#[derive(Debug, Clone, Default)]
pub(crate) struct SkipLevels(pub(crate) Vec<u32>);

pub(super) fn levels(text: &str) -> Result<SkipLevels, String> {
    match text {
        "off" => return Ok(SkipLevels::default()),
        "on" => return Ok(SkipLevels(vec![0])),
        _ => {}
    }
    let level = |part: &str| part.trim().parse().ok().filter(|level| (1..=9).contains(level));
    let all: Option<Vec<u32>> = text.split(',').map(level).collect();
    all.map(SkipLevels).ok_or_else(|| "expected off, on, or a list of levels from 1 to 9 such as 1,3".to_owned())
}

/// A time in seconds above zero.
pub(super) fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value < 9e9 => Ok(value),
        _ => Err("expected seconds above 0 and below 9000000000".to_owned()),
    }
}
