//! Files of the control: where subprograms are, and files of definitions.
//!
//! Facts: reference control-emulator.md 5.4, 5.7, functions.md 9. `_N_NAME_SPF` is `name.spf`. Order: files beside the
//! program that calls, beside the main program, below the root folder, stored with the machine, in folders of the
//! control's names; then the programs of the calling file and of the main file (`%_N_NAME_SPF`). Invariant: letter case
//! never counts, and of several files the first by its number is taken.

use super::block_text::bare;
use super::cursor::SiemensCursor;
use super::item::SiemensItem;
use super::line::{head, read};
use super::{Outcome, Siemens, SiemensBlockError};
use counterpoint_control_api::host::{InterpreterHost, ProgramHost};
use counterpoint_event::FileId;
use counterpoint_fault as diag;
use counterpoint_machine::stored::StoredFile;
use counterpoint_program::shape::ProgramRange;

/// Folders of the control in which subprograms are searched for, in this order.
const FOLDERS: [&str; 5] = ["spf.dir", "cus.dir", "cma.dir", "cst.dir", "sub.dir"];

/// A name of the control as a name of a file: `_N_A_SPF` is `a.spf`.
fn file_name(name: &str) -> String {
    let name = name.to_ascii_lowercase();
    let Some(inner) = name.strip_prefix("_n_") else { return name };
    match inner.rsplit_once('_') {
        Some((stem, extension)) if extension.len() == 3 => format!("{stem}.{extension}"),
        _ => inner.to_owned(),
    }
}

/// A path of the control as a path of files.
pub(super) fn file_path(path: &str) -> String {
    let path = path.replace('\\', "/");
    path.split('/').filter(|part| !part.is_empty()).map(file_name).collect::<Vec<_>>().join("/")
}

/// Name of a program of an archive, after its `%`: without `_N_` and without extension.
pub(super) fn program_name(name: &str) -> String {
    let name = file_name(name.split([' ', '\t', ';', '(']).next().unwrap_or_default());
    let stem = ["spf", "mpf"].iter().find_map(|extension| name.strip_suffix(&format!(".{extension}")));
    stem.unwrap_or(&name).to_ascii_uppercase()
}

fn split(path: &str) -> (&str, &str) {
    path.rsplit_once('/').unwrap_or(("", path))
}

impl Siemens {
    /// A subprogram by its name, found once for each file that calls.
    pub(super) fn program(
        &mut self,
        host: &mut dyn ProgramHost,
        name: &str,
    ) -> Outcome<Option<(FileId, ProgramRange)>> {
        let key = (host.place().file, name.to_owned());
        if let Some(found) = self.found.get(&key) {
            return Ok(*found);
        }
        let found = match self.program_file(host, name) {
            Some(file) => self.in_file(host, file, name, true)?,
            None => None,
        };
        let found = match found {
            Some(found) => Some(found),
            None => match self.in_file(host, key.0, name, false)? {
                Some(found) => Some(found),
                None => {
                    let main = host.main_file();
                    self.in_file(host, main, name, false)?
                }
            },
        };
        self.found.insert(key, found);
        Ok(found)
    }

    /// A subprogram by a path of the control.
    pub(super) fn program_by_path(
        &mut self,
        host: &mut dyn ProgramHost,
        path: &str,
    ) -> Outcome<Option<(FileId, ProgramRange)>> {
        let wanted = file_path(path);
        let (folder, name) = split(&wanted);
        let stem = name.rsplit_once('.').map_or(name, |(stem, _)| stem).to_ascii_uppercase();
        if folder.is_empty() && !name.contains('.') {
            let found = self.program(host, &stem)?;
            let plain = ["_SPF", "_MPF"].iter().find_map(|kind| stem.strip_suffix(kind));
            return match (found, plain) {
                (None, Some(plain)) => self.program(host, plain),
                _ => Ok(found),
            };
        }
        match self.by_path(host, &wanted) {
            Some(file) => self.in_file(host, file, &stem, true),
            None => self.program(host, &stem),
        }
    }

    /// A file that ends with a path.
    fn by_path(&self, host: &dyn ProgramHost, wanted: &str) -> Option<FileId> {
        let root = file_path(&self.settings.root);
        let names = [wanted.to_owned(), format!("{wanted}.spf"), format!("{wanted}.mpf")];
        let rank = |file: &String| {
            let path = file_path(file.strip_prefix(StoredFile::ROOT).unwrap_or(file));
            let whole = |name: &String| path == *name || (!root.is_empty() && path == format!("{root}/{name}"));
            let behind = |name: &String| path.ends_with(&format!("/{name}"));
            let at = names.iter().position(whole);
            at.or_else(|| names.iter().position(behind).map(|at| at + names.len()))
        };
        best(host, rank)
    }

    /// The control has such a file.
    pub(super) fn has_file(&mut self, host: &mut dyn InterpreterHost, path: &str) -> Outcome<bool> {
        let written = self.has_record(host, path)?;
        Ok(written.unwrap_or_else(|| self.file_by_path(host, path).is_some()))
    }

    /// A file by a path of the control.
    pub(super) fn file_by_path(&self, host: &dyn InterpreterHost, path: &str) -> Option<FileId> {
        self.by_path(host, &file_path(path))
    }

