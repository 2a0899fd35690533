//! Arguments of `load`.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;

use crate::remote::Remote;

#[derive(Debug, Args)]
#[command(group(clap::ArgGroup::new("pace").required(true)))]
pub(crate) struct LoadArgs {
    /// Read the kinds of jobs from this TOML file: `[[job]]` with name, weight, machine, programs or made, watch
    #[arg(long, value_name = "FILE")]
    pub(crate) mix: PathBuf,
    /// Submit this many jobs per second, regardless of how they end
    #[arg(long, value_name = "N", group = "pace", value_parser = rate)]
    pub(crate) rate: Option<f64>,
    /// Let this many callers submit one job after another; a caller follows a watched job to its end
    #[arg(long, value_name = "N", group = "pace", value_parser = count)]
    pub(crate) callers: Option<usize>,
    /// Measure for this time (60s, 5m)
    #[arg(long = "for", value_name = "TIME", default_value = "60s", value_parser = some_time)]
    pub(crate) time: Duration,
    /// Submit for this time before measuring
    #[arg(long, value_name = "TIME", default_value = "5s", value_parser = time)]
    pub(crate) warm_up: Duration,
    /// Stop after this many jobs
    #[arg(long, value_name = "N")]
    pub(crate) jobs: Option<u64>,
    /// Wait at most this time for the jobs in progress at the end
    #[arg(long, value_name = "TIME", default_value = "30s", value_parser = time)]
    pub(crate) patience: Duration,
    /// Open this many connections [default: one per 100 callers; 4 with --rate]
    #[arg(long, value_name = "N", value_parser = count)]
    pub(crate) connections: Option<usize>,
    /// Delete each job after its end
    #[arg(long)]
    pub(crate) delete: bool,
    /// Allow load on a server on another machine
    #[arg(long)]
    pub(crate) allow_remote: bool,
    /// Measure processor time, memory, descriptors, threads and data folder of this process [default: the process that
    /// listens on the port of the server]
    #[arg(long, value_name = "PID")]
    pub(crate) server_pid: Option<u32>,
    #[command(flatten)]
    pub(crate) output: ReportOutput,
    #[command(flatten)]
    pub(crate) thresholds: Thresholds,
    #[command(flatten)]
    pub(crate) remote: Remote,
}

/// Where the figures go.
#[derive(Debug, Args)]
pub(crate) struct ReportOutput {
    /// Write the report as JSON into this file
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
    /// Write the report with plots as HTML into this file
    #[arg(long, value_name = "FILE")]
    pub(crate) html: Option<PathBuf>,
    /// Show no live figures
    #[arg(long, short)]
    pub(crate) quiet: bool,
}

/// Thresholds: exit code 1 if one is missed.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Thresholds (exit code 1 if a threshold is missed)")]
pub(crate) struct Thresholds {
    /// Require an answer within this time (30ms) for 99 of 100 submits
    #[arg(long, value_name = "TIME", value_parser = time)]
    pub(crate) max_p99_submit: Option<Duration>,
    /// Require 99 of 100 watched jobs to start within this time
    #[arg(long, value_name = "TIME", value_parser = time)]
    pub(crate) max_p99_queue: Option<Duration>,
    /// Require 99 of 100 watches to deliver their first event within this time
    #[arg(long, value_name = "TIME", value_parser = time)]
    pub(crate) max_p99_first_event: Option<Duration>,
    /// Require 99 of 100 watched jobs to end within this time
    #[arg(long, value_name = "TIME", value_parser = time)]
    pub(crate) max_p99_end: Option<Duration>,
    /// Allow this many errors per 100 jobs
    #[arg(long, value_name = "PERCENT", value_parser = percent)]
    pub(crate) max_errors: Option<f64>,
    /// Allow memory, descriptors, threads and data folder of the server to grow by this many per cent from the first
    /// third of the measured time to the last (medians)
    #[arg(long, value_name = "PERCENT", value_parser = percent)]
    pub(crate) max_growth: Option<f64>,
    /// Require this many accepted jobs per second
    #[arg(long, value_name = "N", value_parser = rate)]
    pub(crate) min_submits: Option<f64>,
    /// Require this many ended watched jobs per second
    #[arg(long, value_name = "N", value_parser = rate)]
    pub(crate) min_ends: Option<f64>,
    /// Require this many events per second
    #[arg(long, value_name = "N", value_parser = rate)]
    pub(crate) min_events: Option<f64>,
}

fn rate(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value <= 1e9 => Ok(value),
        _ => Err("expected a number above 0".to_owned()),
    }
}

fn percent(text: &str) -> Result<f64, String> {
    match text.trim_end_matches('%').parse::<f64>() {
        Ok(value) if (0.0..=100.0).contains(&value) => Ok(value),
        _ => Err("expected 0 to 100".to_owned()),
    }
}

fn count(text: &str) -> Result<usize, String> {
    match text.parse::<usize>() {
        Ok(value) if (1..=100_000).contains(&value) => Ok(value),
        _ => Err("expected 1 to 100000".to_owned()),
    }
}

/// A time with its unit: 500us, 30ms, 60s, 5m, 2h.
fn time(text: &str) -> Result<Duration, String> {
    let expected = || "expected a time with its unit: 500us, 30ms, 60s, 5m or 2h".to_owned();
    let digits = text.len() - text.trim_start_matches(|c: char| c.is_ascii_digit() || c == '.').len();
    let (number, unit) = text.split_at_checked(digits).ok_or_else(expected)?;
    let number: f64 = number.parse().map_err(|_| expected())?;
    let seconds = match unit {
        "us" => 1e-6,
        "ms" => 1e-3,
        "s" => 1.0,
        "m" => 60.0,
        "h" => 3600.0,
        _ => return Err(expected()),
    };
    Duration::try_from_secs_f64(number * seconds).ok().filter(|time| time.as_secs() < 1 << 30).ok_or_else(expected)
}

/// A time above zero.
fn some_time(text: &str) -> Result<Duration, String> {
    time(text).and_then(|time| if time.is_zero() { Err("expected a time above 0".to_owned()) } else { Ok(time) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_read_with_their_unit() {
        for (text, expected) in [("500us", 500), ("30ms", 30_000), ("1.5s", 1_500_000), ("2m", 120_000_000)] {
            assert_eq!(time(text).unwrap(), Duration::from_micros(expected), "{text}");
        }
        assert!(some_time("0s").is_err() && some_time("1s").is_ok() && time("0s").is_ok());
        for wrong in ["", "5", "s", "-1s", "1e3s", "5 s", "1..s", "9999999999h"] {
            assert!(time(wrong).is_err(), "{wrong}");
            assert!(some_time(wrong).is_err(), "{wrong}");
        }
    }
}
