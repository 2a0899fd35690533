//! Where a called program or range of blocks is looked for.
//!
//! Facts: reference control-emulator.md 5.7. Order: the place that the machine names, then the files stored with the
//! machine, then (this project's choice) other places. These are files beside the program that are named after the
//! number, and all files of the job that define a program of the number.

use std::sync::Arc;

use counterpoint_event::event::FileId;
use counterpoint_fault::Halt;
use counterpoint_lang::value::MacroValue;
use counterpoint_machine::ident::{codes, data};
use counterpoint_machine::index::RegisterId;
use counterpoint_machine::model::Placement;
use counterpoint_machine::number::written;
use counterpoint_machine::stored::StoredFile;
use counterpoint_program::block::Block;
use counterpoint_program::layout::opening;
use counterpoint_program::scan::ScanResult;
use counterpoint_program::shape::ProgramRange;

use super::Kernel;
use counterpoint_channel::callee::{Callee, Labels};
use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::macros::store;

/// A place to look in. The names of files are made when their turn comes.
#[derive(Debug, Clone, Copy)]
enum SearchLocation {
    /// The file of the program that calls, by definition word.
    Current,
    /// The file of the main program, by definition word.
    Main,
    /// Files stored with the machine, from their top.
    Stored,
    /// The file of all subprograms: by definition word, otherwise a file without definitions as a whole.
    One,
    /// The file of this subprogram alone, likewise.
    Each,
    /// The file of this subprogram alone, from its top.
    EachFromTop,
    /// Files beside the main program, as the file of all.
    Beside,
    /// All files of the job, by definition word: the memory of a control has them all.
    Memory,
}

impl SearchLocation {
    /// The order of a machine.
    fn order(placement: Placement) -> [Self; 7] {
        match placement {
            Placement::SameFile => {
                [Self::Current, Self::Main, Self::Stored, Self::One, Self::Each, Self::Beside, Self::Memory]
            }
            Placement::OneFile => {
                [Self::One, Self::Stored, Self::Current, Self::Main, Self::Each, Self::Beside, Self::Memory]
            }
            Placement::FileEach => {
                [Self::EachFromTop, Self::Stored, Self::Current, Self::Main, Self::One, Self::Beside, Self::Memory]
            }
        }
    }
}

