//! Diagnostics in place, and their count.
//!
//! Layout: reference listing-and-trace.md 5 and 7.5.

use std::borrow::Cow;
use std::io::{Result, Write};

use counterpoint_event::event::{Diagnostic, DiagnosticOrigin, Event};
use counterpoint_event::info::Info;

/// Characters of a line before the text wraps.
const WIDTH: usize = 110;

/// The two lines of a diagnostic; more when its text is long, and one for the macro that raised it.
pub(super) fn write(info: &Info, event: &Event, diagnostic: &Diagnostic, out: &mut dyn Write) -> Result<()> {
    let word = word(diagnostic.severity);
    let indent = word.len() + 2;
    for (index, line) in wrap(&diagnostic.text, WIDTH - indent).into_iter().enumerate() {
        if index == 0 {
            writeln!(out, "{word}: {line}")?;
        } else {
            writeln!(out, "{:indent$}{line}", "")?;
        }
    }
    if let Some(origin) = origin(info, event, diagnostic) {
        let word = if diagnostic.origin.is_some() { "MACRO" } else { "PROGRAM" };
        writeln!(out, "  {word}({}) LINE({}): {}", origin.name, origin.line, origin.statement)?;
    }
    let place = event.user_place();
    let path = if place.is_some() { info.file_name(place.file) } else { "-" };
    let file = path.rsplit('/').next().unwrap_or(path);
    let (severity, line, number) = (diagnostic.severity, place.line, diagnostic.number);
    write!(out, "  SEVERITY({severity:02}) LINE({line:05}) ERRNUM({number:08}) INPUT({file})")?;
    if !diagnostic.operation.is_empty() {
        write!(out, " OPER({})", diagnostic.operation)?;
    }
    if info.channels.len() > 1 {
        let name = match &*diagnostic.kernel {
            "" => info.channel(event.channel).map_or("MASTER", |c| c.name.as_str()),
            given => given,
        };
        write!(out, " KERNEL({name})")?;
    }
    writeln!(out)
}

/// The statement of a macro that raised it, or the block of a resident program.
pub(super) fn origin<'d>(info: &Info, event: &Event, diagnostic: &'d Diagnostic) -> Option<Cow<'d, DiagnosticOrigin>> {
    let program = || event.caller.is_some().then(|| Cow::Owned(info.origin(event.file, event.line)));
    diagnostic.origin.as_deref().map(Cow::Borrowed).or_else(program)
}

/// Lines of at most `width` characters, broken at blanks where there are any.
fn wrap(text: &str, width: usize) -> Vec<&str> {
    let mut lines = Vec::new();
    for part in text.split('\n') {
        let mut rest = part.trim_end();
        while let Some((limit, _)) = rest.char_indices().nth(width) {
            let head = rest.get(..limit).unwrap_or_default();
            let fits = rest.get(limit..).is_some_and(|r| r.starts_with(' '));
            let cut = if fits { limit } else { head.rfind(' ').filter(|&at| at > 0).unwrap_or(limit) };
            lines.push(rest.get(..cut).unwrap_or_default().trim_end());
            rest = rest.get(cut..).unwrap_or_default().trim_start();
        }
        lines.push(rest);
    }
    lines
}

/// Type word of a severity.
pub(super) fn word(severity: u8) -> &'static str {
    ["Message", "Warning", "Error", "Fatal"].get(rank(severity)).copied().unwrap_or("Fatal")
}

fn rank(severity: u8) -> usize {
    match severity {
        0..=3 => 0,
        4..=7 => 1,
        8..=15 => 2,
        _ => 3,
    }
}

/// Diagnostics by type.
#[derive(Debug, Default)]
pub(super) struct DiagnosticCounts([u64; 4]);

impl DiagnosticCounts {
    pub(super) fn add(&mut self, severity: u8) {
        if let Some(count) = self.0.get_mut(rank(severity)) {
            *count += 1;
        }
    }

    /// The table, or one sentence when there was none.
    pub(super) fn write(&self, out: &mut dyn Write) -> Result<()> {
        let total: u64 = self.0.iter().sum();
        if total == 0 {
            return write!(out, "\nNO DIAGNOSTICS\n");
        }
        write!(out, "\nTYPE      TOTAL\n\n")?;
        for (name, count) in ["MESSAGE", "WARNING", "ERROR", "FATAL"].into_iter().zip(self.0) {
            writeln!(out, "{name:<9}{count:>6}")?;
        }
        writeln!(out, "\n{:<9}{total:>6}", "TOTAL")
    }
}

#[cfg(test)]
mod tests {
    use super::wrap;

    #[test]
    fn text_wraps_at_blanks() {
        assert_eq!(wrap("one two three", 7), ["one two", "three"]);
        assert_eq!(wrap("one two three", 13), ["one two three"]);
        assert_eq!(wrap("abcdefghij kl", 4), ["abcd", "efgh", "ij", "kl"]);
        assert_eq!(wrap("ääää ää", 5), ["ääää", "ää"]);
        assert_eq!(wrap("", 5), [""]);
        assert_eq!(wrap("a\nb", 5), ["a", "b"]);
    }
}
