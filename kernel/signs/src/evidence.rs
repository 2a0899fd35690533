//! Looks for the signs of all machines in the programs of a job, in one walk through the text.
//!
//! *Invariant:* a sign is found at most once, at its first place; the order of the machines does not matter.

use std::collections::BTreeMap;

use bytes::Bytes;
use counterpoint_event::Text;

use super::block::StrippedBlock;
use super::pattern::{PatternTerm, SignPattern};
use super::prose::LineCounts;

/// Signs named in an answer.
const NAMED: usize = 3;

/// Maximum number of bytes searched in a program, and in all programs of a job.
const SEARCHED_IN_PROGRAM: usize = 4 << 20;
const SEARCHED_IN_JOB: usize = 16 << 20;

/// Number of bytes searched in each program of a job that has this number of programs.
#[must_use]
pub fn searched_bytes(programs: usize) -> usize {
    SEARCHED_IN_PROGRAM.min(SEARCHED_IN_JOB / programs.max(1))
}

/// Number of lines searched between two checks for a stop.
const LINES_BETWEEN_STOPS: u32 = 256;

/// A program of a job.
#[derive(Debug, Clone)]
pub struct ExaminedProgram {
    /// Name of its file.
    pub name: String,
    /// The file.
    pub content: Bytes,
    /// Number of the program in the file, if only that one is meant.
    pub number: Option<u32>,
    /// One program or section of the file is meant.
    pub part: bool,
}

/// The lowest M code of three or more digits that all programs have outside round brackets.
pub(crate) fn common_m_code(programs: &[ExaminedProgram]) -> Option<u32> {
    let mut all = programs.iter().map(|program| m_codes(&program.content));
    let mut common = all.next()?;
    for other in all {
        common.retain(|code| other.contains(code));
    }
    common.into_iter().min()
}

fn m_codes(text: &[u8]) -> Vec<u32> {
    let (mut found, mut inside, mut before) = (Vec::new(), false, b' ');
    for (at, &byte) in text.iter().enumerate() {
        match byte {
            b'(' => inside = true,
            b')' | b'\n' => inside = false,
            b'M' | b'm' if !inside && !before.is_ascii_alphabetic() => {
                let rest = text.get(at + 1..).unwrap_or_default();
                let digits = rest.iter().take_while(|byte| byte.is_ascii_digit()).count();
                let number =
                    rest.get(..digits).and_then(|digits| std::str::from_utf8(digits).ok()?.parse::<u32>().ok());
                found.extend(number.filter(|number| (3..=8).contains(&digits) && *number >= 100));
            }
            _ => {}
        }
        before = byte;
    }
    found
}

/// Where a sign was found first.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct SignOccurrence {
    /// How the program shows it.
    pub(crate) text: String,
    /// Number of the program.
    program: usize,
    /// Line, 0 for the name of the file.
    line: u32,
}

/// A sign that the programs show.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FoundSign<'e> {
    /// Its pattern.
    pub(crate) pattern: &'e str,
    /// Its weight.
    pub(crate) weight: u32,
    found: &'e SignOccurrence,
}

impl FoundSign<'_> {
    /// Whether the name of the file shows the sign, not its text.
    pub(crate) fn is_name(&self) -> bool {
        self.found.line == 0
    }
}

/// The signs found in the programs.
#[derive(Debug, Default)]
pub(crate) struct Evidence {
    found: BTreeMap<String, SignOccurrence>,
    /// Names of the files.
    names: Vec<String>,
    /// O-programs in the only file.
    pub(crate) definitions: usize,
    /// Main programs of an archive in the only file.
    pub(crate) mains: usize,
    /// Lines that are blocks, and others.
    pub(crate) lines: LineCounts,
}

