//! Gives the server a digest of the sources that determine the results of a job, so that it does not reuse results of
//! another version.

use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::path::{Path, PathBuf};
use std::{env, fs, io};

/// Parts of a crate that are not in the server.
const NOT_BUILT: [&str; 4] = ["tests", "benches", "fuzz", "target"];

fn main() -> io::Result<()> {
    let root = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default()).join("..");
    let own = ["machines", "Cargo.lock", "proto/counterpoint", "proto/src", "server/src"];
    let mut sources: Vec<PathBuf> = own.iter().map(|part| root.join(part)).collect();
    for krate in sorted(&root.join("kernel"))? {
        // Crates include tables of data and build scripts besides their sources.
        sources.extend(sorted(&krate)?.into_iter().filter(|part| !NOT_BUILT.iter().any(|name| part.ends_with(name))));
    }
    let mut digest = DefaultHasher::new();
    for source in sources.into_iter().filter(|source| source.exists()) {
        println!("cargo:rerun-if-changed={}", source.display());
        add(&source, &root, &mut digest)?;
    }
    println!("cargo:rustc-env=COUNTERPOINT_SOURCES={:016x}", digest.finish());
    Ok(())
}

/// The entries of a folder in an order that does not depend on the file system.
fn sorted(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let mut entries = fs::read_dir(folder)?.map(|entry| Ok(entry?.path())).collect::<io::Result<Vec<_>>>()?;
    entries.sort();
    Ok(entries)
}

/// Adds a file, or all files of a folder, with their paths from the root.
fn add(path: &Path, root: &Path, digest: &mut DefaultHasher) -> io::Result<()> {
    if path.is_dir() {
        return sorted(path)?.iter().try_for_each(|entry| add(entry, root, digest));
    }
    path.strip_prefix(root).unwrap_or(path).to_string_lossy().hash(digest);
    fs::read(path)?.hash(digest);
    Ok(())
}
