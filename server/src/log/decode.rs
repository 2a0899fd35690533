//! Wire encoding back to kernel events, for results made from the log.
//!
//! Invariant: decoding what [`super::encode`] wrote gives the same event, bit for bit (tested), so a result made
//! later equals the one made while the job ran. Damage gives `None`, never a panic.

use std::sync::Arc;

use counterpoint_kernel::log::event::{
    Coolant, Diagnostic, Event, FeedUnit, Kind, MAX_AXES, Member, Motion, MotionKind, Origin, Outlet, Position,
    Release, Spindle, ToolData, Verdict, Wait,
};

use super::encode as numbers;

/// A value on the wire.
enum Value<'a> {
    Number(u64),
    Fixed(u64),
    Bytes(&'a [u8]),
}

impl Value<'_> {
    fn number(&self) -> u64 {
        match self {
            Self::Number(n) | Self::Fixed(n) => *n,
            Self::Bytes(_) => 0,
        }
    }

    fn double(&self) -> f64 {
        f64::from_bits(self.number())
    }
}

impl Value<'_> {
    /// None for a field that is not there.
    fn optional_double(&self) -> Option<f64> {
        match self {
            Self::Fixed(bits) => Some(f64::from_bits(*bits)),
            _ => None,
        }
    }
}

impl<'a> Value<'a> {
    fn bytes(&self) -> &'a [u8] {
        match self {
            Self::Bytes(bytes) => bytes,
            _ => &[],
        }
    }

    fn text(&self) -> Box<str> {
        String::from_utf8_lossy(self.bytes()).into()
    }
}

/// The fields of a message, in order.
struct Fields<'a>(&'a [u8]);

impl<'a> Fields<'a> {
    fn varint(&mut self) -> Option<u64> {
        let mut value = 0;
        for shift in (0..64).step_by(7) {
            let (&byte, rest) = self.0.split_first()?;
            self.0 = rest;
            value |= u64::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return Some(value);
            }
        }
        None
    }

    fn next_field(&mut self) -> Option<(u64, Value<'a>)> {
        let key = self.varint()?;
        let value = match key & 7 {
            0 => Value::Number(self.varint()?),
            1 => {
                let (bytes, rest) = self.0.split_first_chunk::<8>()?;
                self.0 = rest;
                Value::Fixed(u64::from_le_bytes(*bytes))
            }
            2 => {
                let length = usize::try_from(self.varint()?).ok()?;
                let (bytes, rest) = self.0.split_at_checked(length)?;
                self.0 = rest;
                Value::Bytes(bytes)
            }
            _ => return None,
        };
        Some((key >> 3, value))
    }
}

impl<'a> Iterator for Fields<'a> {
    type Item = (u64, Value<'a>);

    fn next(&mut self) -> Option<Self::Item> {
        if self.0.is_empty() { None } else { self.next_field() }
    }
}

/// The encoded events of an encoded batch.
pub(crate) fn events(batch: &[u8]) -> impl Iterator<Item = &[u8]> {
    Fields(batch).filter(|(field, _)| *field == 3).map(|(_, value)| value.bytes())
}

/// Number of the oneof field that says what an encoded event is; 0 when there is none.
pub(crate) fn kind_field(event: &[u8]) -> u64 {
    Fields(event).map(|(field, _)| field).find(|field| *field >= 10).unwrap_or(0)
}

/// Sequence number of an encoded event.
pub(crate) fn seq(event: &[u8]) -> u64 {
    Fields(event).find(|(field, _)| *field == 1).map_or(0, |(_, value)| value.number())
}

/// Decodes one event.
pub(crate) fn event(bytes: &[u8]) -> Option<(u64, Event)> {
    let mut seq = 0;
    let mut event = Event { t_ns: 0, micro: 0, dur_ns: 0, channel: 0, file: 0, line: 0, kind: Kind::Dwell };
    for (field, value) in Fields(bytes) {
        match field {
            1 => seq = value.number(),
            2 => event.t_ns = value.number() as i64,
            3 => event.micro = value.number() as u32,
            4 => event.dur_ns = value.number() as i64,
            5 => event.channel = value.number() as u16,
            6 => event.file = value.number() as u16,
            7 => event.line = value.number() as u32,
            _ => event.kind = kind(field, value.bytes())?,
        }
    }
    Some((seq, event))
}

/// The first fields of a small message, by number from 1; absent ones are zero.
struct Small<'a>([Value<'a>; 7]);

impl<'a> Small<'a> {
    fn read(bytes: &'a [u8]) -> Self {
        let mut values = [const { Value::Number(0) }; 7];
        for (field, value) in Fields(bytes) {
            if let Some(slot) = values.get_mut(field as usize) {
                *slot = value;
            }
        }
        Self(values)
    }

    fn get(&self, field: usize) -> &Value<'a> {
        self.0.get(field).unwrap_or(&Value::Number(0))
    }

    fn number(&self, field: usize) -> u64 {
        self.get(field).number()
    }
}

