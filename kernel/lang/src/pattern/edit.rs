//! Replacing, extracting and splitting.

use super::matcher::PatternSearch;
use super::{BYTES_PER_STEP, Match, TextPattern};
use crate::diag::DiagnosticNumber;
use crate::fault::{MacroFault, Outcome};

/// Calls `each` with every match from left to right until it answers false; it may use up steps, too.
fn matches(
    pattern: &TextPattern,
    text: &str,
    budget: &mut u64,
    mut each: impl FnMut(&Match, &mut u64) -> bool,
) -> Outcome<()> {
    let (mut from, mut last_end) = (0usize, None);
    let mut search = PatternSearch::new(pattern, text);
    while search.find(from, budget)? {
        let found = &search.found;
        let (start, end) = found.whole();
        let empty_behind_a_match = start == end && last_end == Some(start);
        if !empty_behind_a_match && !each(found, budget) {
            break;
        }
        last_end = Some(end);
        from = if start == end {
            end + text.get(end..).and_then(|r| r.chars().next()).map_or(1, char::len_utf8)
        } else {
            end
        };
        if pattern.anchored || from > text.len() {
            break;
        }
    }
    Ok(())
}

/// Appends `template` with `\1` to `\9` filled in.
pub(super) fn fill(out: &mut String, template: &str, text: &str, found: &Match) {
    let mut rest = template;
    // Templates are short, so their bytes are looked at one by one.
    while let Some(at) = rest.bytes().position(|byte| byte == b'\\') {
        let (plain, escaped) = (rest.get(..at).unwrap_or_default(), rest.get(at + 1..).unwrap_or_default());
        out.push_str(plain);
        let mut characters = escaped.chars();
        match characters.next() {
            Some(digit @ '1'..='9') => {
                let group = digit.to_digit(10).and_then(|digit| found.groups.get(digit as usize)).copied().flatten();
                out.push_str(group.and_then(|(start, end)| text.get(start..end)).unwrap_or(""));
            }
            Some(other) => out.push(other),
            None => out.push('\\'),
        }
        rest = characters.as_str();
    }
    out.push_str(rest);
}

/// Uses up steps for bytes that are copied.
fn copying(budget: &mut u64, bytes: usize) {
    *budget = budget.saturating_sub((bytes / BYTES_PER_STEP) as u64);
}

pub(super) fn replace(
    pattern: &TextPattern,
    text: &str,
    (with, which): (&str, usize),
    most: usize,
    budget: &mut u64,
) -> Outcome<String> {
    let (mut out, mut copied, mut count) = (String::with_capacity(text.len() + text.len() / 2), 0usize, 0usize);
    matches(pattern, text, budget, |found, budget| {
        count += 1;
        if which == 0 || count == which {
            let (start, end) = found.whole();
            out.push_str(text.get(copied..start).unwrap_or(""));
            let before = out.len();
            fill(&mut out, with, text, found);
            copying(budget, with.len() + out.len() - before);
            copied = end;
        }
        count != which && out.len() <= most
    })?;
    out.push_str(text.get(copied..).unwrap_or(""));
    if out.len() > most {
        return Err(MacroFault::new(DiagnosticNumber::SIZE, format!("a text has more than {most} bytes")));
    }
    Ok(out)
}

pub(super) fn nth(
    pattern: &TextPattern,
    text: &str,
    (template, which): (Option<&str>, usize),
    budget: &mut u64,
) -> Outcome<Option<String>> {
    let (mut result, mut count) = (None, 0usize);
    matches(pattern, text, budget, |found, _| {
        count += 1;
        if count == which {
            let (start, end) = found.whole();
            let mut out = String::new();
            match template {
                Some(template) => fill(&mut out, template, text, found),
                None => out.push_str(text.get(start..end).unwrap_or("")),
            }
            result = Some(out);
        }
        count != which
    })?;
    Ok(result)
}

pub(super) fn split(
    pattern: &TextPattern,
    text: &str,
    (limit, most): (usize, usize),
    budget: &mut u64,
) -> Outcome<Vec<String>> {
    let (mut pieces, mut copied) = (Vec::new(), 0usize);
    matches(pattern, text, budget, |found, _| {
        let (start, end) = found.whole();
        if limit > 0 && pieces.len() + 1 >= limit || pieces.len() >= most {
            return false;
        }
        if start < end {
            pieces.push(text.get(copied..start).unwrap_or("").to_owned());
            copied = end;
        }
        true
    })?;
    if pieces.len() >= most {
        return Err(MacroFault::new(DiagnosticNumber::SIZE, format!("there are more than {most} elements")));
    }
    pieces.push(text.get(copied..).unwrap_or("").to_owned());
    Ok(pieces)
}
