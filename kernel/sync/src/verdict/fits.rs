//! The nearest code that would end a wait: the place where a partner has the same mark, or waits at a similar one.
//!
//! Facts: reference channel-synchronisation.md 2.3. Decision: only the text of the partner's own program is looked at,
//! at most [`MOST`] lines after and before the block where it is; a mark in a comment is none. *Invariant:* a hint
//! changes nothing.

use counterpoint_event::event::{FileId, Primitive};
use counterpoint_event::info::Info;

use crate::wait::{ChannelSet, Wait, WaitNotation, WaitRule, WaitingChannel};
use crate::waits::JobWaits;

/// Lines of a program that are looked at in each direction.
const MOST: u32 = 50_000;

/// One hint for each pair of a waiting channel and one that is missing; of two that wait for each other, one.
pub(super) fn hints(dead: ChannelSet, waits: &JobWaits, info: &Info) -> Vec<String> {
    let mut out = Vec::new();
    let mut said = ChannelSet::default();
    for channel in dead.iter() {
        let Some(own) = waits.places.at(channel).filter(|own| is_mark(own.wait.primitive)) else { continue };
        // Another code ends this wait: the code of the partner is not a typing error.
        let sent = waits.rules.of(&own.wait).is_some_and(|rule| rule.signals.sent_by.is_some());
        for partner in waits.missing(channel).channels.iter() {
            let mutual = said.has(partner) && waits.missing(partner).channels.has(channel);
            if sent {
                out.extend(written(own, partner, waits, info));
            } else if mutual || waits.missing(partner).channels.has(channel) && standing(own, partner, waits).is_some()
            {
                out.extend(standing(own, partner, waits).filter(|_| !mutual));
            } else {
                out.extend(written(own, partner, waits, info));
            }
        }
        said = said.with(channel);
    }
    out.dedup();
    out
}

/// The partner waits at the same number with other channels, or at another number with the same ones.
fn standing(own: &WaitingChannel, partner: u16, waits: &JobWaits) -> Option<String> {
    let other = waits.places.at(partner).filter(|other| is_mark(other.wait.primitive))?;
    let couples = |wait: &Wait| waits.rules.of(wait).is_some_and(|rule| rule.style == WaitNotation::Axes);
    if couples(&own.wait) != couples(&other.wait) {
        return None;
    }
    let near = other.wait.key.number == own.wait.key.number || other.wait.named == own.wait.named;
    let (one, two) = (waits.rules.text(&own.wait), waits.rules.text(&other.wait));
    near.then(|| {
        format!("did you mean the same code? channel {} waits at {one}, channel {partner} at {two}", own.tag.channel)
    })
}

/// The places where each of two channels with mismatched waits has the code at which the other channel waits.
pub(super) fn of_pair(one: &WaitingChannel, other: &WaitingChannel, waits: &JobWaits, info: &Info) -> Vec<String> {
    if one.wait.key == other.wait.key {
        return Vec::new();
    }
    let hint = |own: &WaitingChannel, partner: &WaitingChannel| {
        written_from(own, partner.tag.channel, (partner.file, partner.line, true), (waits, info))
    };
    hint(one, other).into_iter().chain(hint(other, one)).collect()
}

/// The program of the partner has the mark somewhere else.
fn written(own: &WaitingChannel, partner: u16, waits: &JobWaits, info: &Info) -> Option<String> {
    let stands = waits.places.at(partner).map(|at| (at.file, at.line));
    let waiting = stands.is_some();
    let (file, line) = stands.or_else(|| waits.places.end(partner).map(|end| (end.file, end.line)))?;
    written_from(own, partner, (file, line, waiting), (waits, info))
}

