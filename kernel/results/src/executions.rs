//! The times at which a block of a program was executed.
//!
//! An execution begins when the channel reads the block, and has the time until the next block. If the flow returns into
//! the block (after its subprogram, or after the contour of a cycle), that time belongs to the same execution. *Invariant:*
//! the executions of all blocks together have the time of the channel.

use serde::Serialize;

use crate::instant::{LoggedLine, NotAnEvent};

/// One execution of a block.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Execution {
    /// Channel.
    pub channel: u16,
    /// File of the block, as the job names it.
    pub file: String,
    /// Start, ns.
    pub t_ns: i64,
    /// Its end, ns.
    pub end_ns: i64,
    /// Time in the block itself, without the subprogram that it calls, ns.
    pub dur_ns: i64,
    /// The part of it in which the channel waited, ns.
    pub wait_ns: i64,
}

/// The executions of a block.
#[derive(Debug)]
pub struct FoundExecutions {
    /// Whether the job has such a file among the files of its blocks.
    pub knows_file: bool,
    /// By their start.
    pub executions: Vec<Execution>,
}

/// Finds the executions of a block in the lines of a log.
#[derive(Debug)]
pub struct ExecutionFinder {
    file: String,
    line: u32,
    knows_file: bool,
    /// The channels that are in the block: where in `found`, since when, and since when they wait.
    open: Vec<OpenExecution>,
    found: Vec<Execution>,
}

#[derive(Debug)]
struct OpenExecution {
    channel: u16,
    place: usize,
    since_ns: i64,
    waits_since: Option<i64>,
}

impl ExecutionFinder {
    /// For a line of a file; the file may be given by the end of its path.
    #[must_use]
    pub fn new(file: &str, line: u32) -> Self {
        let file = file.replace('\\', "/");
        let file = file.trim_start_matches("./").to_owned();
        Self { file, line, knows_file: false, open: Vec::new(), found: Vec::new() }
    }

    /// Whether a file of the log is the one asked for: one path is the end of the other.
    fn is_file(&self, name: &str) -> bool {
        let ends = |long: &str, short: &str| {
            long.strip_suffix(short).is_some_and(|rest| rest.is_empty() || rest.ends_with('/'))
        };
        ends(name, &self.file) || ends(&self.file, name)
    }

    /// The next line of the log.
    ///
    /// # Errors
    /// If the line is not an event.
    pub fn line(&mut self, line: &[u8]) -> Result<(), NotAnEvent> {
        let event: LoggedLine = serde_json::from_slice(line).map_err(NotAnEvent)?;
        let Some((file, number)) = event.user_place().filter(|_| event.channel > 0) else { return Ok(()) };
        let of_file = self.is_file(file);
        self.knows_file |= of_file;
        let here = of_file && number == self.line;
        let read = event.kind == "block" && event.is_own();
        let at = self.open.iter().position(|open| open.channel == event.channel);
        if let (Some(open), true, false) = (at.and_then(|at| self.open.get_mut(at)), here, read) {
            match event.kind.as_str() {
                "wait" => open.waits_since = Some(event.t_ns),
                "release" => {
                    let waited = open.waits_since.take().map_or(0, |since| event.t_ns - since);
                    self.found.get_mut(open.place).into_iter().for_each(|found| found.wait_ns += waited);
                }
                _ => {}
            }
            return Ok(());
        }
        if let Some(at) = at {
            let open = self.open.remove(at);
            self.close(&open, event.t_ns);
        }
        if here {
            let known = || self.found.iter().rposition(|found| found.channel == event.channel && found.file == file);
            let place = known().filter(|_| !read).unwrap_or_else(|| {
                let (channel, t_ns, file) = (event.channel, event.t_ns, file.to_owned());
                self.found.push(Execution { channel, file, t_ns, end_ns: t_ns, dur_ns: 0, wait_ns: 0 });
                self.found.len() - 1
            });
            let (channel, since_ns) = (event.channel, event.t_ns);
            self.open.push(OpenExecution { channel, place, since_ns, waits_since: None });
        }
        Ok(())
    }

    fn close(&mut self, open: &OpenExecution, end_ns: i64) {
        if let Some(found) = self.found.get_mut(open.place) {
            found.end_ns = end_ns;
            found.dur_ns += end_ns - open.since_ns;
            found.wait_ns += open.waits_since.map_or(0, |since| end_ns - since);
        }
    }

