//! The short report for people, made from summary.json.

use std::fmt::Write as _;

use crate::problems::{counts, problems};
use crate::say::{BAD, GOOD, WARN, styled};
use crate::summary::{ReportSummary, ReportTool, ReportToolTimes};
use crate::text::{more, table, time};

/// Diagnostics shown at most.
const DIAGNOSTICS: usize = 20;
/// Tools shown at most.
const TOOLS: usize = 20;
/// Waits shown at most.
const WAITS: usize = 20;

/// The report.
pub(crate) fn report(summary: &ReportSummary, verbose: bool) -> String {
    let most = |shown: usize| if verbose { usize::MAX } else { shown };
    let mut head = summary.state.clone();
    let counts = counts(summary);
    if !counts.is_empty() {
        let _ = write!(head, ", {counts}");
    }
    let style = match summary.state.as_str() {
        "SUCCEEDED" if summary.highest_severity >= 4 => WARN,
        "SUCCEEDED" => GOOD,
        _ => BAD,
    };
    // As `status` and `wait` show it: only a job that has succeeded has a cycle time.
    let label = if summary.state == "SUCCEEDED" { "cycle time" } else { "stopped after" };
    let mut out = format!("{}  {label} {}\n", styled(style, head), time(summary.makespan_ns));
    if summary.cancelled() {
        let _ = writeln!(out, "cancelled before the end: times and sync points cover only the part that was run");
    }
    if let Some(coordinates) = &summary.coordinates {
        let _ = writeln!(out, "{}", coordinates.text);
    }
    out.push('\n');
    out.push_str(&problems(summary, most(DIAGNOSTICS)));
    out.push_str(&channels(summary));
    out.push_str(&tools(summary, most(TOOLS)));
    out.push_str(&waits(summary, most(WAITS)));
    out
}

fn channels(summary: &ReportSummary) -> String {
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

/// Tools with the times spent with them, from each load to the next one.
fn tools(summary: &ReportSummary, most: usize) -> String {
    let all = || summary.channels.iter().flat_map(|c| c.tools.iter().map(move |tool| (c.channel, tool)));
    let count = all().count();
    if count == 0 {
        return String::new();
    }
    let sized = all().any(|(_, tool)| tool.diameter.is_some() || tool.radius.is_some());
    let unit = if summary.unit.is_empty() { String::new() } else { format!(" {}", summary.unit) };
    let mut head: Vec<String> = ["tool", "name", "channel"].map(str::to_owned).to_vec();
    if sized {
        head.extend(["diameter", "radius"].map(|size| format!("{size}{unit}")));
    }
    head.extend(["offsets", "time", "feed", "rapid", "misc", "wait"].map(str::to_owned));
    let mut rows = vec![head];
    for (channel, tool) in all().take(most) {
        let name = if tool.name.is_empty() { &tool.operation } else { &tool.name };
        let mut row = vec![tool.tool.to_string(), name.clone(), channel.to_string()];
        if sized {
            let size = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |value| value.to_string());
            row.extend([tool.diameter, tool.radius].map(size));
        }
        row.push(offsets(tool));
        let ReportToolTimes { feed_ns, rapid_ns, misc_ns, wait_ns } = tool.times;
        row.extend([feed_ns + rapid_ns + misc_ns + wait_ns, feed_ns, rapid_ns, misc_ns, wait_ns].map(time));
        rows.push(row);
    }
    let mut out = format!("\n{}", table(&rows, 2));
    more(&mut out, count, most, "tools");
    out
}

/// Offsets that a tool was used with: `3`, `H3 D13` where they differ.
fn offsets(tool: &ReportTool) -> String {
    let list = |numbers: &[u32]| numbers.iter().map(u32::to_string).collect::<Vec<_>>().join(",");
    match (tool.length_offsets.as_slice(), tool.diameter_offsets.as_slice()) {
        ([], []) => "-".to_owned(),
        (length, []) => list(length),
        (length, diameter) if length == diameter => list(length),
        ([], diameter) => format!("D{}", list(diameter)),
        (length, diameter) => format!("H{} D{}", list(length), list(diameter)),
    }
}

