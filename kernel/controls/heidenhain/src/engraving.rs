//! Cycle 225: engraving.
//!
//! Facts: programming manuals of the control (QS500 is the text, Q513 the height of its capitals, Q514 a factor of the
//! room between characters, 0 for the usual one; Q516 = 0: a straight text, turned by Q374; 1: on an arc of the radius
//! Q517, from left to right up to a Q374 of 180 and the other way beyond; 2: always around the circle; Q367 gives the
//! point of the text at which the tool stands; Q574 is its maximum length, Q202 the infeed, a character at a time; the
//! tool comes down at each stroke and rises to the clearance after it; %%, \\ and %at are characters, %time08 a date in
//! the form of that number). Decisions: docs of the family, "Choices of engraving". Refused: other places of texts on
//! arcs, line breaks, tabs, counters. *Invariant:* no letter is left out.

use counterpoint_control_api::host::InterpreterHost;
use counterpoint_motion::contour::closed::turned_by;
use counterpoint_motion::contour::element::{Spot, direction, plus};
use counterpoint_motion::lettering;

use super::Heidenhain;
use super::clearing::{CycleBlockWriter, levels, within_reason};
use super::moves::{Moves, RAPID};
use super::path_state::actual;
use super::q_parameter::{ParameterKind, ParameterValue, QParameter};

/// The text of the cycle.
const TEXT: QParameter = QParameter { kind: ParameterKind::Text, index: 500 };

/// The day on which every job begins, and the second of it: 8 in the morning.
const DAY: (u64, u64, u64) = (2026, 1, 1);
const BEGINS: u64 = 8 * 3600;

/// Forms of a date; letters stand for its parts, D, M and h without the zero before it.
const DATES: [&str; 17] = [
    "dd.mm.YYYY HH:MM:SS",
    "D.mm.YYYY h:MM:SS",
    "D.mm.YYYY h:MM",
    "D.mm.YY h:MM",
    "YYYY-mm-dd HH:MM:SS",
    "YYYY-mm-dd HH:MM",
    "YYYY-mm-dd h:MM",
    "YY-mm-dd h:MM",
    "dd.mm.YYYY",
    "D.mm.YYYY",
    "D.mm.YY",
    "YYYY-mm-dd",
    "YY-mm-dd",
    "HH:MM:SS",
    "h:MM:SS",
    "h:MM",
    "dd.mm.YYYY HH:MM",
];

/// A date in a form, some seconds into the job.
fn date(form: &str, seconds: u64) -> String {
    let (year, month, first) = DAY;
    let whole = BEGINS + seconds;
    // Jobs end within a month.
    let (day, second) = (first + (whole / 86_400).min(30), whole % 86_400);
    let (hour, minute) = (second / 3600, second / 60 % 60);
    let two = |value: u64| format!("{value:02}");
    form.replace("YYYY", &year.to_string())
        .replace("YY", &two(year % 100))
        .replace("MM", &two(minute))
        .replace("SS", &two(second % 60))
        .replace("HH", &two(hour))
        .replace("dd", &two(day))
        .replace("mm", &two(month))
        .replace('D', &day.to_string())
        .replace('h', &hour.to_string())
}

/// The replacements of special signs, and whether one of them is a date.
fn plain(text: &str, seconds: u64) -> Result<(String, bool), String> {
    let (mut out, mut dated) = (String::new(), false);
    let mut rest = text;
    while let Some(character) = rest.chars().next() {
        let behind = rest.get(character.len_utf8()..).unwrap_or_default();
        let skipped = match (character, behind.chars().next()) {
            ('%', Some('%')) | ('\\', Some('\\')) => {
                out.push(character);
                1
            }
            ('\\', _) => return Err("line breaks and tabs in the text of cycle 225 are not emulated".to_owned()),
            ('%', _) if behind.starts_with("at") => {
                out.push('@');
                2
            }
            ('%', _) if behind.starts_with("time") => {
                let form = behind.get(4..6).and_then(|digits| digits.parse::<usize>().ok());
                let form = form
                    .and_then(|form| DATES.get(form))
                    .ok_or_else(|| "a date in the text of cycle 225 is %time with a number from 00 to 16".to_owned())?;
                out.push_str(&date(form, seconds));
                dated = true;
                6
            }
            ('%', _) => {
                return Err(
                    "of the signs behind % the text of cycle 225 may have time, at and %; counters, names and letters of other alphabets are not emulated"
                        .to_owned(),
                );
            }
            _ => {
                out.push(character);
                0
            }
        };
        rest = behind.get(skipped..).unwrap_or_default();
    }
    match lettering::unknown(&out) {
        Some(character) => Err(format!("cycle 225 has no character '{character}'")),
        None => Ok((out, dated)),
    }
}

