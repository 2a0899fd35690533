//! Which program runs on which channel.
//!
//! Facts: reference control-emulator.md 8.1 and channel-synchronisation.md 1.2 (files column). A file per channel, or
//! several O-programs in one file: programs that another one of the file calls are subprograms, the others are main
//! programs from left to right; codes of heads or `$n` may divide a file instead (`sections`). Invariant: files are
//! numbered programs first, then the rest by name, so the same job has the same numbers.

use std::sync::{Arc, OnceLock};

use counterpoint_event::{Letters, Text};
use counterpoint_ports::MemoryShares;
use rustc_hash::FxHashSet;

use super::callers::Callers;
use super::mains::mains;
use super::option_checks;
use super::readers::{ProgramReader, Readers};
use super::sections;
use super::shape::ProgramRange;
use super::source::ProgramSource;
use super::sources::Sources;
use super::syntax::Syntax;
use crate::spec::{ProgramSelection, Spec};
use counterpoint_event::info::{FileSection, Info, JobAxis, JobChannel, JobFile};
use counterpoint_machine::Machine;
use counterpoint_machine::finding::Finding;
use counterpoint_machine::length_units::{begins_in_inches, unit_words};
use counterpoint_machine::model::{ProgramTextFormat, RewindStop};
use counterpoint_machine::stored::StoredFile;
use counterpoint_ports::control::StopSignal;
use counterpoint_ports::files::JobFiles;

/// Assigns the programs of a job. When `stop` is requested meanwhile, the result is of no use.
pub fn assign(
    spec: &Spec,
    syntax: impl Fn(&Machine) -> &'static Syntax,
    files: &dyn JobFiles,
    stop: &StopSignal,
) -> Result<(Info, Sources), Vec<Finding>> {
    let mut findings = Vec::new();
    option_checks::check(spec, &mut findings);
    let readers = Readers::of(&spec.machine, syntax);
    let (table, sources) = file_table(spec, &readers, files, stop, &mut findings);
    if spec.programs.is_empty() {
        findings.push(Finding::error("job", 0, 0, "a job needs at least one program"));
    }
    let mut channels = channels(&spec.machine);
    if findings.is_empty() {
        let candidates = candidates(spec, &readers, (&table, &sources), &mut findings);
        place(spec, candidates, &mut channels, &mut findings);
    }
    if findings.iter().any(|f| f.error) {
        return Err(findings);
    }
    let info = Info {
        machine: spec.machine.name.clone(),
        machine_number: spec.machine.number,
        machine_revision: spec.machine.revision,
        machine_created: spec.machine.created.clone(),
        machine_file: spec.machine.file.clone(),
        parameters: spec.options.parameters.trim().to_owned(),
        unit: spec.machine.unit,
        trace: Letters::parse(&spec.options.trace).unwrap_or_default(),
        room: MemoryShares::of_channels(&spec.options.limits, channels.len()).room(),
        channels,
        files: table,
    };
    Ok((info, sources))
}

fn channels(machine: &Machine) -> Vec<JobChannel> {
    machine
        .channels
        .iter()
        .map(|c| JobChannel {
            number: c.number,
            name: c.name.clone(),
            program: String::new(),
            lines: (0, 0),
            file: 0,
            lower: c.lower,
            inch: begins_in_inches(machine.of_channel(c.number)),
            unit_words: unit_words(machine.of_channel(c.number)),
            axes: c
                .axes
                .iter()
                .map(|axis| &machine.axes[*axis])
                .map(|a| JobAxis { name: a.letter.clone(), rotary: a.role.is_rotary(), diameter: a.diameter })
                .collect(),
        })
        .collect()
}

fn text_of(source: &Option<Arc<ProgramSource>>) -> Option<Arc<Text>> {
    source.as_ref().map(|source| Arc::clone(source.text()))
}

/// The stretches of a file that have names: those of its channels, otherwise its programs by name if there are several.
fn sections_of(source: &ProgramSource) -> Vec<FileSection> {
    if !source.sections().is_empty() {
        return source.sections().to_vec();
    }
    let named = source.programs().iter().filter_map(|range| {
        let name = source.name_at(range.first).filter(|_| range.number.is_none())?;
        let name = String::from_utf8_lossy(name).into();
        Some(FileSection { channel: 0, name, lines: (range.first, range.last) })
    });
    if source.programs().len() > 1 { named.collect() } else { Vec::new() }
}

