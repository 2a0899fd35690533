//! The verdict on channels that can never continue, in words that name every line.

mod fits;

use crate::wait::{ChannelSet, Terminal, WaitingChannel, words};
use crate::waits::{JobWaits, RefusedPairs};
use counterpoint_event::event::{Primitive, Verdict, VerdictKind, VerdictMember};
use counterpoint_event::info::Info;

/// `file line n 'text'`.
pub fn place(info: &Info, file: u16, line: u32) -> String {
    format!("{} line {line} '{}'", info.place_name(file, line), info.block_text(file, line, 60))
}

/// Classifies a set of channels that can never continue, at a time. Others that have been judged before come last.
pub fn of(dead: ChannelSet, at_ns: i64, waits: &JobWaits, info: &Info) -> Verdict {
    let hopeless = ChannelSet(waits.dead().0 & !dead.0);
    let ended = |channel: &u16| waits.places.end(*channel).is_some();
    let partners =
        missing(dead, waits).iter().filter(|channel| hopeless.has(*channel) || ended(channel)).collect::<ChannelSet>();
    let members = ChannelSet(dead.0 | partners.0);
    let sentences = Sentences { waits, info };
    let mut text: Vec<String> = dead.iter().filter_map(|channel| sentences.waiting(channel)).collect();
    text.extend(partners.iter().filter_map(|channel| sentences.waiting(channel)));
    text.extend(partners.iter().filter_map(|channel| sentences.end(channel)));
    let awaited = missing(dead, waits).and(members);
    text.extend(awaited.iter().filter_map(|channel| sentences.passed(channel)));
    text.extend(fits::hints(dead, waits, info));
    Verdict {
        kind: kind(dead, waits),
        at_ns,
        text: text.join("; ").into(),
        members: (members.iter().filter(|c| !hopeless.has(*c)))
            .chain(partners.and(hopeless).iter())
            .map(|channel| member(channel, waits))
            .collect(),
    }
}

/// Waits that the control does not accept at the same time, with the places of the codes that would match.
pub(crate) fn of_refused(refused: &RefusedPairs, waits: &JobWaits, info: &Info) -> String {
    let own = &refused.arriving;
    let at = |waiting: &WaitingChannel| {
        format!("channel {} waits at {}", waiting.tag.channel, place(info, waiting.file, waiting.line))
    };
    let cases = refused.standing.iter().map(|(other, case)| format!("{}, {}: {case}", at(own), at(other)));
    let hints = refused.standing.iter().flat_map(|(other, _)| fits::of_pair(own, other, waits, info));
    format!("{}: {}", refused.title, cases.chain(hints).collect::<Vec<_>>().join("; "))
}

/// Whether these channels, or those that they wait for, have come here by an order that only a run can tell.
pub(crate) fn depends_on_order(dead: ChannelSet, waits: &JobWaits) -> bool {
    (ChannelSet(dead.0 | missing(dead, waits).0).0 & waits.order_matters.0) != 0
}

/// Whom these channels wait for.
fn missing(channels: ChannelSet, waits: &JobWaits) -> ChannelSet {
    channels.iter().fold(ChannelSet::default(), |all, channel| ChannelSet(all.0 | waits.missing(channel).channels.0))
}

/// Why these channels cannot continue: from the partners that they wait for, and the waits of those partners.
fn kind(dead: ChannelSet, waits: &JobWaits) -> VerdictKind {
    let mut reached = dead;
    loop {
        let further = ChannelSet(reached.0 | missing(reached, waits).0);
        if further == reached {
            break;
        }
        reached = further;
    }
    let ends: Vec<Terminal> = reached.iter().filter_map(|c| waits.places.end(c)).map(|finish| finish.how).collect();
    let leases = |channel| waits.places.at(channel).is_some_and(|own| own.wait.primitive == Primitive::Lease);
    if ends.contains(&Terminal::Alarmed) {
        VerdictKind::PartnerAlarmed
    } else if ends.contains(&Terminal::NeverStarted) {
        VerdictKind::PartnerNeverStarted
    } else if !ends.is_empty() {
        VerdictKind::PartnerEnded
    } else if reached.iter().any(leases) {
        VerdictKind::LeaseCycle
    } else if reached.iter().any(|channel| is_mismatch(channel, reached, waits)) {
        VerdictKind::Mismatch
    } else {
        VerdictKind::Cycle
    }
}

