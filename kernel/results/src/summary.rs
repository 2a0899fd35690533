//! The summary of a job: its end, its times, and the waits of its channels.
//!
//! Facts: reference control-emulator.md 6.9 (classes of time). *Invariant:* for every channel
//! `feed_ns + rapid_ns + misc_ns + wait_ns` is its `end_ns`; durations are cut where the log was cut, and a wait
//! that was never satisfied counts up to where its channel ends.

pub mod tally;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use serde::{Deserialize, Serialize};

pub use crate::sync_points::{ChannelArrival, SyncPoint, Waits};
pub use crate::tools::ToolSummary;

use crate::analysis::{Analysis, Race};
pub use crate::coordinates::{ChannelUnits, CoordinateUnits, UnitFrom};
use crate::late::Late;
use crate::reported::{Reported, ReportedContent};
use counterpoint_event::event::{DiagnosticOrigin, FileId, VerdictKind};
use counterpoint_event::info::{self, BLOCK_TEXT, Info};
use counterpoint_fault as diag;
use tally::TimeTally;

/// Diagnostics that a summary lists; the log holds them all.
pub const MAX_DIAGNOSTICS: usize = 10_000;

/// How a job ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub enum JobOutcome {
    /// Every program came to its end without an error.
    Succeeded,
    /// A verdict, a diagnostic of severity 8 or more, or a channel that did not reach its end.
    Failed,
    /// Cancelled before its end.
    Cancelled,
}

/// How a channel ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum ChannelState {
    /// Its program has ended.
    Ended,
    /// It was stopped by an alarm.
    Alarmed,
    /// It is blocked at a wait that was never satisfied.
    Blocked,
    /// It has no program.
    NotStarted,
    /// It was stopped by a limit, an alarm of the machine or a cancel.
    Stopped,
}

/// Summary of a job.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// How it ended.
    pub state: JobOutcome,
    /// Unit of lengths, `mm` or `inch`: that of the machine.
    #[serde(default)]
    pub unit: String,
    /// Highest severity of all diagnostics, 0 without any.
    pub highest_severity: u8,
    /// When the last channel came to its end, ns.
    pub makespan_ns: i64,
    /// Fingerprint of the log.
    pub log_digest: String,
    /// The units in which coordinates were read; left out if nothing has moved.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coordinates: Option<CoordinateUnits>,
    /// Channels, ascending.
    pub channels: Vec<ChannelSummary>,
    /// Sync points in order of their number, then waits that were never satisfied.
    pub waits: Waits,
    /// Why channels can never continue.
    pub verdict: Option<VerdictSummary>,
    /// Diagnostics in log order, [`MAX_DIAGNOSTICS`] at most.
    pub diagnostics: Vec<DiagnosticSummary>,
    /// The causes of the cycle time; omitted unless two channels have run.
    #[serde(default, skip_serializing_if = "is_idle")]
    pub analysis: Late<Analysis>,
}

fn is_idle(analysis: &Late<Analysis>) -> bool {
    analysis.slack.is_empty()
}

/// A channel in the summary.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ChannelSummary {
    /// Number.
    pub channel: u16,
    /// Name.
    pub name: String,
    /// Its program, empty when it has none.
    pub program: String,
    /// How it ended.
    pub state: ChannelState,
    /// Blocks of the user's programs that were read; those of shipped cycles are not counted.
    pub blocks: u64,
    /// When it ended, ns: of a blocked channel its arrival at the wait.
    pub end_ns: i64,
    /// Straight feed, arcs, threads, ns.
    pub feed_ns: i64,
    /// Positioning, ns.
    pub rapid_ns: i64,
    /// Dwell, tool changes, run-up, functions, ns.
    pub misc_ns: i64,
    /// Waiting at sync points, ns.
    pub wait_ns: i64,
    /// Axes, in the order of the channel.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub axes: Vec<AxisSummary>,
    /// Its tools, in the order of the tooling tables; left out without any.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub tools: Vec<ToolSummary>,
}