fn file_table(
    spec: &Spec,
    readers: &Readers<'_>,
    files: &dyn JobFiles,
    stop: &StopSignal,
    findings: &mut Vec<Finding>,
) -> (Vec<JobFile>, Sources) {
    let (mut table, mut sources) = (Vec::new(), Sources::new(readers.count()));
    let mut known: FxHashSet<String> = FxHashSet::default();
    let shaped = |name: &str, bytes, reader: usize| {
        let reader = readers.at(reader);
        Arc::new(sections::source(name, bytes, Arc::clone(&reader.shape), stop.clone(), reader.machine))
    };
    let file = |name: String, text, source: Option<&ProgramSource>| JobFile {
        stored: name.starts_with(StoredFile::ROOT),
        resident: false,
        name,
        text,
        sections: source.map_or(Vec::new(), sections_of),
    };
    for (place, program) in spec.programs.iter().enumerate() {
        if stop.asked_once_resumed() || !known.insert(program.file.clone()) {
            continue;
        }
        let source = match files.read(&program.file) {
            Ok(bytes) => Some(shaped(&program.file, bytes, readers.of_program(&spec.programs, place))),
            Err(error) => {
                findings.push(Finding::error(program.file.clone(), 0, 0, error.to_string()));
                None
            }
        };
        table.push(file(program.file.clone(), OnceLock::from(text_of(&source)), source.as_deref()));
        let own = readers.of_program(&spec.programs, place);
        sources.push(|reader| (reader == own || source.is_none()).then(|| source.clone()));
    }
    for name in files.list() {
        if table.len() + spec.machine.storage.len() >= usize::from(u16::MAX) {
            findings.push(Finding::error("job", 0, 0, "a job can have 65534 files at most"));
            break;
        }
        if !known.contains(&name) {
            table.push(file(name, OnceLock::new(), None));
            sources.push(|_| None);
        }
    }
    for stored in &spec.machine.storage {
        let name = format!("{}{}", StoredFile::ROOT, stored.path);
        let source = Some(shaped(&name, stored.content.clone(), 0));
        let own = |reader: usize| match reader {
            0 => source.clone(),
            reader => Some(shaped(&name, stored.content.clone(), reader)),
        };
        sources.push(|reader| Some(own(reader)));
        let file = file(name, OnceLock::from(text_of(&source)), source.as_deref());
        table.push(JobFile { resident: stored.resident, ..file });
    }
    (table, sources)
}

/// One program to be placed.
struct PlacementCandidate<'a> {
    wish: &'a ProgramSelection,
    file: u16,
    range: ProgramRange,
    /// Its name in the file, where the file has several for channels.
    name: Option<String>,
    /// Channel that the file itself says.
    channel: Option<u16>,
}

impl PlacementCandidate<'_> {
    fn error(&self, text: String) -> Finding {
        Finding::error(self.wish.file.clone(), self.range.first, 0, text)
    }
}

