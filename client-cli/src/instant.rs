//! `counterpoint at` and `counterpoint where`: the state of a job at an instant, and the times of a block.
//!
//! Both read the events of a job of the server, or of the output folder of a run.

use std::fmt::Write as _;
use std::io::{BufRead as _, BufReader, Read as _};
use std::path::Path;

use counterpoint_client::ResultDocument;
use counterpoint_kernel::log::executions::{Execution, ExecutionFinder, FoundExecutions};
use counterpoint_kernel::log::instant::{ChannelInstant, Instant, InstantBuilder, NotAnEvent, parse_time};
use counterpoint_kernel::log::summary::Summary;
use serde::Serialize;

use crate::arguments::{At, OutputFormat, ResultKind, Where};
use crate::client::ServerSession;
use crate::error::Error;
use crate::remote::Remote;
use crate::say::{self, DIM, styled};
use crate::text::{more, table, time};
use crate::{job_names, results};

/// Longest line of events that is read, bytes.
const LONGEST: u64 = 64 << 20;

/// Half of the last digit that reports show of a time, ns.
const ROUNDING: i64 = 500_000;

/// Largest number of executions listed as text.
const ROWS: usize = 20;

/// Source of the events of a job.
enum EventSource {
    Folder(std::path::PathBuf),
    Job(Box<ServerSession>, String),
}

impl EventSource {
    async fn open(of: &str, server: &Remote) -> Result<Self, Error> {
        let path = Path::new(of);
        if path.is_dir() {
            return Ok(Self::Folder(path.to_path_buf()));
        }
        if of.is_empty() || of.contains(['/', '.', '\\']) {
            let text = format!("there is no folder '{of}': give the output folder of a run, or the id of a job");
            return Err(Error::Usage(text));
        }
        let client = ServerSession::connect(&server.server).await?;
        let job = job_names::whole(&client, of).await?;
        Ok(Self::Job(Box::new(client), job))
    }

    async fn summary(&self) -> Result<Summary, Error> {
        let bytes = match self {
            Self::Folder(folder) => {
                let file = folder.join("summary.json");
                std::fs::read(&file).map_err(|error| missing(&file, &error))?
            }
            Self::Job(client, job) => {
                results::whole(client, job, ResultKind::Summary, 0, OutputFormat::Json.into()).await?
            }
        };
        serde_json::from_slice(&bytes).map_err(|error| Error::Usage(format!("summary.json cannot be read: {error}")))
    }

    /// Passes the lines of the events to `each` until `each` returns `false`.
    async fn lines(&self, mut each: impl FnMut(&[u8]) -> Result<bool, NotAnEvent>) -> Result<(), Error> {
        let mut number = 0_u64;
        let mut each = |line: &[u8]| {
            number += 1;
            if line.is_empty() {
                return Ok(true);
            }
            let about = |NotAnEvent(error)| {
                Error::Usage(format!(
                    "line {number} of the events is not an event of this version: {error}; run the job again"
                ))
            };
            each(line).map_err(about)
        };
        match self {
            Self::Folder(folder) => {
                let file = folder.join("events.jsonl");
                let mut reader = BufReader::new(std::fs::File::open(&file).map_err(|error| missing(&file, &error))?);
                let mut line = Vec::new();
                while reader.by_ref().take(LONGEST).read_until(b'\n', &mut line).map_err(Error::file(&file))? > 0 {
                    let text = line.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&line);
                    if !each(text.trim_ascii_end())? {
                        return Ok(());
                    }
                    line.clear();
                }
            }
            Self::Job(client, job) => {
                let mut chunks = client.document(job, &ResultDocument::Events).await?;
                let mut rest = Vec::new();
                while let Some(chunk) = chunks.next().await? {
                    rest.extend_from_slice(&chunk);
                    let whole = rest.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1);
                    for line in rest.get(..whole).unwrap_or_default().split(|byte| *byte == b'\n') {
                        if !each(line)? {
                            return Ok(());
                        }
                    }
                    rest.drain(..whole);
                }
            }
        }
        Ok(())
    }
}

/// A file of an output folder that cannot be read.
fn missing(file: &Path, error: &std::io::Error) -> Error {
    let hint = "write it with run --out DIR, or with --write summary,events if --write is used";
    Error::Usage(format!("{} cannot be read: {error}; {hint}", file.display()))
}

