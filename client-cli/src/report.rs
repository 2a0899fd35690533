//! The short report for people, made from summary.json.

use std::fmt::Write as _;

use crate::problems::{counts, problems};
use crate::say::{BAD, GOOD, WARN, styled};
use crate::summary::{Summary, Tool};
use crate::text::{more, table, time};

/// Diagnostics shown at most.
const DIAGNOSTICS: usize = 20;
/// Tools shown at most.
const TOOLS: usize = 20;
/// Waits shown at most.
const WAITS: usize = 20;

/// The report.
pub(crate) fn report(summary: &Summary, verbose: bool) -> String {
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
    let mut out = format!("{}  cycle time {}\n", styled(style, head), time(summary.makespan_ns));
    if summary.cancelled() {
        let _ = writeln!(out, "cancelled before the end: times and sync points cover only the part that was run");
    }
    out.push('\n');
    out.push_str(&problems(summary, most(DIAGNOSTICS)));
    out.push_str(&channels(summary));
    out.push_str(&tools(summary));
    out.push_str(&waits(summary, most(WAITS)));
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

/// Tools with a known name, diameter or radius.
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
    fn times_and_groups() {
        assert_eq!(time(61_234_567_890), "01:01.235");
        assert_eq!(time(3_661_000_000_000), "1:01:01.000");
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