fn candidates<'a>(
    spec: &'a Spec,
    readers: &Readers<'_>,
    (table, sources): (&[JobFile], &Sources),
    findings: &mut Vec<Finding>,
) -> Vec<PlacementCandidate<'a>> {
    let mut candidates: Vec<PlacementCandidate<'a>> = Vec::new();
    // One more than fit is enough to say that there are too many.
    for wish in spec.programs.iter().take(spec.machine.channels.len() + 1) {
        let Some(index) = table.iter().position(|f| f.name == wish.file) else { continue };
        let file = index as u16;
        // The first program of a file says who reads it.
        let first = spec.programs.iter().position(|program| program.file == wish.file).unwrap_or(0);
        let reader = readers.of_program(&spec.programs, first);
        let Some(source) = sources.read_by(reader, file) else { continue };
        let ProgramReader { machine, callers, .. } = readers.at(reader);
        let format = &machine.format;
        let is_blank = |n: u32| source.line(n).iter().all(u8::is_ascii_whitespace);
        if source.walk(1, source.lines()).all(is_blank) {
            let text = "the file is empty: a program needs at least one block";
            findings.push(Finding::error(wish.file.clone(), 0, 0, text));
            continue;
        }
        let is_stop = |n: u32| source.line(n).trim_ascii() == format.rws.as_bytes();
        if source.walk(1, source.lines()).all(|n| is_blank(n) || is_stop(n)) {
            let text = format!("the file contains only '{}': a program needs at least one block", format.rws);
            findings.push(Finding::error(wish.file.clone(), 0, 0, text));
            continue;
        }
        if let Some(sections) = in_sections(wish, source, callers) {
            let sections = sections.into_iter().map(|(channel, range)| {
                let seen = source.seen_by(channel);
                let range = opening(seen, range, format);
                PlacementCandidate {
                    wish,
                    file,
                    range,
                    name: Some(section_name(source, channel)),
                    channel: Some(channel),
                }
            });
            candidates.extend(sections);
            continue;
        }
        if let Some(section) = &wish.section
            && wanted(section, source).is_none()
        {
            findings.push(missing_section(wish, section, source));
            continue;
        }
        let ranges = match wish.number {
            None if wish.section.is_some() => {
                wish.section.as_deref().and_then(|name| wanted(name, source)).into_iter().collect()
            }
            Some(number) => match named(number, source, callers) {
                Some(range) => vec![range],
                None => {
                    findings.push(missing_number(wish, number, source));
                    continue;
                }
            },
            None if spec.programs.len() == 1 => mains(source, callers),
            None => {
                let free = |r: &&ProgramRange| {
                    !candidates.iter().any(|t| t.file == file && t.range.number == r.number && t.range.last == r.last)
                };
                let mains = mains(source, callers);
                mains.iter().find(free).or_else(|| source.programs().first()).copied().into_iter().collect()
            }
        };
        let several = (ranges.len() > 1 || wish.section.is_some()) && spec.machine.channels.len() > 1;
        for range in ranges {
            let name = source.name_at(range.first).filter(|_| several && range.number.is_none());
            let name = name.map(|name| String::from_utf8_lossy(name).into_owned());
            let range = opening(source, range, format);
            candidates.push(PlacementCandidate { wish, file, range, name, channel: None });
        }
    }
    candidates
}

/// The name of the first section of a channel.
fn section_name(source: &ProgramSource, channel: u16) -> String {
    let first = source.sections().iter().find(|section| section.channel == channel);
    first.map_or(String::new(), |section| section.name.to_string())
}

/// The programs of channels in a file with sections that a request selects: channel and main program, as that channel
/// sees the file.
fn in_sections(
    wish: &ProgramSelection,
    source: &Arc<ProgramSource>,
    callers: &Callers,
) -> Option<Vec<(u16, ProgramRange)>> {
    let mut found = channel_mains(source, callers)?;
    if let Some(number) = wish.number {
        let of_number =
            |channel: u16| Some((channel, trimmed(source, channel, named(number, source.seen_by(channel), callers)?)));
        let owner = source.programs().iter().find(|range| range.number == Some(number)).map(|range| range.first);
        let owner = source.sections().iter().find(|section| owner.is_some_and(|line| within(section, line)));
        found = match owner {
            Some(section) => of_number(section.channel).into_iter().collect(),
            None => found.into_iter().filter_map(|(channel, _)| of_number(channel)).collect(),
        };
    }
    if let Some(name) = &wish.section {
        let named = |section: &&FileSection| section.channel > 0 && section.name.eq_ignore_ascii_case(name);
        let owner = source.sections().iter().find(named).map(|section| section.channel);
        found.retain(|(channel, _)| Some(*channel) == owner);
    }
    if let Some(wanted) = wish.channel {
        found.retain(|(channel, _)| *channel == wanted);
    }
    (!found.is_empty()).then_some(found)
}

fn within(section: &FileSection, line: u32) -> bool {
    (section.lines.0..=section.lines.1).contains(&line)
}

