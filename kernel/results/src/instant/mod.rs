//! The state of a job at an instant: for each channel its block, activity, position, tool, spindles and wait.
//!
//! An [`InstantBuilder`] reads the lines of the ordered log ([`crate::jsonl`]). Between the ends of a motion the
//! position follows the law of the motion, if the job has recorded laws; otherwise only the ends are given.
//! *Invariant:* events that begin at the instant are included, regardless of their microstep.

mod lines;
mod position;
#[cfg(test)]
mod tests;
mod text;

use std::collections::BTreeMap;

use serde::ser::{SerializeMap as _, Serializer};
use serde::{Deserialize, Serialize};

use counterpoint_event::event::{Motion, MotionLaw, SpindleDirection};
use counterpoint_event::info::JobAxis;

use crate::summary::{AxisSummary, ChannelSummary, Summary};
pub(crate) use lines::EventLine as LoggedLine;
use lines::{EventLine, FrameLine, LawLine, LevelLine, ModeLine, MotionLine, PhaseLine, ToolLine, WaitLine};

pub use position::position;
pub use text::parse_time;

/// A line that is not an event of a job.
#[derive(Debug)]
pub struct NotAnEvent(pub serde_json::Error);

/// The state of a job at an instant.
#[derive(Debug, Serialize)]
pub struct Instant {
    /// The instant, ns.
    pub t_ns: i64,
    /// End of the last channel, ns.
    pub makespan_ns: i64,
    /// Channels, ascending.
    pub channels: Vec<ChannelInstant>,
    /// The last command of each spindle, by any channel; spindles without a command are left out.
    pub spindles: Vec<SpindleInstant>,
}

/// The activity of a channel at an instant.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ChannelActivity {
    /// The program has not started, or the channel has no program.
    NotStarted,
    /// The channel executes blocks.
    Running,
    /// The channel waits for other channels.
    Waiting,
    /// The program has ended.
    Ended,
    /// An alarm has stopped the channel.
    Alarmed,
    /// The channel is blocked at a wait without end.
    Blocked,
    /// A limit, an alarm of the machine or a cancel has stopped the channel.
    Stopped,
}

/// A channel at an instant.
#[derive(Debug, Serialize)]
pub struct ChannelInstant {
    /// Number.
    pub channel: u16,
    /// Name.
    pub name: String,
    /// Activity.
    pub state: ChannelActivity,
    /// File of the block, in the programs of the user; empty before the first block.
    pub file: String,
    /// Line of the block, from 1; 0 before the first block.
    pub line: u32,
    /// Nesting level of subprograms.
    pub level: u16,
    /// The event in progress.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub action: Option<ActionInstant>,
    /// Positions by axis in the work frame, in units of the machine: after work and tool offsets, without programmed
    /// shifts and rotations, diameters on a diameter axis. `None` before the first motion, during a motion without a
    /// law, and after a change of a transformation until the next motion.
    pub position: Option<AxisValues>,
    /// Machine position minus position in the work frame, by axis; exact unless a frame is rotated.
    pub shift: AxisValues,
    /// Loaded tool, 0 for none, and its offset.
    pub tool: [u32; 2],
    /// Modal states by the first words of their text, as the listing names them.
    pub modes: BTreeMap<String, String>,
    /// The wait in progress.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wait: Option<WaitInstant>,
}

/// An event in progress.
#[derive(Debug, Clone, Serialize)]
pub struct ActionInstant {
    /// Kind of the event, for a motion the kind of motion: `rapid`, `linear`, `dwell`, `tool`.
    pub kind: String,
    /// Start, ns.
    pub since_ns: i64,
    /// End, ns.
    pub until_ns: i64,
    /// Start and end of a motion by axis.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ends: Option<[AxisValues; 2]>,
    /// Why the position between the ends is not known; `None` if the position is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unknown: Option<&'static str>,
}

/// The last command of a spindle.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct SpindleInstant {
    /// Number of the spindle.
    pub spindle: u16,
    /// The channel that commanded it last.
    #[serde(default)]
    pub channel: u16,
    /// Direction.
    pub direction: SpindleDirection,
    /// Whether constant surface speed is active.
    pub css: bool,
    /// Rev/min, or surface speed in m/min or ft/min.
    pub speed: f64,
    /// Speed limit in rev/min, if there is one.
    pub limit: Option<f64>,
}

/// Values by axis, in the order of the channel.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct AxisValues(pub Vec<(String, f64)>);

impl Serialize for AxisValues {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        self.0.iter().try_for_each(|(axis, value)| map.serialize_entry(axis, value))?;
        map.end()
    }
}

/// A wait in progress.
#[derive(Debug, Clone, Serialize)]
pub struct WaitInstant {
    /// The mark, such as `M101`.
    pub key: String,
    /// Arrival of the channel, ns.
    pub since_ns: i64,
    /// The channels that take part and have not arrived.
    pub missing: Vec<u16>,
}

/// A motion that began at or before the instant.
struct LastMotion {
    start_ns: i64,
    end_ns: i64,
    motion: Motion,
    law: Option<MotionLaw>,
}

