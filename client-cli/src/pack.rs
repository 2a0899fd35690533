//! Collects the files of a job: programs and the subprograms beside them.
//!
//! Each file is read and hashed once. Files keep their name inside the job. *Invariant:* the job can read exactly the
//! packed files.

use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use counterpoint_client::Blob;
use counterpoint_proto::v1;

use crate::arguments::Inputs;
use crate::encoding::Encoding;
use crate::error::Error;
use crate::numbered::{Computed, FEW, Numbered};
use crate::standard_input;
use crate::subprograms::{Mentionable, best_of_number, by_number, holds, is_taken_by_name, may_call};

/// The file that makes a folder a machine.
pub(crate) const DEFINITION: &str = "machine.toml";

/// Larger files beside a program are not taken as subprograms.
const NEIGHBOUR_MAX: u64 = 64 << 20;

fn read(path: &Path) -> Result<Blob, Error> {
    Ok(Blob::new(fs::read(path).map_err(Error::file(path))?))
}

/// A file that may be a program, in UTF-8 if it is written in a code page.
fn read_in(path: &Path, encoding: Option<Encoding>) -> Result<Blob, Error> {
    let Some(encoding) = encoding else { return read(path) };
    let bytes = fs::read(path).map_err(Error::file(path))?;
    decoded(path, bytes, Some(encoding))
}

/// The bytes of a program, in UTF-8 if they are written in a code page.
fn decoded(path: &Path, bytes: Vec<u8>, encoding: Option<Encoding>) -> Result<Blob, Error> {
    let Some(encoding) = encoding else { return Ok(Blob::new(bytes)) };
    let text = encoding.decode(&bytes).ok_or_else(|| {
        Error::Usage(format!("'{}' has bytes that are not characters of the code page of --encoding", path.display()))
    })?;
    Ok(Blob::new(text.into_bytes()))
}

/// Files by path inside the job or the machines folder.
#[derive(Debug, Default)]
pub(crate) struct PackedFiles(pub(crate) BTreeMap<String, Blob>);

impl PackedFiles {
    pub(crate) fn add(&mut self, name: String, path: &Path) -> Result<(), Error> {
        self.add_in(name, path, None)
    }

    fn add_in(&mut self, name: String, path: &Path, encoding: Option<Encoding>) -> Result<(), Error> {
        if let Entry::Vacant(place) = self.0.entry(name) {
            place.insert(read_in(path, encoding)?);
        }
        Ok(())
    }

    pub(crate) fn blobs(&self) -> Vec<Blob> {
        self.0.values().cloned().collect()
    }
}

/// Programs and files of a job.
#[derive(Debug, Default)]
pub(crate) struct Pack {
    pub(crate) programs: Vec<v1::Program>,
    pub(crate) files: PackedFiles,
    /// The block that may call any program number, so that all numbered files beside a program were added.
    pub(crate) computed: Option<Computed>,
}

/// A program whose folder may have files that it calls.
struct ProgramFolder {
    folder: PathBuf,
    /// Name of the program's file without its ending.
    stem: String,
    /// Name of the program inside the job.
    name: String,
}

impl ProgramFolder {
    /// Whether the program has the number after P or O, as its calls have, and does not contain the program itself.
    fn may_call(&self, number: u32, files: &PackedFiles) -> bool {
        files.0.get(&self.name).is_some_and(|blob| may_call(blob.content(), number) && !holds(blob.content(), number))
    }
}

/// Gathers the programs and all files they may call.
pub(crate) fn job(inputs: &Inputs) -> Result<Pack, Error> {
    let mut pack = Pack::default();
    let mut used: BTreeMap<PathBuf, String> = BTreeMap::new();
    let mut folders: Vec<ProgramFolder> = Vec::new();
    let piped = piped(inputs)?;
    for text in &inputs.programs {
        let (path, inside) = program(text)?;
        if let (true, Some(name)) = (standard_input::is(&path), &piped) {
            if !pack.files.0.contains_key(name) {
                let blob = decoded(Path::new(name), standard_input::read()?, inputs.files.encoding)?;
                is_program(Path::new(name), blob.content())?;
                pack.files.0.insert(name.clone(), blob);
            }
            pack.programs.push(in_job(name.clone(), inside));
            continue;
        }
        if path.is_dir() {
            let hint = if path.join(DEFINITION).is_file() { " (use --machine for a machine)" } else { "" };
            return Err(Error::Usage(format!("'{}' is a folder: give program files{hint}", path.display())));
        }
        let name = match used.get(&path) {
            Some(name) => name.clone(),
            None => free_name(&pack.files, &path)?,
        };
        pack.files.add_in(name.clone(), &path, inputs.files.encoding)?;
        if let Some(blob) = pack.files.0.get(&name) {
            is_program(&path, blob.content())?;
        }
        used.insert(path.clone(), name.clone());
        pack.programs.push(in_job(name.clone(), inside));
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        folders.push(ProgramFolder { folder: path.parent().map(Path::to_owned).unwrap_or_default(), stem, name });
    }
    for with in &inputs.files.with {
        standard_input::refuse("--with", with)?;
        if with.is_dir() {
            for path in files_of(with)? {
                pack.files.add_in(file_name(&path)?, &path, inputs.files.encoding)?;
            }
        } else {
            pack.files.add_in(file_name(with)?, with, inputs.files.encoding)?;
        }
    }
    for program in folders.iter().filter(|_| !inputs.files.no_neighbours) {
        let computed = neighbours(&mut pack.files, program, inputs.files.encoding)?;
        pack.computed = pack.computed.or(computed);
    }
    Ok(pack)
}