impl Evidence {
    /// Looks for patterns in programs.
    pub(crate) fn of(
        programs: &[ExaminedProgram],
        patterns: &[&SignPattern],
        stop: &dyn Fn() -> bool,
    ) -> Result<Self, String> {
        let mut search = SignSearch::new(patterns);
        let mut evidence = Self { names: programs.iter().map(|one| one.name.clone()).collect(), ..Self::default() };
        for (index, program) in programs.iter().enumerate() {
            search.name(index, &program.name);
            let content = program.content.slice(..program.content.len().min(searched_bytes(programs.len())));
            let text = Text::new(content, || false);
            let mut current = None;
            for line in 1..=text.lines() {
                if line % LINES_BETWEEN_STOPS == 0 && stop() {
                    return Err("the search for signs was stopped".to_owned());
                }
                let bytes = text.line(line);
                current = definition(bytes).or(current);
                evidence.definitions += usize::from(definition(bytes).is_some());
                evidence.mains += usize::from(is_main(bytes));
                if program.number.is_none() || current.is_none() || program.number == current {
                    let block = StrippedBlock::of(&String::from_utf8_lossy(bytes));
                    evidence.lines.count(&block.line);
                    search.block(&block, (index, line));
                }
            }
        }
        evidence.found = search.into_found();
        Ok(evidence)
    }

    /// The rows of tables that the programs show, each pattern once with its highest weight.
    pub(crate) fn shown<'e>(&'e self, rows: impl IntoIterator<Item = &'e (SignPattern, u32)>) -> Vec<FoundSign<'e>> {
        let mut all: BTreeMap<&str, FoundSign<'e>> = BTreeMap::new();
        for (pattern, weight) in rows {
            let Some(found) = self.found.get(pattern.text()).filter(|_| *weight > 0) else { continue };
            let shown = FoundSign { pattern: pattern.text(), weight: *weight, found };
            let known = all.entry(pattern.text()).or_insert(shown);
            known.weight = known.weight.max(*weight);
        }
        let mut all: Vec<_> = all.into_values().collect();
        all.sort_by_key(|shown| Self::order(shown.found));
        all
    }

    /// The heaviest signs with their places; signs of equal weight in the order of their places.
    pub(crate) fn named(&self, shown: &[FoundSign<'_>]) -> String {
        let mut shown: Vec<_> = shown.iter().collect();
        shown.sort_by_key(|one| (std::cmp::Reverse(one.weight), Self::order(one.found)));
        let mut texts: Vec<String> = Vec::new();
        for text in shown.into_iter().map(|one| self.place(one.found)) {
            if !texts.contains(&text) && texts.len() < NAMED {
                texts.push(text);
            }
        }
        texts.join(", ")
    }

    /// A sign with its place.
    fn place(&self, found: &SignOccurrence) -> String {
        let name = self.names.get(found.program).map_or("", String::as_str);
        match found.line {
            0 => format!("{} ({name})", found.text),
            line if self.names.len() > 1 => format!("{} ({name} line {line})", found.text),
            line => format!("{} (line {line})", found.text),
        }
    }

    /// Order of places.
    fn order(found: &SignOccurrence) -> (usize, u32) {
        (found.program, found.line)
    }
}

/// Whether a program of that number is defined in a file.
#[must_use]
pub fn has_program(content: &Bytes, number: u32) -> bool {
    let text = Text::new(content.clone(), || false);
    (1..=text.lines()).any(|line| definition(text.line(line)) == Some(number))
}

/// The number of the program that a line defines.
fn definition(line: &[u8]) -> Option<u32> {
    let [b'O' | b'o' | b':', rest @ ..] = line.trim_ascii_start() else { return None };
    let digits = rest.iter().take_while(|b| b.is_ascii_digit());
    let (count, number) = digits.fold((0, 0_u32), |(count, number), digit| {
        (count + 1, number.saturating_mul(10).saturating_add(u32::from(digit - b'0')))
    });
    (count > 0).then_some(number)
}

/// Whether a line is the head of a main program in an archive of a Siemens control. In a job archive, whose heads have
/// a channel and a number, those with the number 0 are (`%_N_1_0_MPF`).
fn is_main(line: &[u8]) -> bool {
    let line = line.trim_ascii().to_ascii_uppercase();
    let name = line.strip_prefix(b"%_N_").and_then(|rest| rest.strip_suffix(b"_MPF"));
    let digits = |text: &[u8]| !text.is_empty() && text.iter().all(u8::is_ascii_digit);
    name.is_some_and(|name| match name.iter().position(|byte| *byte == b'_').and_then(|at| name.split_at_checked(at)) {
        Some((channel, [b'_', number @ ..])) if digits(channel) && digits(number) => number.iter().all(|b| *b == b'0'),
        _ => true,
    })
}

/// A sign that is looked for.
struct Sought<'p> {
    pattern: &'p SignPattern,
    /// First places of its parts, as far as they are found.
    parts: Vec<Option<SignOccurrence>>,
    /// Whether a word was found that must not be in any block.
    refuted: bool,
}

