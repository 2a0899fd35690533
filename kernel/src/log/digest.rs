//! The fingerprint of a log: equal logs, and only those, have the same digest on every platform.
//!
//! BLAKE3 over a canonical binary form of every event in log order. Integers are little-endian, `-0.0` counts as
//! `0.0`, texts and lists carry their length (u32), kinds and enums their number as listed in this file. Each event
//! begins with a byte of flags and its kind; a field whose flag is set is the one of the event before (of the duration:
//! zero) and is left out. A motion says which axes of its start differ from where the last motion ended and which of
//! its end differ from its start, and gives only those. Invariant: every field of every event can be told from the
//! form; numbers already given to a kind or a state never change.

use blake3::Hasher;

use crate::log::event::{
    Direction, Event, FeedUnit, Kind, MAX_AXES, Motion, MotionKind, Phase, Position, Primitive, Stop, ToolAction,
    Verdict, VerdictKind,
};

/// Bytes that are hashed at once: long runs keep the hash function's parallel lanes busy.
const CHUNK: usize = 32 * 1024;

/// Builds the digest of a log, event by event.
#[derive(Debug)]
pub struct Digest {
    hasher: Hasher,
    form: Form,
}

/// The canonical form and what it leans on.
#[derive(Debug)]
struct Form {
    out: Vec<u8>,
    /// Head of the event before.
    last: Head,
    /// Where the last motion ended.
    end: Position,
}

/// The fields that every event has, without its duration.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Head {
    t_ns: i64,
    micro: u32,
    channel: u16,
    file: u16,
    line: u32,
}

impl Default for Digest {
    fn default() -> Self {
        Self::new()
    }
}

impl Digest {
    /// Digest of an empty log.
    #[must_use]
    pub fn new() -> Self {
        let out = Vec::with_capacity(CHUNK + 1024);
        Self { hasher: Hasher::new(), form: Form { out, last: Head::default(), end: [0.0; MAX_AXES] } }
    }

    /// Adds the next event of the log.
    pub fn event(&mut self, event: &Event) {
        self.form.event(event);
        if self.form.out.len() >= CHUNK {
            self.hasher.update(&self.form.out);
            self.form.out.clear();
        }
    }

    /// The digest as 64 hexadecimal digits.
    #[must_use]
    pub fn hex(mut self) -> String {
        self.hasher.update(&self.form.out);
        self.hasher.finalize().to_hex().to_string()
    }
}

impl Form {
    fn event(&mut self, event: &Event) {
        let head =
            Head { t_ns: event.t_ns, micro: event.micro, channel: event.channel, file: event.file, line: event.line };
        let last = std::mem::replace(&mut self.last, head);
        let same = [
            head.t_ns == last.t_ns,
            head.micro == last.micro,
            event.dur_ns == 0,
            head.channel == last.channel,
            head.file == last.file,
            head.line == last.line,
        ];
        let flags = same.iter().rev().fold(0_u8, |bits, same| bits << 1 | u8::from(*same));
        let out = &mut self.out;
        out.extend_from_slice(&[flags, number(&event.kind)]);
        if !same[0] {
            out.extend_from_slice(&head.t_ns.to_le_bytes());
        }
        if !same[1] {
            out.extend_from_slice(&head.micro.to_le_bytes());
        }
        if !same[2] {
            out.extend_from_slice(&event.dur_ns.to_le_bytes());
        }
        if !same[3] {
            out.extend_from_slice(&head.channel.to_le_bytes());
        }
        if !same[4] {
            out.extend_from_slice(&head.file.to_le_bytes());
        }
        if !same[5] {
            out.extend_from_slice(&head.line.to_le_bytes());
        }
        match &event.kind {
            Kind::Motion(motion) => self.motion(motion),
            kind => write_kind(out, kind),
        }
    }

    fn motion(&mut self, motion: &Motion) {
        let turns = motion.turns.to_le_bytes();
        self.out.extend_from_slice(&[
            match motion.kind {
                MotionKind::Rapid => 0,
                MotionKind::Linear => 1,
                MotionKind::ArcCw => 2,
                MotionKind::ArcCcw => 3,
                MotionKind::Thread => 4,
            },
            match motion.feed_unit {
                FeedUnit::PerMinute => 0,
                FeedUnit::PerRevolution => 1,
                FeedUnit::InverseTime => 2,
                FeedUnit::Rapid => 3,
            },
            motion.moving,
            motion.plane_axes[0],
            motion.plane_axes[1],
            turns[0],
            turns[1],
        ]);
        let end = self.end;
        self.changed(&end, &motion.from);
        self.changed(&motion.from, &motion.to);
        self.end = motion.to;
        if motion.center == [0.0, 0.0] {
            self.out.push(0);
        } else {
            self.out.push(1);
            float(&mut self.out, motion.center[0]);
            float(&mut self.out, motion.center[1]);
        }
        float(&mut self.out, motion.feed);
        float(&mut self.out, motion.length);
    }

    /// Bits of the axes that differ, then their values in `now`. A NaN differs from everything.
    fn changed(&mut self, before: &Position, now: &Position) {
        let mark = self.out.len();
        self.out.push(0);
        let mut bits = 0_u8;
        for (axis, (a, b)) in before.iter().zip(now).enumerate() {
            if a != b {
                bits |= 1 << axis;
                float(&mut self.out, *b);
            }
        }
        if let Some(slot) = self.out.get_mut(mark) {
            *slot = bits;
        }
    }
}