/// Whether a program is standard input.
pub(crate) fn reads_standard_input(programs: &[String]) -> bool {
    programs.iter().any(|text| program(text).is_ok_and(|(path, _)| standard_input::is(&path)))
}

/// The file of standard input inside the job; none if no program is `-`. It must be the first file of its name.
fn piped(inputs: &Inputs) -> Result<Option<String>, Error> {
    let name = inputs.files.name.as_deref();
    let programs = inputs.programs.iter().map(|text| program(text)).collect::<Result<Vec<_>, _>>()?;
    let from_input: Vec<_> = programs.iter().filter(|(path, _)| standard_input::is(path)).collect();
    if from_input.is_empty() {
        return match name {
            Some(_) => {
                Err(Error::Usage("--name names the program from standard input, but no program is -".to_owned()))
            }
            None => Ok(None),
        };
    }
    if from_input.len() > 1 && from_input.iter().any(|(_, inside)| inside.is_none()) {
        let text = "standard input (-) can be read only once: give the other programs as files, or name programs in it \
                    (-- -#2101 -#2102)";
        return Err(Error::Usage(text.to_owned()));
    }
    let name = name.unwrap_or(standard_input::NAME);
    let taken = |path: &Path| !standard_input::is(path) && path.file_name().is_some_and(|file| file == name);
    if programs.iter().any(|(path, _)| taken(path)) {
        return Err(Error::Usage(format!("--name {name}: another program has this name")));
    }
    Ok(Some(name.to_owned()))
}

/// A program of a job.
fn in_job(path: String, inside: Option<Inside>) -> v1::Program {
    let (number, section) = match inside {
        Some(Inside::Number(number)) => (Some(number), None),
        Some(Inside::Name(section)) => (None, Some(section)),
        None => (None, None),
    };
    v1::Program { path, number, section, channel: None }
}

/// A program is text and has at least one block.
fn is_program(path: &Path, content: &[u8]) -> Result<(), Error> {
    const LOOKED_AT: usize = 64 << 10;
    /// The end of a text on some controls.
    const END_OF_FILE: u8 = 26;
    let path = path.display();
    let content = content.trim_ascii_end();
    let content = content.strip_suffix(&[END_OF_FILE]).unwrap_or(content);
    if content.iter().all(u8::is_ascii_whitespace) {
        return Err(Error::Usage(format!("'{path}' is empty: a program needs at least one block")));
    }
    // Tapes start and end with zeros, and files in UTF-16 have many.
    let strange = |byte: &u8| matches!(byte, 1..=8 | 11 | 12 | 14..=31 | 127);
    let head = content.get(..LOOKED_AT).unwrap_or(content);
    let count = head.iter().filter(|byte| strange(byte)).count();
    if count * 20 > head.len() {
        return Err(Error::Usage(format!(
            "'{path}' is not a text file ({count} of {} bytes are control characters): give the NC program itself",
            head.len()
        )));
    }
    Ok(())
}

/// A program inside a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Inside {
    /// By its O-number.
    Number(u32),
    /// By its name, or the mark of a channel's section.
    Name(String),
}

/// `FILE`, `FILE#2102` or `FILE#NAME`; a file whose name has a `#` is taken literally.
pub(crate) fn program(text: &str) -> Result<(PathBuf, Option<Inside>), Error> {
    if let (false, Some((path, name))) = (Path::new(text).is_file(), text.rsplit_once('#')) {
        let number = name.trim_start_matches(['O', 'o']).parse().ok().map(Inside::Number);
        let named = || Inside::Name(name.to_owned());
        if name.is_empty() {
            return Err(Error::Usage(format!("'{text}': a program is missing after '#': FILE#1234 or FILE#NAME")));
        }
        return Ok((PathBuf::from(path), Some(number.unwrap_or_else(named))));
    }
    Ok((PathBuf::from(text), None))
}

