//! Search for a called program or range of blocks.
//!
//! Facts: reference control-emulator.md 5.7. Order: the place that the machine names, then the files stored with the
//! machine, then (this project's choice) other places. These are files beside the program that are named after the
//! number, and all files of the job that define a program of the number.

use counterpoint_channel::callee::Callee;
use counterpoint_channel::macros::store;
use counterpoint_channel::program_places::{begun_at, files_beside, in_file, main_program, names, stored_files};
use counterpoint_event::event::FileId;
use counterpoint_fault::Halt;
use counterpoint_lang::value::MacroValue;
use counterpoint_machine::model::Placement;
use counterpoint_program::layout::opening;
use counterpoint_program::shape::ProgramRange;

use super::Kernel;

/// A place to search. The names of files are made when their turn comes.
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
                SearchLocation::Stored => self.first_of(stored_files(&self.channel, what), what, true)?,
                SearchLocation::One => self.named(&self.subprogram_files(what).1, what, false)?,
                SearchLocation::Each => self.named(&self.subprogram_files(what).0, what, false)?,
                SearchLocation::EachFromTop => self.named(&self.subprogram_files(what).0, what, true)?,
                SearchLocation::Beside => self.first_of(files_beside(&self.channel, &self.flow, what), what, false)?,
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

    /// The file of this subprogram alone, and the file of all of them.
    fn subprogram_files(&self, what: &Callee) -> (String, String) {
        let (folder, stem) = main_program(&self.channel, &self.flow);
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

    /// The file of the machine's placement in which something missing was searched.
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

    /// Places of the search for a missing program.
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
