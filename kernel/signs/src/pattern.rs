//! The pattern of a sign: a short text that says which words or texts of a program are meant.
//!
//! Words of a block: `T M6`, `G50|G92 S !X`, `M100-199`, `F<2`, `T####`, `D.`, `G14 alone`. `!` is a word that the
//! block does not have, `!!` one that no program has. `line WAITM(*` is a whole line, `has LIMS=` a name in it, `file
//! .mpf` the ending of a file, `; text` a text after a semicolon, `blocks end with ;` three of them. `&&` joins
//! patterns that must all be found. *Invariant:* a pattern that exists can match some program.

use super::block::{StrippedBlock, Word, bit};

/// Number of blocks that must end with a semicolon.
const ENDS: u32 = 3;

/// The pattern of a sign.
#[derive(Debug, Clone, PartialEq)]
pub struct SignPattern {
    text: String,
    pub(crate) parts: Vec<PatternTerm>,
    pub(crate) nowhere: Vec<Alternatives>,
}

/// The expected findings.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum PatternTerm {
    /// Words of a block.
    Words(WordPattern),
    /// A line, `*` for any text and `#` for a digit.
    Line(String),
    /// A name or text in a line.
    Has(String),
    /// The ending of a file, in small letters.
    File(String),
    /// A text after a semicolon.
    Remark,
    /// Blocks that end with a semicolon.
    Ends,
}

/// Words that a block has, and has not.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct WordPattern {
    with: Vec<Alternatives>,
    without: Vec<Alternatives>,
    /// No other word is in the block.
    alone: bool,
    /// Letters of which a block needs one: those of the first alternatives.
    letters: u32,
}

/// Words of which one is enough.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Alternatives(Vec<(u8, ValuePattern)>);

/// Which values of a word are meant.
#[derive(Debug, Clone, PartialEq)]
enum ValuePattern {
    Any,
    /// From one number to another.
    Numbers(f64, f64),
    Below(f64),
    Above(f64),
    /// As many digits as the text has `#`, others as they are.
    Digits(String),
    /// With a decimal point.
    Pointed,
}

impl SignPattern {
    /// Reads a pattern, or reports the error in it.
    ///
    /// # Errors
    ///
    /// A text that is not a pattern.
    pub fn parse(text: &str) -> Result<Self, String> {
        let (mut parts, mut nowhere) = (Vec::new(), Vec::new());
        for part in text.split("&&").map(str::trim) {
            let found = match part.split_once(' ') {
                Some((";", "text")) => PatternTerm::Remark,
                Some(("file", ending)) if ending.starts_with('.') => PatternTerm::File(ending.to_ascii_lowercase()),
                Some(("line", line)) if !line.trim().is_empty() => PatternTerm::Line(line.trim().to_ascii_uppercase()),
                Some(("has", name)) if !name.trim().is_empty() => PatternTerm::Has(name.trim().to_ascii_uppercase()),
                _ if part == "blocks end with ;" => PatternTerm::Ends,
                _ => PatternTerm::Words(words(part, &mut nowhere)?),
            };
            parts.push(found);
        }
        let empty = |part: &PatternTerm| matches!(part, PatternTerm::Words(words) if words.with.is_empty());
        parts.retain(|part| !empty(part));
        if parts.is_empty() {
            return Err("must name a word that is in the program".to_owned());
        }
        Ok(Self { text: text.to_owned(), parts, nowhere })
    }

    /// M codes of a range.
    #[must_use]
    pub fn m_codes(first: u32, last: u32) -> Self {
        let alternatives = Alternatives(vec![(b'M', ValuePattern::Numbers(f64::from(first), f64::from(last)))]);
        let words = WordPattern { letters: bit(b'M'), with: vec![alternatives], ..WordPattern::default() };
        Self { text: format!("M{first}-{last}"), parts: vec![PatternTerm::Words(words)], nowhere: Vec::new() }
    }