/// The same, seen from a line of the partner, where it waits or has ended.
fn written_from(
    own: &WaitingChannel,
    partner: u16,
    (file, line, is_waiting): (FileId, u32, bool),
    (waits, info): (&JobWaits, &Info),
) -> Option<String> {
    let rule = waits.rules.of(&own.wait)?;
    let channel = info.channel(partner).filter(|channel| !channel.program.is_empty())?;
    let (first, last) = channel.lines;
    // In a subprogram nothing shows on which side of the call a line of the main program is.
    let is_main = file == channel.file && (first..=last).contains(&line);
    let here = if is_main { line } else { first.saturating_sub(1) };
    let sections = info.files.get(usize::from(channel.file)).map_or(&[][..], |file| &file.sections);
    let has = |line: &u32| {
        let section = sections.iter().find(|section| (section.lines.0..=section.lines.1).contains(line));
        let is_own = section.is_none_or(|section| section.channel == 0 || section.channel == partner);
        is_own && mentions(&info.line_text(channel.file, *line), rule, &own.wait)
    };
    let ahead = (here.saturating_add(1)..=last.min(here.saturating_add(MOST))).find(has);
    // The partner has not passed the block that it waits in.
    let waits_here = is_waiting && is_main && has(&here);
    if waits_here && ahead.is_none() {
        let text = info.block_text(channel.file, here, 60);
        return Some(format!("channel {partner} waits at '{text}' itself, in line {here}"));
    }
    let passed = here.saturating_add(u32::from(!is_waiting));
    let behind = || (first.max(here.saturating_sub(MOST))..passed).rev().find(has);
    let found = ahead.map(|line| (line, "later")).or_else(|| behind().map(|line| (line, "earlier")));
    let Some((line, side)) = found else {
        let code = if let Some(word) = &rule.signals.sent_by {
            format!("{word} [ID{}]", own.wait.key.number)
        } else if rule.style == WaitNotation::Statement && rule.numbered {
            format!("{}({},...)", rule.word, rule.marked(own.wait.key.number))
        } else if rule.style == WaitNotation::Axes && !mentions(&info.line_text(own.file, own.line), rule, &own.wait) {
            // The code comes from a word of the builder.
            info.block_text(own.file, own.line, 60).to_string()
        } else if matches!(rule.style, WaitNotation::LineUp | WaitNotation::Axes) || !rule.numbered {
            waits.rules.text(&own.wait)
        } else {
            format!("{}{}", rule.word, own.wait.key.number)
        };
        return Some(format!("the program of channel {partner} has no {code}"));
    };
    let text = info.block_text(channel.file, line, 60);
    let side = if is_main { format!(" {side},") } else { String::new() };
    Some(format!("channel {partner} has '{text}'{side} in line {line}"))
}

/// Whether a line has the mark of a wait, with any list of channels.
fn mentions(line: &str, rule: &WaitRule, wait: &Wait) -> bool {
    let text = plain(line, rule.style);
    let word = rule.signals.sent_by.as_ref().unwrap_or(&rule.word).to_ascii_uppercase();
    if word.is_empty() {
        return false;
    }
    text.match_indices(&word).any(|(at, _)| {
        let (before, after) = (text.get(..at).unwrap_or_default(), text.get(at + word.len()..).unwrap_or_default());
        let alone =
            !before.ends_with(|c: char| c.is_ascii_alphabetic() || c == '_') || !word.starts_with(char::is_alphabetic);
        let number = |text: &str| {
            let digits = text.bytes().take_while(u8::is_ascii_digit).count();
            text.get(..digits).and_then(|digits| digits.parse::<u32>().ok())
        };
        let label =
            || after.split_once('L').filter(|(systems, _)| systems.bytes().all(|b| b.is_ascii_digit() || b == b'!'));
        alone
            && match rule.style {
                WaitNotation::Word if rule.numbered => number(after) == Some(wait.key.number),
                WaitNotation::Word => true,
                WaitNotation::Statement => {
                    after.strip_prefix('(').is_some_and(|rest| !rule.numbered || number(rest) == Some(wait.key.number))
                }
                WaitNotation::LineUp => label().is_some_and(|(_, rest)| number(rest) == Some(wait.key.number)),
                WaitNotation::Axes => {
                    let value = |letter| after.split_once(letter).and_then(|(_, rest)| number(rest));
                    let (first, second) = (wait.key.number >> 15, wait.key.number & 0x7fff);
                    value('Q') == Some(second) && (first == 0 || value('P') == Some(first))
                }
                WaitNotation::Keys => {
                    let keys = after.strip_prefix("SYN").unwrap_or(after).strip_prefix('[');
                    let id = keys.and_then(|keys| keys.split_once("ID")).map(|(_, rest)| rest);
                    id.is_some_and(|id| number(id.strip_prefix('=').unwrap_or(id)) == Some(wait.key.number))
                }
            }
    })
}