/// An axis of a channel in the summary.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct AxisSummary {
    /// Name.
    pub name: String,
    /// Whether values are degrees; otherwise they are lengths.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub rotary: bool,
    /// Whether values are diameters.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub diameter: bool,
}

impl AxisSummary {
    /// Converts an axis of the job.
    fn new(info::JobAxis { name, rotary, diameter }: &info::JobAxis) -> Self {
        Self { name: name.clone(), rotary: *rotary, diameter: *diameter }
    }

    /// Converts the axis to an axis of the job.
    #[must_use]
    pub fn job_axis(&self) -> info::JobAxis {
        info::JobAxis { name: self.name.clone(), rotary: self.rotary, diameter: self.diameter }
    }
}

/// The verdict in the summary.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct VerdictSummary {
    /// Its class.
    pub kind: VerdictKind,
    /// When it became certain, ns.
    pub at_ns: i64,
    /// The story for people.
    pub text: String,
    /// Channels concerned, ascending.
    pub members: Vec<VerdictChannel>,
}

/// A channel in the verdict.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct VerdictChannel {
    /// Channel number.
    pub channel: u16,
    /// File name, empty when it is at no line.
    pub file: String,
    /// Line, 0 when it is at none.
    pub line: u32,
    /// Text of the block.
    pub block: String,
    /// Channels it waits for.
    pub waiting_for: Vec<u16>,
}

/// A diagnostic in the summary.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DiagnosticSummary {
    /// Stable number.
    pub number: u32,
    /// Word of the number, left out where only the machine knows the number.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub name: String,
    /// 0–3 message, 4–7 warning, 8–15 error, 16–99 fatal.
    pub severity: u8,
    /// Channel, 0 = master.
    pub channel: u16,
    /// File name, empty without a line.
    pub file: String,
    /// Line, 0 = none.
    pub line: u32,
    /// Text of the block.
    pub block: String,
    /// Text for people.
    pub text: String,
    /// Name of the operation as macros have set it, left out without one.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub operation: String,
    /// Name of the kernel as macros have set it, left out while it is that of the channel.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub kernel: String,
    /// The statement of a macro that raised it, left out if no macro did.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub origin: Option<Box<DiagnosticOrigin>>,
    /// When, ns.
    pub t_ns: i64,
}

/// The diagnostics and verdicts of a log.
#[derive(Debug)]
pub struct Findings {
    info: Arc<Info>,
    verdict: Option<VerdictSummary>,
    diagnostics: Vec<DiagnosticSummary>,
    highest_severity: u8,
    races: Vec<Race>,
    /// A channel of programs that are not run was judged up to a block only.
    lost: bool,
}

impl ChannelSummary {
    /// From the times of a channel, its state and where it ended.
    pub fn new(channel: &info::JobChannel, tally: &TimeTally, (state, end_ns): (ChannelState, i64)) -> Self {
        Self {
            channel: channel.number,
            name: channel.name.clone(),
            program: channel.program.clone(),
            state,
            blocks: tally.blocks(),
            end_ns,
            feed_ns: tally.feed_ns,
            rapid_ns: tally.rapid_ns,
            misc_ns: tally.misc_ns,
            wait_ns: tally.wait_ns,
            axes: channel.axes.iter().map(AxisSummary::new).collect(),
            tools: Vec::new(),
        }
    }
}

impl Findings {
    /// For a job that has not logged anything yet.
    pub fn new(info: &Arc<Info>) -> Self {
        Self {
            info: info.clone(),
            verdict: None,
            diagnostics: Vec::new(),
            highest_severity: 0,
            races: Vec::new(),
            lost: false,
        }
    }

    /// The next one in the order of the log.
    pub fn take(&mut self, reported: &Reported) {
        match &reported.what {
            ReportedContent::Diagnostic(diagnostic) => self.diagnostic(reported, diagnostic),
            ReportedContent::Verdict(verdict) if self.verdict.is_none() => self.verdict = Some(self.judged(verdict)),
            ReportedContent::Verdict(_) => {}
        }
    }