/// Whether a channel is at the mark of one that it waits for, but they wait there for different channels.
fn is_mismatch(channel: u16, among: ChannelSet, waits: &JobWaits) -> bool {
    let Some(own) = waits.places.at(channel).filter(|own| own.wait.primitive == Primitive::Barrier) else {
        return false;
    };
    waits.missing(channel).channels.and(among).iter().filter_map(|partner| waits.places.at(partner)).any(|other| {
        other.wait.primitive == Primitive::Barrier
            && other.wait.key == own.wait.key
            && other.wait.parts != own.wait.parts
    })
}

/// A channel as a member, with its wait.
pub fn member(channel: u16, waits: &JobWaits) -> VerdictMember {
    match (waits.places.at(channel), waits.places.end(channel)) {
        (Some(w), _) => VerdictMember {
            channel,
            file: w.file,
            line: w.line,
            waiting_for: waits.missing(channel).channels.iter().collect(),
        },
        (None, Some(f)) => VerdictMember { channel, file: f.file, line: f.line, waiting_for: Vec::new() },
        (None, None) => VerdictMember { channel, file: 0, line: 0, waiting_for: Vec::new() },
    }
}

/// `channel 1 waits from 1.000 s on at x.nc line 3 'M101' for channel 2`.
pub fn waiting_sentence(channel: u16, waits: &JobWaits, info: &Info) -> Option<String> {
    Sentences { waits, info }.waiting(channel)
}

/// Statements about channels.
#[derive(Clone, Copy)]
struct Sentences<'a> {
    waits: &'a JobWaits,
    info: &'a Info,
}

impl Sentences<'_> {
    fn waiting(self, channel: u16) -> Option<String> {
        let waiting = self.waits.places.at(channel)?;
        let missing = self.waits.missing(channel);
        let channels: Vec<u16> = missing.channels.iter().collect();
        let plural = if channels.len() == 1 { "" } else { "s" };
        let some = match usize::from(missing.need) {
            need if need == channels.len() => String::new(),
            need => format!("{need} of "),
        };
        let since = match self.waits.timeless {
            true => String::new(),
            false => format!(" from {:.3} s on", waiting.tag.t as f64 / 1e9),
        };
        Some(format!(
            "channel {channel} waits{since} at {} for {some}channel{plural} {}",
            place(self.info, waiting.file, waiting.line),
            words(&channels)
        ))
    }

    fn end(self, channel: u16) -> Option<String> {
        let finish = self.waits.places.end(channel)?;
        let place = || place(self.info, finish.file, finish.line);
        Some(match finish.how {
            Terminal::Ended => format!("channel {channel} has ended at {}", place()),
            Terminal::Alarmed => format!("channel {channel} is stopped by an alarm at {}", place()),
            Terminal::Stopped => format!("channel {channel} was stopped at {}", place()),
            Terminal::NeverStarted => format!("channel {channel} has no program"),
        })
    }

    /// The last wait of a channel that has got past one.
    fn passed(self, channel: u16) -> Option<String> {
        let (passed, t) = self.waits.places.passed(channel)?;
        let wait = self.waits.rules.text(&passed.wait);
        let at = match self.waits.timeless {
            true => String::new(),
            false => format!(", at {:.3} s", *t as f64 / 1e9),
        };
        Some(format!("channel {channel} passed {wait} in line {} last{at}", passed.line))
    }
}
