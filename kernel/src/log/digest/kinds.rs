//! The fields of each kind of event but motions and blocks, and the numbers of kinds and enums.
//!
//! Invariant: numbers already given never change; texts and lists carry their length.

use crate::log::event::{Direction, Kind, Outlet, Phase, Primitive, Stop, ToolAction, Verdict, VerdictKind};

pub(super) fn number(kind: &Kind) -> u8 {
    match kind {
        Kind::Lifecycle(_) => 0,
        Kind::Block { .. } => 1,
        Kind::Motion(_) => 2,
        Kind::Dwell => 3,
        Kind::Tool { .. } => 4,
        Kind::Spindle(_) => 5,
        Kind::Coolant(_) => 6,
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
        Kind::Trace { .. } => 18,
        Kind::ToolData(_) => 19,
    }
}

pub(super) fn write_kind(out: &mut Vec<u8>, kind: &Kind) {
    match kind {
        Kind::Dwell | Kind::Motion(_) | Kind::Block { .. } => {}
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
        Kind::ToolData(data) => {
            out.extend_from_slice(&data.tool.to_le_bytes());
            text(out, &data.name);
            for value in [data.diameter, data.radius, data.length] {
                out.push(u8::from(value.is_some()));
                value.into_iter().for_each(|value| float(out, value));
            }
            out.extend_from_slice(&data.place.to_le_bytes());
        }
        Kind::Spindle(spindle) => {
            out.extend_from_slice(&spindle.spindle.to_le_bytes());
            out.push(match spindle.direction {
                Direction::Off => 0,
                Direction::Clockwise => 1,
                Direction::CounterClockwise => 2,
                Direction::Oriented => 3,
                Direction::Locked => 4,
                Direction::Neutral => 5,
            });
            out.push(u8::from(spindle.css));
            float(out, spindle.speed);
            float(out, spindle.limit);
            float(out, spindle.angle);
        }
        Kind::Coolant(coolant) => out.extend_from_slice(&[
            u8::from(coolant.on),
            coolant.fluid,
            match coolant.outlet {
                Outlet::Main => 0,
                Outlet::Device(number) => number,
                Outlet::Side => 255,
            },
        ]),
        Kind::Function { letter, value } => {
            out.extend_from_slice(&u32::from(*letter).to_le_bytes());
            float(out, *value);
        }
        Kind::Mode { text: words } => text(out, words),
        Kind::Message { text: words, printed } => {
            text(out, words);
            if *printed {
                out.push(1);
            }
        }
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
            let origin = diagnostic.origin.as_deref();
            if !diagnostic.operation.is_empty() || !diagnostic.kernel.is_empty() || origin.is_some() {
                text(out, &diagnostic.operation);
            }
            if !diagnostic.kernel.is_empty() || origin.is_some() {
                text(out, &diagnostic.kernel);
            }
            if let Some(origin) = origin {
                text(out, &origin.name);
                text(out, &origin.file);
                out.extend_from_slice(&origin.line.to_le_bytes());
                text(out, &origin.statement);
            }
        }
        Kind::Trace { letter, text: line } => {
            out.extend_from_slice(&u32::from(*letter).to_le_bytes());
            text(out, line);
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

pub(super) fn bits(value: f64) -> u64 {
    // Adding zero turns -0.0 into 0.0 and changes nothing else; every NaN counts as the same one.
    if value.is_nan() { f64::NAN.to_bits() } else { (value + 0.0).to_bits() }
}

fn float(out: &mut Vec<u8>, value: f64) {
    out.extend_from_slice(&bits(value).to_le_bytes());
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
