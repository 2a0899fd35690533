//! Machines shipped with the project, and a user's machines over them.
//!
//! Invariant: a user's view overrides shipped files one by one, so a user's machine may extend a shipped family and may
//! also replace one.

use std::sync::LazyLock;

use include_dir::{Dir, DirEntry, include_dir};

use counterpoint_ports::files::{Bytes, FileError, JobFiles, MemoryFiles};

static MACHINES: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/../../machines");

/// The files by path. Their bytes are those of the program itself.
static FILES: LazyLock<MemoryFiles> = LazyLock::new(|| {
    let mut files = MemoryFiles::default();
    add(&MACHINES, &mut files);
    files
});

/// The machines folder as shipped.
#[must_use]
pub fn shipped() -> MemoryFiles {
    FILES.clone()
}

/// Whether a file of a machine is as shipped: the same path with the same content.
pub(crate) fn is_shipped(path: &str, content: &Bytes) -> bool {
    FILES.0.get(path).is_some_and(|shipped| shipped == content)
}

fn add(dir: &'static Dir<'_>, files: &mut MemoryFiles) {
    for entry in dir.entries() {
        match entry {
            DirEntry::Dir(dir) => add(dir, files),
            DirEntry::File(file) => {
                let parts: Vec<_> = file.path().iter().map(|part| part.to_string_lossy()).collect();
                files.0.insert(parts.join("/"), Bytes::from_static(file.contents()));
            }
        }
    }
}

/// Names of the shipped machines, families not included, sorted.
#[must_use]
pub fn shipped_names() -> Vec<String> {
    let folders = FILES.0.iter().filter_map(|(path, text)| Some((path.strip_suffix("/machine.toml")?, text)));
    let mut names: Vec<String> =
        folders.filter(|(_, text)| !is_family(text)).map(|(folder, _)| folder.to_owned()).collect();
    // The paths stand in another order: a hyphen comes before the slash.
    names.sort_unstable();
    names
}

/// Whether a `machine.toml` is that of a family: `abstract = true` before the first section.
fn is_family(text: &[u8]) -> bool {
    let mut head = text.split(|byte| *byte == b'\n').take_while(|line| !line.starts_with(b"["));
    head.any(|line| line.split(|byte| *byte == b'=').map(<[u8]>::trim_ascii).eq([&b"abstract"[..], b"true"]))
}

/// One view of files over another.
#[derive(Debug, Clone)]
pub struct Overlay<U, L> {
    upper: U,
    lower: L,
}

impl<U: JobFiles> Overlay<U, MemoryFiles> {
    /// A user's machines over the shipped ones.
    #[must_use]
    pub fn over_shipped(user: U) -> Self {
        Self::new(user, shipped())
    }
}

impl<U: JobFiles, L: JobFiles> Overlay<U, L> {
    /// `upper` is asked first.
    #[must_use]
    pub fn new(upper: U, lower: L) -> Self {
        Self { upper, lower }
    }
}

impl<U: JobFiles, L: JobFiles> JobFiles for Overlay<U, L> {
    fn read(&self, path: &str) -> Result<Bytes, FileError> {
        match self.upper.read(path) {
            Err(FileError::Missing(_)) => self.lower.read(path),
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
