//! Arguments for submitting and selecting jobs.

use clap::{ArgGroup, Args, ValueEnum};
use counterpoint_server::utc::from_iso;

use super::filled::{EMPTY, filled};
use crate::remote::Remote;

/// Properties of a job besides its programs and options.
#[derive(Debug, Args)]
pub(crate) struct RequestArgs {
    /// Identify the request: a repeated id returns the same job instead of creating a new one
    #[arg(long, value_name = "ID", value_parser = filled)]
    pub(crate) request_id: Option<String>,
    /// Label the job; NAME alone is the label `name`; can be repeated
    #[arg(long = "label", value_name = "NAME|KEY=VALUE", value_parser = label)]
    pub(crate) labels: Vec<(String, String)>,
    /// Set the priority of the job among your own jobs
    #[arg(long, value_enum)]
    pub(crate) priority: Option<JobPriority>,
    /// Stop the job if it has not ended by this time: a time from now (90s, 30m, 2h), a date
    /// (2026-11-29T12:30:00Z) or @ and seconds since 1970
    #[arg(long, value_name = "TIME", value_parser = span_or_time)]
    pub(crate) deadline: Option<TimePoint>,
}

/// Priorities of a job.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum JobPriority {
    Low,
    Normal,
    High,
}

/// A time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum TimePoint {
    /// This many milliseconds from or before now.
    Span(i64),
    /// Milliseconds since 1970.
    At(i64),
}

/// Key of a label given by a name alone.
pub(crate) const NAME: &str = "name";

fn label(text: &str) -> Result<(String, String), String> {
    if text.is_empty() {
        return Err(EMPTY.to_owned());
    }
    let (key, value) = text.split_once('=').unwrap_or((NAME, text));
    Ok((key.to_owned(), value.to_owned()))
}

fn span_or_time(text: &str) -> Result<TimePoint, String> {
    let wrong = || {
        "expected a number with s, m, h or d (90s, 30m, 2h), a date (2026-11-29 or 2026-11-29T12:30:00Z, UTC), or @ \
         and seconds since 1970"
            .to_owned()
    };
    let number = |digits: &str, unit: i64| {
        let value: i64 = digits.parse().map_err(|_| wrong())?;
        value.checked_mul(unit).filter(|ms| *ms > 0).ok_or_else(wrong)
    };
    if let Some(seconds) = text.strip_prefix('@') {
        return number(seconds, 1000).map(TimePoint::At);
    }
    if text.contains('-') {
        return from_iso(text).filter(|ms| *ms > 0).map(TimePoint::At).ok_or_else(wrong);
    }
    let units = [('s', 1000), ('m', 60_000), ('h', 3_600_000), ('d', 86_400_000)];
    let found = units.iter().find_map(|(unit, ms)| Some((text.strip_suffix(*unit)?, *ms)));
    let (digits, ms) = found.ok_or_else(wrong)?;
    number(digits, ms).map(TimePoint::Span)
}