pub(crate) fn file_name(path: &Path) -> Result<String, Error> {
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned());
    name.ok_or_else(|| Error::Usage(format!("'{}' is not a file", path.display())))
}

/// The file's name; if another file has the same name, the name is preceded by its folder.
fn free_name(files: &PackedFiles, path: &Path) -> Result<String, Error> {
    let name = file_name(path)?;
    if !files.0.contains_key(&name) {
        return Ok(name);
    }
    let folder = path.parent().and_then(Path::file_name).unwrap_or_default().to_string_lossy();
    (1..100)
        .map(|n| if n == 1 { format!("{folder}/{name}") } else { format!("{folder}-{n}/{name}") })
        .find(|name| !name.starts_with('/') && !files.0.contains_key(name))
        .ok_or_else(|| Error::Usage(format!("too many files are named '{name}'")))
}

pub(crate) fn files_of(folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let entries = fs::read_dir(folder).map_err(Error::file(folder))?;
    let mut paths: Vec<_> = entries.filter_map(|entry| entry.ok().map(|e| e.path())).filter(|p| p.is_file()).collect();
    paths.sort();
    Ok(paths)
}

/// Files of a program number that calls do not get, because another file beside them is the program or because they are
/// copies.
fn other_files_of_numbers(
    paths: &[PathBuf],
    program: &ProgramFolder,
    files: &PackedFiles,
) -> Result<BTreeSet<String>, Error> {
    let names: Vec<String> = paths.iter().map(|path| file_name(path)).collect::<Result<_, _>>()?;
    let mut left_out = BTreeSet::new();
    for (number, mut names) in by_number(names.into_iter()) {
        if names.iter().any(|name| files.0.contains_key(name)) {
            // The user has given this file.
            left_out.extend(names);
            continue;
        }
        match best_of_number(&names, &program.name) {
            Ok(best) => names.retain(|name| best.as_ref() != Some(name)),
            Err(several) if program.may_call(number, files) => {
                return Err(Error::Usage(format!(
                    "'{}' may call O{number}, but {several} beside it have that number: give the right one with --with",
                    program.name
                )));
            }
            Err(_) => {}
        }
        left_out.extend(names);
    }
    Ok(left_out)
}

/// Adds the files beside a program that it may call: those known by their names, and those that the program or an added
/// file mentions. If many files are named by program numbers, only those that may be called are added. Returns the
/// block that computes the number of a call, if there is one.
fn neighbours(
    files: &mut PackedFiles,
    program: &ProgramFolder,
    encoding: Option<Encoding>,
) -> Result<Option<Computed>, Error> {
    let mut paths = BTreeMap::new();
    let mut mentionable = Mentionable::default();
    let (mut unread, mut taken) = (vec![program.name.clone()], Vec::new());
    let listed = files_of(&program.folder)?;
    let left_out = other_files_of_numbers(&listed, program, files)?;
    for path in listed {
        let name = file_name(&path)?;
        if files.0.contains_key(&name) || fs::metadata(&path).map_or(true, |meta| meta.len() > NEIGHBOUR_MAX) {
            continue;
        }
        if left_out.contains(&name) {
            continue;
        }
        if is_taken_by_name(&name, &program.stem) {
            taken.push(name.clone());
        } else {
            mentionable.add(&name);
        }
        paths.insert(name, path);
    }
    let of_numbers = by_number(taken.iter().cloned());
    let mut numbered = Numbered::default();
    if of_numbers.len() > FEW {
        taken.retain(|name| !of_numbers.values().flatten().any(|numbered| numbered == name));
        numbered = Numbered::new(of_numbers);
        taken.extend(numbered.take_of_codes());
        // Files given by the user may call others, too.
        unread.extend(files.0.keys().filter(|name| **name != program.name).cloned());
    }
    loop {
        for name in taken.drain(..) {
            if let Some(path) = paths.remove(&name) {
                files.add_in(name.clone(), &path, encoding)?;
                unread.push(name);
            }
        }
        let Some(name) = unread.pop() else { return Ok(numbered.computed) };
        if let Some(blob) = files.0.get(&name) {
            taken.extend(mentionable.take_mentioned(blob.content()));
            taken.extend(numbered.take_called(&name, blob.content()));
        }
    }
}

#[cfg(test)]
mod tests;