/// A channel while lines are read.
struct ChannelReplay {
    axes: Vec<JobAxis>,
    now: ChannelInstant,
    motion: Option<LastMotion>,
    participants: Vec<u16>,
    /// Transformations between program and axes that are on, by the first word of their modal state.
    transformed: Vec<String>,
}

/// First words of modal states of transformations: when one changes, the position in the work frame is another one,
/// which the next motion tells.
const TRANSFORMATIONS: [&str; 5] = ["tilt", "rtcp", "cylinder", "c2p", "polar"];

/// Reads the lines of a log up to an instant.
pub struct InstantBuilder {
    t_ns: i64,
    makespan_ns: i64,
    channels: Vec<ChannelReplay>,
    spindles: Vec<SpindleInstant>,
    last_ns: i64,
    lines: u64,
}

impl InstantBuilder {
    /// Starts the state at this instant, ns, for the job with this summary.
    #[must_use]
    pub fn new(summary: &Summary, t_ns: i64) -> Self {
        let channels = summary.channels.iter().map(ChannelReplay::new).collect();
        let makespan_ns = summary.makespan_ns;
        Self { t_ns, makespan_ns, channels, spindles: Vec::new(), last_ns: i64::MIN, lines: 0 }
    }

    /// Reads the next line; `false` if this line and all later lines are after the instant.
    ///
    /// # Errors
    /// If the line is not an event of this job.
    pub fn line(&mut self, line: &[u8]) -> Result<bool, NotAnEvent> {
        let event: EventLine = serde_json::from_slice(line).map_err(NotAnEvent)?;
        let known = event.channel == 0 || self.channels.iter().any(|channel| channel.now.channel == event.channel);
        let late = event.channel > 0 && event.t_ns > self.makespan_ns;
        if !known || late || event.t_ns < self.last_ns {
            let wrong = match known {
                true => "its time is before that of the line before, or after the end of the job",
                false => "the summary does not have its channel",
            };
            return Err(NotAnEvent(serde::de::Error::custom(wrong)));
        }
        (self.last_ns, self.lines) = (event.t_ns, self.lines + 1);
        if event.t_ns > self.t_ns {
            return Ok(false);
        }
        if event.kind == "spindle" && event.channel > 0 {
            let mut spindle: SpindleInstant = serde_json::from_slice(line).map_err(NotAnEvent)?;
            spindle.channel = event.channel;
            self.spindles.retain(|known| known.spindle != spindle.spindle);
            self.spindles.push(spindle);
        }
        if let Some(channel) = self.channels.iter_mut().find(|channel| channel.now.channel == event.channel) {
            channel.event(&event, line, self.t_ns).map_err(NotAnEvent)?;
        }
        Ok(true)
    }

    /// Whether a line has been read.
    #[must_use]
    pub fn has_lines(&self) -> bool {
        self.lines > 0
    }

    /// Returns the state.
    #[must_use]
    pub fn finish(self) -> Instant {
        let Self { t_ns, makespan_ns, channels, mut spindles, .. } = self;
        spindles.sort_by_key(|spindle| spindle.spindle);
        let at_wait = |channel: &ChannelReplay, key: &str| channel.now.wait.as_ref().is_some_and(|w| w.key == key);
        let arrived = |number: u16, key: &str| {
            channels.iter().any(|channel| channel.now.channel == number && at_wait(channel, key))
        };
        let missing: Vec<Vec<u16>> = channels
            .iter()
            .map(|channel| match &channel.now.wait {
                Some(wait) => channel.participants.iter().copied().filter(|at| !arrived(*at, &wait.key)).collect(),
                None => Vec::new(),
            })
            .collect();
        let channels = channels.into_iter().zip(missing).map(|(channel, missing)| channel.finish(t_ns, missing));
        Instant { t_ns, makespan_ns, channels: channels.collect(), spindles }
    }
}

impl ChannelReplay {
    fn new(channel: &ChannelSummary) -> Self {
        let axes = channel.axes.iter().map(AxisSummary::job_axis).collect();
        let shift = AxisValues(channel.axes.iter().map(|axis| (axis.name.clone(), 0.0)).collect());
        let now = ChannelInstant {
            channel: channel.channel,
            name: channel.name.clone(),
            state: ChannelActivity::NotStarted,
            file: String::new(),
            line: 0,
            level: 0,
            action: None,
            position: None,
            shift,
            tool: [0; 2],
            modes: BTreeMap::new(),
            wait: None,
        };
        Self { axes, now, motion: None, participants: Vec::new(), transformed: Vec::new() }
    }