/// Where the text lies.
#[derive(Debug, Clone, Copy)]
enum TextLayout {
    /// Turned about the point of the text that lies where the tool is.
    Straight { turn: f64, at: Spot },
    /// The middle of the text in a direction from the centre; clockwise with the tops outwards.
    Round { middle: f64, radius: f64, clockwise: bool },
}

impl TextLayout {
    /// A spot of a character whose middle is at a place of the text, in heights; the text has a length.
    fn place(self, [along, up]: Spot, middle: f64, length: f64, height: f64) -> Spot {
        match self {
            Self::Straight { turn, at } => {
                plus([0.0; 2], turned_by(plus([middle + along, up], at, -1.0), turn), height)
            }
            Self::Round { middle: center, radius, clockwise } => {
                let sense = if clockwise { -1.0 } else { 1.0 };
                let way = ((middle - length / 2.0) * height / radius).to_degrees();
                let [x, y] = direction(center + sense * way);
                // Outwards with the clock, inwards against it.
                let (top, right) = ([-sense * x, -sense * y], [-sense * y, sense * x]);
                plus(plus([x * radius, y * radius], right, along * height), top, up * height)
            }
        }
    }
}

impl Heidenhain {
    /// How the text lies; its length in heights.
    fn layout(&self, length: f64) -> Result<TextLayout, String> {
        let position = self.sl(367);
        let turn = self.sl(374);
        if self.sl(516) == 0.0 {
            let ends = [0.0, 0.0, 0.5, 1.0, 1.0, 0.5, 0.0, 0.0, 0.5, 1.0];
            let heights = [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.5, 0.5, 0.5];
            let place = position as usize;
            let (Some(end), Some(up)) = (ends.get(place), heights.get(place)) else {
                return Err("Q367 of cycle 225 is 0 to 9".to_owned());
            };
            return Ok(TextLayout::Straight { turn, at: [end * length, *up] });
        }
        if position != 0.0 {
            return Err("texts on arcs at other places (Q367) are not emulated in cycle 225: program Q367=0".to_owned());
        }
        let radius = self.sl(517);
        if radius <= 0.0 {
            return Err("the radius Q517 of cycle 225 is not above 0".to_owned());
        }
        let around = self.sl(516) == 2.0;
        Ok(TextLayout::Round { middle: turn, radius, clockwise: around || (0.0..=180.0).contains(&turn) })
    }

    /// The blocks of cycle 225.
    pub(super) fn engrave(&self, host: &mut dyn InterpreterHost) -> Result<Moves, String> {
        let Some(ParameterValue::Text(text)) = self.variables.get(TEXT) else {
            return Err("cycle 225 has no text QS500".to_owned());
        };
        if self.sl(515) != 0.0 {
            return Err("texts in other fonts are not emulated in cycle 225: program Q515=0".to_owned());
        }
        let (text, dated) = plain(&text, u64::try_from(host.clock() / 1_000_000_000).unwrap_or(0))?;
        if dated {
            let text = format!("the date of the text is that of an imagined day, in '{}'", host.block_text());
            host.report(&counterpoint_fault::PATH_NOT_MADE, 4, text);
        }
        let gap = lettering::GAP * if self.sl(514) == 0.0 { 1.0 } else { self.sl(514) };
        let length = lettering::width(text.len(), gap);
        let mut height = self.sl(513);
        let most = self.sl(574);
        if most > 0.0 && length * height > most {
            height = most / length;
        }
        let layout = self.layout(length)?;
        let stands = actual(host);
        let begin = self.path.plane.map(|axis| stands.get(axis).copied().unwrap_or(0.0));
        let unit = host.length_factor();
        let clear = self.sl(203) + self.sl(200);
        let grounds = levels(self.sl(203), self.sl(203) + self.sl(201), self.sl(202));
        // A character has at most 20 moves.
        within_reason(text.len() * 20, grounds.len())?;
        let mut blocks = CycleBlockWriter::of(self, host);
        blocks.rise_to(clear, RAPID);
        for (place, character) in text.chars().enumerate() {
            let middle = place as f64 * (lettering::WIDTH + gap) + lettering::WIDTH / 2.0;
            // Blocks take places in units of the machine.
            let at = |[x, y]: Spot| {
                let spot = layout.place([x - lettering::WIDTH / 2.0, y], middle, length, height);
                plus([0.0; 2], plus(begin, spot, 1.0), unit)
            };
            for ground in &grounds {
                for stroke in lettering::strokes(&character.to_string(), gap) {
                    let mut spots = stroke.into_iter().map(at);
                    let Some(first) = spots.next() else { continue };
                    blocks.over(first);
                    blocks.rise_to(*ground, self.sl(206));
                    for spot in spots {
                        blocks.line(spot, self.sl(207));
                    }
                    blocks.rise_to(clear, RAPID);
                }
            }
        }
        if self.sl(204) > self.sl(200) {
            blocks.rise_to(self.sl(203) + self.sl(204), RAPID);
        }
        Ok(blocks.moves)
    }
}
