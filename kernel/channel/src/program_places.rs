//! Where programs and parts of programs are in their files.
//!
//! Facts: reference control-emulator.md 5.4, 5.7. *Invariant:* labels of a file are read once.

use std::sync::Arc;

use counterpoint_event::event::FileId;
use counterpoint_machine::ident::{codes, data};
use counterpoint_machine::index::RegisterId;
use counterpoint_machine::number::written;
use counterpoint_machine::stored::StoredFile;
use counterpoint_program::block::Block;
use counterpoint_program::scan::ScanResult;
use counterpoint_program::shape::ProgramRange;

use crate::callee::{Callee, Labels};
use crate::channel_context::ChannelContext;
use crate::flow::ProgramFlow;

/// The blocks of a range in the current file.
pub fn find_range(channel: &ChannelContext<'_>, flow: &mut ProgramFlow, what: &Callee) -> Option<ProgramRange> {
    let sources = channel.env.sources;
    let source = sources.get(channel.at.file)?;
    // A range is called by whole lines.
    let numbered = |number| {
        let blocks = source.sequences(number).iter();
        blocks.filter(|block| block.offset == 0).map(|block| block.line).collect::<Vec<u32>>()
    };
    let (from, to) = match *what {
        Callee::Program(_) | Callee::ProgramFrom(..) | Callee::Named(_) => return None,
        Callee::Blocks(first, last) => (numbered(first), numbered(last)),
        Callee::From(first) => {
            let start = numbered(first).first().copied()?;
            let programs = source.programs().iter();
            let last = programs.filter(|range| range.last >= start).map(|range| range.last).next();
            return Some(ProgramRange { number: None, first: start, last: last.unwrap_or(source.lines()) });
        }
        Callee::Labels(first, last) => {
            let labels = labels_of_file(channel, flow);
            let lines = |label| labels.get(&label).cloned().unwrap_or_default();
            (lines(first), lines(last))
        }
    };
    let start = from.first().copied()?;
    let end = *to.get(to.partition_point(|&line| line < start))?;
    Some(ProgramRange { number: None, first: start, last: end })
}

/// Labels of the current file, found once. A block with a word for a label has it, unless it calls a range.
fn labels_of_file(channel: &ChannelContext<'_>, flow: &mut ProgramFlow) -> Arc<Labels> {
    if let Some(labels) = flow.known.labels.get(&channel.at.file) {
        return Arc::clone(labels);
    }
    let mut labels = Labels::default();
    let scanner = &channel.tables.scanner;
    let sources = channel.tables.sources_of(data::LABEL);
    let mut block = Block::default();
    if let Some(source) = channel.env.sources.get(channel.at.file).filter(|_| !sources.is_empty()) {
        for line in source.walk(1, source.lines()) {
            let is_plain = scanner.scan_as(source.line(line), false, &mut block, scanner.has_preprocessor());
            if is_plain != ScanResult::Words || calls_range(channel, &block) {
                continue;
            }
            let word = |of: RegisterId| block.words.iter().find(|word| word.register == of).map(|word| word.value);
            let label = sources.iter().find_map(|s| word(s.register).map(|value| value * s.mul + s.add));
            if let Some(label) = label.filter(|v| *v >= 0.0 && v.fract() == 0.0 && *v <= f64::from(u32::MAX)) {
                labels.entry(label as u32).or_default().push(line);
            }
        }
    }
    flow.known.tables += labels.len() * 64;
    let labels = Arc::new(labels);
    flow.known.labels.insert(channel.at.file, Arc::clone(&labels));
    labels
}

/// Whether a code of the block calls a range.
fn calls_range(channel: &ChannelContext<'_>, block: &Block) -> bool {
    let words = block.words.iter().flat_map(|word| channel.env.machine.tables.code(word.register, word.value));
    words.chain(&block.texts).any(|&row| channel.env.machine.codes[row].id == codes::CALSUB_RANGE)
}