    /// Ends the summary with the fingerprint of the log and the units. `cut_short`: a program did not reach its end.
    pub fn finish(
        self,
        channels: Vec<ChannelSummary>,
        waits: Waits,
        (cancelled, cut_short): (bool, bool),
        (log_digest, coordinates): (String, Option<CoordinateUnits>),
    ) -> Summary {
        let state = if cancelled {
            JobOutcome::Cancelled
        } else if self.verdict.is_some() || self.highest_severity >= 8 || cut_short && !self.lost {
            JobOutcome::Failed
        } else {
            JobOutcome::Succeeded
        };
        let ran = channels.iter().filter(|channel| channel.state != ChannelState::NotStarted);
        let ends: Vec<(u16, i64)> = ran.map(|channel| (channel.channel, channel.end_ns)).collect();
        let (of, races) = (waits.clone(), self.races);
        let analysis = move || match ends.len() {
            0 | 1 => Analysis::default(),
            _ => Analysis { races, ..Analysis::of(&ends, &of) },
        };
        Summary {
            state,
            unit: self.info.unit.name().to_owned(),
            highest_severity: self.highest_severity,
            makespan_ns: channels.iter().map(|c| c.end_ns).max().unwrap_or(0),
            analysis: Late::new(analysis),
            log_digest,
            coordinates,
            channels,
            waits,
            verdict: self.verdict,
            diagnostics: self.diagnostics,
        }
    }

    fn diagnostic(&mut self, reported: &Reported, diagnostic: &counterpoint_event::event::Diagnostic) {
        self.highest_severity = self.highest_severity.max(diagnostic.severity);
        self.lost |= [diag::LINT_LOST.number, diag::LINT_ORDER.number].contains(&diagnostic.number);
        if let Some(race) = diagnostic.race.as_deref().filter(|_| self.races.len() < MAX_DIAGNOSTICS) {
            let lines = [(race.channel, race.line), (reported.channel, reported.user_place().line)];
            self.races.push((race.variable.as_ref().into(), lines.into()));
        }
        if self.diagnostics.len() >= MAX_DIAGNOSTICS {
            return;
        }
        let place = reported.user_place();
        let (file, block) = self.place(place.file, place.line);
        self.diagnostics.push(DiagnosticSummary {
            number: diagnostic.number,
            name: diag::name(diagnostic.number).unwrap_or_default().to_owned(),
            severity: diagnostic.severity,
            channel: reported.channel,
            file,
            line: place.line,
            block,
            text: diagnostic.text.to_string(),
            operation: diagnostic.operation.to_string(),
            kernel: diagnostic.kernel.to_string(),
            origin: diagnostic.origin.clone().or_else(|| self.origin(reported)),
            t_ns: reported.t_ns,
        });
    }

    fn judged(&self, verdict: &counterpoint_event::event::Verdict) -> VerdictSummary {
        let member = |m: &counterpoint_event::event::VerdictMember| {
            let (file, block) = self.place(m.file, m.line);
            VerdictChannel { channel: m.channel, file, line: m.line, block, waiting_for: m.waiting_for.clone() }
        };
        VerdictSummary {
            kind: verdict.kind,
            at_ns: verdict.at_ns,
            text: verdict.text.to_string(),
            members: verdict.members.iter().map(member).collect(),
        }
    }

    /// The block of a resident program that raised a diagnostic, if it was one.
    fn origin(&self, reported: &Reported) -> Option<Box<DiagnosticOrigin>> {
        reported.caller.is_some().then(|| Box::new(self.info.origin(reported.file, reported.line)))
    }

    /// File name and block text of a line.
    fn place(&self, file: FileId, line: u32) -> (String, String) {
        if line == 0 {
            return (String::new(), String::new());
        }
        (self.info.place_name(file, line).into_owned(), self.info.block_text(file, line, BLOCK_TEXT).into_owned())
    }
}
