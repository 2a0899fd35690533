//! The words of the language: minor words (keywords), major words (records), reserved words; near misses.
//!
//! *Invariant:* words are looked up in upper case; every word and code appears once per table. Facts: the lists of
//! minor, major and reserved words of the reference.

use crate::value::RecordName;
use std::collections::HashMap;
use std::sync::OnceLock;

/// Class of the records that major words name.
pub const MAJOR_CLASS: i32 = 2000;

struct WordCodes {
    codes: HashMap<&'static str, i32>,
    names: HashMap<i32, &'static str>,
}

fn words(table: &'static str) -> WordCodes {
    let mut words = WordCodes { codes: HashMap::new(), names: HashMap::new() };
    for line in table.lines() {
        let Some((word, code)) = line.split_once('\t') else { continue };
        let Ok(code) = code.trim().parse() else { continue };
        words.codes.insert(word, code);
        words.names.entry(code).or_insert(word);
    }
    words
}

fn minor() -> &'static WordCodes {
    static TABLE: OnceLock<WordCodes> = OnceLock::new();
    TABLE.get_or_init(|| words(include_str!("../data/minor-words.tsv")))
}

fn major() -> &'static WordCodes {
    static TABLE: OnceLock<WordCodes> = OnceLock::new();
    TABLE.get_or_init(|| words(include_str!("../data/major-words.tsv")))
}

/// Code of a minor word given in upper case.
#[must_use]
pub fn minor_code(word: &str) -> Option<i32> {
    minor().codes.get(word).copied()
}

/// Name of a minor word's code.
#[must_use]
pub fn minor_name(code: i32) -> Option<&'static str> {
    minor().names.get(&code).copied()
}

/// Subclass of a major word given in upper case.
#[must_use]
pub fn major_code(word: &str) -> Option<i32> {
    major().codes.get(word).copied()
}

/// Name of a major word's subclass.
#[must_use]
pub fn major_name(subclass: i32) -> Option<&'static str> {
    major().names.get(&subclass).copied()
}

/// The record that a word names: a major word, or a reserved word of the post-processor product that is a record of its
/// own. The numbers of the latter are those of cutter location data; class 29000 is this project's own, for words
/// without one.
#[must_use]
pub fn record(word: &str) -> Option<RecordName> {
    let reserved = || records().iter().find(|(name, _)| *name == word).map(|(_, record)| *record);
    major_code(word).map(|subclass| RecordName { class: MAJOR_CLASS, subclass }).or_else(reserved)
}

/// Word that names a record.
#[must_use]
pub fn record_name(record: RecordName) -> Option<&'static str> {
    if record.class == MAJOR_CLASS {
        return major_name(record.subclass);
    }
    records().iter().find(|(_, other)| *other == record).map(|(name, _)| *name)
}

fn records() -> &'static [(&'static str, RecordName)] {
    static TABLE: OnceLock<Vec<(&'static str, RecordName)>> = OnceLock::new();
    TABLE.get_or_init(|| {
        let row = |line: &'static str| {
            let mut parts = line.split('\t');
            let name = parts.next()?;
            let mut number = || parts.next()?.trim().parse().ok();
            Some((name, RecordName { class: number()?, subclass: number()? }))
        };
        include_str!("../data/record-words.tsv").lines().filter_map(row).collect()
    })
}

/// Use of a reserved word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reserved {
    /// The control emulator's macros.
    Control,
    /// The post-processor product only.
    Post,
}

/// Tells whether `word` (upper case) is reserved.
#[must_use]
pub fn reserved(word: &str) -> Option<Reserved> {
    static TABLE: OnceLock<HashMap<&'static str, Reserved>> = OnceLock::new();
    TABLE
        .get_or_init(|| {
            include_str!("../data/reserved-words.tsv")
                .lines()
                .map(|line| match line.split_once('\t') {
                    Some((word, "post")) => (word, Reserved::Post),
                    Some((word, _)) => (word, Reserved::Control),
                    None => (line, Reserved::Control),
                })
                .collect()
        })
        .get(word)
        .copied()
}

/// Tells whether a user name must be written with a leading `%`.
#[must_use]
pub fn needs_percent(word: &str) -> bool {
    reserved(word).is_some() || minor_code(word).is_some() || major_code(word).is_some()
}

/// The candidate nearest to `word`, if it is near enough to be a slip of the fingers.
pub fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let limit = match word.chars().count() {
        0..=2 => 1,
        3..=6 => 2,
        _ => 3,
    };
    candidates
        .into_iter()
        .filter(|candidate| *candidate != word && candidate.len().abs_diff(word.len()) <= limit)
        .map(|candidate| (distance(word, candidate), candidate))
        .filter(|(distance, candidate)| *distance <= limit && *distance < candidate.len())
        .min_by_key(|(distance, candidate)| (*distance, *candidate))
        .map(|(_, candidate)| candidate)
}

/// Edits (insert, delete, replace, swap neighbours) between two words.
fn distance(a: &str, b: &str) -> usize {
    let (a, b): (Vec<u8>, Vec<u8>) = (a.bytes().take(40).collect(), b.bytes().take(40).collect());
    let mut before: Vec<usize> = Vec::new();
    let mut last: Vec<usize> = (0..=b.len()).collect();
    for (i, &x) in a.iter().enumerate() {
        let mut row = vec![i + 1];
        for (j, &y) in b.iter().enumerate() {
            let at = |row: &[usize], j: usize| row.get(j).copied().unwrap_or(usize::MAX / 2);
            let mut cost = (at(&last, j) + usize::from(x != y)).min(at(&last, j + 1) + 1).min(at(&row, j) + 1);
            if i > 0 && j > 0 && a.get(i - 1) == Some(&y) && b.get(j - 1) == Some(&x) {
                cost = cost.min(at(&before, j - 1) + 1);
            }
            row.push(cost);
        }
        before = std::mem::replace(&mut last, row);
    }
    last.last().copied().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_the_reference() {
        assert_eq!((minor_code("ON"), minor_code("OFF"), minor_name(60)), (Some(71), Some(72), Some("CLW")));
        assert_eq!(major_code("TRANS"), Some(1037));
        assert_eq!(reserved("WHILE"), Some(Reserved::Control));
        assert_eq!(reserved("GOTO"), Some(Reserved::Post));
        assert_eq!(reserved("MATCH"), Some(Reserved::Control));
        assert_eq!(record("GOTO"), Some(RecordName { class: 5000, subclass: 5 }));
        assert_eq!(record("COOLNT"), Some(RecordName { class: MAJOR_CLASS, subclass: 1030 }));
        for (name, record) in records() {
            assert!(reserved(name).is_some() && minor_code(name).is_none() && major_code(name).is_none(), "{name}");
            assert_eq!(record_name(*record), Some(*name));
        }
        assert!(needs_percent("ON") && !needs_percent("ZTOP"));
    }

    #[test]
    fn near_misses() {
        assert_eq!(nearest("WHLIE", ["WHEN", "WHILE"]), Some("WHILE"));
        assert_eq!(nearest("$FTOLOWER", ["$FTOLOWR", "$FTOUPER"]), Some("$FTOLOWR"));
        assert_eq!(nearest("XYZZY", ["WHILE"]), None);
    }
}