impl Kernel<'_> {
    /// Looks a program up; one that was called by number before is known, unless macros say where programs are.
    pub fn find_program(&mut self, what: &Callee) -> Result<Option<(FileId, ProgramRange)>, Halt> {
        if let Callee::ProgramFrom(number, first) = *what {
            let whole = self.find_program(&Callee::Program(number))?;
            return Ok(whole.and_then(|(file, range)| Some((file, begun_at(&self.channel, file, range, first)?))));
        }
        let Callee::Program(number) = *what else { return self.look_for_program(what) };
        let [Some(main), Some(caller)] = [self.flow.frames.first(), self.flow.frames.last()] else {
            return self.look_for_program(what);
        };
        let wanted = (number, caller.file, main.file);
        if self.plan.hooks.is_some() {
            return self.look_for_program(what);
        }
        if let Some(found) = self.flow.known.programs.get(wanted) {
            return Ok(Some(found));
        }
        let found = self.look_for_program(what)?;
        if let Some(found) = found {
            self.flow.known.programs.keep(wanted, found);
        }
        Ok(found)
    }

    /// Looks for a program in all places.
    fn look_for_program(&mut self, what: &Callee) -> Result<Option<(FileId, ProgramRange)>, Halt> {
        self.work(self.channel.env.info.files.len())?;
        for look in SearchLocation::order(self.channel.env.machine.subprograms.placement) {
            let found = match look {
                SearchLocation::Current => self.defined_in(self.flow.frames.last().map(|frame| frame.file), what)?,
                SearchLocation::Main => self.defined_in(self.flow.frames.first().map(|frame| frame.file), what)?,
                SearchLocation::Stored => self.first_of(self.stored(what), what, true)?,
                SearchLocation::One => self.named(&self.subprogram_files(what).1, what, false)?,
                SearchLocation::Each => self.named(&self.subprogram_files(what).0, what, false)?,
                SearchLocation::EachFromTop => self.named(&self.subprogram_files(what).0, what, true)?,
                SearchLocation::Beside => self.first_of(self.beside(what), what, false)?,
                SearchLocation::Memory => self.in_memory(what)?,
            };
            if found.is_some() {
                return Ok(found);
            }
        }
        Ok(None)
    }

    /// By definition word in a file that is loaded.
    fn defined_in(&mut self, file: Option<FileId>, what: &Callee) -> Result<Option<(FileId, ProgramRange)>, Halt> {
        let Some(file) = file else { return Ok(None) };
        let searched = self.channel.env.sources.get(file).map_or(0, |source| source.programs().len());
        self.work(searched / 16)?;
        Ok(in_file(&self.channel, file, what).map(|range| (file, range)))
    }

    /// The first file of the job that defines a program of this number.
    fn in_memory(&mut self, what: &Callee) -> Result<Option<(FileId, ProgramRange)>, Halt> {
        if !matches!(what, Callee::Program(_)) || self.channel.tables.registers.definition.is_none() {
            return Ok(None);
        }
        for file in 0..self.channel.env.info.files.len() as FileId {
            self.load(file)?;
            if let Some(found) = self.defined_in(Some(file), what)? {
                return Ok(Some(found));
            }
        }
        Ok(None)
    }

    /// The first of these files that has the program.
    fn first_of(
        &mut self,
        files: Vec<String>,
        what: &Callee,
        from_top: bool,
    ) -> Result<Option<(FileId, ProgramRange)>, Halt> {
        for name in files {
            if let Some(found) = self.named(&name, what, from_top)? {
                return Ok(Some(found));
            }
        }
        Ok(None)
    }

    /// The blocks of a range in the current file.
    pub fn find_range(&mut self, what: &Callee) -> Option<ProgramRange> {
        let sources = self.channel.env.sources;
        let source = sources.get(self.channel.at.file)?;
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
                let labels = self.labels();
                let lines = |label| labels.get(&label).cloned().unwrap_or_default();
                (lines(first), lines(last))
            }
        };
        let start = from.first().copied()?;
        let end = *to.get(to.partition_point(|&line| line < start))?;
        Some(ProgramRange { number: None, first: start, last: end })
    }

    /// Labels of the current file, found once. A block with a word for a label has it, unless it calls a range.
    fn labels(&mut self) -> Arc<Labels> {
        if let Some(labels) = self.flow.known.labels.get(&self.channel.at.file) {
            return Arc::clone(labels);
        }
        let mut labels = Labels::default();
        let scanner = &self.channel.tables.scanner;
        let sources = self.channel.tables.sources_of(data::LABEL);
        let mut block = Block::default();
        if let Some(source) = self.channel.env.sources.get(self.channel.at.file).filter(|_| !sources.is_empty()) {
            for line in source.walk(1, source.lines()) {
                let is_plain = scanner.scan_as(source.line(line), false, &mut block, scanner.has_preprocessor());
                if is_plain != ScanResult::Words || self.calls_range(&block) {
                    continue;
                }
                let word = |of: RegisterId| block.words.iter().find(|word| word.register == of).map(|word| word.value);
                let label = sources.iter().find_map(|s| word(s.register).map(|value| value * s.mul + s.add));
                if let Some(label) = label.filter(|v| *v >= 0.0 && v.fract() == 0.0 && *v <= f64::from(u32::MAX)) {
                    labels.entry(label as u32).or_default().push(line);
                }
            }
        }
        self.flow.known.tables += labels.len() * 64;
        let labels = Arc::new(labels);
        self.flow.known.labels.insert(self.channel.at.file, Arc::clone(&labels));
        labels
    }

    /// Whether a code of the block calls a range.
    fn calls_range(&self, block: &Block) -> bool {
        let words = block.words.iter().flat_map(|word| self.channel.env.machine.tables.code(word.register, word.value));
        words.chain(&block.texts).any(|&row| self.channel.env.machine.codes[row].id == codes::CALSUB_RANGE)
    }

    /// A program of a file by name; `whole` takes the file from its top, regardless of its definitions.
    fn named(&mut self, name: &str, what: &Callee, whole: bool) -> Result<Option<(FileId, ProgramRange)>, Halt> {
        let Some(file) = self.channel.env.info.files.iter().position(|f| f.name.eq_ignore_ascii_case(name)) else {
            return Ok(None);
        };
        let file = file as FileId;
        self.load(file)?;
        if let Some(range) = in_file(&self.channel, file, what) {
            return Ok(Some((file, range)));
        }
        let sources = self.channel.env.sources;
        let Some(source) = sources.get(file).filter(|s| s.lines() > 0) else { return Ok(None) };
        let plain = source.programs().first().copied().filter(|&range| source.is_plain(range));
        let all = match plain {
            // Text before definitions is a program: that after which the file is named.
            Some(range) if !whole => range,
            None if !whole => return Ok(None),
            _ => ProgramRange { number: None, first: 1, last: source.lines() },
        };
        let mut range = opening(source, all, &self.channel.env.machine.format);
        if self.channel.env.machine.format.is_rewind_stop(source.line(range.first)) {
            range.first += 1;
        }
        Ok(Some((file, range)))
    }

    /// Folder of the main program with its slash, and its name without extension.
    fn main_program(&self) -> (String, String) {
        let main = self.flow.frames.first().map_or("", |f| self.channel.env.info.file_name(f.file));
        let (folder, name) = main.rsplit_once('/').map_or(("", main), |(f, n)| (f, n));
        let stem = name.rsplit_once('.').map_or(name, |(s, _)| s);
        let folder = if folder.is_empty() { String::new() } else { format!("{folder}/") };
        (folder, stem.to_owned())
    }

    /// The file of this subprogram alone, and the file of all of them.
    fn subprogram_files(&self, what: &Callee) -> (String, String) {
        let (folder, stem) = self.main_program();
        let extension = match self.plan.hooks.map(|_| self.macros.variables.store.get(store::names().extension)) {
            Some(MacroValue::Text(set)) => set.trim().trim_start_matches('.'),
            _ => self.channel.env.machine.subprograms.extension.as_str(),
        };
        let id = match what {
            Callee::Named(name) => name.to_string(),
            Callee::Program(number) | Callee::ProgramFrom(number, _) => number.to_string(),
            Callee::Blocks(..) | Callee::Labels(..) | Callee::From(_) => String::new(),
        };
        (format!("{folder}{stem}_{id}.{extension}"), format!("{folder}{stem}.{extension}"))
    }

    /// The file of the machine's placement where something missing was looked for.
    pub fn looked_for(&self, what: &Callee) -> String {
        let main =
            || self.flow.frames.first().map_or("", |frame| self.channel.env.info.file_name(frame.file)).to_owned();
        let (each, one) = self.subprogram_files(what);
        match (what, self.channel.env.machine.subprograms.placement) {
            (Callee::Blocks(..) | Callee::Labels(..) | Callee::From(_), _) => {
                self.channel.env.info.file_name(self.channel.at.file).to_owned()
            }
            (_, Placement::SameFile) => main(),
            (_, Placement::OneFile) => one,
            (_, Placement::FileEach) => each,
        }
    }

    /// Files stored with the machine that are named after the program: the definition word, four digits or more, or the
    /// name.
    fn stored(&self, what: &Callee) -> Vec<String> {
        if self.channel.env.machine.storage.is_empty() {
            return Vec::new();
        }
        let definition =
            self.channel.tables.registers.definition.map(|register| &self.channel.env.machine.registers[register]);
        let mut wanted = names(what);
        if let (Some(register), &Callee::Program(number)) = (definition, what) {
            wanted.insert(
                0,
                format!("{}{}{}", register.before, written(f64::from(number), &register.format), register.after),
            );
        }
        let is_root = |path: &str| !path.contains('/');
        let stem = |path: &str| path.rsplit_once('.').map_or(path, |(stem, _)| stem).to_owned();
        let fits =
            |path: &str| wanted.iter().any(|w| w.eq_ignore_ascii_case(path) || w.eq_ignore_ascii_case(&stem(path)));
        let files = self.channel.env.machine.storage.iter().filter(|file| is_root(&file.path) && fits(&file.path));
        files.map(|file| format!("{}{}", StoredFile::ROOT, file.path)).collect()
    }

    /// Files beside the main program that are named after the program.
    fn beside(&self, what: &Callee) -> Vec<String> {
        let (folder, _) = self.main_program();
        let wanted = names(what);
        let mut out = Vec::new();
        for file in &self.channel.env.info.files {
            let Some(rest) = file.name.strip_prefix(&folder) else { continue };
            let stem = rest.rsplit_once('.').map_or(rest, |(s, _)| s);
            if wanted.iter().any(|w| w.eq_ignore_ascii_case(stem) || w.eq_ignore_ascii_case(rest)) {
                out.push(file.name.clone());
            }
        }
        out
    }

    /// Where a missing program was looked for.
    pub(crate) fn places(&self, what: &Callee) -> String {
        let (each, one) = self.subprogram_files(what);
        let first = match self.channel.env.machine.subprograms.placement {
            Placement::FileEach => format!("{each}, {one}"),
            Placement::SameFile | Placement::OneFile => format!("{one}, {each}"),
        };
        let stored =
            if self.channel.env.machine.storage.is_empty() { "" } else { ", the files stored with the machine" };
        let named = names(what).into_iter().next().unwrap_or_default();
        format!(
            "looked in the program's file, {first}{stored}, files named {named} and definitions in all files of the job"
        )
    }
}