    /// The pattern as it is written.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The letters of the rotary axes that the pattern names, in alphabetical order. Empty if a part is anything but
    /// plain words of rotary axes or words of other letters.
    pub(crate) fn rotary_axes(&self) -> Vec<char> {
        let letter = |alternatives: &Alternatives| match alternatives.0.as_slice() {
            [(letter @ b'A'..=b'C', ValuePattern::Any)] => Some(char::from(*letter)),
            _ => None,
        };
        let mut letters = Vec::new();
        for part in &self.parts {
            let PatternTerm::Words(words) = part else { return Vec::new() };
            if words.with.iter().all(|alternatives| alternatives.0.iter().all(|(letter, _)| *letter > b'C')) {
                continue;
            }
            let Some(of_part) = words.with.iter().map(letter).collect::<Option<Vec<_>>>() else { return Vec::new() };
            letters.extend(of_part);
        }
        letters.sort_unstable();
        letters
    }

    /// Whether it is a range of M codes and nothing else.
    pub(crate) fn is_m_codes(&self) -> bool {
        let m = |part: &PatternTerm| matches!(part, PatternTerm::Words(words) if words.letters == bit(b'M') && words.with.len() == 1);
        self.parts.iter().all(m) && self.nowhere.is_empty()
    }
}

/// Reads the terms of a pattern of words.
fn words(text: &str, nowhere: &mut Vec<Alternatives>) -> Result<WordPattern, String> {
    let mut words = WordPattern::default();
    for term in text.split_whitespace() {
        if term == "alone" {
            words.alone = true;
        } else if let Some(term) = term.strip_prefix("!!") {
            nowhere.push(alternatives(term)?);
        } else if let Some(term) = term.strip_prefix('!') {
            words.without.push(alternatives(term)?);
        } else {
            words.with.push(alternatives(term)?);
        }
    }
    words.letters = words.with.first().map_or(0, |first| first.0.iter().fold(0, |bits, (l, _)| bits | bit(*l)));
    if words.with.is_empty() && (words.alone || !words.without.is_empty()) {
        return Err("must name a word that is in the block".to_owned());
    }
    Ok(words)
}

fn alternatives(term: &str) -> Result<Alternatives, String> {
    let one = |word: &str| {
        let wrong = || format!("has '{word}', which is not a word: give a letter and, if it matters, its value");
        let (letter, spec) = word.split_at_checked(1).ok_or_else(wrong)?;
        let letter = letter.bytes().next().filter(u8::is_ascii_uppercase).ok_or_else(wrong)?;
        let number = |text: &str| text.parse::<f64>().ok().filter(|n| n.is_finite()).ok_or_else(wrong);
        let value = match spec.split_once('-') {
            _ if spec.is_empty() => ValuePattern::Any,
            _ if spec == "." => ValuePattern::Pointed,
            _ if spec.contains('#') && spec.bytes().all(|b| b.is_ascii_digit() || matches!(b, b'#' | b'.')) => {
                ValuePattern::Digits(spec.to_owned())
            }
            Some((first, last)) => ValuePattern::Numbers(number(first)?, number(last)?),
            None => match (spec.strip_prefix('<'), spec.strip_prefix('>')) {
                (Some(limit), _) => ValuePattern::Below(number(limit)?),
                (_, Some(limit)) => ValuePattern::Above(number(limit)?),
                _ => ValuePattern::Numbers(number(spec)?, number(spec)?),
            },
        };
        Ok((letter, value))
    };
    term.split('|').map(one).collect::<Result<_, String>>().map(Alternatives)
}

impl Alternatives {
    /// The first word of a block that is meant.
    fn of<'b>(&self, block: &'b StrippedBlock) -> Option<&'b Word> {
        block.words.iter().find(|(letter, value)| self.0.iter().any(|(l, v)| l == letter && v.is(value)))
    }

    /// Whether a block has such a word.
    pub(crate) fn is_in(&self, block: &StrippedBlock) -> bool {
        block.has_letters(self.0.iter().fold(0, |bits, (l, _)| bits | bit(*l))) && self.of(block).is_some()
    }
}