    /// All executions. `makespan_ns`: the end of the job, at which channels that still are in the block leave it.
    #[must_use]
    pub fn finish(mut self, makespan_ns: i64) -> FoundExecutions {
        for open in std::mem::take(&mut self.open) {
            self.close(&open, makespan_ns.max(open.since_ns));
        }
        self.found.sort_by_key(|execution| (execution.t_ns, execution.channel));
        FoundExecutions { knows_file: self.knows_file, executions: self.found }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Channel, start, time and waiting of each execution.
    fn executions(place: (&str, u32), lines: &[String], makespan_ns: i64) -> Vec<(u16, i64, i64, i64)> {
        let mut finder = ExecutionFinder::new(place.0, place.1);
        for line in lines {
            finder.line(line.as_bytes()).unwrap();
        }
        let all = finder.finish(makespan_ns).executions;
        all.iter().map(|found| (found.channel, found.t_ns, found.dur_ns, found.wait_ns)).collect()
    }

    fn event(t_ns: i64, channel: u16, kind: &str, place: &str) -> String {
        let (file, line) = place.split_once(':').unwrap();
        format!(
            r#"{{"seq":1,"t_ns":{t_ns},"dur_ns":0,"channel":{channel},"kind":"{kind}","file":"{file}","line":{line}}}"#
        )
    }

    fn inner(t_ns: i64, kind: &str, caller: u32) -> String {
        let own = r#""channel":1,"file":"//ICAMFS/c.spf","line":2,"caller_file":"p.nc""#;
        format!(r#"{{"seq":3,"t_ns":{t_ns},"dur_ns":0,"kind":"{kind}",{own},"caller_line":{caller}}}"#)
    }

    #[test]
    fn each_pass_of_a_block_is_an_execution() {
        let log = [
            event(0, 1, "block", "a/p.nc:7"),
            event(0, 1, "motion", "a/p.nc:7"),
            event(2, 2, "block", "b/p.nc:7"),
            event(5, 1, "block", "a/p.nc:8"),
            event(5, 2, "block", "b/p.nc:8"),
            event(9, 1, "block", "a/p.nc:7"),
            event(9, 1, "wait", "a/p.nc:7"),
            event(12, 1, "release", "a/p.nc:7"),
            event(12, 1, "block", "a/p.nc:7"),
            event(12, 1, "dwell", "a/p.nc:7"),
        ];
        assert_eq!(executions(("a/p.nc", 7), &log, 16), [(1, 0, 5, 0), (1, 9, 3, 3), (1, 12, 4, 0)]);
        for name in ["p.nc", "./p.nc"] {
            assert_eq!(executions((name, 7), &log, 16).len(), 4, "the end of the path names a file");
        }
        for name in ["/home/a/p.nc", "C:\\a\\p.nc"] {
            assert_eq!(executions((name, 7), &log, 16).len(), 3, "a longer path names it, too");
        }
        for place in [(".nc", 7), ("p.nc", 9), ("q.nc", 7)] {
            assert_eq!(executions(place, &log, 16), [], "{place:?}");
        }
        let mut finder = ExecutionFinder::new("q.nc", 7);
        log.iter().for_each(|line| finder.line(line.as_bytes()).unwrap());
        assert!(!finder.finish(16).knows_file);
    }

    #[test]
    fn blocks_of_a_shipped_cycle_belong_to_the_block_that_called_it() {
        let log = [event(0, 1, "block", "p.nc:7"), inner(0, "block", 7), inner(3, "motion", 7), inner(6, "block", 7)];
        let log: Vec<String> = log.into_iter().chain([event(9, 1, "block", "p.nc:8")]).collect();
        assert_eq!(executions(("p.nc", 7), &log, 9), [(1, 0, 9, 0)]);
    }

    #[test]
    fn a_block_to_which_the_flow_returns_is_executed_once() {
        let log = [
            event(0, 1, "block", "p.nc:7"),
            event(2, 1, "block", "p.nc:20"),
            event(7, 1, "motion", "p.nc:7"),
            event(9, 1, "block", "p.nc:8"),
        ];
        assert_eq!(executions(("p.nc", 7), &log, 9), [(1, 0, 4, 0)]);
    }

    #[test]
    fn a_wait_without_end_lasts_to_the_end_of_the_job() {
        let log = [
            event(2, 1, "block", "p.nc:7"),
            event(2, 1, "wait", "p.nc:7"),
            event(5, 0, "diagnostic", "p.nc:7"),
            event(5, 1, "diagnostic", "p.nc:7"),
        ];
        assert_eq!(executions(("p.nc", 7), &log, 6), [(1, 2, 4, 4)]);
    }
}