    fn program_file(&self, host: &dyn ProgramHost, name: &str) -> Option<FileId> {
        let wanted = name.to_ascii_lowercase();
        let files = host.files();
        let folder_of =
            |file: FileId| files.get(usize::from(file)).map_or(String::new(), |path| split(path).0.to_owned());
        let here = folder_of(host.place().file);
        let main = folder_of(host.main_file());
        let root = file_path(&self.settings.root);
        let rank = |path: &String| {
            let (folder, name) = split(path);
            let name = file_name(name);
            let extension = match name.strip_prefix(&wanted)? {
                ".spf" => 0,
                ".mpf" => 1,
                _ => return None,
            };
            let place = file_path(folder);
            let known = FOLDERS.iter().position(|known| place == *known || place.ends_with(&format!("/{known}")));
            let folder = if folder == here {
                0
            } else if folder == main {
                1
            } else if !root.is_empty() && (place == root || place.starts_with(&format!("{root}/"))) {
                2 + known.map_or(FOLDERS.len(), |at| at)
            } else if path.starts_with(StoredFile::ROOT) {
                20
            } else {
                30 + known?
            };
            Some(folder * 2 + extension)
        };
        best(host, rank)
    }

    /// A program in a file; with `whole` the file itself, where it has no program of that name.
    fn in_file(
        &mut self,
        host: &mut dyn ProgramHost,
        file: FileId,
        name: &str,
        whole: bool,
    ) -> Outcome<Option<(FileId, ProgramRange)>> {
        host.load(file)?;
        let places = self.places(host, file);
        let range = |first, last| Some((file, ProgramRange { number: None, first, last }));
        if let Some((_, first, last)) = places.programs.iter().find(|(program, ..)| program == name) {
            return Ok(range(*first, *last));
        }
        let lines = host.source(file).map_or(0, |source| source.lines());
        let last = places.programs.get(1).map_or(lines, |(_, first, _)| first.saturating_sub(1));
        Ok(if whole && lines > 0 { range(1, last) } else { None })
    }

    /// Reads the definition files that a macro has requested.
    pub(super) fn definition_files(&mut self, host: &mut dyn InterpreterHost) -> Outcome<()> {
        let asked = std::mem::take(&mut self.settings.definitions);
        if asked.is_empty() {
            return Ok(());
        }
        // Most jobs have no such file, and each program asks.
        let is_definition = |file: &String| file.to_ascii_lowercase().ends_with("def");
        let has = asked.iter().any(|(_, reports)| *reports) || host.files().iter().any(is_definition);
        for (name, reports) in asked.into_iter().filter(|_| has) {
            let path = file_path(&name);
            let dotted = path.rsplit_once('_').map_or(path.clone(), |(stem, extension)| format!("{stem}.{extension}"));
            let found = [dotted, path].iter().find_map(|path| self.by_path(host, path));
            match found {
                Some(file) => self.definition_file(host, file)?,
                None if reports => {
                    let text = format!("definition file {name} not found");
                    host.diagnose(&diag::SIEMENS_FILE, text);
                }
                None => {}
            }
        }
        Ok(())
    }

    /// Definitions of the channel and of the control; other lines of the file are ignored. A line that cannot be
    /// executed is reported with its place, and the lines after it count.
    fn definition_file(&mut self, host: &mut dyn InterpreterHost, file: FileId) -> Outcome<()> {
        host.load(file)?;
        let Some(source) = host.source(file) else { return Ok(()) };
        let before = std::mem::replace(&mut self.settings.global, true);
        let mut done = Ok(());
        for line in source.walk(1, source.lines()) {
            let text = String::from_utf8_lossy(source.line(line)).into_owned();
            let mut cursor = SiemensCursor::new(bare(&text));
            head(&mut cursor);
            let word = cursor.peeked_name().unwrap_or_default().to_ascii_uppercase();
            if !matches!(word.as_str(), "DEF" | "REDEF" | "DEFINE") {
                continue;
            }
            // Macros of files before it count.
            let text = self.expanded(cursor.rest());
            done = match read(&text) {
                Ok(line) => line.items.iter().try_for_each(|item| self.definition(host, item)),
                Err(text) => super::syntax(text),
            };
            match done {
                Err(SiemensBlockError::Alarm(_, why)) => {
                    let text = format!("{why}: '{}' in line {line} of {} is left out", text.trim(), source.name);
                    host.diagnose(&diag::SIEMENS_DEFINITION_LINE, text);
                    done = Ok(());
                }
                Err(SiemensBlockError::Halt(_)) => break,
                Ok(()) => {}
            }
        }
        self.settings.global = before;
        self.watch(host);
        done
    }

    fn definition(&mut self, host: &mut dyn InterpreterHost, item: &SiemensItem) -> Outcome<()> {
        match item {
            SiemensItem::Declare(declaration) => self.declare(host, declaration, false),
            SiemensItem::Redeclare(declaration) => self.declare(host, declaration, true),
            SiemensItem::Define(name, text) => {
                self.define(name, text);
                Ok(())
            }
            _ => Ok(()),
        }
    }
}

/// The file with the lowest rank, the first of several.
fn best(host: &dyn ProgramHost, rank: impl Fn(&String) -> Option<usize>) -> Option<FileId> {
    let files = host.files();
    let ranked = files.iter().enumerate().filter_map(|(at, file)| Some((rank(file)?, at)));
    ranked.min().and_then(|(_, at)| FileId::try_from(at).ok())
}
