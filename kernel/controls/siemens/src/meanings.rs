//! Words whose meaning depends on the state of the channel: the machine's tables get other words for them.
//!
//! TRANS replaces the whole translation. G58 and G59 replace the absolute and the additive part of the translation of
//! the axes that they name; ATRANS adds to the additive part. G74 goes to the reference point and G75 to a fixed point
//! with the axes that the block names. The values of these axes have no meaning, as in MIRROR and AMIRROR. Facts:
//! programming manual, fundamentals, chapters "programmable zero offset", "reference point approach", "fixed point
//! approach". Decisions: TRANS, ROT, SCALE and MIRROR remove the additive part, as they remove the whole frame; G58 and
//! G59 in a frame that is turned, scaled or mirrored are refused. *Invariant:* no value of a G74 or G75 is a position.

use super::left::SiemensRemainder;
use super::value::Data;
use super::{Outcome, Siemens, SiemensBlockError, syntax};
use counterpoint_control_api::host::{AxisPlace, InterpreterHost};
use counterpoint_fault as diag;

/// Words for the machine's tables: reference point, fixed point and its number.
const HOME: &str = "SC_HOME";
const FIXED: &str = "SC_FIXED";
const POINT: &str = "SC_POINT";
/// Fixed points of an axis.
const POINTS: std::ops::RangeInclusive<i64> = 1..=3;
/// Words that replace the whole programmable frame.
const WHOLE: [&str; 4] = ["TRANS", "ROT", "SCALE", "MIRROR"];

/// G functions that are rewritten here.
fn code(word: &str) -> Option<u32> {
    let digits = word.strip_prefix(['G', 'g'])?.trim_start_matches('0');
    digits.parse().ok().filter(|code| matches!(code, 58 | 59 | 74 | 75))
}

/// Behind a G: one of these functions.
pub(super) fn is_rewritten(text: &[u8]) -> bool {
    let digits = text.iter().take_while(|byte| byte.is_ascii_digit()).count();
    let digits = std::str::from_utf8(text.get(..digits).unwrap_or_default()).unwrap_or_default();
    matches!(digits.trim_start_matches('0'), "58" | "59" | "74" | "75")
}

/// Whether some word may be one of those above. Most blocks take this test, so only the first two characters of each
/// word count.
fn may_be_rewritten(words: &str) -> bool {
    let mut begins = true;
    words.as_bytes().windows(2).any(|pair| {
        let first = std::mem::replace(&mut begins, pair.first() == Some(&b' '));
        first && matches!(pair, b"TR" | b"RO" | b"SC" | b"MI" | b"AT" | b"AM" | [b'G' | b'g', b'0' | b'5' | b'7'])
    })
}

/// The axis of a word by its letter, and the value.
fn axis_word<'w>(axes: &[AxisPlace], word: &'w str) -> Option<(usize, &'w str)> {
    let (letter, value) = word.split_at_checked(1)?;
    let value = value.strip_prefix('=').unwrap_or(value);
    value.parse::<f64>().ok()?;
    axes.iter().position(|axis| axis.letter.eq_ignore_ascii_case(letter)).map(|at| (at, value))
}

impl Siemens {
    /// Rewrites the words of a block.
    pub(super) fn rewrite(&mut self, host: &mut dyn InterpreterHost, left: &mut SiemensRemainder) -> Outcome<()> {
        if !may_be_rewritten(&left.words) {
            return Ok(());
        }
        match left.words.split(' ').find_map(code) {
            Some(74) => return to_points(host, left, false),
            Some(75) => return to_points(host, left, true),
            Some(part) => return self.part_of_translation(host, left, part == 59),
            None => {}
        }
        let frame = left.words.split(' ').find(|word| WHOLE.contains(word) || matches!(*word, "ATRANS" | "AMIRROR"));
        let Some(frame) = frame.map(str::to_owned).filter(|frame| host.is_code_text(frame)) else { return Ok(()) };
        if frame == "ATRANS" {
            let axes = host.axes();
            for (at, value) in left.words.split(' ').filter_map(|word| axis_word(&axes, word)) {
                let value = value.parse::<f64>().unwrap_or(0.0);
                if let Some(slot) = axes.get(at).and_then(slot).and_then(|at| self.held.additive.get_mut(at)) {
                    *slot += value;
                }
            }
            return Ok(());
        }
        if frame.ends_with("MIRROR") {
            at_zero(host, left);
        }
        if frame == "AMIRROR" {
            return Ok(());
        }
        self.held.additive = [0.0; 3];
        if frame == "TRANS" {
            whole_translation(host, left);
        }
        Ok(())
    }

