//! `counterpoint analyse`: the causes of the cycle time of a job, from its summary.

use std::fmt::Write as _;
use std::path::Path;

use counterpoint_kernel::log::analysis::{Analysis, WhatIf};
use counterpoint_kernel::log::summary::{ChannelState, JobOutcome, Summary};
use serde::Serialize;

use crate::arguments::{Analyse, OutputFormat, ResultKind};
use crate::client::ServerSession;
use crate::error::Error;
use crate::say::{self, BAD, DIM, styled};
use crate::text::{more, table, time};
use crate::{job_names, results, standard_input, text};

/// Rows of a table at most.
const ROWS: usize = 20;

/// A question of the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct WhatIfQuestion {
    channel: u16,
    faster_ns: i64,
}

/// The answer as JSON.
#[derive(Debug, Serialize)]
struct AnalysisReport<'a> {
    state: JobOutcome,
    makespan_ns: i64,
    analysis: &'a Analysis,
    what_if: &'a [WhatIf],
}

/// Executes the command.
pub(crate) async fn analyse(arguments: Analyse) -> Result<u8, Error> {
    let questions = arguments.what_if.iter().map(|text| question(text)).collect::<Result<Vec<_>, _>>()?;
    let bytes = summary(&arguments).await?;
    let read = serde_json::from_slice(&bytes);
    let summary: Summary =
        read.map_err(|error| Error::Usage(format!("'{}' is not the summary of a job: {error}", name(&arguments.of))))?;
    let ran = summary.channels.iter().filter(|channel| channel.state != ChannelState::NotStarted);
    let ends: Vec<(u16, i64)> = ran.map(|channel| (channel.channel, channel.end_ns)).collect();
    let mut what_if = Vec::new();
    for WhatIfQuestion { channel, faster_ns } in questions {
        what_if.push(WhatIf::of(&ends, &summary.waits, channel, faster_ns).ok_or_else(|| {
            let all: Vec<String> = ends.iter().map(|(channel, _)| channel.to_string()).collect();
            Error::Usage(format!(
                "channel {channel} cannot work {} faster: it does not run, or its work takes less time (channels: {})",
                text::time(faster_ns),
                all.join(", ")
            ))
        })?);
    }
    let races = summary.analysis.races.clone();
    let analysis = &Analysis { races, ..Analysis::of(&ends, &summary.waits) };
    if arguments.json {
        let answer =
            AnalysisReport { state: summary.state, makespan_ns: summary.makespan_ns, analysis, what_if: &what_if };
        let json = serde_json::to_string_pretty(&answer).map_err(|error| Error::Usage(error.to_string()))?;
        say::line(&json)?;
    } else {
        say::data(shown(&summary, analysis, &what_if).as_bytes())?;
    }
    Ok(u8::from(summary.state != JobOutcome::Succeeded))
}

/// The name of the argument in messages.
fn name(of: &str) -> &str {
    if standard_input::is(Path::new(of)) { standard_input::NAME } else { of }
}

/// summary.json: a file, that of a folder, or of a job of the server.
async fn summary(arguments: &Analyse) -> Result<Vec<u8>, Error> {
    let path = Path::new(&arguments.of);
    if standard_input::is(path) {
        return standard_input::read();
    }
    let file = if path.is_dir() { path.join("summary.json") } else { path.to_path_buf() };
    if file.exists() || arguments.of.contains(['/', '.']) {
        return std::fs::read(&file).map_err(Error::file(&file));
    }
    let of = &arguments.of;
    let about = |error: Error| match error {
        Error::Connection(text) => Error::Connection(format!(
            "there is no file or folder '{of}', and the server cannot be asked for a job with this id: {text}"
        )),
        Error::Refused(status) if status.code() == tonic::Code::NotFound => {
            Error::Usage(format!("'{of}' is not a file, a folder or a job of the server"))
        }
        other => other,
    };
    let client = ServerSession::connect(&arguments.remote.server).await.map_err(about)?;
    let job = job_names::whole(&client, &arguments.of).await.map_err(about)?;
    results::whole(&client, &job, ResultKind::Summary, 0, OutputFormat::Json.into()).await.map_err(about)
}

/// `2:2.5s`: channel, and how much faster it works. A minus sign means the same, a plus sign slower.
fn question(text: &str) -> Result<WhatIfQuestion, Error> {
    let wrong =
        || Error::Usage(format!("'{text}' is not a channel and a time: write 2:-2.5s if channel 2 works 2.5 s faster"));
    let (channel, change) = text.split_once(':').ok_or_else(wrong)?;
    let channel = channel.trim().parse().map_err(|_| wrong())?;
    let change = change.trim();
    let (slower, size) = match change.strip_prefix('+') {
        Some(size) => (true, size),
        None => (false, change.strip_prefix('-').unwrap_or(change)),
    };
    let units = [("ms", 1e6), ("min", 60e9), ("s", 1e9)];
    let (number, unit) =
        units.iter().find_map(|(name, ns)| Some((size.strip_suffix(name)?, *ns))).unwrap_or((size, 1e9));
    let ns = number.trim().parse::<f64>().ok().map(|value| value * unit);
    let ns = ns.filter(|ns| (0.0..=1e18).contains(ns)).ok_or_else(wrong)?.round() as i64;
    Ok(WhatIfQuestion { channel, faster_ns: if slower { -ns } else { ns } })
}

