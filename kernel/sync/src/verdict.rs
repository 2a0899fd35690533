//! The verdict on channels that can never go on, in words that name every line.

use crate::wait::{Set, Terminal, words};
use crate::waits::Waits;
use counterpoint_event::event::{Member, Primitive, Verdict, VerdictKind};
use counterpoint_event::info::Info;

/// `file line n 'text'`.
pub fn place(info: &Info, file: u16, line: u32) -> String {
    format!("{} line {line} '{}'", info.place_name(file, line), info.block_text(file, line, 60))
}

/// Classifies a set of dead channels at a time.
pub fn of(dead: Set, at_ns: i64, waits: &Waits, info: &Info) -> Verdict {
    let mut partners = Set::default();
    for channel in dead.iter() {
        for missing in waits.missing(channel).channels.iter() {
            if waits.places.end(missing).is_some() {
                partners = partners.with(missing);
            }
        }
    }
    let ends: Vec<Terminal> = partners.iter().filter_map(|c| waits.places.end(c)).map(|f| f.how).collect();
    let kind = if ends.contains(&Terminal::Alarmed) {
        VerdictKind::PartnerAlarmed
    } else if ends.contains(&Terminal::NeverStarted) {
        VerdictKind::PartnerNeverStarted
    } else if !ends.is_empty() {
        VerdictKind::PartnerEnded
    } else if dead.iter().filter_map(|c| waits.places.at(c)).any(|w| w.wait.primitive == Primitive::Lease) {
        VerdictKind::LeaseCycle
    } else {
        VerdictKind::Cycle
    };
    let mut sentences: Vec<String> = dead.iter().filter_map(|c| waiting_sentence(c, waits, info)).collect();
    sentences.extend(partners.iter().filter_map(|c| end_sentence(c, waits, info)));
    sentences.extend(hint(dead, waits));
    let members = Set(dead.0 | partners.0).iter().map(|c| member(c, waits)).collect();
    Verdict { kind, at_ns, text: sentences.join("; ").into(), members }
}

/// A channel as a member, with what it waits for.
pub fn member(channel: u16, waits: &Waits) -> Member {
    match (waits.places.at(channel), waits.places.end(channel)) {
        (Some(w), _) => Member {
            channel,
            file: w.file,
            line: w.line,
            waiting_for: waits.missing(channel).channels.iter().collect(),
        },
        (None, Some(f)) => Member { channel, file: f.file, line: f.line, waiting_for: Vec::new() },
        (None, None) => Member { channel, file: 0, line: 0, waiting_for: Vec::new() },
    }
}

/// `channel 1 waits since 1.000 s at x.nc line 3 'M101' for channel 2`.
pub fn waiting_sentence(channel: u16, waits: &Waits, info: &Info) -> Option<String> {
    let waiting = waits.places.at(channel)?;
    let missing = waits.missing(channel);
    let channels: Vec<u16> = missing.channels.iter().collect();
    let plural = if channels.len() == 1 { "" } else { "s" };
    let some = match usize::from(missing.need) {
        need if need == channels.len() => String::new(),
        need => format!("{need} of "),
    };
    Some(format!(
        "channel {channel} waits since {:.3} s at {} for {some}channel{plural} {}",
        waiting.tag.t as f64 / 1e9,
        place(info, waiting.file, waiting.line),
        words(&channels)
    ))
}

fn end_sentence(channel: u16, waits: &Waits, info: &Info) -> Option<String> {
    let finish = waits.places.end(channel)?;
    Some(match finish.how {
        Terminal::Ended => format!("channel {channel} has ended at {}", place(info, finish.file, finish.line)),
        Terminal::Alarmed => {
            format!("channel {channel} is stopped by an alarm at {}", place(info, finish.file, finish.line))
        }
        Terminal::Stopped => format!("channel {channel} was stopped at {}", place(info, finish.file, finish.line)),
        Terminal::NeverStarted => format!("channel {channel} has no program"),
    })
}

/// Names the nearest code of a partner that would fit.
fn hint(dead: Set, waits: &Waits) -> Option<String> {
    for channel in dead.iter() {
        let own = waits.places.at(channel)?;
        for partner in waits.missing(channel).channels.iter() {
            if let Some(other) = waits.places.at(partner)
                && (other.wait.key.number == own.wait.key.number || other.wait.named == own.wait.named)
                && [own, other].iter().all(|waiting| is_mark(waiting.wait.primitive))
            {
                return Some(format!(
                    "did you mean the same code? channel {channel} waits at {}, channel {partner} at {}",
                    waits.rules.text(&own.wait),
                    waits.rules.text(&other.wait)
                ));
            }
        }
    }
    None
}

/// Channels wait at it for each other, so that two numbers may be one by mistake.
fn is_mark(primitive: Primitive) -> bool {
    match primitive {
        Primitive::Barrier | Primitive::Flag | Primitive::Count | Primitive::Signal => true,
        Primitive::Order | Primitive::Join | Primitive::Lease => false,
    }
}
