//! The licences of all crates in the programs, with the texts that their authors ship.
//!
//! *Invariant:* every crate that is linked for the target has a licence here; equal texts are printed once.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::Path;

use crate::graph::Linked;

/// Prefixes of the names of licence files, in capitals.
const NAMES: [&str; 6] = ["LICENSE", "LICENCE", "COPYING", "COPYRIGHT", "NOTICE", "UNLICENSE"];

/// Licence texts in the folder of a crate.
fn texts(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut files: Vec<_> = entries
        .filter(|entry| {
            let name = entry.file_name().to_string_lossy().to_ascii_uppercase();
            NAMES.iter().any(|begin| name.starts_with(begin)) && entry.path().is_file()
        })
        .map(|entry| entry.path())
        .collect();
    files.sort();
    let text = |path| std::fs::read_to_string(path).ok();
    files.iter().filter_map(text).map(|text| text.replace("\r\n", "\n").trim().to_owned()).collect()
}

/// Writes the licence document for the linked crates.
///
/// # Errors
/// A crate names no licence.
pub(super) fn notices(linked: &[Linked]) -> Result<String, String> {
    let mut out = String::from(
        "Licences of the crates in the programs. The Rust standard library is also part of them: MIT OR Apache-2.0.\n\n",
    );
    let mut all: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for one in linked.iter().filter(|one| one.source.is_some()) {
        let name = format!("{} {}", one.name, one.version);
        let license = one.license.as_ref().ok_or_else(|| format!("{name} names no licence"))?;
        let of = one.repository.as_deref().or(one.authors.first().map(String::as_str)).unwrap_or("");
        let _ = writeln!(out, "{name}: {license}  {of}");
        let folder = one.manifest_path.parent().unwrap_or(Path::new(""));
        for text in texts(folder) {
            all.entry(text).or_default().insert(name.clone());
        }
    }
    for (text, crates) in all {
        let crates: Vec<String> = crates.into_iter().collect();
        let _ = writeln!(out, "\n{}\n{}\n\n{text}", "-".repeat(80), crates.join(", "));
    }
    Ok(out)
}