impl ValuePattern {
    fn is(&self, written: &str) -> bool {
        let number = || written.parse::<f64>().ok();
        match self {
            Self::Any => true,
            Self::Numbers(first, last) => number().is_some_and(|n| *first <= n && n <= *last),
            Self::Below(limit) => number().is_some_and(|n| n < *limit),
            Self::Above(limit) => number().is_some_and(|n| n > *limit),
            Self::Pointed => written.contains('.'),
            Self::Digits(form) => {
                let same = |(form, b): (u8, u8)| form == b || form == b'#' && b.is_ascii_digit();
                form.len() == written.len() && form.bytes().zip(written.bytes()).all(same)
            }
        }
    }
}

impl PatternTerm {
    /// The sign in a line, in a form for people; `ends` counts the blocks that end with a semicolon.
    pub(crate) fn in_block(&self, block: &StrippedBlock, ends: u32) -> Option<String> {
        match self {
            Self::Words(words) => words.in_block(block),
            Self::Line(form) => {
                let line = block.line.trim();
                is_like(form.as_bytes(), line.as_bytes()).then(|| named(form, line))
            }
            Self::Has(name) => has(&block.line, name).then(|| name.trim_end_matches(['(', '=']).to_owned()),
            Self::Remark => block.remark.then(|| "; text".to_owned()),
            Self::Ends => (block.ends && ends == ENDS).then(|| "blocks that end with ;".to_owned()),
            Self::File(_) => None,
        }
    }
}

impl WordPattern {
    fn in_block(&self, block: &StrippedBlock) -> Option<String> {
        if !block.has_letters(self.letters) || self.alone && block.words.len() != self.with.len() {
            return None;
        }
        if self.without.iter().any(|no| no.is_in(block)) {
            return None;
        }
        let mut shown = String::new();
        let mut last: Option<&Word> = None;
        for term in &self.with {
            let word = term.of(block)?;
            // Two terms are two words.
            let word = match last {
                Some(known) if std::ptr::eq(known, word) => {
                    block.words.iter().find(|other| !std::ptr::eq(*other, word) && term.takes(other))?
                }
                _ => word,
            };
            last = Some(word);
            let plain = word.1.parse::<f64>().is_ok();
            let value = if plain { word.1.as_str() } else { "" };
            shown = format!("{shown}{}{}{value}", if shown.is_empty() { "" } else { " " }, char::from(word.0));
        }
        Some(shown)
    }
}

impl Alternatives {
    fn takes(&self, (letter, value): &Word) -> bool {
        self.0.iter().any(|(l, v)| l == letter && v.is(value))
    }
}

/// Name of a line: the text that the form gives, or the line itself where the form has places in the middle.
fn named(form: &str, line: &str) -> String {
    const LONGEST: usize = 24;
    let literal = form.trim_end_matches('*');
    if literal.contains(['*', '#']) {
        line.chars().take(LONGEST).collect()
    } else {
        literal.trim_end_matches(['(', ' ']).to_owned()
    }
}

/// Whether a text is of a form with `*` for any text and `#` for a digit.
fn is_like(form: &[u8], text: &[u8]) -> bool {
    match (form, text) {
        ([], []) => true,
        ([b'*'], _) => true,
        ([b'*', rest @ ..], _) => (0..=text.len()).any(|at| is_like(rest, text.get(at..).unwrap_or_default())),
        ([b'#', form @ ..], [digit, text @ ..]) if digit.is_ascii_digit() => is_like(form, text),
        ([one, form @ ..], [other, text @ ..]) if one == other => is_like(form, text),
        _ => false,
    }
}

