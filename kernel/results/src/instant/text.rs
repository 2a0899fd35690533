//! The state at an instant as rows of text, and times as users write them.

use counterpoint_event::event::SpindleDirection;

use super::{ActionInstant, AxisValues, ChannelActivity, ChannelInstant, SpindleInstant, WaitInstant};
use crate::summary::AxisSummary;

/// Parses a time in simulated seconds: `12.5`, `12.5s`, `300ms`, `2min`, or as reports show it, `02:05.300`. Returns
/// nanoseconds; `None` if it is not a time.
#[must_use]
pub fn parse_time(text: &str) -> Option<i64> {
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|value| *value >= 0.0);
    let seconds = if text.contains(':') {
        text.split(':').try_fold(0.0, |sum, part| Some(sum * 60.0 + number(part)?))
    } else {
        let units = [("ms", 1e-3), ("min", 60.0), ("s", 1.0)];
        let (value, unit) =
            units.iter().find_map(|(name, factor)| Some((text.strip_suffix(name)?, *factor))).unwrap_or((text, 1.0));
        number(value).map(|value| value * unit)
    };
    seconds.map(|seconds| seconds * 1e9).filter(|ns| *ns < 9e18).map(|ns| ns.round() as i64)
}

impl ChannelActivity {
    /// In words.
    #[must_use]
    pub fn text(self) -> &'static str {
        match self {
            Self::NotStarted => "not started",
            Self::Running => "running",
            Self::Waiting => "waiting",
            Self::Ended => "ended",
            Self::Alarmed => "stopped by an alarm",
            Self::Blocked => "blocked",
            Self::Stopped => "stopped",
        }
    }
}

impl ChannelInstant {
    /// Names and values of its state at this instant, ns. `of`: its axes, and the unit of lengths; `time` formats times.
    #[must_use]
    pub fn rows(&self, t_ns: i64, of: (&[AxisSummary], &str), time: fn(i64) -> String) -> Vec<Vec<String>> {
        let mut rows = Vec::new();
        let mut row = |name: &str, text: String| rows.push(vec![name.to_owned(), text]);
        if let Some(WaitInstant { key, since_ns, missing }) = &self.wait {
            let missing: Vec<String> = missing.iter().map(u16::to_string).collect();
            let of = if missing.is_empty() { String::new() } else { format!(", for channel {}", missing.join(", ")) };
            row("wait", format!("{key} for {}{of}", time(t_ns - since_ns)));
        }
        if let Some(ActionInstant { kind, since_ns, until_ns, ends, unknown }) = &self.action {
            row("action", format!("{kind} from {} to {}", time(*since_ns), time(*until_ns)));
            if let (Some([from, to]), Some(reason)) = (ends, unknown) {
                let why = if *reason == "not_recorded" {
                    "run with --law to record it".to_owned()
                } else {
                    reason.replace('_', " ")
                };
                let [from, to] = [from, to].map(|end| values(end, of));
                row("moves", format!("{from} to {to}, position between them not known ({why})"));
            }
        }
        if let Some(position) = &self.position {
            row("position", values(position, of));
        }
        if self.tool[0] != 0 {
            let [tool, offset] = self.tool;
            row("tool", if offset == 0 { tool.to_string() } else { format!("{tool} offset {offset}") });
        }
        if self.level > 0 {
            row("subprogram", format!("level {}", self.level));
        }
        if !self.modes.is_empty() {
            row("modes", self.modes.values().cloned().collect::<Vec<_>>().join(", "));
        }
        rows
    }
}

impl SpindleInstant {
    /// Its number, rotation and commander; `unit`: the unit of lengths.
    #[must_use]
    pub fn row(&self, unit: &str) -> Vec<String> {
        let SpindleInstant { spindle, channel, direction, css, speed, limit } = self;
        let speed = match direction {
            SpindleDirection::Clockwise | SpindleDirection::CounterClockwise if *css => {
                let per_minute = if unit == "inch" { "ft/min" } else { "m/min" };
                let most = limit.map_or_else(String::new, |limit| format!(", at most {limit} rev/min"));
                format!(" {speed} {per_minute}{most}")
            }
            SpindleDirection::Clockwise | SpindleDirection::CounterClockwise => format!(" {speed} rev/min"),
            _ => String::new(),
        };
        let direction = direction.word().replace('_', " ");
        vec![spindle.to_string(), format!("{direction}{speed}"), format!("by channel {channel}")]
    }
}

/// Formats positions as `X 40  Z -12.5 mm` and `C 30°`.
fn values(position: &AxisValues, (axes, unit): (&[AxisSummary], &str)) -> String {
    let rotary = |name: &str| axes.iter().any(|axis| axis.name == name && axis.rotary);
    let value = |(name, at): &(String, f64)| {
        let degrees = if rotary(name) { "°" } else { "" };
        format!("{name} {}{degrees}", (at * 1e4).round() / 1e4 + 0.0)
    };
    let all = position.0.iter().map(value).collect::<Vec<_>>().join("  ");
    if position.0.iter().all(|(name, _)| rotary(name)) { all } else { format!("{all} {unit}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_is_a_number_of_seconds_or_a_time_of_a_report() {
        assert_eq!(parse_time("12.5"), Some(12_500_000_000));
        assert_eq!(parse_time("300ms"), Some(300_000_000));
        assert_eq!(parse_time("2min"), Some(120_000_000_000));
        assert_eq!(parse_time("02:05.300"), Some(125_300_000_000));
        assert_eq!(parse_time("1:00:00.5"), Some(3_600_500_000_000));
        for wrong in ["", "-1", "x", "1:", "nan", "inf", "1e30"] {
            assert_eq!(parse_time(wrong), None, "{wrong}");
        }
    }
}
