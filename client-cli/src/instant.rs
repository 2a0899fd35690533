//! `counterpoint at` and `counterpoint where`: the state of a job at an instant, and the times of a block.
//!
//! Both read the events of a job of the server, or of the output folder of a run.

use std::fmt::Write as _;
use std::io::{BufRead as _, BufReader};
use std::path::Path;

use counterpoint_client::ResultDocument;
use counterpoint_kernel::log::event::SpindleDirection;
use counterpoint_kernel::log::executions::{Execution, ExecutionFinder};
use counterpoint_kernel::log::instant::{
    ActionInstant, AxisValues, ChannelActivity, ChannelInstant, Instant, InstantBuilder, NotAnEvent, SpindleInstant,
    WaitInstant,
};
use counterpoint_kernel::log::summary::Summary;
use serde::Serialize;

use crate::arguments::{At, OutputFormat, ResultKind, Where};
use crate::client::ServerSession;
use crate::error::Error;
use crate::remote::Remote;
use crate::say::{self, DIM, styled};
use crate::text::{more, table, time};
use crate::{job_names, results};

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
        if of.contains(['/', '.', '\\']) {
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
                std::fs::read(&file).map_err(Error::file(&file))?
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
                let mut reader = BufReader::new(std::fs::File::open(&file).map_err(Error::file(&file))?);
                let mut line = Vec::new();
                while reader.read_until(b'\n', &mut line).map_err(Error::file(&file))? > 0 {
                    if !each(line.trim_ascii_end())? {
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

/// Parses a time in simulated seconds: `12.5`, `12.5s`, `300ms`, `2min`, or as reports show it, `02:05.300`.
fn instant(text: &str) -> Result<i64, Error> {
    let wrong = || Error::Usage(format!("'{text}' is not a time: write seconds as 12.5, or 300ms, 2min, 02:05.300"));
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|value| *value >= 0.0);
    let seconds = if text.contains(':') {
        text.split(':').try_fold(0.0, |sum, part| Some(sum * 60.0 + number(part)?))
    } else {
        let units = [("ms", 1e-3), ("min", 60.0), ("s", 1.0)];
        let (value, unit) =
            units.iter().find_map(|(name, factor)| Some((text.strip_suffix(name)?, *factor))).unwrap_or((text, 1.0));
        number(value).map(|value| value * unit)
    };
    let ns = seconds.map(|seconds| seconds * 1e9).filter(|ns| *ns < 9e18);
    ns.map(|ns| ns.round() as i64).ok_or_else(wrong)
}

/// Shows the state of a job at an instant.
pub(crate) async fn at(arguments: At) -> Result<u8, Error> {
    let t_ns = instant(&arguments.time)?;
    let source = EventSource::open(&arguments.of, &arguments.remote).await?;
    let summary = source.summary().await?;
    if let Some(number) = arguments.channel
        && !summary.channels.iter().any(|channel| channel.channel == number)
    {
        return Err(Error::Usage(format!("the job has no channel {number}")));
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
    let mut instant = builder.finish();
    instant.channels.retain(|channel| arguments.channel.is_none_or(|number| number == channel.channel));
    if arguments.json {
        return json(&instant);
    }
    say::data(shown(&instant, &summary.unit).as_bytes())?;
    Ok(0)
}

fn json(value: &impl Serialize) -> Result<u8, Error> {
    let json = serde_json::to_string_pretty(value).map_err(|error| Error::Usage(error.to_string()))?;
    say::line(&json)?;
    Ok(0)
}

fn shown(Instant { t_ns, makespan_ns, channels }: &Instant, unit: &str) -> String {
    let mut out = format!("{} of {}\n", time(*t_ns), time(*makespan_ns));
    for channel in channels {
        let ChannelInstant { channel: number, name, state, file, line, .. } = channel;
        let place = if *line == 0 { String::new() } else { format!("  {file}:{line}") };
        let _ = writeln!(out, "\nchannel {number} {name}  {}{place}", word(*state));
        out.push_str(&table(&rows(channel, *t_ns, unit), 2));
    }
    out
}

fn word(state: ChannelActivity) -> &'static str {
    match state {
        ChannelActivity::NotStarted => "not started",
        ChannelActivity::Running => "running",
        ChannelActivity::Waiting => "waiting",
        ChannelActivity::Ended => "ended",
        ChannelActivity::Stopped => "stopped",
    }
}

fn rows(channel: &ChannelInstant, t_ns: i64, unit: &str) -> Vec<Vec<String>> {
    let mut rows = Vec::new();
    let mut row = |name: &str, text: String| rows.push(vec![name.to_owned(), text]);
    if let Some(WaitInstant { key, since_ns, missing }) = &channel.wait {
        let missing: Vec<String> = missing.iter().map(u16::to_string).collect();
        let of = if missing.is_empty() { String::new() } else { format!(", for channel {}", missing.join(", ")) };
        row("wait", format!("{key} for {}{of}", time(t_ns - since_ns)));
    }
    if let Some(ActionInstant { kind, since_ns, until_ns, ends, unknown }) = &channel.action {
        row("action", format!("{kind} from {} to {}", time(*since_ns), time(*until_ns)));
        if let (Some([from, to]), Some(reason)) = (ends, unknown) {
            let why = if *reason == "not_recorded" {
                "run with --law to record it".to_owned()
            } else {
                reason.replace('_', " ")
            };
            row("moves", format!("{} to {}, position between them not known ({why})", values(from), values(to)));
        }
    }
    if let Some(position) = &channel.position {
        row("position", format!("{} {unit}", values(position)));
    }
    if channel.tool[0] != 0 {
        row("tool", format!("{} offset {}", channel.tool[0], channel.tool[1]));
    }
    for SpindleInstant { spindle, direction, css, speed, limit } in &channel.spindles {
        let speed = match direction {
            SpindleDirection::Clockwise | SpindleDirection::CounterClockwise if *css => {
                let per_minute = if unit == "inch" { "ft/min" } else { "m/min" };
                let most = limit.map_or_else(String::new, |limit| format!(", at most {limit} rev/min"));
                format!(" {speed} {per_minute}{most}")
            }
            SpindleDirection::Clockwise | SpindleDirection::CounterClockwise => format!(" {speed} rev/min"),
            _ => String::new(),
        };
        row("spindle", format!("{spindle} {}{speed}", direction.word().replace('_', " ")));
    }
    if channel.level > 0 {
        row("subprogram", format!("level {}", channel.level));
    }
    if !channel.modes.is_empty() {
        row("modes", channel.modes.values().cloned().collect::<Vec<_>>().join(", "));
    }
    rows
}

/// Formats positions as `X 40  Z -12.5`.
fn values(position: &AxisValues) -> String {
    let value = |value: &f64| (value * 1e4).round() / 1e4 + 0.0;
    position.0.iter().map(|(axis, at)| format!("{axis} {}", value(at))).collect::<Vec<_>>().join("  ")
}

/// Shows when a block was executed.
pub(crate) async fn times(arguments: Where) -> Result<u8, Error> {
    let place = &arguments.place;
    let wrong = || Error::Usage(format!("'{place}' is not a block: write the file and the line, such as part.nc:120"));
    let (file, line) = place.rsplit_once(':').ok_or_else(wrong)?;
    let line = line.parse().ok().filter(|line| *line > 0 && !file.is_empty()).ok_or_else(wrong)?;
    let source = EventSource::open(&arguments.of, &arguments.remote).await?;
    let mut finder = ExecutionFinder::new(file, line);
    source.lines(|line| finder.line(line).map(|()| true)).await?;
    let found = finder.finish();
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
    let head = ["channel", "from", "to", "takes", "waits"].map(str::to_owned);
    let row = |Execution { channel, t_ns, dur_ns, wait_ns }: &Execution| {
        vec![channel.to_string(), time(*t_ns), time(t_ns + dur_ns), time(*dur_ns), time(*wait_ns)]
    };
    let rows: Vec<Vec<String>> = std::iter::once(head.to_vec()).chain(found.iter().take(ROWS).map(row)).collect();
    out.push_str(&table(&rows, 1));
    more(&mut out, found.len(), ROWS, "executions (--json shows all)");
    if found.len() > ROWS {
        let _ = writeln!(out, "{}", styled(DIM, "the sum includes all executions"));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_instant_is_a_number_of_seconds_or_a_time_of_a_report() {
        let read = |text| instant(text).map_err(|error| error.to_string());
        assert_eq!(read("12.5"), Ok(12_500_000_000));
        assert_eq!(read("300ms"), Ok(300_000_000));
        assert_eq!(read("2min"), Ok(120_000_000_000));
        assert_eq!(read("02:05.300"), Ok(125_300_000_000));
        assert_eq!(read("1:00:00.5"), Ok(3_600_500_000_000));
        for wrong in ["", "-1", "x", "1:", "nan", "inf", "1e30"] {
            assert!(read(wrong).is_err_and(|text| text.contains("12.5")), "{wrong}");
        }
    }
}
