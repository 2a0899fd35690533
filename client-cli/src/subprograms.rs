//! Files beside a program that it may call: by their names, or because a taken file mentions them.
//!
//! *Invariant:* the files taken depend on the names in the folder and on the texts of the taken files only.

use std::collections::{BTreeMap, BTreeSet};

/// Endings of program files that calls name without the ending: `L20`, `CALL PGM SUB`, `CALL OSUB`, `o<name> call`.
const CALLED_WITHOUT_ENDING: [&str; 7] = ["spf", "mpf", "h", "i", "sub", "ssb", "ngc"];

/// Ending of libraries, which hold programs of any name.
const LIBRARY: &str = "lib";

/// Whether a file is taken without being mentioned: `O` and digits with any ending, `<stem>.tps`, `<stem>_*.tps`, and
/// libraries.
pub(crate) fn is_taken_by_name(name: &str, stem: &str) -> bool {
    let o_number = name.strip_prefix(['O', 'o']).is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit()));
    let own = || name.strip_suffix(".tps").and_then(|rest| rest.strip_prefix(stem));
    let library = || name.rsplit_once('.').is_some_and(|(_, ending)| ending.eq_ignore_ascii_case(LIBRARY));
    o_number || own().is_some_and(|rest| rest.is_empty() || rest.starts_with('_')) || library()
}

/// Endings of copies that editors and users keep beside a file.
const COPIES: [&str; 8] = ["bak", "old", "orig", "tmp", "sav", "save", "copy", "swp"];

/// The number and the ending of a file named by `O` and digits.
fn number_and_ending(name: &str) -> Option<(u32, String)> {
    let (stem, ending) = name.split_once('.').unwrap_or((name, ""));
    let digits = stem.strip_prefix(['O', 'o'])?;
    let digits = digits.get(..digits.bytes().take_while(u8::is_ascii_digit).count())?;
    Some((digits.parse().ok()?, ending.to_ascii_lowercase()))
}

/// Of several files of one program number, the file that calls get: the one with the ending of the calling program,
/// never a copy. `Err` names the files if several remain.
pub(crate) fn best_of_number(names: &[String], program: &str) -> Result<Option<String>, String> {
    let own = program.rsplit_once('.').map_or_else(String::new, |(_, ending)| ending.to_ascii_lowercase());
    let ending = |name: &str| number_and_ending(name).map(|(_, ending)| ending).unwrap_or_default();
    let like = names.iter().filter(|name| ending(name) == own).collect::<Vec<_>>();
    let plain = || names.iter().filter(|name| !is_copy(&ending(name))).collect::<Vec<_>>();
    match if like.is_empty() { plain() } else { like }.as_slice() {
        [] => Ok(None),
        [name] => Ok(Some((*name).clone())),
        several => Err(several.iter().map(|name| format!("'{name}'")).collect::<Vec<_>>().join(" and ")),
    }
}

/// Whether a text has a number after P or O: `M98 P0100`, `CALL O100`, or as the last four digits after a repeat count:
/// `M98 P30100`.
pub(crate) fn may_call(text: &[u8], number: u32) -> bool {
    memchr::memchr3_iter(b'P', b'O', b'p', text).chain(memchr::memchr_iter(b'o', text)).any(|at| {
        let rest = text.get(at + 1..).unwrap_or_default();
        let digits = rest.get(..rest.iter().take_while(|byte| byte.is_ascii_digit()).count()).unwrap_or_default();
        let is_number = |digits: &[u8]| std::str::from_utf8(digits).is_ok_and(|digits| digits.parse() == Ok(number));
        is_number(digits) || after_count(digits).is_some_and(is_number)
    })
}

/// The last four of more than four digits: some controls put a repeat count before the number (`P0051234`).
pub(crate) fn after_count(digits: &[u8]) -> Option<&[u8]> {
    digits.len().checked_sub(4).filter(|&at| at > 0).and_then(|at| digits.get(at..))
}

/// Whether a program with this number begins on a line of a text: `O0100` or `:100`.
pub(crate) fn holds(text: &[u8], number: u32) -> bool {
    text.split(|byte| matches!(byte, b'\n' | b'\r')).any(|line| {
        let Some((b'O' | b'o' | b':', rest)) = line.trim_ascii_start().split_first() else { return false };
        let digits = rest.get(..rest.iter().take_while(|byte| byte.is_ascii_digit()).count()).unwrap_or_default();
        std::str::from_utf8(digits).is_ok_and(|digits| digits.parse() == Ok(number))
    })
}

fn is_copy(ending: &str) -> bool {
    let last = ending.rsplit('.').next().unwrap_or_default();
    COPIES.contains(&last) || last.ends_with('~')
}