fn number(kind: &Kind) -> u8 {
    match kind {
        Kind::Lifecycle(_) => 0,
        Kind::Block { .. } => 1,
        Kind::Motion(_) => 2,
        Kind::Dwell => 3,
        Kind::Tool { .. } => 4,
        Kind::Spindle(_) => 5,
        Kind::Coolant { .. } => 6,
        Kind::Function { .. } => 7,
        Kind::Mode { .. } => 8,
        Kind::Frame { .. } => 9,
        Kind::Stop(_) => 10,
        Kind::Call { .. } => 11,
        Kind::Return { .. } => 12,
        Kind::Message { .. } => 13,
        Kind::Wait(_) => 14,
        Kind::Release(_) => 15,
        Kind::Diagnostic(_) => 16,
        Kind::Verdict(_) => 17,
    }
}

fn write_kind(out: &mut Vec<u8>, kind: &Kind) {
    match kind {
        Kind::Dwell | Kind::Motion(_) => {}
        Kind::Block { number } => out.extend_from_slice(&number.to_le_bytes()),
        Kind::Lifecycle(phase) => out.push(phase_number(*phase)),
        Kind::Tool { action, tool, offset } => {
            out.push(match action {
                ToolAction::Select => 0,
                ToolAction::Load => 1,
                ToolAction::Offset => 2,
            });
            out.extend_from_slice(&tool.to_le_bytes());
            out.extend_from_slice(&offset.to_le_bytes());
        }
        Kind::Spindle(spindle) => {
            out.extend_from_slice(&spindle.spindle.to_le_bytes());
            out.push(match spindle.direction {
                Direction::Off => 0,
                Direction::Clockwise => 1,
                Direction::CounterClockwise => 2,
                Direction::Oriented => 3,
            });
            out.push(u8::from(spindle.css));
            float(out, spindle.speed);
            float(out, spindle.limit);
        }
        Kind::Coolant { on } => out.push(u8::from(*on)),
        Kind::Function { letter, value } => {
            out.extend_from_slice(&u32::from(*letter).to_le_bytes());
            float(out, *value);
        }
        Kind::Mode { text: words } | Kind::Message { text: words } => text(out, words),
        Kind::Frame { shift } => {
            shift.iter().for_each(|&value| float(out, value));
        }
        Kind::Stop(stop) => out.push(match stop {
            Stop::Program => 0,
            Stop::Optional => 1,
            Stop::End => 2,
            Stop::Rewind => 3,
        }),
        Kind::Call { program, level } => {
            text(out, program);
            out.extend_from_slice(&level.to_le_bytes());
        }
        Kind::Return { level } => out.extend_from_slice(&level.to_le_bytes()),
        Kind::Wait(wait) => {
            text(out, &wait.key);
            out.push(primitive_number(wait.primitive));
            channels(out, &wait.participants);
        }
        Kind::Release(release) => {
            text(out, &release.key);
            out.push(primitive_number(release.primitive));
            out.extend_from_slice(&release.since_ns.to_le_bytes());
            out.extend_from_slice(&release.meeting.to_le_bytes());
        }
        Kind::Diagnostic(diagnostic) => {
            out.extend_from_slice(&diagnostic.number.to_le_bytes());
            out.push(diagnostic.severity);
            text(out, &diagnostic.text);
        }
        Kind::Verdict(verdict) => write_verdict(out, verdict),
    }
}

fn write_verdict(out: &mut Vec<u8>, verdict: &Verdict) {
    out.push(match verdict.kind {
        VerdictKind::Cycle => 0,
        VerdictKind::Mismatch => 1,
        VerdictKind::PartnerEnded => 2,
        VerdictKind::PartnerAlarmed => 3,
        VerdictKind::PartnerNeverStarted => 4,
        VerdictKind::PartnerSpinning => 5,
        VerdictKind::LeaseCycle => 6,
        VerdictKind::Limit => 7,
    });
    out.extend_from_slice(&verdict.at_ns.to_le_bytes());
    text(out, &verdict.text);
    length(out, verdict.members.len());
    for member in &verdict.members {
        out.extend_from_slice(&member.channel.to_le_bytes());
        out.extend_from_slice(&member.file.to_le_bytes());
        out.extend_from_slice(&member.line.to_le_bytes());
        channels(out, &member.waiting_for);
    }
}

fn phase_number(phase: Phase) -> u8 {
    match phase {
        Phase::MachineStart => 0,
        Phase::ProgramStart => 1,
        Phase::NotStarted => 2,
        Phase::ProgramEnd => 3,
        Phase::Alarmed => 4,
        Phase::Stopped => 5,
        Phase::Blocked => 6,
        Phase::MachineEnd => 7,
    }
}

fn primitive_number(primitive: Primitive) -> u8 {
    match primitive {
        Primitive::Barrier => 0,
        Primitive::Flag => 1,
        Primitive::Order => 2,
        Primitive::Count => 3,
        Primitive::Signal => 4,
        Primitive::Join => 5,
    }
}

fn float(out: &mut Vec<u8>, value: f64) {
    // Adding zero turns -0.0 into 0.0 and changes nothing else; every NaN counts as the same one.
    let bits = if value.is_nan() { f64::NAN.to_bits() } else { (value + 0.0).to_bits() };
    out.extend_from_slice(&bits.to_le_bytes());
}

fn length(out: &mut Vec<u8>, count: usize) {
    out.extend_from_slice(&u32::try_from(count).unwrap_or(u32::MAX).to_le_bytes());
}

fn text(out: &mut Vec<u8>, text: &str) {
    length(out, text.len());
    out.extend_from_slice(text.as_bytes());
}

fn channels(out: &mut Vec<u8>, channels: &[u16]) {
    length(out, channels.len());
    for channel in channels {
        out.extend_from_slice(&channel.to_le_bytes());
    }
}

#[cfg(test)]
mod tests;