/// Files stored with the machine that are named after the program: the definition word, four digits or more, or the
/// name.
pub fn stored_files(channel: &ChannelContext<'_>, what: &Callee) -> Vec<String> {
    if channel.env.machine.storage.is_empty() {
        return Vec::new();
    }
    let definition = channel.tables.registers.definition.map(|register| &channel.env.machine.registers[register]);
    let mut wanted = names(what);
    if let (Some(register), &Callee::Program(number)) = (definition, what) {
        wanted.insert(
            0,
            format!("{}{}{}", register.before, written(f64::from(number), &register.format), register.after),
        );
    }
    let is_root = |path: &str| !path.contains('/');
    let stem = |path: &str| path.rsplit_once('.').map_or(path, |(stem, _)| stem).to_owned();
    let fits = |path: &str| wanted.iter().any(|w| w.eq_ignore_ascii_case(path) || w.eq_ignore_ascii_case(&stem(path)));
    let files = channel.env.machine.storage.iter().filter(|file| is_root(&file.path) && fits(&file.path));
    files.map(|file| format!("{}{}", StoredFile::ROOT, file.path)).collect()
}

/// Files beside the main program that are named after the program.
pub fn files_beside(channel: &ChannelContext<'_>, flow: &ProgramFlow, what: &Callee) -> Vec<String> {
    let (folder, _) = main_program(channel, flow);
    let wanted = names(what);
    let mut out = Vec::new();
    for file in &channel.env.info.files {
        let Some(rest) = file.name.strip_prefix(&folder) else { continue };
        let stem = rest.rsplit_once('.').map_or(rest, |(s, _)| s);
        if wanted.iter().any(|w| w.eq_ignore_ascii_case(stem) || w.eq_ignore_ascii_case(rest)) {
            out.push(file.name.clone());
        }
    }
    out
}

/// Folder of the main program with its slash, and its name without extension.
pub fn main_program(channel: &ChannelContext<'_>, flow: &ProgramFlow) -> (String, String) {
    let main = flow.frames.first().map_or("", |f| channel.env.info.file_name(f.file));
    let (folder, name) = main.rsplit_once('/').map_or(("", main), |(f, n)| (f, n));
    let stem = name.rsplit_once('.').map_or(name, |(s, _)| s);
    let folder = if folder.is_empty() { String::new() } else { format!("{folder}/") };
    (folder, stem.to_owned())
}

/// Names of files that hold a program alone.
pub fn names(what: &Callee) -> Vec<String> {
    match what {
        Callee::Program(n) | Callee::ProgramFrom(n, _) => {
            vec![format!("O{n:04}"), format!("O{n}"), format!("{n:04}"), n.to_string()]
        }
        Callee::Named(name) => vec![name.to_string()],
        Callee::Blocks(..) | Callee::Labels(..) | Callee::From(_) => Vec::new(),
    }
}

/// The blocks of a program from a line with a sequence number on.
pub fn begun_at(channel: &ChannelContext<'_>, file: FileId, range: ProgramRange, number: u32) -> Option<ProgramRange> {
    let mut blocks = channel.env.sources.get(file)?.sequences(number).iter();
    let inside = |line: u32| (range.first..=range.last).contains(&line);
    let first = blocks.find(|block| block.offset == 0 && inside(block.line))?.line;
    Some(ProgramRange { first, ..range })
}

/// The part of a file that a call requests.
pub fn in_file(channel: &ChannelContext<'_>, file: FileId, what: &Callee) -> Option<ProgramRange> {
    let source = channel.env.sources.get(file)?;
    match what {
        Callee::Named(name) => source.named(name),
        Callee::Program(number) => source.programs().iter().find(|r| r.number == Some(*number)).copied(),
        Callee::ProgramFrom(..) | Callee::Blocks(..) | Callee::Labels(..) | Callee::From(_) => None,
    }
}