/// Files named by a program number, grouped by that number.
pub(crate) fn by_number(names: impl Iterator<Item = String>) -> BTreeMap<u32, Vec<String>> {
    let mut numbered: BTreeMap<u32, Vec<String>> = BTreeMap::new();
    for name in names {
        if let Some((number, _)) = number_and_ending(&name) {
            numbered.entry(number).or_default().push(name);
        }
    }
    numbered
}

/// Files of a folder that texts may mention, by the lowercase words that mention them.
#[derive(Debug, Default)]
pub(crate) struct Mentionable {
    /// By whole names.
    names: BTreeMap<Vec<u8>, BTreeSet<String>>,
    /// By names without the ending.
    stems: BTreeMap<Vec<u8>, BTreeSet<String>>,
}

impl Mentionable {
    /// Adds a file of the folder: its whole name mentions it, and for program files the name without the ending.
    pub(crate) fn add(&mut self, name: &str) {
        let Some((stem, ending)) = name.rsplit_once('.') else { return };
        let add = |words: &mut BTreeMap<Vec<u8>, BTreeSet<String>>, word: &str| {
            let word = word.to_ascii_lowercase().into_bytes();
            words.entry(word).or_default().insert(name.to_owned());
        };
        add(&mut self.names, name);
        if CALLED_WITHOUT_ENDING.iter().any(|known| ending.eq_ignore_ascii_case(known)) {
            add(&mut self.stems, stem);
        }
        // Calls of LinuxCNC have a letter before the number: `o100 call`, `M98 P100`.
        if ending.eq_ignore_ascii_case("ngc") && stem.bytes().all(|byte| byte.is_ascii_digit()) {
            add(&mut self.stems, &format!("o{stem}"));
            add(&mut self.stems, &format!("p{stem}"));
        }
    }

    /// Takes out the files that a text mentions.
    pub(crate) fn take_mentioned(&mut self, text: &[u8]) -> BTreeSet<String> {
        let mut mentioned = BTreeSet::new();
        if self.names.is_empty() {
            return mentioned;
        }
        let text = text.to_ascii_lowercase();
        self.take_names(&text, &mut mentioned);
        if !self.stems.is_empty() {
            self.take_stems(&text, &mut mentioned);
        }
        mentioned
    }

    /// Looks at words around the endings only: most words of a program are numbers.
    fn take_names(&mut self, text: &[u8], mentioned: &mut BTreeSet<String>) {
        let ending =
            |name: &Vec<u8>| name.iter().rposition(|byte| *byte == b'.').map(|at| name.split_at(at).1.to_vec());
        let endings: BTreeSet<Vec<u8>> = self.names.keys().filter_map(ending).collect();
        for ending in endings {
            for at in memchr::memmem::find_iter(text, &ending) {
                let (before, after) = text.split_at(at);
                let begin = before.iter().rposition(|byte| !is_part(*byte)).map_or(0, |at| at + 1);
                let end = at + after.iter().position(|byte| !is_part(*byte)).unwrap_or(after.len());
                if let Some(names) = text.get(begin..end).and_then(|word| self.names.remove(word)) {
                    mentioned.extend(names);
                }
            }
        }
    }

    fn take_stems(&mut self, text: &[u8], mentioned: &mut BTreeSet<String>) {
        let firsts = self.stems.keys().filter_map(|stem| stem.first().copied());
        // Names of a Siemens archive begin with `_N_`.
        let firsts: Vec<u8> = firsts.chain([b'_']).collect();
        let mut begins = [false; 256];
        for (byte, begins) in (0..=u8::MAX).zip(&mut begins) {
            *begins = firsts.contains(&byte);
        }
        let may_begin = |word: &[u8]| word.first().is_some_and(|byte| begins.get(usize::from(*byte)) == Some(&true));
        for word in text.split(|byte| !is_part(*byte)).filter(|word| may_begin(word)) {
            let without_ending = word.iter().position(|&byte| byte == b'.').and_then(|at| word.get(..at));
            for word in [Some(word), without_ending, archive_name(word)].into_iter().flatten() {
                mentioned.extend(self.stems.remove(word).unwrap_or_default());
            }
        }
    }
}

/// The name of a program in the form of an archive: `part` of `_n_part_mpf`.
fn archive_name(word: &[u8]) -> Option<&[u8]> {
    let name = word.strip_prefix(b"_n_")?;
    name.strip_suffix(b"_mpf").or_else(|| name.strip_suffix(b"_spf"))
}

/// Whether a byte is part of a name.
fn is_part(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'-' | b'$' | b'.' | 128..)
}

#[cfg(test)]
mod tests;