/// Names of files that hold a program alone.
fn names(what: &Callee) -> Vec<String> {
    match what {
        Callee::Program(n) | Callee::ProgramFrom(n, _) => {
            vec![format!("O{n:04}"), format!("O{n}"), format!("{n:04}"), n.to_string()]
        }
        Callee::Named(name) => vec![name.to_string()],
        Callee::Blocks(..) | Callee::Labels(..) | Callee::From(_) => Vec::new(),
    }
}

/// The blocks of a program from a line with a sequence number on.
fn begun_at(channel: &ChannelContext<'_>, file: FileId, range: ProgramRange, number: u32) -> Option<ProgramRange> {
    let mut blocks = channel.env.sources.get(file)?.sequences(number).iter();
    let inside = |line: u32| (range.first..=range.last).contains(&line);
    let first = blocks.find(|block| block.offset == 0 && inside(block.line))?.line;
    Some(ProgramRange { first, ..range })
}

fn in_file(channel: &ChannelContext<'_>, file: FileId, what: &Callee) -> Option<ProgramRange> {
    let source = channel.env.sources.get(file)?;
    match what {
        Callee::Named(name) => source.named(name),
        Callee::Program(number) => source.programs().iter().find(|r| r.number == Some(*number)).copied(),
        Callee::ProgramFrom(..) | Callee::Blocks(..) | Callee::Labels(..) | Callee::From(_) => None,
    }
}
