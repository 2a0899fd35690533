//! Words that a block must not combine.
//!
//! Facts: reference siemens-cycles.md 6: frames and poles need separate blocks (12120), RP is not negative (14200), a
//! block has polar or Cartesian words of its plane (14280), a circle has a centre, an end or a radius (14900), an angle
//! within a turn (14910), a corner is not negative (16500). *Invariant:* a block that is refused moves nothing.

use super::{Outcome, SiemensBlockError};
use counterpoint_fault as diag;

/// Statements whose axis words are data.
const OWN_BLOCK: [&str; 13] =
    ["TRANS", "ATRANS", "ROT", "AROT", "ROTS", "AROTS", "SCALE", "ASCALE", "MIRROR", "AMIRROR", "G110", "G111", "G112"];

/// Refuses such words; `plane`: 1 for G17 to 3 for G19.
pub(super) fn check(words: &str, plane: impl Fn() -> Option<i64>) -> Outcome<()> {
    if !words.split(' ').any(is_looked_at) {
        return Ok(());
    }
    let mut before = words.split(' ').take_while(|word| !OWN_BLOCK.contains(word));
    let own = words.split(' ').find(|word| OWN_BLOCK.contains(word));
    if let Some(own) = own {
        let moves = before.find(|word| is_axis(word) || is_motion(word));
        if let Some(word) = moves.or_else(|| words.split(' ').find(|word| is_motion(word))) {
            let text = format!("{own} must be alone in its block; remove {word} (alarm 12120)");
            return Err(SiemensBlockError::Alarm(&diag::SIEMENS_STATE, text));
        }
    }
    let below = |word: &&str| {
        let value = ["RND=", "RNDM=", "CHF=", "CHR="].iter().find_map(|name| word.strip_prefix(name));
        value.and_then(|value| value.parse::<f64>().ok()).is_some_and(|value| value < 0.0)
    };
    if let Some(word) = words.split(' ').find(below) {
        return refused(format!("{word} is negative (alarm 16500)"));
    }
    circle(words, &plane)?;
    if !words.split(' ').any(|word| word.starts_with("RP=") || word.starts_with("AP=")) {
        return Ok(());
    }
    if words.split(' ').any(|word| word.starts_with("RP=-") && word != "RP=-0") {
        let text = "the polar radius RP is negative (alarm 14200)".to_owned();
        return Err(SiemensBlockError::Alarm(&diag::SIEMENS_STATE, text));
    }
    let axes = axes(plane());
    match words.split(' ').find(|word| is_axis(word) && word.starts_with(axes)) {
        Some(word) => {
            let text = format!("{word} and polar words are in one block; use one kind (alarm 14280)");
            Err(SiemensBlockError::Alarm(&diag::SIEMENS_STATE, text))
        }
        None => Ok(()),
    }
}

/// Whether the words of these rules have two letters or are G110 to G112; those of most blocks have one letter.
fn is_looked_at(word: &str) -> bool {
    matches!(word.as_bytes(), [_, second, ..] if second.is_ascii_alphabetic()) || word.starts_with("G11")
}

fn refused<T>(text: String) -> Outcome<T> {
    Err(SiemensBlockError::Alarm(&diag::SIEMENS_STATE, text))
}

/// Axes of a plane.
fn axes(plane: Option<i64>) -> [char; 2] {
    match plane {
        Some(2) => ['Z', 'X'],
        Some(3) => ['Y', 'Z'],
        _ => ['X', 'Y'],
    }
}

/// A circle by its angle has a centre or an end in its plane, one by its radius no centre.
fn circle(words: &str, plane: impl Fn() -> Option<i64>) -> Outcome<()> {
    let by = |name: &str| words.split(' ').find_map(|word| word.strip_prefix(name));
    let (angle, radius) = (by("AR="), by("CR="));
    if angle.is_none() && radius.is_none() {
        return Ok(());
    }
    if angle.and_then(|angle| angle.parse::<f64>().ok()).is_some_and(|angle| angle <= 0.0 || angle >= 360.0) {
        return refused("the angle AR of a circle must be above 0 and below 360 degrees (alarm 14910)".to_owned());
    }
    let axes = axes(plane());
    let centers = axes.map(|axis| match axis {
        'X' => 'I',
        'Y' => 'J',
        _ => 'K',
    });
    let Some(center) = words.split(' ').find(|word| is_word(word, &centers)) else { return Ok(()) };
    if radius.is_some() {
        return refused(format!("{center} and CR are in one block; program the centre or the radius (alarm 14900)"));
    }
    match words.split(' ').find(|word| is_word(word, &axes)) {
        Some(end) => {
            refused(format!("{center}, {end} and AR are in one block; program the centre or the end (alarm 14900)"))
        }
        None => Ok(()),
    }
}

/// Whether this is a word of one of the letters.
fn is_word(word: &str, letters: &[char]) -> bool {
    let value = word.strip_prefix(letters);
    value.is_some_and(|value| value.starts_with(|next: char| next.is_ascii_digit() || "+-.=".contains(next)))
}

/// A word of X, Y or Z.
fn is_axis(word: &str) -> bool {
    is_word(word, &['X', 'Y', 'Z'])
}

/// G0 to G3, with leading zeros or without.
fn is_motion(word: &str) -> bool {
    let digits = word.strip_prefix('G').filter(|digits| !digits.is_empty());
    digits.is_some_and(|digits| matches!(digits.trim_start_matches('0'), "" | "1" | "2" | "3"))
}

#[cfg(test)]
mod tests {
    use super::check;

    #[test]
    fn frames_and_polar_words_beside_moves() {
        for words in ["TRANS X5", "ROT RPL=30", "G110 X5 Y5", "G0 RP=10 AP=45", "G1 RP=10 AP=45 Z5", "G111 RP=5 AP=0"] {
            assert!(check(words, || Some(1)).is_ok(), "{words}");
        }
        for words in ["G0 X5 ROT Z45", "X5 MIRROR Y0", "G00 Y5 TRANS X1", "TRANS X5 G1", "G0 G110 X5 Y5", "RP=-5 AP=0"]
        {
            assert!(check(words, || Some(1)).is_err(), "{words}");
        }
        for words in ["G2 X10 Y0 I5 J0 CR=5", "G2 X10 Y0 I5 J0 AR=180", "G3 I5 J0 AR=360", "G1 X5 RND=-2"] {
            assert!(check(words, || Some(1)).is_err(), "{words}");
        }
        for words in ["G2 X10 Y0 CR=5", "G2 X10 Y0 AR=90", "G2 I5 J0 Z-5 AR=90", "G1 X5 RND=0"] {
            assert!(check(words, || Some(1)).is_ok(), "{words}");
        }
        assert!(check("G0 X3 RP=5 AP=45", || Some(1)).is_err() && check("G0 X3 RP=5 AP=45", || Some(3)).is_ok());
    }
}
