//! The results of a job, as the fences of a page show them.

use std::fmt::Write as _;

use counterpoint_kernel::log::event::{
    Dwell, Event, Kind, Motion, MotionKind, OperatorMessage, SubprogramEntry, TimedFunction, ToolChange,
};
use counterpoint_kernel::log::info::Info;
use counterpoint_kernel::log::listing;

use crate::Done;

fn motion(info: &Info, event: &Event, motion: &Motion) -> String {
    let kind = match motion.kind {
        MotionKind::Rapid => "rapid",
        MotionKind::Linear => "linear",
        MotionKind::ArcCw => "arc cw",
        MotionKind::ArcCcw => "arc ccw",
        MotionKind::ArcSpace => "arc space",
        MotionKind::Thread => "thread",
    };
    let mut text = kind.to_owned();
    let axes = info.channel(event.channel).map_or(&[][..], |channel| &channel.axes);
    for (at, axis) in axes.iter().enumerate() {
        if motion.moving & 1 << at != 0 {
            let _ = write!(text, " {}{}", axis.name, (motion.to[at] * 1e6).round() / 1e6);
        }
    }
    if motion.feed != 0.0 {
        let _ = write!(text, " f={}", motion.feed);
    }
    text
}

/// An event as pages show it; none for blocks and the like. On a machine with several channels its channel comes first.
pub(super) fn event(info: &Info, event: &Event) -> Option<String> {
    let text = match &event.kind {
        Kind::Motion(m) => motion(info, event, m),
        Kind::Message(OperatorMessage { text, .. }) => format!("message {text}"),
        Kind::Mode(mode) => format!("mode {mode}"),
        Kind::Tool(ToolChange { action, tool, .. }) => format!("tool {} {tool}", format!("{action:?}").to_lowercase()),
        Kind::Spindle(s) => {
            let of = if s.spindle > 1 { format!(" of {}", s.spindle) } else { String::new() };
            format!("spindle {} {}{of}", format!("{:?}", s.direction).to_lowercase(), s.speed)
        }
        Kind::Coolant(coolant) => coolant.to_string(),
        Kind::Function(TimedFunction { letter, value }) => format!("function {letter}{value}"),
        Kind::Call(SubprogramEntry { program, .. }) => format!("call {program}"),
        Kind::Return(_) => "return".to_owned(),
        Kind::Stop(stop) => format!("stop {}", format!("{stop:?}").to_lowercase()),
        Kind::Dwell(Dwell) => format!("dwell {}", event.dur_ns as f64 / 1e9),
        Kind::Wait(wait) => format!("wait {}", wait.key),
        Kind::Release(release) => format!("release {}", release.key),
        Kind::Verdict(verdict) => format!("verdict {:?}", verdict.kind).to_lowercase(),
        _ => return None,
    };
    Some(if info.channels.len() > 1 { format!("{}! {text}", event.channel) } else { text })
}

/// Texts of the diagnostics, each with the line of the macro that raised it.
pub(super) fn texts(done: &Done) -> String {
    let mut texts = String::new();
    for event in &done.events {
        let Kind::Diagnostic(diagnostic) = &event.kind else { continue };
        let _ = writeln!(texts, "{}", diagnostic.text);
        if let Some(origin) = &diagnostic.origin {
            let _ = writeln!(texts, "  MACRO({}) LINE({}): {}", origin.name, origin.line, origin.statement);
        }
    }
    texts
}

/// The program of each channel in the summary.
pub(super) fn ran(done: &Done) -> String {
    done.summary.channels.iter().map(|c| format!("{} {}\n", c.channel, c.program)).collect()
}

/// A listing of a kind; VERSION stands for the version of this project.
pub(super) fn listing(kind: &str, channel: u16, info: &Info, done: &Done) -> String {
    let mut events = (1_u64..).zip(done.events.iter().cloned());
    let mut out = Vec::new();
    let summary = &done.summary;
    let written = match kind {
        "trace" => listing::render_trace(info, channel, &mut events, &mut out),
        "log" => listing::render_log(info, channel, summary, &mut events, &mut out),
        "console" => listing::render_console(info, 0, &mut events, &mut out),
        "merged" => listing::render_merged(info, summary, &mut events, &mut out),
        _ => listing::render(info, channel, summary, &mut events, &mut out),
    };
    match written {
        Ok(()) => String::from_utf8_lossy(&out).replace(env!("CARGO_PKG_VERSION"), "VERSION"),
        Err(error) => format!("{error}\n"),
    }
}