/// Shows the state of a job at an instant.
pub(crate) async fn at(arguments: At) -> Result<u8, Error> {
    let wrong = || format!("'{}' is not a time: write seconds as 12.5, or 300ms, 2min, 02:05.300", arguments.time);
    let mut t_ns = parse_time(&arguments.time).ok_or_else(|| Error::Usage(wrong()))?;
    let source = EventSource::open(&arguments.of, &arguments.remote).await?;
    let summary = source.summary().await?;
    if let Some(number) = arguments.channel
        && !summary.channels.iter().any(|channel| channel.channel == number)
    {
        return Err(Error::Usage(format!("the job has no channel {number}")));
    }
    // Reports round times to milliseconds.
    if t_ns - summary.makespan_ns <= ROUNDING {
        t_ns = t_ns.min(summary.makespan_ns);
    }
    if t_ns > summary.makespan_ns {
        let (asked, end) = (time(t_ns), time(summary.makespan_ns));
        return Err(Error::Usage(format!("the job ends at {end}, before {asked}: give an earlier time")));
    }
    if summary.channels.iter().all(|channel| channel.axes.is_empty()) {
        let text = format!(
            "an earlier version wrote the summary of '{}', which names no axes: run the job again",
            arguments.of
        );
        return Err(Error::Usage(text));
    }
    let mut builder = InstantBuilder::new(&summary, t_ns);
    source.lines(|line| builder.line(line)).await?;
    if !builder.has_lines() {
        let text = format!("the events of '{}' are empty: run the job again", arguments.of);
        return Err(Error::Usage(text));
    }
    let mut instant = builder.finish();
    instant.channels.retain(|channel| arguments.channel.is_none_or(|number| number == channel.channel));
    if arguments.json {
        return json(&instant);
    }
    say::data(shown(&instant, &summary).as_bytes())?;
    Ok(0)
}

fn json(value: &impl Serialize) -> Result<u8, Error> {
    let json = serde_json::to_string_pretty(value).map_err(|error| Error::Usage(error.to_string()))?;
    say::line(&json)?;
    Ok(0)
}

fn shown(Instant { t_ns, makespan_ns, channels, spindles }: &Instant, summary: &Summary) -> String {
    let mut out = format!("{} of {}\n", time(*t_ns), time(*makespan_ns));
    for channel in channels {
        let ChannelInstant { channel: number, name, state, file, line, .. } = channel;
        let place = if *line == 0 { String::new() } else { format!("  {file}:{line}") };
        let _ = writeln!(out, "\nchannel {number} {name}  {}{place}", state.text());
        let known = summary.channels.iter().find(|of| of.channel == *number);
        let axes = known.map_or(&[][..], |channel| &channel.axes);
        out.push_str(&table(&channel.rows(*t_ns, (axes, &summary.unit), time), 2));
    }
    if !spindles.is_empty() {
        out.push_str("\nspindles\n");
        let rows: Vec<Vec<String>> = spindles.iter().map(|spindle| spindle.row(&summary.unit)).collect();
        out.push_str(&table(&rows, 2));
    }
    out
}

/// Shows when a block was executed.
pub(crate) async fn times(arguments: Where) -> Result<u8, Error> {
    let place = &arguments.place;
    let wrong = || Error::Usage(format!("'{place}' is not a block: write the file and the line, such as part.nc:120"));
    let (file, line) = place.rsplit_once(':').ok_or_else(wrong)?;
    let line = line.parse().ok().filter(|line| *line > 0 && !file.is_empty()).ok_or_else(wrong)?;
    let source = EventSource::open(&arguments.of, &arguments.remote).await?;
    let makespan_ns = source.summary().await?.makespan_ns;
    let mut finder = ExecutionFinder::new(file, line);
    source.lines(|line| finder.line(line).map(|()| true)).await?;
    let FoundExecutions { knows_file, executions: found } = finder.finish(makespan_ns);
    if !knows_file {
        let text = format!("no block of '{}' is in a file '{file}': give a file of the job", arguments.of);
        return Err(Error::Usage(text));
    }
    if arguments.json {
        json(&found)?;
    } else if found.is_empty() {
        say::line(&format!("{place} was not executed"))?;
    } else {
        say::data(listed(place, &found).as_bytes())?;
    }
    Ok(u8::from(found.is_empty()))
}

fn listed(place: &str, found: &[Execution]) -> String {
    let sum: i64 = found.iter().map(|execution| execution.dur_ns).sum();
    let plural = if found.len() == 1 { "" } else { "s" };
    let mut out = format!("{place} was executed {} time{plural}, {} in all\n", found.len(), time(sum));
    let head = ["channel", "file", "from", "to", "takes", "waits"].map(str::to_owned);
    let row = |Execution { channel, file, t_ns, end_ns, dur_ns, wait_ns }: &Execution| {
        let times = [t_ns, end_ns, dur_ns, wait_ns].map(|ns| time(*ns));
        [channel.to_string(), file.clone()].into_iter().chain(times).collect()
    };
    let rows: Vec<Vec<String>> = std::iter::once(head.to_vec()).chain(found.iter().take(ROWS).map(row)).collect();
    out.push_str(&table(&rows, 2));
    more(&mut out, found.len(), ROWS, "executions (--json shows all)");
    if found.len() > ROWS {
        let _ = writeln!(out, "{}", styled(DIM, "the sum includes all executions"));
    }
    out
}
