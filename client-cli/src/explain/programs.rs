//! Programs that are stored with a machine, such as the cycles of a control.
//!
//! *Invariant:* a program is found by the name of its file, regardless of letter case and extension.

use counterpoint_kernel::machine::Machine;
use counterpoint_kernel::machine::stored::StoredFile;
use serde_json::{Value, json};

/// Beginning of the line with the parameters of a program.
const HEAD: &str = "PROC ";

/// Stored programs of this name; text after a bracket is arguments.
pub(super) fn stored(machine: &Machine, word: &str) -> Vec<Value> {
    let name = word.split('(').next().unwrap_or_default().trim();
    let own =
        machine.storage.iter().filter(|file| stem(&file.path).is_some_and(|stem| stem.eq_ignore_ascii_case(name)));
    let row = |file: &StoredFile| {
        let text = String::from_utf8_lossy(&file.content);
        let head = text.lines().zip(1..).find(|(line, _)| line.trim_start().to_uppercase().starts_with(HEAD));
        let (head, line) = head.map_or((None, 1), |(text, line)| (Some(text.trim().to_owned()), line));
        // The first sentence of the remark at the beginning.
        let remark: Vec<&str> = text.lines().map_while(|line| line.trim().strip_prefix(';')).map(str::trim).collect();
        let comment = remark.join(" ").split_once(". ").map(|(first, _)| first.to_owned());
        json!({ "path": format!("//ICAMFS/{}", file.path), "line": line, "head": head, "about": comment })
    };
    own.map(row).collect()
}

/// Name of a file without folder and ending.
pub(super) fn stem(path: &str) -> Option<&str> {
    let file = path.rsplit('/').next()?;
    Some(file.split_once('.').map_or(file, |(stem, _)| stem)).filter(|stem| !stem.is_empty())
}
