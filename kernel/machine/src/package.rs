//! Machines shipped with the project, and a user's machines over them.
//!
//! Invariant: what a user's view holds wins over what is shipped, file by file, so a user's machine may extend a
//! shipped family and may also replace one.

use include_dir::{Dir, DirEntry, include_dir};

use counterpoint_ports::files::{Bytes, Error, Files, Memory};

static MACHINES: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/../../machines");

/// The machines folder as shipped.
#[must_use]
pub fn shipped() -> Memory {
    let mut files = Memory::default();
    add(&MACHINES, &mut files);
    files
}

fn add(dir: &Dir<'_>, files: &mut Memory) {
    for entry in dir.entries() {
        match entry {
            DirEntry::Dir(dir) => add(dir, files),
            DirEntry::File(file) => {
                let parts: Vec<_> = file.path().iter().map(|part| part.to_string_lossy()).collect();
                files.insert(parts.join("/"), file.contents());
            }
        }
    }
}

/// Names of the shipped machines, families not included, sorted.
#[must_use]
pub fn shipped_names() -> Vec<String> {
    let files = shipped();
    let folders = files.list().into_iter().filter_map(|path| path.strip_suffix("/machine.toml").map(str::to_owned));
    let mut names: Vec<String> = folders.filter(|folder| !is_family(&files, folder)).collect();
    // The paths stand in another order: a hyphen comes before the slash.
    names.sort_unstable();
    names
}

/// Whether a folder holds a family: `abstract = true` before the first section.
fn is_family(files: &Memory, folder: &str) -> bool {
    let text = files.read(&format!("{folder}/machine.toml")).unwrap_or_default();
    let text = String::from_utf8_lossy(&text);
    let mut head = text.lines().take_while(|line| !line.starts_with('['));
    head.any(|line| line.split('=').map(str::trim).eq(["abstract", "true"]))
}

/// One view of files over another.
#[derive(Debug, Clone)]
pub struct Overlay<U, L> {
    upper: U,
    lower: L,
}

impl<U: Files> Overlay<U, Memory> {
    /// A user's machines over the shipped ones.
    #[must_use]
    pub fn over_shipped(user: U) -> Self {
        Self::new(user, shipped())
    }
}

impl<U: Files, L: Files> Overlay<U, L> {
    /// `upper` is asked first.
    #[must_use]
    pub fn new(upper: U, lower: L) -> Self {
        Self { upper, lower }
    }
}

impl<U: Files, L: Files> Files for Overlay<U, L> {
    fn read(&self, path: &str) -> Result<Bytes, Error> {
        match self.upper.read(path) {
            Err(Error::Missing(_)) => self.lower.read(path),
            found => found,
        }
    }

    fn list(&self) -> Vec<String> {
        let mut paths = self.upper.list();
        paths.extend(self.lower.list());
        paths.sort();
        paths.dedup();
        paths
    }
}