#[derive(Debug, Args)]
pub(crate) struct Rerun {
    /// Id of the job to run again, or a prefix of it
    pub(crate) job: String,
    #[command(flatten)]
    pub(crate) remote: Remote,
    #[command(flatten)]
    pub(crate) request: RequestArgs,
    /// Print the id of the new job as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// Which jobs.
#[derive(Debug, Args)]
pub(crate) struct JobFilter {
    /// Select only jobs in these states
    #[arg(long, value_enum, value_delimiter = ',')]
    pub(crate) state: Vec<StateFilter>,
    /// Select only jobs for this machine, a name or NAME@REVISION
    #[arg(long, value_name = "NAME", value_parser = filled)]
    pub(crate) machine: Option<String>,
    /// Select only jobs with this label; NAME alone is the label `name`; can be repeated
    #[arg(long = "label", value_name = "NAME|KEY=VALUE", value_parser = label)]
    pub(crate) labels: Vec<(String, String)>,
    /// Select only jobs accepted since this time: a time before now (90s, 30m, 2h, 7d), a date
    /// (2026-11-29) or @ and seconds since 1970
    #[arg(long, value_name = "TIME", value_parser = span_or_time)]
    pub(crate) since: Option<TimePoint>,
}

#[derive(Debug, Args)]
pub(crate) struct WatchArgs {
    /// Id of the job, or a prefix of it
    #[arg(required_unless_present = "all")]
    pub(crate) job: Option<String>,
    /// Follow the states of all jobs that the filter selects, with a line for each change, until interrupted
    #[arg(long, conflicts_with = "job")]
    pub(crate) all: bool,
    #[command(flatten)]
    pub(crate) filter: JobFilter,
    /// Print JSON, one object per line; needs --all
    #[arg(long, conflicts_with = "job")]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) remote: Remote,
    /// Print no progress
    #[arg(long, short)]
    pub(crate) quiet: bool,
    /// Exit with code 1 even if there are only warnings
    #[arg(long)]
    pub(crate) strict: bool,
}

#[derive(Debug, Args)]
pub(crate) struct JobListArgs {
    #[command(flatten)]
    pub(crate) remote: Remote,
    #[command(flatten)]
    pub(crate) filter: JobFilter,
    /// List the oldest jobs first
    #[arg(long, overrides_with = "newest")]
    pub(crate) oldest: bool,
    /// List the newest jobs first (the default)
    #[arg(long, overrides_with = "oldest")]
    pub(crate) newest: bool,
    /// Show whole ids
    #[arg(long)]
    pub(crate) long: bool,
    /// List at most this many jobs
    #[arg(long, value_name = "N")]
    pub(crate) limit: Option<usize>,
    /// Print JSON, one object per line
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct StatusArgs {
    /// Id of the job, or a prefix of it
    pub(crate) job: String,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) remote: Remote,
}

/// Arguments of a filter, which exclude `--all`.
const FILTERS: [&str; 4] = ["state", "machine", "labels", "since"];

/// Arguments that select the jobs of `wait`; one of them must be given.
const AWAITED: [&str; 6] = ["jobs", "state", "machine", "labels", "since", "all"];

/// The jobs to wait for.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("awaited").args(AWAITED).required(true).multiple(true))]
pub(crate) struct WaitArgs {
    /// Ids of the jobs, or prefixes of them
    #[arg(value_name = "JOB", conflicts_with_all = ["state", "machine", "labels", "since", "all"])]
    pub(crate) jobs: Vec<String>,
    #[command(flatten)]
    pub(crate) filter: JobFilter,
    /// Wait for all your jobs that have not ended
    #[arg(long, conflicts_with_all = FILTERS)]
    pub(crate) all: bool,
    #[command(flatten)]
    pub(crate) remote: Remote,
    /// Print only errors
    #[arg(long, short)]
    pub(crate) quiet: bool,
    /// Exit with code 1 even if there are only warnings
    #[arg(long)]
    pub(crate) strict: bool,
    /// Print the status of each ended job as JSON, one object per line
    #[arg(long)]
    pub(crate) json: bool,
}

/// Arguments that select the jobs of `cancel` and `delete`; one of them must be given.
const SELECTORS: [&str; 6] = ["job", "state", "machine", "labels", "since", "all"];

/// One job, or the jobs of a filter.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("selected").args(SELECTORS).required(true).multiple(true))]
pub(crate) struct Many {
    /// Id of the job, or a prefix of it
    #[arg(conflicts_with_all = ["state", "machine", "labels", "since", "all", "dry_run", "yes"])]
    pub(crate) job: Option<String>,
    #[command(flatten)]
    pub(crate) filter: JobFilter,
    /// Select all your jobs
    #[arg(long, conflicts_with_all = FILTERS)]
    pub(crate) all: bool,
    /// Print the ids of the jobs that the filter selects, and change nothing
    #[arg(long)]
    pub(crate) dry_run: bool,
    /// Skip the confirmation (required to change the jobs of a filter without a terminal)
    #[arg(long, short)]
    pub(crate) yes: bool,
    #[command(flatten)]
    pub(crate) remote: Remote,
    /// Print no ids
    #[arg(long, short)]
    pub(crate) quiet: bool,
}

/// States to filter by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum StateFilter {
    /// Waiting for a worker, or held back
    Queued,
    /// Held back by `pause`
    Paused,
    Running,
    Succeeded,
    Failed,
    Cancelled,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_and_labels_are_read() {
        assert_eq!(span_or_time("90s"), Ok(TimePoint::Span(90_000)));
        assert_eq!(span_or_time("2h"), Ok(TimePoint::Span(7_200_000)));
        assert_eq!(span_or_time("@1798761600"), Ok(TimePoint::At(1_798_761_600_000)));
        for (text, seconds) in [
            ("2027-01-01", 1_798_761_600),
            ("2027-01-01T00:00:30Z", 1_798_761_630),
            ("2027-01-01 00:01", 1_798_761_660),
            ("2027-01-01T01:00:00+01:00", 1_798_761_600),
        ] {
            assert_eq!(span_or_time(text), Ok(TimePoint::At(seconds * 1000)), "{text}");
        }
        for wrong in ["2027-13-01", "2027-01-01T", "2027-1-1", "2027-01-01T25:00", "1969-01-01"] {
            assert!(span_or_time(wrong).is_err(), "{wrong}");
        }
        for wrong in ["", "s", "5", "5w", "-5m", "0s", "@", "@x", "99999999999999999d", "µs"] {
            assert!(span_or_time(wrong).is_err(), "{wrong}");
        }
        assert_eq!(label("a=b=c"), Ok(("a".to_owned(), "b=c".to_owned())));
        assert_eq!(label("bracket 17"), Ok(("name".to_owned(), "bracket 17".to_owned())));
        assert!(label("").is_err());
    }
}