fn waits(summary: &ReportSummary, most: usize) -> String {
    if summary.waits.is_empty() {
        return String::new();
    }
    let mut rows = vec![["sync point", "released", "arrivals"].map(str::to_owned).to_vec()];
    for wait in summary.waits.iter().take(most) {
        let arrivals = wait.arrivals.iter().map(|a| match a.line {
            0 => format!("{}: {}", a.channel, time(a.t_ns)),
            line => format!("{}: {} line {line}", a.channel, time(a.t_ns)),
        });
        let open = if summary.cancelled() { "not yet" } else { "never" };
        let released = wait.release_ns.map_or_else(|| open.to_owned(), time);
        rows.push(vec![wait.key.clone(), released, arrivals.collect::<Vec<_>>().join(", ")]);
    }
    let mut out = format!("\n{}", table(&rows, 3));
    more(&mut out, summary.waits.len(), most, "sync points");
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn deceptive_characters_in_names_are_escaped() {
        let text = r#"{"state":"SUCCEEDED","channels":[{"channel":1,"name":"A\u200bB","program":"a\u202ecn.nc",
            "state":"ENDED"}]}"#;
        let report = report(&serde_json::from_str(text).unwrap(), false);
        assert!(report.contains("1 A\\u200bB  a\\u202ecn.nc  ENDED"), "{report}");
        assert!(!report.contains(['\u{200b}', '\u{202e}']), "{report}");
    }

    #[test]
    fn times_and_groups() {
        assert_eq!(time(61_234_567_890), "01:01.235");
        assert_eq!(time(3_661_000_000_000), "1:01:01.000");
        let text = r#"{"state":"FAILED","makespan_ns":5000000,"channels":[{"channel":1,"name":"UPPER","state":"ENDED",
            "tools":[{"tool":3,"name":"ROUGH 80","radius":0.8,"length_offsets":[3,13],"times":{"feed_ns":3000000000,
            "wait_ns":1000000000}},{"tool":5,"operation":"DRILL","diameter_offsets":[7]}]}],"unit":"mm",
            "waits":[{"key":"M101","release_ns":null,"arrivals":[{"channel":1,"t_ns":1000000,"line":3}]}],
            "verdict":{"kind":"CYCLE","text":"all wait"},
            "diagnostics":[{"number":7,"severity":2,"channel":1,"text":"a"},{"number":9,"severity":9,"channel":1,
            "file":"p.nc","line":4,"block":"G99","text":"b"},{"number":7,"severity":2,"channel":1,"text":"a"}]}"#;
        let report = report(&serde_json::from_str(text).unwrap(), false);
        assert!(report.contains("  stopped after 00:00.005\n"), "as in `wait`: {report}");
        let line = |start: &str| report.lines().find(|line| line.trim_start().starts_with(start)).unwrap_or_default();
        let words = |line: &str| line.split_whitespace().map(str::to_owned).collect::<Vec<_>>().join(" ");
        assert_eq!(words(line("tool")), "tool name channel diameter mm radius mm offsets time feed rapid misc wait");
        let rough = "3 ROUGH 80 1 - 0.8 3,13 00:04.000 00:03.000 00:00.000 00:00.000 00:01.000";
        assert_eq!(words(line("3 ")), rough);
        assert!(words(line("5 ")).starts_with("5 DRILL 1 - - D7 00:00.000"), "{report}");
        assert!(report.contains("M101") && report.contains("never") && report.contains("CYCLE"), "{report}");
        assert!(report.contains("p.nc:4: b") && report.contains("a (2 times)"), "{report}");
        assert!(report.find("p.nc:4").unwrap() < report.find("(2 times)").unwrap(), "worst first");
    }

    #[test]
    fn a_cancelled_run_does_not_read_like_a_deadlock() {
        let text = r#"{"state":"CANCELLED","makespan_ns":5000000,
            "channels":[{"channel":1,"name":"UPPER","program":"a","state":"STOPPED"}],
            "waits":[{"key":"M101","release_ns":null,"arrivals":[{"channel":1,"t_ns":1000000,"line":0}]}]}"#;
        let report = report(&serde_json::from_str(text).unwrap(), false);
        assert!(report.contains("cancelled before the end"), "{report}");
        assert!(report.contains("M101        not yet") && !report.contains("never"), "{report}");
        assert!(!report.contains("line 0"), "{report}");
    }
}