fn kind(field: u64, bytes: &[u8]) -> Option<Kind> {
    if field == 12 {
        return Some(Kind::Motion(motion(bytes)?));
    }
    let m = Small::read(bytes);
    Some(match field {
        10 => Kind::Lifecycle(numbers::phase_of(m.number(1))?),
        11 => Kind::Block { number: m.number(1) },
        13 => Kind::Dwell,
        14 => Kind::Tool {
            action: numbers::tool_action_of(m.number(1))?,
            tool: m.number(2) as u32,
            offset: m.number(3) as u32,
        },
        15 => Kind::Spindle(Spindle {
            spindle: m.number(1) as u16,
            direction: numbers::direction_of(m.number(2))?,
            css: m.number(3) != 0,
            speed: m.get(4).double(),
            limit: m.get(5).double(),
            angle: m.get(6).double(),
        }),
        16 => Kind::Coolant(Coolant {
            on: m.number(1) != 0,
            fluid: m.number(2) as u8,
            outlet: match (m.number(3), m.number(4)) {
                (0, 0) => Outlet::Main,
                (0, number) => Outlet::Device(number as u8),
                _ => Outlet::Side,
            },
        }),
        17 => Kind::Function { letter: m.get(1).text().chars().next()?, value: m.get(2).double() },
        18 => Kind::Mode { text: m.get(1).text() },
        19 => Kind::Frame { shift: Box::new(position(m.get(1).bytes())) },
        20 => Kind::Stop(numbers::stop_of(m.number(1))?),
        21 => Kind::Call { program: m.get(1).text(), level: m.number(2) as u16 },
        22 => Kind::Return { level: m.number(1) as u16 },
        23 => Kind::Message { text: m.get(1).text(), printed: m.number(2) != 0 },
        24 => Kind::Wait(Arc::new(Wait {
            key: m.get(1).text().into(),
            primitive: numbers::primitive_of(m.number(2))?,
            participants: channels(m.get(3).bytes()).into(),
        })),
        25 => Kind::Release(Release {
            key: m.get(1).text().into(),
            primitive: numbers::primitive_of(m.number(2))?,
            since_ns: m.number(3) as i64,
            meeting: m.number(4),
        }),
        26 => Kind::Diagnostic(Box::new(Diagnostic {
            number: m.number(1) as u32,
            severity: m.number(2) as u8,
            text: m.get(3).text(),
            operation: m.get(4).text(),
            kernel: m.get(5).text(),
            origin: match m.get(6) {
                Value::Bytes(bytes) => Some(Box::new(origin(bytes))),
                _ => None,
            },
        })),
        29 => Kind::ToolData(Box::new(ToolData {
            tool: m.number(1) as u32,
            name: m.get(2).text(),
            diameter: m.get(3).optional_double(),
            radius: m.get(4).optional_double(),
            length: m.get(5).optional_double(),
            place: m.number(6) as u16,
        })),
        28 => Kind::Trace { letter: m.get(1).text().chars().next()?, text: m.get(2).text() },
        27 => Kind::Verdict(Box::new(Verdict {
            kind: numbers::verdict_kind_of(m.number(1))?,
            at_ns: m.number(2) as i64,
            text: m.get(3).text(),
            members: Fields(bytes).filter(|(field, _)| *field == 4).map(|(_, v)| member(v.bytes())).collect(),
        })),
        _ => return None,
    })
}

fn origin(bytes: &[u8]) -> Origin {
    let m = Small::read(bytes);
    Origin { name: m.get(1).text(), file: m.get(2).text(), line: m.number(3) as u32, statement: m.get(4).text() }
}

fn member(bytes: &[u8]) -> Member {
    let m = Small::read(bytes);
    Member {
        channel: m.number(1) as u16,
        file: m.number(2) as u16,
        line: m.number(3) as u32,
        waiting_for: channels(m.get(4).bytes()),
    }
}

fn motion(bytes: &[u8]) -> Option<Motion> {
    let mut motion = Motion {
        kind: MotionKind::Rapid,
        moving: 0,
        from: [0.0; MAX_AXES],
        to: [0.0; MAX_AXES],
        center: [0.0; 2],
        plane_axes: [255; 2],
        turns: 0,
        feed: 0.0,
        feed_unit: FeedUnit::Rapid,
        length: 0.0,
    };
    for (field, value) in Fields(bytes) {
        match field {
            1 => motion.kind = numbers::motion_kind_of(value.number())?,
            2 => motion.moving = value.number() as u8,
            3 => motion.from = position(value.bytes()),
            4 => motion.to = position(value.bytes()),
            5 => doubles(value.bytes(), &mut motion.center),
            6 => {
                let mut axes = Fields(value.bytes());
                motion.plane_axes = [axes.varint()? as u8, axes.varint()? as u8];
            }
            7 => motion.turns = value.number() as u16,
            8 => motion.feed = value.double(),
            9 => motion.feed_unit = numbers::feed_unit_of(value.number())?,
            10 => motion.length = value.double(),
            _ => {}
        }
    }
    Some(motion)
}

fn doubles(bytes: &[u8], into: &mut [f64]) {
    for (slot, chunk) in into.iter_mut().zip(bytes.chunks_exact(8)) {
        *slot = chunk.try_into().map_or(0.0, f64::from_le_bytes);
    }
}

fn position(bytes: &[u8]) -> Position {
    let mut position = [0.0; MAX_AXES];
    doubles(bytes, &mut position);
    position
}

fn channels(bytes: &[u8]) -> Vec<u16> {
    let mut fields = Fields(bytes);
    std::iter::from_fn(|| fields.varint()).map(|channel| channel as u16).collect()
}

#[cfg(test)]
#[path = "codec_tests.rs"]
mod tests;