/// The main programs of a file that has sections, by channel; each as its channel sees the file.
fn channel_mains(source: &Arc<ProgramSource>, callers: &Callers) -> Option<Vec<(u16, ProgramRange)>> {
    let mut channels: Vec<u16> = source.sections().iter().map(|section| section.channel).filter(|&c| c > 0).collect();
    channels.sort_unstable();
    channels.dedup();
    let main = |channel: u16| {
        let seen = source.seen_by(channel);
        Some((channel, trimmed(source, channel, mains(seen, callers).first().copied()?)))
    };
    (!channels.is_empty()).then(|| channels.into_iter().filter_map(main).collect())
}

/// A program of a channel ends with the last of its stretches there; that of a head other than the first begins with
/// one.
fn trimmed(source: &ProgramSource, channel: u16, range: ProgramRange) -> ProgramRange {
    let own = || {
        let overlap = |section: &&FileSection| section.lines.0 <= range.last && section.lines.1 >= range.first;
        source.sections().iter().filter(|section| section.channel == channel).filter(overlap)
    };
    let (Some(first), Some(last)) = (own().next(), own().next_back()) else { return range };
    let starts = first.name.starts_with('$') || source.sections().first() == Some(first);
    ProgramRange {
        first: if starts { range.first } else { first.lines.0.max(range.first) },
        last: last.lines.1.min(range.last),
        ..range
    }
}

fn place(
    spec: &Spec,
    candidates: Vec<PlacementCandidate<'_>>,
    channels: &mut [JobChannel],
    findings: &mut Vec<Finding>,
) {
    let machine = &spec.machine.name;
    let count = channels.len();
    for candidate in candidates {
        let slot = match candidate.wish.channel.or(candidate.channel) {
            Some(number) => match channels.iter_mut().find(|c| c.number == number) {
                Some(channel) if channel.program.is_empty() => Some(channel),
                Some(_) => {
                    findings.push(candidate.error(format!("channel {number} already has a program")));
                    continue;
                }
                None => {
                    findings.push(candidate.error(format!("the machine {machine} has no channel {number}")));
                    continue;
                }
            },
            None => channels.iter_mut().find(|c| c.program.is_empty()),
        };
        match slot {
            Some(channel) => {
                channel.file = candidate.file;
                channel.lines = (candidate.range.first, candidate.range.last);
                let file = &candidate.wish.file;
                channel.program = match (candidate.range.number, candidate.name) {
                    (Some(number), _) => format!("{file}#{number}"),
                    (None, Some(name)) if !name.is_empty() => format!("{file}#{name}"),
                    (None, _) => file.clone(),
                };
            }
            // Further programs of a single file stay callable; more files than channels are a mistake, and so are
            // further main programs of a machine whose channels share a file.
            None if spec.programs.len() == 1 && count == 1 => {}
            None if spec.programs.len() == 1 => {
                let name = match (candidate.range.number, &candidate.name) {
                    (Some(number), _) => format!("O{number:04}"),
                    (None, Some(name)) => name.clone(),
                    (None, None) => "this program".to_owned(),
                };
                let file = &candidate.wish.file;
                let text = format!(
                    "{name} is one more main program than machine {machine} has channels ({count}): name those that run, \
                     each as {file}#NUMBER, or end it with M99 if it is a subprogram"
                );
                findings.push(candidate.error(text));
            }
            None => {
                let plural = if count == 1 { "" } else { "s" };
                let text = format!(
                    "machine {machine} has {count} channel{plural}, but the job has more programs: name at most one for \
                     each channel, or run each as a job of its own"
                );
                findings.push(candidate.error(text));
            }
        }
    }
}

/// The program of a number, with the text before it that it begins with.
fn named(number: u32, source: &ProgramSource, callers: &Callers) -> Option<ProgramRange> {
    let is = |range: &&ProgramRange| range.number == Some(number);
    mains(source, callers).iter().find(is).or_else(|| source.programs().iter().find(is)).copied()
}

/// The program that has a name, as an archive or the control writes it.
fn wanted(name: &str, source: &ProgramSource) -> Option<ProgramRange> {
    let plain = name.trim_start_matches('%');
    let plain = plain
        .get(..3)
        .filter(|start| start.eq_ignore_ascii_case("_N_"))
        .map_or(plain, |_| plain.get(3..).unwrap_or_default());
    let ending =
        |text: &str| [".MPF", ".SPF", "_MPF", "_SPF"].iter().any(|end| text.to_ascii_uppercase().ends_with(end));
    let stem = plain.get(..plain.len().saturating_sub(4)).filter(|_| ending(plain));
    source.named(name).or_else(|| source.named(plain)).or_else(|| source.named(stem?))
}

