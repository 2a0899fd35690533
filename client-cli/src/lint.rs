//! `counterpoint lint`: judges the waits, calls and jumps of programs without running them.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use counterpoint_proto::v1;

use crate::arguments::{Lint, OutputFormat, ResultKind};
use crate::client::{RequestedResults, ServerSession};
use crate::error::Error;
use crate::json_summary::with_remedies;
use crate::outcome::{exit_code, not_run};
use crate::problems::{counts, problems, say_errors};
use crate::run::{Submission, follow, machine, submit_pack};
use crate::say::{self, BAD, GOOD, WARN, styled};
use crate::summary::{ReportChannel, ReportSummary};
use crate::text::{more, table};
use crate::{pack, results};

/// Rows and diagnostics shown at most.
const ROWS: usize = 20;
/// A channel is judged up to a block only.
const ENDS_EARLY: u32 = 2_900_441;
/// The outcome of waits depends on which channel comes first.
const ORDER: u32 = 2_900_444;

/// Executes the command.
pub(crate) async fn lint(arguments: Lint) -> Result<u8, Error> {
    let inputs = arguments.inputs();
    let pack = pack::job(&inputs)?;
    let client = ServerSession::embed(RequestedResults::default(), false, false).await?;
    let quiet = arguments.quiet || arguments.json;
    let name = machine(&client, &inputs, &pack, arguments.quiet).await?;
    let request = v1::SubmitJobRequest { request_id: counterpoint_client::request_id(), ..Default::default() };
    let submission = Submission { request, lint: true, ..Submission::default() };
    let job = submit_pack(&client, &inputs, pack, name, submission).await?.job;
    let status = follow(&client, &job, (quiet, false, false)).await?;
    if let Some(code) = not_run(&status) {
        return Ok(code);
    }
    let text = results::whole(&client, &job, ResultKind::Summary, 0, OutputFormat::Json.into()).await?;
    if arguments.json {
        say::verdict(&with_remedies(&text))?;
        return Ok(exit_code(&status, arguments.strict));
    }
    let summary: ReportSummary = serde_json::from_slice(&text)
        .map_err(|error| Error::Connection(format!("cannot read the summary: {error}")))?;
    if arguments.quiet {
        say_errors(summary, arguments.strict);
    } else {
        say::verdict(report(&summary, if arguments.verbose { usize::MAX } else { ROWS }).as_bytes())?;
    }
    Ok(exit_code(&status, arguments.strict))
}

/// The report for people.
fn report(summary: &ReportSummary, most: usize) -> String {
    let said = |number| summary.diagnostics.iter().any(|diagnostic| diagnostic.number == number);
    let waits_in_vain = summary.channels.iter().any(|channel| channel.state == "BLOCKED");
    let lost = said(ENDS_EARLY) || said(ORDER) && waits_in_vain;
    let (text, style) = match (summary.state.as_str(), lost) {
        ("SUCCEEDED", false) if summary.highest_severity < 4 => ("no mistake found", GOOD),
        ("SUCCEEDED", false) => ("no mistake found", WARN),
        ("SUCCEEDED", true) => ("no mistake found as far as the programs could be judged", WARN),
        ("CANCELLED", _) => ("cancelled before the end", BAD),
        _ => ("the programs cannot run like this", BAD),
    };
    let counts = counts(summary);
    let head = if counts.is_empty() { text.to_owned() } else { format!("{text}, {counts}") };
    let mut out = format!("{}\n\n", styled(style, head));
    out.push_str(&problems(summary, most));
    out.push_str(&channels(summary));
    out.push_str(&waits(summary, most));
    out
}

fn channels(summary: &ReportSummary) -> String {
    let mut rows = vec![["channel", "program", "judged", "blocks", "waits"].map(str::to_owned).to_vec()];
    for channel in &summary.channels {
        let arrivals = summary.waits.iter().flat_map(|wait| &wait.arrivals);
        let waits = arrivals.filter(|arrival| arrival.channel == channel.channel).count();
        let mut row = vec![format!("{} {}", channel.channel, channel.name), channel.program.clone()];
        row.extend([judged(summary, channel), channel.blocks.to_string(), waits.to_string()]);
        rows.push(row);
    }
    table(&rows, 3)
}

/// How far a channel is judged.
fn judged(summary: &ReportSummary, channel: &ReportChannel) -> String {
    let mut own = summary.diagnostics.iter().filter(|diagnostic| diagnostic.channel == channel.channel);
    let mut arrivals = summary.waits.iter().flat_map(|wait| wait.arrivals.iter().map(move |arrival| (wait, arrival)));
    let open = arrivals.rfind(|(wait, arrival)| arrival.channel == channel.channel && wait.release_ns.is_none());
    match channel.state.as_str() {
        "ENDED" => "to its end".to_owned(),
        "ALARMED" => "to its alarm".to_owned(),
        "NOT_STARTED" => "no program".to_owned(),
        _ => match (own.find(|diagnostic| diagnostic.number == ENDS_EARLY), open) {
            (Some(diagnostic), _) => format!("to line {}", diagnostic.line),
            (None, Some((wait, arrival))) => format!("waits at line {} for {}", arrival.line, wait.key),
            (None, None) => "in part".to_owned(),
        },
    }
}

/// How often each channel comes to each sync point.
fn waits(summary: &ReportSummary, most: usize) -> String {
    if summary.waits.is_empty() {
        return String::new();
    }
    let mut marks: BTreeMap<&str, (usize, usize, BTreeMap<u32, usize>)> = BTreeMap::new();
    let mut order = Vec::new();
    for wait in &summary.waits {
        let mark = marks.entry(&wait.key).or_insert_with(|| {
            order.push(wait.key.as_str());
            Default::default()
        });
        match wait.release_ns {
            Some(_) => mark.0 += 1,
            None => mark.1 += 1,
        }
        for arrival in &wait.arrivals {
            *mark.2.entry(arrival.channel).or_default() += 1;
        }
    }
    let mut rows = vec![["sync point", "times that each channel comes", "met", "never"].map(str::to_owned).to_vec()];
    for key in order.iter().take(most) {
        let Some((met, open, channels)) = marks.get(key) else { continue };
        let mut text = String::new();
        for (channel, times) in channels {
            let _ = write!(text, "{}{channel}: {times}", if text.is_empty() { "" } else { ", " });
        }
        rows.push(vec![(*key).to_owned(), text, met.to_string(), open.to_string()]);
    }
    let mut out = format!("\n{}", table(&rows, 2));
    more(&mut out, order.len(), most, "sync points");
    out
}