    fn event(&mut self, event: &EventLine, line: &[u8], t_ns: i64) -> Result<(), serde_json::Error> {
        let now = &mut self.now;
        if let Some((file, line)) = event.user_place() {
            file.clone_into(&mut now.file);
            now.line = line;
        }
        let end_ns = event.t_ns.saturating_add(event.dur_ns);
        if event.dur_ns > 0 && end_ns > t_ns && event.kind != "law" {
            let (kind, ends, unknown) = (event.kind.clone(), None, None);
            now.action = Some(ActionInstant { kind, since_ns: event.t_ns, until_ns: end_ns, ends, unknown });
        }
        match event.kind.as_str() {
            "motion" => {
                let motion: MotionLine = serde_json::from_slice(line)?;
                if let Some(action) = now.action.as_mut().filter(|action| action.since_ns == event.t_ns) {
                    motion.motion.word().clone_into(&mut action.kind);
                }
                let motion = motion.motion(&self.axes);
                self.motion = Some(LastMotion { start_ns: event.t_ns, end_ns, motion, law: None });
            }
            "law" => {
                let law: LawLine = serde_json::from_slice(line)?;
                if let Some(last) = self.motion.as_mut().filter(|last| last.start_ns == event.t_ns) {
                    last.law = Some(law.law(&self.axes));
                }
            }
            "frame" => {
                let frame: FrameLine = serde_json::from_slice(line)?;
                self.shift(&frame);
                if !self.transformed.is_empty() {
                    self.motion = None;
                }
            }
            "tool" => {
                let tool: ToolLine = serde_json::from_slice(line)?;
                match tool.action.as_str() {
                    "load" => now.tool = [tool.tool, tool.offset],
                    "offset" => now.tool[1] = tool.offset,
                    _ => {}
                }
            }
            "mode" => {
                let mode: ModeLine = serde_json::from_slice(line)?;
                self.mode(&mode);
            }
            "call" => now.level = serde_json::from_slice::<LevelLine>(line)?.level,
            "return" => now.level = serde_json::from_slice::<LevelLine>(line)?.level.saturating_sub(1),
            "wait" => {
                let WaitLine { key, participants } = serde_json::from_slice(line)?;
                self.participants = participants;
                now.wait = Some(WaitInstant { key, since_ns: event.t_ns, missing: Vec::new() });
                now.state = ChannelActivity::Waiting;
            }
            "release" => {
                now.wait = None;
                now.state = ChannelActivity::Running;
            }
            "lifecycle" => {
                now.state = match serde_json::from_slice::<PhaseLine>(line)?.phase.as_str() {
                    "program_start" => ChannelActivity::Running,
                    "program_end" => ChannelActivity::Ended,
                    "alarmed" => ChannelActivity::Alarmed,
                    "blocked" => ChannelActivity::Blocked,
                    "stopped" => ChannelActivity::Stopped,
                    _ => now.state,
                };
            }
            _ => {}
        }
        Ok(())
    }

    fn mode(&mut self, ModeLine { text, carried }: &ModeLine) {
        let mut words = text.split(' ');
        let first = words.next().unwrap_or_default();
        // Data that a block sets are no modal states. Compensations have several: `comp length`, `comp diam`.
        let key = match words.next() {
            Some(second) if first == "comp" => format!("{first} {second}"),
            _ => first.to_owned(),
        };
        if first != "set" {
            self.now.modes.insert(key, text.clone());
        }
        if TRANSFORMATIONS.contains(&first) {
            self.transformed.retain(|known| known != first);
            if !text.ends_with(" off") {
                self.transformed.push(first.to_owned());
            }
            self.motion = None;
        }
        if let (Some(carried), Some(last)) = (carried, &mut self.motion) {
            last.motion.to = carried.to.position(&self.axes);
        }
    }

    /// Moves the work frame, and converts the last position to the new frame.
    fn shift(&mut self, frame: &FrameLine) {
        let after = self.by_axis(&frame.shift.position(&self.axes));
        let before = std::mem::replace(&mut self.now.shift, after);
        if let Some(last) = &mut self.motion {
            let changes = before.0.iter().zip(&self.now.shift.0);
            last.motion.to.iter_mut().zip(changes).for_each(|(slot, (before, after))| *slot += before.1 - after.1);
        }
    }

    fn by_axis(&self, position: &[f64]) -> AxisValues {
        AxisValues(self.axes.iter().zip(position).map(|(axis, value)| (axis.name.clone(), *value)).collect())
    }

    fn finish(mut self, t_ns: i64, missing: Vec<u16>) -> ChannelInstant {
        if let Some(wait) = &mut self.now.wait {
            wait.missing = missing;
        }
        if let Some(LastMotion { start_ns, end_ns, motion, law }) = self.motion.take() {
            let moves = end_ns > t_ns;
            let place = if moves {
                let share = (t_ns - start_ns) as f64 / (end_ns - start_ns) as f64;
                match &law {
                    Some(law) => position(&motion, law, &self.axes, share),
                    None => (share <= 0.0).then_some(motion.from),
                }
            } else {
                Some(motion.to)
            };
            self.now.position = place.map(|place| self.by_axis(&place));
            let ends = [&motion.from, &motion.to].map(|end| self.by_axis(end));
            if let Some(action) = self.now.action.as_mut().filter(|action| moves && action.since_ns == start_ns) {
                action.ends = Some(ends);
                action.unknown = match (place, law) {
                    (Some(_), _) => None,
                    (None, Some(MotionLaw::Unknown(reason))) => Some(reason.word()),
                    (None, _) => Some("not_recorded"),
                };
            }
        }
        self.now
    }
}
