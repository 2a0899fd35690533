//! The times at which a block of a program was executed.
//!
//! An execution begins with the first event of the block. It ends when the next event of the channel belongs to another
//! block, or when the last action of the block ends. *Invariant:* executions of a channel are in order and do not
//! overlap.

use serde::Serialize;

use crate::instant::{LoggedLine, NotAnEvent};

/// One execution of a block.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Execution {
    /// Channel.
    pub channel: u16,
    /// Start, ns.
    pub t_ns: i64,
    /// Time until the next block, ns.
    pub dur_ns: i64,
    /// Time in which the channel waited, ns; part of `dur_ns`.
    pub wait_ns: i64,
}

/// Finds the executions of a block in the lines of a log.
#[derive(Debug)]
pub struct ExecutionFinder {
    file: String,
    line: u32,
    /// Open executions, at most one for each channel, with the latest end of their events and the start of their wait.
    open: Vec<OpenExecution>,
    found: Vec<Execution>,
}

#[derive(Debug)]
struct OpenExecution {
    execution: Execution,
    last_ns: i64,
    waits_since: Option<i64>,
}

impl ExecutionFinder {
    /// Finds the executions of a line of a file; the end of the file's path suffices.
    #[must_use]
    pub fn new(file: &str, line: u32) -> Self {
        Self { file: file.to_owned(), line, open: Vec::new(), found: Vec::new() }
    }

    fn is_file(&self, name: &str) -> bool {
        let rest = name.strip_suffix(self.file.as_str());
        rest.is_some_and(|rest| rest.is_empty() || rest.ends_with('/') || self.file.starts_with('/'))
    }

    /// Reads the next line of the log.
    ///
    /// # Errors
    /// If the line is not an event.
    pub fn line(&mut self, line: &[u8]) -> Result<(), NotAnEvent> {
        let event: LoggedLine = serde_json::from_slice(line).map_err(NotAnEvent)?;
        let Some((file, number)) = event.user_place() else { return Ok(()) };
        let here = number == self.line && self.is_file(file);
        let end_ns = event.t_ns.saturating_add(event.dur_ns);
        let place = self.open.iter().position(|open| open.execution.channel == event.channel);
        match (place.and_then(|at| self.open.get_mut(at)), here) {
            (Some(open), true) if event.kind != "block" => {
                open.last_ns = open.last_ns.max(end_ns);
                match event.kind.as_str() {
                    "wait" => open.waits_since = Some(event.t_ns),
                    "release" => {
                        let since = open.waits_since.take();
                        open.execution.wait_ns += since.map_or(0, |since| event.t_ns - since);
                    }
                    _ => {}
                }
                return Ok(());
            }
            (None, false) => return Ok(()),
            _ => {}
        }
        if let Some(at) = place {
            let open = self.open.remove(at);
            self.close(open, Some(event.t_ns));
        }
        if here {
            let execution = Execution { channel: event.channel, t_ns: event.t_ns, dur_ns: 0, wait_ns: 0 };
            self.open.push(OpenExecution { execution, last_ns: end_ns, waits_since: None });
        }
        Ok(())
    }

    fn close(&mut self, open: OpenExecution, next_ns: Option<i64>) {
        let OpenExecution { mut execution, last_ns, .. } = open;
        execution.dur_ns = next_ns.unwrap_or(last_ns) - execution.t_ns;
        self.found.push(execution);
    }

    /// Returns all executions in the order of their starts.
    #[must_use]
    pub fn finish(mut self) -> Vec<Execution> {
        for open in std::mem::take(&mut self.open) {
            self.close(open, None);
        }
        self.found.sort_by_key(|execution| (execution.t_ns, execution.channel));
        self.found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn executions(file: &str, line: u32, lines: &[&str]) -> Vec<(u16, i64, i64, i64)> {
        let mut finder = ExecutionFinder::new(file, line);
        for line in lines {
            finder.line(line.as_bytes()).unwrap();
        }
        let all = finder.finish();
        all.iter().map(|found| (found.channel, found.t_ns, found.dur_ns, found.wait_ns)).collect()
    }

    fn event(t_ns: i64, dur_ns: i64, channel: u16, kind: &str, place: &str) -> String {
        let (file, line) = place.split_once(':').unwrap();
        format!(
            r#"{{"seq":1,"t_ns":{t_ns},"dur_ns":{dur_ns},"channel":{channel},"kind":"{kind}","file":"{file}","line":{line}}}"#
        )
    }

    #[test]
    fn each_pass_of_a_block_is_an_execution() {
        let log = [
            event(0, 0, 1, "block", "a/p.nc:7"),
            event(0, 5, 1, "motion", "a/p.nc:7"),
            event(2, 3, 2, "motion", "b/p.nc:7"),
            event(5, 0, 1, "block", "a/p.nc:8"),
            event(5, 0, 2, "block", "b/p.nc:8"),
            event(9, 0, 1, "block", "a/p.nc:7"),
            event(9, 0, 1, "wait", "a/p.nc:7"),
            event(12, 0, 1, "release", "a/p.nc:7"),
            event(12, 0, 1, "block", "a/p.nc:7"),
            event(12, 4, 1, "dwell", "a/p.nc:7"),
        ];
        let log: Vec<&str> = log.iter().map(String::as_str).collect();
        assert_eq!(executions("a/p.nc", 7, &log), [(1, 0, 5, 0), (1, 9, 3, 3), (1, 12, 4, 0)]);
        // The end of a path matches only whole names of folders and files.
        assert_eq!(executions("p.nc", 7, &log).len(), 4);
        assert_eq!(executions(".nc", 7, &log), []);
        assert_eq!(executions("p.nc", 9, &log), []);
    }

    #[test]
    fn a_shipped_cycle_counts_for_the_block_that_called_it() {
        let inner = r#"{"seq":1,"t_ns":3,"dur_ns":4,"channel":1,"kind":"motion","file":"//ICAMFS/c.spf","line":2,"caller_file":"p.nc","caller_line":7}"#;
        let log = [event(0, 0, 1, "block", "p.nc:7"), inner.to_owned(), event(9, 0, 1, "block", "p.nc:8")];
        let log: Vec<&str> = log.iter().map(String::as_str).collect();
        assert_eq!(executions("p.nc", 7, &log), [(1, 0, 9, 0)]);
    }
}
