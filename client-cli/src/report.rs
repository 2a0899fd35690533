//! The short report for people, made from summary.json.

use std::fmt::Write as _;

use serde::Deserialize;

use crate::say::{BAD, DIM, GOOD, WARN, styled};

/// Diagnostics shown at most.
const DIAGNOSTICS: usize = 20;
/// Tools shown at most.
const TOOLS: usize = 20;
/// Waits shown at most.
const WAITS: usize = 20;

/// summary.json as far as the report needs it.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Summary {
    pub(crate) state: String,
    pub(crate) highest_severity: u8,
    makespan_ns: i64,
    pub(crate) channels: Vec<Channel>,
    waits: Vec<Wait>,
    verdict: Option<Verdict>,
    diagnostics: Vec<Diagnostic>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Channel {
    pub(crate) channel: u32,
    name: String,
    pub(crate) program: String,
    state: String,
    blocks: u64,
    end_ns: i64,
    feed_ns: i64,
    rapid_ns: i64,
    misc_ns: i64,
    wait_ns: i64,
    tools: Vec<Tool>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Tool {
    tool: u32,
    name: String,
    diameter: Option<f64>,
    radius: Option<f64>,
    length_offsets: Vec<u32>,
    diameter_offsets: Vec<u32>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Wait {
    key: String,
    release_ns: Option<i64>,
    arrivals: Vec<Arrival>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Arrival {
    channel: u32,
    t_ns: i64,
    line: u32,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Verdict {
    kind: String,
    text: String,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Diagnostic {
    number: u32,
    severity: u8,
    channel: u32,
    file: String,
    line: u32,
    block: String,
    text: String,
    origin: Option<Origin>,
}

/// The statement of a macro that raised a diagnostic.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Origin {
    file: String,
    line: u32,
}

/// Simulated time as minutes, seconds and milliseconds.
pub(crate) fn time(ns: i64) -> String {
    let ms = (ns + 500_000) / 1_000_000;
    format!("{:02}:{:02}.{:03}", ms / 60_000, ms / 1000 % 60, ms % 1000)
}

/// Lays rows out in columns; the first `left` columns to the left, the rest to the right.
pub(crate) fn table(rows: &[Vec<String>], left: usize) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |c: usize| rows.iter().filter_map(|row| row.get(c)).map(|cell| cell.chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let mut out = String::new();
    for row in rows {
        let cells =
            row.iter().zip(&widths).enumerate().map(|(c, (cell, &width))| {
                if c < left { format!("{cell:<width$}") } else { format!("{cell:>width$}") }
            });
        let line = cells.collect::<Vec<_>>().join("  ");
        let _ = writeln!(out, "  {}", line.trim_end());
    }
    out
}

/// The report.
pub(crate) fn report(summary: &Summary, verbose: bool) -> String {
    let most = |shown: usize| if verbose { usize::MAX } else { shown };
    let style = if summary.state == "SUCCEEDED" { GOOD } else { BAD };
    let mut out = format!("{}  {}\n\n", styled(style, &summary.state), time(summary.makespan_ns));
    out.push_str(&channels(summary));
    out.push_str(&tools(summary));
    out.push_str(&waits(summary, most(WAITS)));
    if let Some(verdict) = &summary.verdict {
        let _ = writeln!(out, "\n{} {}", styled(BAD, &verdict.kind), verdict.text);
    }
    out.push_str(&diagnostics(summary, most(DIAGNOSTICS)));
    out
}

fn channels(summary: &Summary) -> String {
    let head = ["channel", "program", "state", "blocks", "end", "feed", "rapid", "misc", "wait"];
    let mut rows = vec![head.map(str::to_owned).to_vec()];
    rows.extend(summary.channels.iter().map(|c| {
        let mut row = vec![format!("{} {}", c.channel, c.name), c.program.clone(), c.state.clone()];
        row.push(c.blocks.to_string());
        row.extend([c.end_ns, c.feed_ns, c.rapid_ns, c.misc_ns, c.wait_ns].map(time));
        row
    }));
    table(&rows, 3)
}

/// Tools of which more than the number is known.
fn tools(summary: &Summary) -> String {
    let all = || summary.channels.iter().flat_map(|c| c.tools.iter().map(move |tool| (c.channel, tool)));
    let known = |tool: &Tool| !tool.name.is_empty() || tool.diameter.is_some() || tool.radius.is_some();
    let count = all().filter(|(_, tool)| known(tool)).count();
    if count == 0 {
        return String::new();
    }
    let head = ["tool", "name", "channel", "diameter", "radius", "length offsets", "diam offsets"];
    let mut rows = vec![head.map(str::to_owned).to_vec()];
    for (channel, tool) in all().filter(|(_, tool)| known(tool)).take(TOOLS) {
        let size = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |value| value.to_string());
        let list = |numbers: &[u32]| numbers.iter().map(u32::to_string).collect::<Vec<_>>().join(",");
        let mut row = vec![tool.tool.to_string(), tool.name.clone(), channel.to_string()];
        row.extend([tool.diameter, tool.radius].map(size));
        row.extend([&tool.length_offsets, &tool.diameter_offsets].map(|numbers| list(numbers)));
        rows.push(row);
    }
    let mut out = format!("\n{}", table(&rows, 2));
    more(&mut out, count, TOOLS, "tools");
    out
}

fn waits(summary: &Summary, most: usize) -> String {
    if summary.waits.is_empty() {
        return String::new();
    }
    let mut rows = vec![["meeting", "released", "arrivals"].map(str::to_owned).to_vec()];
    for wait in summary.waits.iter().take(most) {
        let arrivals = wait.arrivals.iter().map(|a| format!("{}: {} line {}", a.channel, time(a.t_ns), a.line));
        let released = wait.release_ns.map_or_else(|| "never".to_owned(), time);
        rows.push(vec![wait.key.clone(), released, arrivals.collect::<Vec<_>>().join(", ")]);
    }
    let mut out = format!("\n{}", table(&rows, 3));
    more(&mut out, summary.waits.len(), most, "meetings");
    out
}

fn more(out: &mut String, count: usize, shown: usize, what: &str) {
    if count > shown {
        let _ = writeln!(out, "  {}", styled(DIM, format_args!("and {} more {what}", count - shown)));
    }
}

/// Diagnostics, worst first; the same one of many places once with a count.
fn diagnostics(summary: &Summary, most: usize) -> String {
    let mut groups: Vec<(&Diagnostic, usize)> = Vec::new();
    for diagnostic in &summary.diagnostics {
        let same = |g: &&mut (&Diagnostic, usize)| {
            let what = |d: &'_ Diagnostic| (d.number, d.channel, d.origin.as_ref().map(|o| (o.file.clone(), o.line)));
            what(g.0) == what(diagnostic) && g.0.text == diagnostic.text
        };
        match groups.iter_mut().find(same) {
            Some(group) => group.1 += 1,
            None => groups.push((diagnostic, 1)),
        }
    }
    groups.sort_by_key(|(diagnostic, _)| std::cmp::Reverse(diagnostic.severity));
    let mut out = String::new();
    for (diagnostic, count) in groups.iter().take(most) {
        out.push_str(&one(diagnostic, *count));
    }
    more(&mut out, groups.len(), most, "kinds of diagnostics");
    if out.is_empty() { out } else { format!("\n{out}") }
}

fn one(d: &Diagnostic, count: usize) -> String {
    let (word, style) = match d.severity {
        0..=3 => ("note", DIM),
        4..=7 => ("warning", WARN),
        8..=15 => ("error", BAD),
        _ => ("fatal", BAD),
    };
    let place = if d.line == 0 { String::new() } else { format!("{}:{}: ", d.file, d.line) };
    let times = if count > 1 { format!(" ({count} times)") } else { String::new() };
    let head = styled(style, format_args!("{word} {}", d.number));
    let origin = d.origin.as_ref().map(|o| format!(" ({}:{})", o.file, o.line)).unwrap_or_default();
    let mut out = format!("  {head} channel {} {place}{}{origin}{times}\n", d.channel, d.text);
    if !d.block.is_empty() {
        let _ = writeln!(out, "      {}", styled(DIM, &d.block));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_and_groups() {
        assert_eq!(time(61_234_567_890), "01:01.235");
        let text = r#"{"state":"FAILED","makespan_ns":5000000,"channels":[{"channel":1,"name":"UPPER","state":"ENDED",
            "tools":[{"tool":3,"name":"ROUGH 80","radius":0.8,"length_offsets":[3,13]},{"tool":5}]}],
            "waits":[{"key":"M101","release_ns":null,"arrivals":[{"channel":1,"t_ns":1000000,"line":3}]}],
            "verdict":{"kind":"CYCLE","text":"all wait"},
            "diagnostics":[{"number":7,"severity":2,"channel":1,"text":"a"},{"number":9,"severity":9,"channel":1,
            "file":"p.nc","line":4,"block":"G99","text":"b"},{"number":7,"severity":2,"channel":1,"text":"a"}]}"#;
        let report = report(&serde_json::from_str(text).unwrap(), false);
        assert!(report.contains("3     ROUGH 80        1         -     0.8            3,13"), "{report}");
        assert!(report.contains("M101") && report.contains("never") && report.contains("CYCLE"), "{report}");
        assert!(report.contains("p.nc:4: b") && report.contains("a (2 times)"), "{report}");
        assert!(report.find("p.nc:4").unwrap() < report.find("(2 times)").unwrap(), "worst first");
    }
}