fn shown(summary: &Summary, analysis: &Analysis, what_if: &[WhatIf]) -> String {
    let name = |number: u16| {
        let found = summary.channels.iter().find(|channel| channel.channel == number);
        format!("{number} {}", found.map_or("", |channel| &channel.name))
    };
    let row = |cells: &[&str]| cells.iter().map(|cell| (*cell).to_owned()).collect::<Vec<_>>();
    let mut out = String::new();
    if summary.state != JobOutcome::Succeeded {
        let state = if summary.state == JobOutcome::Failed { "FAILED" } else { "CANCELLED" };
        let _ = writeln!(out, "{}: the analysis ends where the channels stopped", styled(BAD, state));
    }
    let _ = writeln!(out, "cycle time {}\n", time(summary.makespan_ns));
    out.push_str("critical path: the job ends earlier only if one of these parts takes less time\n");
    let mut rows = vec![row(&["channel", "from", "to", "takes", "share"])];
    for &(channel, from, to) in analysis.critical.iter().take(ROWS) {
        let share = (to - from) as f64 / summary.makespan_ns.max(1) as f64 * 100.0;
        rows.push(vec![name(channel), time(from), time(to), time(to - from), format!("{share:.0} %")]);
    }
    out.push_str(&table(&rows, 1));
    more(&mut out, analysis.critical.len(), ROWS, "parts (--json shows all)");
    out.push_str("\nslack: how much longer a channel may take without a later end of the job\n");
    let mut rows = vec![row(&["channel", "slack"])];
    rows.extend(analysis.slack.iter().map(|(channel, ns)| vec![name(*channel), time(*ns)]));
    out.push_str(&table(&rows, 1));
    if !analysis.wait_cost.is_empty() {
        out.push_str("\nwaits: how long channels waited there for the last one\n");
        let mut rows = vec![row(&["mark", "time"])];
        rows.extend(analysis.wait_cost.iter().take(ROWS).map(|(key, ns)| vec![key.to_string(), time(*ns)]));
        out.push_str(&table(&rows, 1));
        more(&mut out, analysis.wait_cost.len(), ROWS, "marks (--json shows all)");
    }
    if !analysis.redundant.is_empty() {
        let marks: Vec<&str> = analysis.redundant.iter().map(AsRef::as_ref).take(ROWS).collect();
        let _ = writeln!(out, "\nredundant: no time passes between the sync point before and {}", marks.join(", "));
        more(&mut out, analysis.redundant.len(), ROWS, "marks (--json shows all)");
    }
    if !analysis.races.is_empty() {
        out.push_str("\nraces: only timing decides the value of these variables\n");
        let mut rows = vec![row(&["variable", "channel and line"])];
        for (variable, lines) in analysis.races.iter().take(ROWS) {
            let lines: Vec<String> = lines.iter().map(|(channel, line)| format!("{channel}:{line}")).collect();
            rows.push(vec![variable.to_string(), lines.join("  ")]);
        }
        out.push_str(&table(&rows, 1));
        more(&mut out, analysis.races.len(), ROWS, "races (--json shows all)");
    }
    if !what_if.is_empty() {
        out.push_str("\nwhat if\n");
    }
    for WhatIf { channel, faster_ns, saves_ns } in what_if {
        let change =
            |ns: i64, more: &str, less: &str| format!("{} {}", time(ns.abs()), if ns < 0 { less } else { more });
        let _ = writeln!(
            out,
            "  channel {} works {}: the job ends {}",
            name(*channel),
            change(*faster_ns, "faster", "slower"),
            if *saves_ns == 0 { "at the same time".to_owned() } else { change(*saves_ns, "earlier", "later") }
        );
    }
    if analysis.slack.len() < 2 {
        let _ = writeln!(out, "\n{}", styled(DIM, "one channel has run: it alone decides the cycle time"));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_question_names_a_channel_and_a_time() {
        let ask =
            |text| question(text).map(|asked| (asked.channel, asked.faster_ns)).map_err(|error| error.to_string());
        assert_eq!(ask("2:-2.5s"), Ok((2, 2_500_000_000)));
        assert_eq!(ask("2:2.5"), Ok((2, 2_500_000_000)));
        assert_eq!(ask("1:+300ms"), Ok((1, -300_000_000)));
        assert_eq!(ask("1: 2min"), Ok((1, 120_000_000_000)));
        for wrong in ["", "2", "2:", "x:1s", "2:1h", "2:--1s", "2:nan", "70000:1s", "2:1e30s"] {
            assert!(ask(wrong).is_err_and(|text| text.contains("2:-2.5s")), "{wrong}");
        }
    }
}
