//! Packs the folder of a machine: its files, the machines that it extends, and the components of a composite.
//!
//! *Invariant:* only the folder and the folders beside it that definitions name are packed.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use crate::error::Error;
use crate::pack::{DEFINITION, PackedFiles, file_name, files_of};

/// Whether a machine argument means a folder.
pub(crate) fn is_folder(machine: &str) -> bool {
    Path::new(machine).join(DEFINITION).is_file() || is_definition(Path::new(machine))
}

/// Whether a machine argument is the definition in a folder, which then stands for the folder.
fn is_definition(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name == DEFINITION) && path.is_file()
}

/// Packs a machine folder and the folders beside it that it needs; returns the name of the machine, too.
pub(crate) fn machine(folder: &Path) -> Result<(String, PackedFiles), Error> {
    let folder = fs::canonicalize(folder).map_err(Error::file(folder))?;
    let folder = if is_definition(&folder) { folder.parent().map(Path::to_owned).unwrap_or_default() } else { folder };
    let name = file_name(&folder)?;
    let mut files = PackedFiles::default();
    let mut seen: BTreeSet<String> = BTreeSet::new();
    let mut left: Vec<(String, PathBuf)> = vec![(name.clone(), folder)];
    while let Some((name, folder)) = left.pop() {
        let definition = folder.join(DEFINITION);
        if !seen.insert(name.clone()) || !definition.is_file() {
            continue;
        }
        let root = fs::canonicalize(&folder).map_err(Error::file(&folder))?;
        if !stays_in(&root, &definition) {
            continue;
        }
        whole_folder(&mut files, &root, &folder, &name, 0)?;
        let inside = format!("{name}/");
        let definitions = files.0.iter().filter(|(path, _)| is_own_definition(path, &inside));
        let texts: Vec<String> =
            definitions.map(|(_, blob)| String::from_utf8_lossy(blob.content()).into_owned()).collect();
        let others = texts.iter().flat_map(|text| named(text)).filter(|name| is_plain(name));
        left.extend(others.filter_map(|other| Some((other.clone(), folder.parent()?.join(other)))));
    }
    Ok((name, files))
}

/// Whether a path is the definition of a machine, or of a component in its folder.
fn is_own_definition(path: &str, inside: &str) -> bool {
    path.strip_prefix(inside)
        .is_some_and(|rest| rest == DEFINITION || rest.split_once('/').is_some_and(|(_, file)| file == DEFINITION))
}

/// The machines that a definition names: the one that it extends, and those of its components.
fn named(text: &str) -> Vec<String> {
    let table = toml::from_str::<toml::Table>(text).unwrap_or_default();
    let rows = table.get("components").and_then(toml::Value::as_array).into_iter().flatten();
    let components = rows.filter_map(|row| Some(row.get("machine")?.as_str()?.to_owned()));
    extends(text).into_iter().chain(components).collect()
}

/// The machine that a definition extends. Only the lines before the first table are read if they are valid TOML alone.
fn extends(text: &str) -> Option<String> {
    let first_table =
        text.split_inclusive('\n').take_while(|line| !line.trim_start().starts_with('[')).map(str::len).sum();
    let read = |text| toml::from_str::<toml::Table>(text).ok();
    let table = text.get(..first_table).and_then(read).or_else(|| read(text))?;
    table.get("extends")?.as_str().map(str::to_owned)
}

/// Whether a name is a plain folder name, without a path.
fn is_plain(name: &str) -> bool {
    let mut parts = Path::new(name).components();
    matches!((parts.next(), parts.next()), (Some(std::path::Component::Normal(_)), None))
}

/// Whether a file is in a folder, even if links are followed.
fn stays_in(root: &Path, path: &Path) -> bool {
    fs::canonicalize(path).is_ok_and(|path| path.starts_with(root))
}

/// Adds a folder and its subfolders. Hidden entries, links to folders and links to files outside `root` are skipped.
fn whole_folder(files: &mut PackedFiles, root: &Path, folder: &Path, name: &str, depth: usize) -> Result<(), Error> {
    const DEEPEST: usize = 8;
    for path in files_of(folder)? {
        let file = file_name(&path)?;
        if !file.starts_with('.') && stays_in(root, &path) {
            files.add(format!("{name}/{file}"), &path)?;
        }
    }
    let entries = fs::read_dir(folder).map_err(Error::file(folder))?;
    let folders = entries.filter_map(Result::ok).filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_dir()));
    let mut folders: Vec<_> = folders.map(|entry| entry.path()).collect();
    folders.sort();
    for path in folders {
        let inner = file_name(&path)?;
        if !inner.starts_with('.') && depth < DEEPEST {
            whole_folder(files, root, &path, &format!("{name}/{inner}"), depth + 1)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
