//! Helpers of the tests in this folder: hand-made jobs and real small ones.

use std::sync::{Arc, OnceLock};

use crate::builder::{JobResults, ResultsBuilder};
use counterpoint_event::RunEnd;
use counterpoint_event::Text;
use counterpoint_event::event::{Diagnostic, FeedUnit};
use counterpoint_event::event::{
    Event, Kind, MAX_AXES, Motion, MotionKind, Phase, Position, Primitive, Release, SourcePlace, WaitArrival,
};
use counterpoint_event::info::{Info, JobAxis, JobChannel, JobFile, MachineUnit, ResultBudget};

/// A job of a two-turret lathe (X diameter, Z, C on the upper one) with a program text for each channel.
pub(crate) fn lathe(texts: &[&str]) -> Arc<Info> {
    info(texts, &[&["X", "Z", "C"], &["X", "Z"], &["X", "Z"]], true)
}

/// A job of a lathe whose live tools move along Y.
pub(crate) fn lathe_with_y(text: &str) -> Arc<Info> {
    info(&[text], &[&["X", "Z", "Y"]], true)
}

/// A job of a three-axis mill.
pub(crate) fn mill(text: &str) -> Arc<Info> {
    info(&[text], &[&["X", "Y", "Z"]], false)
}

fn info(texts: &[&str], axes: &[&[&str]], diameter: bool) -> Arc<Info> {
    let axis = |name: &&str| JobAxis { name: (*name).into(), rotary: *name == "C", diameter: diameter && *name == "X" };
    let channel = |(index, axes): (usize, &&[&str])| JobChannel {
        number: index as u16 + 1,
        name: ["UPPER", "LOWER", "THIRD"][index].into(),
        program: format!("jobs/p{}.nc", index + 1),
        lines: (1, 99),
        file: index as u16,
        lower: index == 1,
        inch: false,
        unit_words: "G20/G21".into(),
        axes: axes.iter().map(axis).collect(),
    };
    let file = |(index, text): (usize, &&str)| {
        let name = format!("jobs/p{}.nc", index + 1);
        let source = Arc::new(Text::new(bytes::Bytes::copy_from_slice(text.as_bytes()), || false));
        JobFile { name, stored: false, resident: false, text: OnceLock::from(Some(source)), sections: Vec::new() }
    };
    Arc::new(Info {
        machine: "lathe2".into(),
        machine_number: 2,
        machine_revision: 1,
        machine_created: String::new(),
        machine_file: "lathe2/machine.toml".into(),
        parameters: String::new(),
        trace: counterpoint_event::Letters::default(),
        unit: MachineUnit::Mm,
        room: ResultBudget { path: 16 << 20, bars: 4 << 20, waiting: 4 << 20 },
        channels: axes.iter().enumerate().take(texts.len()).map(channel).collect(),
        files: texts.iter().enumerate().map(file).collect(),
    })
}

/// An event of a channel in its own file.
pub(crate) fn at(channel: u16, line: u32, t_ns: i64, dur_ns: i64, kind: Kind) -> Event {
    Event { t_ns, micro: 0, dur_ns, channel, file: channel.saturating_sub(1), line, caller: SourcePlace::NONE, kind }
}

pub(crate) fn life(channel: u16, t_ns: i64, phase: Phase) -> Event {
    at(channel, 0, t_ns, 0, Kind::Lifecycle(phase))
}

pub(crate) fn position(values: &[f64]) -> Position {
    let mut out = [0.0; MAX_AXES];
    out[..values.len()].copy_from_slice(values);
    out
}

pub(crate) fn motion(kind: MotionKind, from: &[f64], to: &[f64]) -> Motion {
    let (from, to) = (position(from), position(to));
    let length = from.iter().zip(&to).map(|(a, b)| (b - a) * (b - a)).sum::<f64>().sqrt();
    let feed_unit = if kind == MotionKind::Rapid { FeedUnit::Rapid } else { FeedUnit::PerMinute };
    let feed = if kind == MotionKind::Rapid { 0.0 } else { 100.0 };
    Motion { kind, moving: 1, from, to, center: [0.0; 2], plane_axes: [255; 2], turns: 0, feed, feed_unit, length }
}

/// Mark of a wait code with a letter.
fn mark(key: &str) -> Arc<str> {
    key.split(' ').next().unwrap_or(key).trim_start_matches('M').into()
}

pub(crate) fn wait(channel: u16, line: u32, t_ns: i64, key: &str, participants: &[u16]) -> Event {
    let wait = WaitArrival {
        key: key.into(),
        primitive: Primitive::Barrier,
        participants: participants.into(),
        mark: mark(key),
        acts: false,
    };
    at(channel, line, t_ns, 0, Kind::Wait(Arc::new(wait)))
}

pub(crate) fn release(channel: u16, line: u32, since_ns: i64, t_ns: i64, key: &str, meeting: u64) -> Event {
    let release = Release { key: key.into(), primitive: Primitive::Barrier, since_ns, meeting, mark: mark(key), by: 1 };
    at(channel, line, t_ns, 0, Kind::Release(release))
}

pub(crate) fn diagnostic(channel: u16, line: u32, t_ns: i64, number: u32, severity: u8, text: &str) -> Event {
    at(
        channel,
        line,
        t_ns,
        0,
        Kind::Diagnostic(Box::new(Diagnostic { number, severity, text: text.into(), ..Diagnostic::default() })),
    )
}

/// How a complete run of that many events ends.
pub(crate) fn outcome(events: usize) -> RunEnd {
    RunEnd { events: events as u64, cancelled: false, sink_failed: false }
}

/// Results of a log.
pub(crate) fn results(info: &Arc<Info>, events: &[Event], outcome: &RunEnd) -> JobResults {
    let mut builder = ResultsBuilder::new(info);
    events.iter().for_each(|event| builder.event(event));
    builder.finish(outcome)
}