    /// G58 and G59: the frame with another part of its translation.
    fn part_of_translation(
        &mut self,
        host: &mut dyn InterpreterHost,
        left: &mut SiemensRemainder,
        additive: bool,
    ) -> Outcome<()> {
        if !host.is_code_text("TRANS") {
            return Ok(());
        }
        let frame = host.local_frame();
        let turned = (0..3).any(|row| {
            (0..3).any(|column| {
                let same = if row == column { 1.0 } else { 0.0 };
                frame.get(row * 4 + column).is_some_and(|cell| (cell - same).abs() > 1e-9)
            })
        });
        let name = if additive { "G59" } else { "G58" };
        let axes = host.axes();
        if turned || axes.iter().any(|axis| axis.line[0] != 1.0) {
            return Err(SiemensBlockError::Alarm(
                &diag::SIEMENS_STATE,
                format!(
                    "{name} in a frame that is turned, scaled or mirrored is not emulated; program TRANS before it"
                ),
            ));
        }
        let mut shift = [3, 7, 11].map(|at| frame.get(at).copied().unwrap_or(0.0));
        for word in left.words.split(' ').filter(|word| code(word).is_none()) {
            let found = axis_word(&axes, word).and_then(|(at, value)| Some((slot(axes.get(at)?)?, value)));
            let Some((at, value)) = found else {
                return syntax(format!("{name} takes X, Y and Z only, not {word}"));
            };
            let value = value.parse::<f64>().unwrap_or(0.0);
            if let (Some(shift), Some(own)) = (shift.get_mut(at), self.held.additive.get_mut(at)) {
                if additive {
                    *shift += value - *own;
                    *own = value;
                } else {
                    *shift = value + *own;
                }
            }
        }
        left.replace("TRANS".to_owned());
        for (at, letter) in ["X", "Y", "Z"].into_iter().enumerate() {
            if axes.iter().any(|axis| axis.letter.eq_ignore_ascii_case(letter)) {
                let word = format!("{letter}{}", Data::Real(shift.get(at).copied().unwrap_or(0.0)).word());
                left.add(&word);
            }
        }
        for axis in axes.iter().filter(|axis| axis.line[1] != 0.0) {
            left.add(&format!("{}{}", axis.letter, Data::Real(axis.line[1]).word()));
        }
        host.effect();
        Ok(())
    }
}

/// Sets the values of axis words to 0: they only name mirrored axes, and mirrors are at the zero of the frame.
fn at_zero(host: &dyn InterpreterHost, left: &mut SiemensRemainder) {
    let axes = host.axes();
    let word = |word: &str| match axis_word(&axes, word) {
        Some((_, _)) => format!("{}0", word.get(..1).unwrap_or_default()),
        None => word.to_owned(),
    };
    left.replace(left.words.split(' ').map(word).collect::<Vec<_>>().join(" "));
}

/// X, Y or Z as 0, 1 or 2.
fn slot(axis: &AxisPlace) -> Option<usize> {
    ["X", "Y", "Z"].iter().position(|letter| axis.letter.eq_ignore_ascii_case(letter))
}

/// G74 and G75.
fn to_points(host: &mut dyn InterpreterHost, left: &mut SiemensRemainder, fixed: bool) -> Outcome<()> {
    let (name, text) = if fixed { ("G75", FIXED) } else { ("G74", HOME) };
    if !host.is_code_text(text) {
        return Ok(());
    }
    let (axes, relative) = (host.axes(), left.relative.unwrap_or_else(|| host.relative()));
    let (mut words, mut number, mut mode) = (String::new(), 1, "");
    for word in left.words.split(' ').filter(|word| code(word).is_none()) {
        if let Some(point) = word.strip_prefix("FP=").filter(|_| fixed) {
            number = point.trim_end_matches('.').parse().unwrap_or(0);
            continue;
        }
        if word.eq_ignore_ascii_case("G90") || word.eq_ignore_ascii_case("G91") {
            mode = if relative { "G91 " } else { "G90 " };
            continue;
        }
        let Some(axis) = axis_word(&axes, word).and_then(|(at, _)| axes.get(at)) else {
            return syntax(format!("{name} takes axes only, not {word}"));
        };
        // The point before the axis goes to the reference point is where it is.
        let here = if relative { 0.0 } else { axis.from };
        words.push_str(&format!(" {}{}", axis.letter, Data::Real(here).word()));
    }
    if words.is_empty() {
        return syntax(format!("{name} needs the axes that go to the point, as X1=0"));
    }
    if fixed && !POINTS.contains(&number) {
        return syntax(format!("fixed point {number} does not exist, expected 1 to 3 (alarm 17800)"));
    }
    let point = if fixed { format!(" {POINT}={}", number + 1) } else { String::new() };
    left.replace([mode, text, &point, &words].concat());
    Ok(())
}

/// TRANS replaces the whole translation: axes that it does not name are no longer moved.
fn whole_translation(host: &dyn InterpreterHost, left: &mut SiemensRemainder) {
    if left.words.split(' ').any(|word| word.len() == 1) {
        // An axis without its value: the message shows the block as it is.
        return;
    }
    for axis in host.axes().iter().filter(|axis| slot(axis).is_some()) {
        let is_axis = |word: &str| {
            let (letter, value) = word.split_at_checked(1).unwrap_or_default();
            letter.eq_ignore_ascii_case(&axis.letter) && !value.starts_with(|c: char| c.is_ascii_alphabetic())
        };
        if !left.words.split(' ').any(is_axis) {
            let word = format!("{}0", axis.letter);
            left.add(&word);
        }
    }
}