struct SignSearch<'p> {
    sought: Vec<Sought<'p>>,
    ends: u32,
}

impl<'p> SignSearch<'p> {
    fn new(patterns: &[&'p SignPattern]) -> Self {
        let mut known = BTreeMap::new();
        for pattern in patterns {
            let sought = || Sought { pattern, parts: vec![None; pattern.parts.len()], refuted: false };
            known.entry(pattern.text()).or_insert_with(sought);
        }
        Self { sought: known.into_values().collect(), ends: 0 }
    }

    fn name(&mut self, program: usize, name: &str) {
        self.ends = 0;
        let Some((_, ending)) = name.rsplit_once('.') else { return };
        let small = format!(".{}", ending.to_ascii_lowercase());
        for sought in &mut self.sought {
            for (part, found) in sought.pattern.parts.iter().zip(&mut sought.parts) {
                if matches!(part, PatternTerm::File(of) if *of == small) && found.is_none() {
                    *found = Some(SignOccurrence { text: format!("the file ending .{ending}"), program, line: 0 });
                }
            }
        }
    }

    fn block(&mut self, block: &StrippedBlock, (program, line): (usize, u32)) {
        self.ends += u32::from(block.ends);
        if block.line.is_empty() && !block.remark {
            return;
        }
        for sought in self.sought.iter_mut().filter(|sought| !sought.refuted) {
            sought.refuted = sought.pattern.nowhere.iter().any(|no| no.is_in(block));
            for (part, found) in sought.pattern.parts.iter().zip(&mut sought.parts) {
                if found.is_none() {
                    *found = part.in_block(block, self.ends).map(|text| SignOccurrence { text, program, line });
                }
            }
        }
    }

    /// The signs of which every part was found; each where its last part is.
    fn into_found(self) -> BTreeMap<String, SignOccurrence> {
        let one = |sought: Sought<'p>| {
            let parts: Vec<SignOccurrence> = sought.parts.into_iter().collect::<Option<_>>()?;
            let last = parts.iter().max_by_key(|found| Evidence::order(found))?.clone();
            let text = parts.into_iter().map(|found| found.text).collect::<Vec<_>>().join(" and ");
            Some((sought.pattern.text().to_owned(), SignOccurrence { text, ..last })).filter(|_| !sought.refuted)
        };
        self.sought.into_iter().filter_map(one).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_programs_of_a_job_have_a_bounded_share_and_a_stop_ends_the_search() {
        assert_eq!([1, 4, 16, 64].map(searched_bytes), [4 << 20, 4 << 20, 1 << 20, 256 << 10]);
        let content = Bytes::from("G1 X1\n".repeat(2 * LINES_BETWEEN_STOPS as usize));
        let program = ExaminedProgram { name: "a.nc".into(), content, number: None, part: false };
        let looks = std::cell::Cell::new(0);
        let stop = || looks.replace(looks.get() + 1) == 1;
        assert!(Evidence::of(std::slice::from_ref(&program), &[], &stop).is_err());
        assert_eq!(looks.get(), 2);
        assert!(Evidence::of(&[program], &[], &|| false).is_ok());
    }
}
