//! The position of a stepped job, as text.

use std::fmt::Write as _;

use counterpoint_proto::v1;
use counterpoint_proto::v1::breakpoint::At;
use counterpoint_proto::v1::dialog_value::Value;

use crate::text::{table, time};

/// A stop: why, and a line for each channel.
pub(super) fn stop(state: &v1::DebugState) -> String {
    format!("stop: {}\n{}", state.reason, channels(state))
}

fn channels(state: &v1::DebugState) -> String {
    let rows: Vec<Vec<String>> = state.channels.iter().map(channel).collect();
    table(&rows, 6)
}

/// Number, time, activity, place, block.
fn channel(of: &v1::DebugChannel) -> Vec<String> {
    let doing = match of.state() {
        v1::ChannelState::Waiting => format!("waits for {}", of.waiting_for),
        v1::ChannelState::Running if of.in_block => "in".to_owned(),
        v1::ChannelState::Running if of.line > 0 => "before".to_owned(),
        v1::ChannelState::NotStarted => "no program".to_owned(),
        v1::ChannelState::Running | v1::ChannelState::Ready | v1::ChannelState::Unspecified => "ready".to_owned(),
        state => state.as_str_name().trim_start_matches("CHANNEL_STATE_").to_lowercase(),
    };
    let held = if of.held { "hold" } else { "" };
    let place = if of.line > 0 { format!("{}:{}", of.file, of.line) } else { String::new() };
    vec![of.channel.to_string(), time(of.t_ns), held.to_owned(), doing, place, of.block.clone()]
}

/// Channels with positions and variables, shared variables, breakpoints.
pub(super) fn whole(state: &v1::DebugState) -> String {
    let mut out = channels(state);
    for channel in &state.channels {
        list(&mut out, &format!("channel {} positions", channel.channel), &channel.positions);
        list(&mut out, &format!("channel {} words", channel.channel), &channel.words);
        list(&mut out, &format!("channel {} variables", channel.channel), &channel.variables);
    }
    list(&mut out, "shared variables", &state.variables);
    for one in &state.breakpoints {
        let _ = writeln!(out, "breakpoint {}", breakpoint(one));
    }
    out
}

fn list(out: &mut String, title: &str, variables: &[v1::DebugVariable]) {
    if !variables.is_empty() {
        let values: Vec<String> = variables.iter().map(|one| format!("{}={}", one.name, value(one))).collect();
        let _ = writeln!(out, "{title}: {}", values.join(" "));
    }
}

fn value(of: &v1::DebugVariable) -> String {
    match of.value.as_ref().and_then(|value| value.value.as_ref()) {
        Some(Value::Number(number)) => number.to_string(),
        Some(Value::Flag(flag)) => if *flag { ".TRUE." } else { ".FALSE." }.to_owned(),
        Some(Value::Text(text)) => format!("'{text}'"),
        None => String::new(),
    }
}

/// A breakpoint: number and place.
pub(super) fn breakpoint(of: &v1::Breakpoint) -> String {
    let place = match &of.at {
        Some(At::Wait(key)) if key.is_empty() => "wait".to_owned(),
        Some(At::Wait(key)) => format!("wait {key}"),
        Some(At::Write(name)) => format!("write {name}"),
        Some(At::Line(v1::BreakLine { file, line })) if file.is_empty() => format!("line {line}"),
        Some(At::Line(v1::BreakLine { file, line })) => format!("line {file}:{line}"),
        Some(At::TNs(ns)) => format!("time {}", *ns as f64 / 1e9),
        None => String::new(),
    };
    let count = if of.count > 1 { format!(" x{}", of.count) } else { String::new() };
    format!("{}: {place}{count}{}", of.id, if of.once { ", once" } else { "" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stop_has_a_line_for_each_channel() {
        let number = |name: &str, n| v1::DebugVariable {
            name: name.into(),
            value: Some(v1::DialogValue { value: Some(Value::Number(n)) }),
        };
        let one = v1::DebugChannel {
            channel: 1,
            state: v1::ChannelState::Waiting.into(),
            file: "upper.nc".into(),
            line: 2,
            block: "M101".into(),
            t_ns: 2_000_000_000,
            waiting_for: "M101".into(),
            in_block: true,
            positions: vec![number("X", 100.5), number("Z", -2.0)],
            words: vec![number("T", 101.0), number("M", 3.0)],
            ..Default::default()
        };
        let two = v1::DebugChannel { channel: 2, line: 1, held: true, waiting_for: String::new(), ..one.clone() };
        let two = v1::DebugChannel { state: v1::ChannelState::Running.into(), in_block: false, t_ns: 0, ..two };
        let state = v1::DebugState {
            reason: "step".into(),
            channel: 1,
            channels: vec![one, v1::DebugChannel { positions: Vec::new(), words: Vec::new(), ..two }],
            variables: vec![number("#500", 7.0)],
            breakpoints: vec![v1::Breakpoint { id: 3, at: Some(At::Wait("M101".into())), count: 2, once: true }],
        };
        let lines = [
            "  1  00:02.000        waits for M101  upper.nc:2  M101\n",
            "  2  00:00.000  hold  before          upper.nc:1  M101\n",
        ]
        .concat();
        assert_eq!(stop(&state), format!("stop: step\n{lines}"));
        let more = "channel 1 positions: X=100.5 Z=-2\nchannel 1 words: T=101 M=3\nshared variables: #500=7\nbreakpoint 3: wait M101 x2, once\n";
        assert_eq!(whole(&state), format!("{lines}{more}"));
    }
}
