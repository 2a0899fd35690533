//! The words of a block, as rules of the tape editor see them.
//!
//! Facts: texts, comments and identifiers are units of the languages of all controls; an edit of words changes none of
//! them. *Invariant:* places in the visible text are places in the block; a place that is not visible has a character
//! that no program has.

use std::borrow::Cow;

use super::syntax::Syntax;
use counterpoint_machine::model::ProgramTextFormat;

/// Placeholder for each byte of a comment, a message or a quoted text.
const HIDDEN: u8 = 1;

/// The marks that hide text on a machine.
#[derive(Debug, Default)]
pub struct RemarkDelimiters {
    /// Begins and ends of comments and messages; without an end they reach the end of the block.
    remarks: Vec<(Vec<u8>, Vec<u8>)>,
    /// Names have digits: `AB1C` is one name, not a word `AB1` and a word `C`.
    long_names: bool,
}

/// The visible part of a block.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Visible<'t> {
    /// The block with placeholders, without a remark at its end.
    pub(super) text: Cow<'t, str>,
    /// The remark at its end.
    pub(super) rest: &'t str,
}

impl RemarkDelimiters {
    /// Those of a machine and its pre-processor.
    pub fn new(format: &ProgramTextFormat, syntax: &Syntax) -> Self {
        let pairs = [&format.comment, &format.message].into_iter().flatten();
        Self::of(pairs.map(|(start, end)| (start.as_str(), end.as_str())), syntax.keeps_names)
    }

    pub(super) fn of<'m>(remarks: impl IntoIterator<Item = (&'m str, &'m str)>, long_names: bool) -> Self {
        let bytes = |text: &str| text.as_bytes().to_vec();
        let remarks = remarks.into_iter().filter(|(start, _)| !start.is_empty());
        Self { remarks: remarks.map(|(start, end)| (bytes(start), bytes(end))).collect(), long_names }
    }

    /// The words of a block.
    pub(super) fn visible<'t>(&self, block: &'t str) -> Visible<'t> {
        let bytes = block.as_bytes();
        let (mut hidden, mut at, mut end) = (None::<Vec<u8>>, 0, bytes.len());
        while let Some(rest) = bytes.get(at..).filter(|rest| !rest.is_empty()) {
            let remark = self.remarks.iter().find(|(start, _)| rest.starts_with(start));
            let (from, to) = if let Some((start, close)) = remark {
                let to = length(rest.get(start.len()..).unwrap_or_default(), close).map(|inside| start.len() + inside);
                (at, at + to.unwrap_or(rest.len()))
            } else if rest.first() == Some(&b'"') {
                match memchr::memchr(b'"', rest.get(1..).unwrap_or_default()) {
                    Some(inside) => (at + 1, at + 1 + inside),
                    None => (at, at),
                }
            } else {
                (at, at)
            };
            if from < to {
                if remark.is_some() && bytes.get(to..).unwrap_or_default().trim_ascii().is_empty() {
                    end = from;
                    break;
                }
                let text = hidden.get_or_insert_with(|| bytes.to_vec());
                text.get_mut(from..to).unwrap_or_default().fill(HIDDEN);
            }
            // Behind the mark that ends a quoted text.
            at = to + usize::from(remark.is_none());
        }
        let (whole, rest) = block.split_at_checked(end).unwrap_or((block, ""));
        let text = match hidden {
            None => Cow::from(whole),
            Some(mut hidden) => {
                hidden.truncate(end);
                String::from_utf8(hidden).map_or(Cow::from(whole), Cow::from)
            }
        };
        Visible { text, rest }
    }

    /// Whether a match consists of words: it begins outside hidden text, and neither end is inside a name.
    pub(super) fn is_of_words(&self, text: &str, (start, end): (usize, usize)) -> bool {
        let bytes = text.as_bytes();
        let letter =
            |at: usize| bytes.get(at).is_some_and(|byte| byte.is_ascii_alphabetic() || matches!(byte, b'_' | b'$'));
        let cuts = |at: usize| at > 0 && letter(at - 1) && letter(at);
        let hidden = end > start && bytes.get(start) == Some(&HIDDEN);
        let in_name = self.long_names && letter(start) && within_name(bytes, start);
        !hidden && !in_name && (end == start || !cuts(start) && !cuts(end))
    }
}

/// Bytes up to the end of a remark and with it.
fn length(rest: &[u8], close: &[u8]) -> Option<usize> {
    if close.is_empty() { None } else { memchr::memmem::find(rest, close).map(|at| at + close.len()) }
}

/// Whether a name of two or more letters begins before this place and continues there.
fn within_name(bytes: &[u8], place: usize) -> bool {
    let letter = |byte: u8| byte.is_ascii_alphabetic() || matches!(byte, b'_' | b'$');
    let mut at = 0;
    while at < place {
        let (first, second) = (bytes.get(at).copied().unwrap_or(0), bytes.get(at + 1).copied().unwrap_or(0));
        let is_name = letter(first) && (letter(second) || !first.is_ascii_alphabetic());
        if is_name {
            let rest = bytes.get(at..).unwrap_or_default();
            at += rest.iter().take_while(|byte| letter(**byte) || byte.is_ascii_digit()).count();
        } else {
            at += 1;
        }
    }
    at > place
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(marks: &RemarkDelimiters, block: &str) -> (String, String) {
        let Visible { text, rest } = marks.visible(block);
        (text.replace('\u{1}', "."), rest.to_owned())
    }

    #[test]
    fn remarks_and_quoted_texts_are_hidden() {
        let siemens = RemarkDelimiters::of([(";", "")], true);
        let fanuc = RemarkDelimiters::of([("(", ")")], false);
        let pair = |text: &str, rest: &str| (text.to_owned(), rest.to_owned());
        assert_eq!(shown(&siemens, "G1 X5 ; SPOS"), pair("G1 X5 ", "; SPOS"));
        assert_eq!(shown(&siemens, "MSG(\"a;b\") ; c"), pair("MSG(\"...\") ", "; c"));
        assert_eq!(shown(&siemens, "MSG(\"öa\")"), pair("MSG(\"...\")", ""));
        assert_eq!(shown(&siemens, "A\"\"\"b\"\"\"C"), pair("A\"\"\".\"\"\"C", ""));
        assert_eq!(shown(&fanuc, "T1(D\"1)X2(L3) "), pair("T1.....X2", "(L3) "));
        assert_eq!(shown(&fanuc, "T1(open"), pair("T1", "(open"));
        assert_eq!(shown(&fanuc, "T1\"open"), pair("T1\"open", ""));
    }

    #[test]
    fn no_match_cuts_a_name() {
        let (siemens, fanuc) = (RemarkDelimiters::of([], true), RemarkDelimiters::of([], false));
        let of = |marks: &RemarkDelimiters, block: &str, word: &str| {
            let at = block.find(word).unwrap();
            marks.is_of_words(block, (at, at + word.len()))
        };
        for block in ["SPOS=1", "N10SPOS=1", "G1 X1SPOS=1", "R1SPOS=1"] {
            assert!(of(&siemens, block, "SPOS"), "{block}");
        }
        for block in ["ZSPOS=1", "ADISPOS=1", "SPOSA=1", "_SPOS=1", "AB1SPOS=1", "$SPOS=1", "SPOS_1=2"] {
            assert!(!of(&siemens, block, "SPOS"), "{block}");
        }
        assert!(of(&fanuc, "AB1T2", "T2") && of(&fanuc, "COOL8", "COOL") && !of(&fanuc, "COOLER", "COOL"));
    }
}