/// A line in capitals, without blanks and comments.
fn plain(line: &str, style: WaitNotation) -> String {
    let ends_at_semicolon = matches!(style, WaitNotation::Statement | WaitNotation::Keys);
    let line = if ends_at_semicolon { line.split(';').next().unwrap_or_default() } else { line };
    let mut depth = 0_u32;
    let mut out = String::with_capacity(line.len());
    for c in line.chars().filter(|c| !c.is_whitespace()) {
        match c {
            '(' if style != WaitNotation::Statement => depth += 1,
            ')' if style != WaitNotation::Statement => depth = depth.saturating_sub(1),
            _ if depth == 0 => out.push(c.to_ascii_uppercase()),
            _ => {}
        }
    }
    out
}

/// Whether channels wait at it for each other, so that two numbers may be one by mistake.
fn is_mark(primitive: Primitive) -> bool {
    match primitive {
        Primitive::Barrier | Primitive::Flag | Primitive::Count | Primitive::Signal => true,
        Primitive::Order | Primitive::Join | Primitive::Lease => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wait::{MarkSpace, RuleId};
    use crate::wait::{SignalRules, WaitMark};

    #[test]
    fn marks_in_lines() {
        let wait = |number| Wait {
            primitive: Primitive::Barrier,
            key: WaitMark { space: MarkSpace::Statements, number },
            named: None,
            parts: ChannelSet::up_to(2),
            need: 0,
            rule: RuleId::Start,
        };
        let word = WaitRule::plain("M");
        let statement = WaitRule { style: WaitNotation::Statement, ..WaitRule::plain("WAITM") };
        let line_up = WaitRule { style: WaitNotation::LineUp, ..WaitRule::plain("!") };
        let text = WaitRule { numbered: false, ..WaitRule::plain("SYNC") };
        let signals = SignalRules { sent_by: Some("#SIGNAL".into()), ..SignalRules::default() };
        let keys = WaitRule { style: WaitNotation::Keys, signals, ..WaitRule::plain("#WAIT") };
        for (line, rule, number, has) in [
            ("N5 #SIGNAL [ID7 CH1 CH2]", &keys, 7, true),
            ("#signal syn [ CH=2 ID=7 ]", &keys, 7, true),
            ("#SIGNAL [ID70 CH1]", &keys, 7, false),
            ("#WAIT [ID7 CH1]", &keys, 7, false),
            ("G4 X1 ; #SIGNAL [ID7]", &keys, 7, false),
            ("N10 M101 P12", &word, 101, true),
            ("m0101", &word, 101, true),
            ("M1011", &word, 101, false),
            ("(M101)", &word, 101, false),
            ("G4 P1 (A) M101", &word, 101, true),
            ("N5 WAITM(40, 1,2)", &statement, 40, true),
            ("WAITM(4,1,2)", &statement, 40, false),
            ("; WAITM(40,1)", &statement, 40, false),
            ("SWAITM(40)", &statement, 40, false),
            ("!2L1", &line_up, 1, true),
            ("!1!2L1", &line_up, 1, true),
            ("!2L12", &line_up, 1, false),
            ("G0 X1 SYNC", &text, 0, true),
            ("", &word, 101, false),
        ] {
            assert_eq!(mentions(line, rule, &wait(number)), has, "{line}");
        }
    }
}
