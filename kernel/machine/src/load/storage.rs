//! `files`: the folder beside the machine file whose content programs and macros reach as `//ICAMFS/…`.
//!
//! Invariant: paths are unique regardless of letter case, sorted, and use `/`. Facts: reference control-emulator.md
//! 7.1.

use crate::package;
use crate::stored::StoredFile;
use crate::toml::section::TableReader;
use counterpoint_ports::files::JobFiles;

/// Most files.
const MOST: usize = 1000;

/// Most bytes of all files together.
const BYTES: usize = 64 << 20;

/// Reads the folder that `files` names, in the folder of the file that says so.
pub(super) fn read(top: &mut TableReader<'_>, files: &dyn JobFiles) -> Vec<StoredFile> {
    let Some(name) = top.name("files", 64) else { return Vec::new() };
    let name = name.trim_end_matches('/');
    if name.starts_with(['/', '.']) || name.contains(['\\', ':']) || name.split('/').any(|part| part.is_empty()) {
        top.error(
            "files",
            format!("`files` must be a folder beside the machine file, not \"{}\"", name.escape_debug()),
        );
        return Vec::new();
    }
    let file = top.place_of("files").file.clone();
    let folder = file.rsplit_once('/').map_or("", |(folder, _)| folder);
    let prefix = format!("{folder}/{name}/");
    let mut stored: Vec<StoredFile> = Vec::new();
    let mut size = 0;
    for path in files.list() {
        let Some(inside) = path.strip_prefix(&prefix).filter(|inside| !inside.is_empty()) else { continue };
        if stored.iter().any(|other| other.path.eq_ignore_ascii_case(inside)) {
            top.error("files", format!("{inside} is there twice; letter case does not distinguish files"));
            continue;
        }
        match files.read(&path) {
            Ok(content) => {
                size += content.len();
                let resident = package::is_shipped(&path, &content);
                stored.push(StoredFile { path: inside.to_owned(), content, resident });
            }
            Err(error) => top.error("files", error.to_string()),
        }
    }
    if stored.is_empty() {
        top.error("files", format!("the folder {prefix} has no files"));
    } else if stored.len() > MOST || size > BYTES {
        top.error("files", format!("at most {MOST} files with {} MiB together are stored", BYTES >> 20));
    }
    stored.sort_by(|a, b| a.path.cmp(&b.path));
    stored
}