/// Whether a line has a name or text that is not a part of a longer name.
fn has(line: &str, name: &str) -> bool {
    let part = |b: u8| b.is_ascii_alphanumeric() || b == b'_';
    let (bytes, ends) = (line.as_bytes(), name.bytes().next_back().is_some_and(part));
    let begins = name.bytes().next().is_some_and(part);
    line.match_indices(name).any(|(at, _)| {
        let before = at.checked_sub(1).and_then(|at| bytes.get(at)).is_some_and(|b| part(*b) || *b == b'$');
        let after = bytes.get(at + name.len()).is_some_and(|b| part(*b));
        !(begins && before || ends && after)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(pattern: &str, line: &str) -> Option<String> {
        let pattern = SignPattern::parse(pattern).unwrap();
        let block = StrippedBlock::of(line);
        pattern.parts.first().and_then(|part| part.in_block(&block, ENDS))
    }

    #[test]
    fn words_are_found_with_their_values() {
        for (pattern, line, found) in [
            ("T M6", "N10 T01 M06", Some("T01 M06")),
            ("T M6", "T1", None),
            ("G50|G92 S !X !Z", "G92 S2500", Some("G92 S2500")),
            ("G50|G92 S !X !Z", "G92 X0 S2500", None),
            ("M100-199", "M130 P12", Some("M130")),
            ("M100-199", "M30", None),
            ("F<2", "G1 X1 F.1", Some("F.1")),
            ("F<2", "G1 F#101", None),
            ("T####", "T0101", Some("T0101")),
            ("T#### !T##00", "T0100", None),
            ("T###.##", "T001.01", Some("T001.01")),
            ("D.", "G71 P1 Q2 D2.5", Some("D2.5")),
            ("D.", "G71 P1 Q2 D2500", None),
            ("G14 alone", "N10 G14 (B)", Some("G14")),
            ("G14 alone", "G14 X1", None),
            ("G90 G0-89", "G90 G54", Some("G90 G54")),
            ("G90 G0-90", "G90", None),
            ("X", "X[#1]", Some("X")),
        ] {
            assert_eq!(shown(pattern, line).as_deref(), found, "{pattern} in {line}");
        }
    }

    #[test]
    fn texts_are_whole_names_outside_of_comments() {
        for (pattern, line, found) in [
            ("line WAITM(*", "N10 WAITM(1,1,2)", Some("WAITM")),
            ("line CYCLE#*", "CYCLE81(1)", Some("CYCLE81()")),
            ("line DIAMON*", "(80 DEG DIAMOND CNMG)", None),
            ("has DIAMON", "G18 DIAMON", Some("DIAMON")),
            ("has DIAMON", "G18 DIAMOND", None),
            ("has LIMS=", "G96 S200 LIMS=3000", Some("LIMS")),
            ("has SPOS=", "MSG(\"SPOS=90\")", None),
            ("line $*%", "$SHAFT.MIN%", Some("$SHAFT.MIN%")),
            ("line $1", "$1", Some("$1")),
            ("; text", ";FLAVOR:Marlin", Some("; text")),
        ] {
            assert_eq!(shown(pattern, line).as_deref(), found, "{pattern} in {line}");
        }
    }

    #[test]
    fn a_sign_of_rotary_axes_names_nothing_else() {
        for (pattern, letters) in [
            ("C !G65 && B !G65", "BC"),
            ("A !G65 !G76", "A"),
            ("A|B", ""),
            ("A0", ""),
            ("B && M6", "B"),
            ("T M6", ""),
            ("B M6", ""),
            ("has A3=", ""),
            ("B && has TRAORI", ""),
        ] {
            let axes: String = SignPattern::parse(pattern).unwrap().rotary_axes().into_iter().collect();
            assert_eq!(axes, letters, "{pattern}");
        }
    }

    #[test]
    fn what_is_no_pattern_is_refused() {
        for text in ["", "!X", "!!X", "alone", "7", "XY", "T<", "file mpf", "G1 && "] {
            let known = SignPattern::parse(text);
            assert!(known.is_err() || text == "G1 && ", "{text}: {known:?}");
        }
    }
}
