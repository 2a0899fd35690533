//! A line of a program as signs see it: in capitals, without comments, texts and its number.
//!
//! *Invariant:* nothing of a comment is left. Text in round brackets, in quotes and after a semicolon is dropped; of an
//! argument list the empty brackets stay, so that `MSG("M6")` is `MSG()`.

/// A word: its letter and its value as written.
pub(crate) type Word = (u8, String);

/// A line of a program.
#[derive(Debug, Default)]
pub(crate) struct StrippedBlock {
    /// The line without comments, block skip mark and number.
    pub(crate) line: String,
    /// Words of one letter; names of several letters are not words.
    pub(crate) words: Vec<Word>,
    /// Text after a semicolon that is not a block.
    pub(crate) remark: bool,
    /// A block that ends with a semicolon.
    pub(crate) ends: bool,
    /// The letters of the words, bit 0 = A.
    letters: u32,
}

impl StrippedBlock {
    /// Reads a line.
    pub(crate) fn of(raw: &str) -> Self {
        let raw = raw.trim().to_ascii_uppercase();
        let (plain, remark) = plain(&raw);
        let line = unnumbered(plain.trim()).to_owned();
        let words = words(&line);
        let letters = words.iter().fold(0, |letters, (letter, _)| letters | bit(*letter));
        let ends = !line.is_empty() && raw.ends_with(';');
        Self { line, words, remark, ends, letters }
    }

    /// Whether some word has one of these letters.
    pub(crate) fn has_letters(&self, letters: u32) -> bool {
        self.letters & letters != 0
    }
}

/// The bit of a letter.
pub(crate) fn bit(letter: u8) -> u32 {
    1_u32.checked_shl(u32::from(letter.wrapping_sub(b'A'))).unwrap_or(0)
}

/// A line without comments and texts, and whether a semicolon is followed by a text.
fn plain(raw: &str) -> (String, bool) {
    let mut out = String::with_capacity(raw.len());
    let (mut depth, mut quoted) = (0_u32, false);
    let mut rest = raw.char_indices();
    for (at, c) in rest.by_ref() {
        match c {
            '"' if depth == 0 => {
                quoted = !quoted;
                out.push('"');
            }
            _ if quoted => {}
            '(' => {
                if depth == 0 && ends_with_name(&out) {
                    out.push_str("()");
                }
                depth += 1;
            }
            ')' => depth = depth.saturating_sub(1),
            _ if depth > 0 => {}
            ';' => return (out, is_remark(raw.get(at + 1..).unwrap_or_default())),
            _ => out.push(c),
        }
    }
    (out, false)
}

/// Whether a text ends with the name of a function or cycle: two letters or more, then letters and digits.
fn ends_with_name(text: &str) -> bool {
    let part = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let name = text.get(text.trim_end_matches(part).len()..).unwrap_or_default().trim_start_matches('_');
    name.bytes().take(2).filter(u8::is_ascii_alphabetic).count() == 2
}

/// Whether a text follows the semicolon, not the end of the line or another block.
fn is_remark(tail: &str) -> bool {
    let tail = tail.trim();
    if tail.ends_with(';') {
        return false;
    }
    let (tail, _) = plain(tail);
    let letters: Vec<bool> = tail.chars().map(|c| c.is_alphabetic()).collect();
    letters.windows(2).any(|pair| matches!(pair, [true, true]))
}

/// A line without the mark of block skip and its number: `N10`, or the bare number of a Heidenhain control.
fn unnumbered(line: &str) -> &str {
    let digits = |text: &str| text.len() - text.trim_start_matches(|c: char| c.is_ascii_digit()).len();
    let mut line = line;
    if let Some(rest) = line.strip_prefix('/') {
        line = rest.get(digits(rest).min(1)..).unwrap_or_default().trim_start();
    }
    if let Some(rest) = line.strip_prefix('N') {
        let rest = rest.trim_start();
        if digits(rest) > 0 {
            line = rest.get(digits(rest)..).unwrap_or_default().trim_start();
        }
    } else if let Some(rest) = line.get(digits(line)..).filter(|rest| digits(line) > 0 && rest.starts_with(' ')) {
        line = rest.trim_start();
    }
    // A heading in the structure of a Heidenhain program.
    if line.starts_with("* ") { "" } else { line }
}

/// Words of one letter with their values.
fn words(line: &str) -> Vec<Word> {
    let mut words = Vec::new();
    let mut rest = line;
    let mut before = ' ';
    while let Some(at) = rest.find(|c: char| c.is_ascii_alphabetic()) {
        before = rest.get(..at).and_then(|skipped| skipped.chars().next_back()).unwrap_or(before);
        let tail = rest.get(at..).unwrap_or_default();
        let letters = tail.len() - tail.trim_start_matches(|c: char| c.is_ascii_alphabetic() || c == '_').len();
        let (name, after) = tail.split_at(letters);
        let value: String = after
            .trim_start()
            .chars()
            .take_while(|c| c.is_ascii_digit() || matches!(c, '.' | '-' | '+' | '#' | '[' | '='))
            .collect();
        let is_part = value.is_empty() || matches!(before, '_' | '$' | '<');
        if let ([letter], false) = (name.as_bytes(), is_part) {
            // A chamfer (,C) and an angle of a line (,A) are not axis words.
            if before != ',' || !matches!(letter, b'A' | b'C') {
                words.push((*letter, value));
            }
        }
        before = name.chars().next_back().unwrap_or(' ');
        rest = after;
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_texts_and_numbers_are_left_out() {
        for (raw, line) in [
            ("N10 G54 (80 DEG DIAMOND CNMG)", "G54 "),
            ("t1 m6(drill (8.5) hss)", "T1 M6"),
            ("O0036(300-11, NV4500)", "O0036"),
            ("POCKET3(1,2) X1", "POCKET3() X1"),
            ("N10 MSG(\"SPOS=90\") ; text", "MSG() "),
            ("/2 N20 G1 X1", "G1 X1"),
            ("12 L X+10 R0 FMAX M3 ; rough", "L X+10 R0 FMAX M3 "),
            ("3 * - ROUGHING M6", ""),
            ("WAITM(1,(1),2)", "WAITM()"),
            ("TOOL CALL \"MILL D10\" Z", "TOOL CALL \"\" Z"),
            ("NLAP1 G81", "NLAP1 G81"),
            ("(OPEN G96 S200", ""),
        ] {
            assert_eq!(StrippedBlock::of(raw).line.trim(), line.trim(), "{raw}");
        }
        let of = |raw: &str| (StrippedBlock::of(raw).remark, StrippedBlock::of(raw).ends);
        assert_eq!(of(";FLAVOR:Marlin"), (true, false));
        assert_eq!(of("T101 (OD) ;"), (false, true));
        assert_eq!(of("G1 X1 ; (note)"), (false, false));
        assert_eq!(of(";"), (false, false));
    }

    #[test]
    fn words_have_one_letter() {
        let of = |raw: &str| {
            StrippedBlock::of(raw)
                .words
                .iter()
                .map(|(l, v)| format!("{}{v}", char::from(*l)))
                .collect::<Vec<_>>()
                .join(" ")
        };
        assert_eq!(of("N1T01M06 X-.5Y[#1+2]"), "T01 M06 X-.5 Y[#1+2");
        assert_eq!(of("CYCLE81(1,2) LIMS=3000 _X1 A3=1"), "A3=1");
        assert_eq!(of("L X+10 R0 FMAX M128"), "X+10 R0 M128");
    }
}
