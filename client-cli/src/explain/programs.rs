//! Programs that are stored with a machine, such as the cycles of a control.
//!
//! *Invariant:* a program is found by the name of its file, regardless of letter case and extension.

use counterpoint_kernel::machine::Machine;
use counterpoint_kernel::machine::stored::StoredFile;
use serde_json::{Value, json};

use super::arguments::LETTERS;

/// Beginning of the line with the parameters of a program.
const HEAD: &str = "PROC ";

/// Stored programs of a word: the program of its name, of a cycle that it defines (`CYCL DEF 200`), or those that it
/// calls.
pub(super) fn of_word(machine: &Machine, word: &str, called: &[u32]) -> Vec<Value> {
    let upper = word.to_uppercase();
    let cycle =
        upper.strip_prefix("CYCL DEF ").map(str::trim).filter(|number| number.bytes().all(|b| b.is_ascii_digit()));
    let mut all = stored(machine, cycle.unwrap_or(word));
    for number in called {
        all.extend(stored(machine, &format!("O{number:04}")));
    }
    all
}

/// Parameters that the text of a program reads: Q parameters from 200 on, or the arguments of a macro by their letters.
fn parameters(path: &str, text: &str) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    let heidenhain = path.to_lowercase().ends_with(".h");
    let sign = if heidenhain { 'Q' } else { '#' };
    for (at, _) in text.match_indices(sign) {
        let digits: String = text.get(at + 1..).unwrap_or_default().chars().take_while(char::is_ascii_digit).collect();
        let Ok(number) = digits.parse::<u32>() else { continue };
        let name = match heidenhain {
            true => (200..400).contains(&number).then(|| format!("Q{number}")),
            false => LETTERS.iter().find(|(_, of)| *of == number).map(|(letter, _)| letter.to_string()),
        };
        found.extend(name.filter(|name| !found.contains(name)));
    }
    found.sort();
    found
}

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
        let read = if head.is_none() { parameters(&file.path, &text) } else { Vec::new() };
        json!({ "parameters": read, "path": format!("//ICAMFS/{}", file.path), "line": line, "head": head, "about": comment })
    };
    own.map(row).collect()
}

/// Blocks of stored programs that raise the alarm with this number, with their comments.
pub(super) fn that_raise(machine: &Machine, number: &str) -> Vec<Value> {
    let own = number.parse().ok().and_then(|number: u32| number.checked_sub(machine.variables.system.alarm));
    let Some(own) = own.filter(|_| machine.variables.system.alarm > 0) else { return Vec::new() };
    let raises = format!("#3000={own}");
    let mut found = Vec::new();
    for file in machine.storage.iter() {
        let text = String::from_utf8_lossy(&file.content);
        for (line, at) in text.lines().zip(1..) {
            let Some((_, rest)) = line.split_once(&raises) else { continue };
            if rest.starts_with(|c: char| c.is_ascii_digit() || c == '.') {
                continue;
            }
            let comment = rest.trim().trim_start_matches('(').trim_end_matches(')');
            found.push(json!({ "path": format!("//ICAMFS/{}", file.path), "line": at, "about": comment }));
        }
    }
    found
}

/// Name of a file without folder and ending.
pub(super) fn stem(path: &str) -> Option<&str> {
    let file = path.rsplit('/').next()?;
    Some(file.split_once('.').map_or(file, |(stem, _)| stem)).filter(|stem| !stem.is_empty())
}