fn missing_section(wish: &ProgramSelection, name: &str, source: &ProgramSource) -> Finding {
    let mut known: Vec<String> = source.sections().iter().map(|section| section.name.to_string()).collect();
    known.extend(source.programs().iter().filter_map(|range| match range.number {
        Some(number) => Some(format!("O{number:04}")),
        None => Some(String::from_utf8_lossy(source.name_at(range.first)?).into_owned()),
    }));
    let mut seen = FxHashSet::default();
    known.retain(|name| seen.insert(name.clone()));
    known.truncate(20);
    let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
    let name = name.escape_debug();
    Finding::error(
        wish.file.clone(),
        0,
        0,
        format!("program or section {name} not found in the file, which has {known}"),
    )
}

fn missing_number(wish: &ProgramSelection, number: u32, source: &ProgramSource) -> Finding {
    let known: Vec<String> = source.programs().iter().filter_map(|r| r.number).map(|n| format!("O{n:04}")).collect();
    let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
    Finding::error(wish.file.clone(), 0, 0, format!("program O{number:04} not found in the file, which has {known}"))
}

/// The main program of a file that a channel runs when it is given the file.
pub fn first_main(source: &Arc<ProgramSource>, machine: &Machine, channel: u16) -> Option<ProgramRange> {
    let callers = Callers::of(machine, source.syntax());
    let own = channel_mains(source, &callers).and_then(|mains| mains.into_iter().find(|(of, _)| *of == channel));
    own.map_or_else(|| mains(source, &callers).first().copied(), |(_, range)| Some(range))
}

/// Main programs of a file from a line on, in the order of the channels; none in place of one that ends before it.
pub fn from_line(source: &Arc<ProgramSource>, line: u32, machine: &Machine) -> Vec<Option<ProgramRange>> {
    let callers = Callers::of(machine, source.syntax());
    let ranges: Vec<Option<ProgramRange>> = match channel_mains(source, &callers) {
        Some(found) => {
            let of = |number| found.iter().find(|(channel, _)| *channel == number).map(|(_, range)| *range);
            machine.channels.iter().map(|channel| of(channel.number)).collect()
        }
        None => mains(source, &callers).into_iter().map(Some).collect(),
    };
    let opened =
        ranges.into_iter().zip(machine.channels.iter().map(|channel| channel.number).chain(std::iter::repeat(0)));
    let opened = opened.map(|(range, channel)| Some(opening(source.seen_by(channel), range?, &machine.format)));
    opened
        .map(|range| range.filter(|range| range.last >= line).map(|r| ProgramRange { first: r.first.max(line), ..r }))
        .collect()
}

/// The first program of a file begins at the rewind-stop before it, or at the comments before it, so that the listing
/// shows those lines. Where a rewind-stop is expected before the program, one that stands only at the end leaves
/// nothing to do (reference control-emulator.md 5.1).
pub fn opening(source: &ProgramSource, range: ProgramRange, format: &ProgramTextFormat) -> ProgramRange {
    let is_stop = |n: &u32| format.is_rewind_stop(source.line(*n));
    let is_blank = |n: u32| source.line(n).iter().all(u8::is_ascii_whitespace);
    let expected = format.rws_at == RewindStop::Start;
    let first_program = source.programs().first().is_some_and(|r| r.first == range.first);
    let first = if source.is_plain(range) && source.programs().len() < 2 {
        // A text without definition word begins at its first rewind-stop, if that is not its end.
        source
            .walk(range.first, range.last)
            .find(is_stop)
            .filter(|line| expected || source.walk(line + 1, range.last).any(|n| !is_blank(n)))
    } else if first_program {
        let before = source.walk(1, range.first.saturating_sub(1));
        before.clone().rev().find(is_stop).or_else(|| before.clone().find(|&n| !is_blank(n)))
    } else {
        None
    };
    first.map_or(range, |line| ProgramRange { first: line, ..range })
}
