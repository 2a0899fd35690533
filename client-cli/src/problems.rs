//! The problems of a job, for the report: causes before consequences, each once, with place, block and remedy.
//!
//! Errors are listed in the order in which they occurred, so a cause comes before its consequences: those that led to
//! the verdict, the verdict, then later verdicts and errors. Warnings and notes follow. *Invariant:* a diagnostic that
//! repeats the verdict is shown only as the verdict.

use std::fmt::Write as _;

use crate::macros::{remedy, remedy_for};
use crate::say::{self, BAD, DIM, styled};
use crate::severity::{self, ERROR, WARNING};
use crate::summary::{ReportDiagnostic, ReportMember, ReportSummary, ReportVerdict};
use crate::text::more;

/// The verdict of a limit, in small letters.
const LIMIT: &str = "limit";

/// `2 errors, 1 warning`, empty without any.
pub(crate) fn counts(summary: &ReportSummary) -> String {
    let count = |of: &dyn Fn(u32) -> bool| own(summary).filter(|d| of(d.severity)).count();
    let errors = count(&|severity| severity >= ERROR) + usize::from(summary.verdict.is_some());
    let warnings = count(&|severity| (WARNING..ERROR).contains(&severity));
    let some = |count: usize, word: &str| match count {
        0 => None,
        1 => Some(format!("1 {word}")),
        count => Some(format!("{count} {word}s")),
    };
    let parts: Vec<_> = [some(errors, "error"), some(warnings, "warning")].into_iter().flatten().collect();
    parts.join(", ")
}

/// Diagnostics that are not the verdict.
fn own(summary: &ReportSummary) -> impl Iterator<Item = &ReportDiagnostic> {
    summary.diagnostics.iter().filter(|d| summary.verdict.as_ref().is_none_or(|verdict| !says(d, verdict)))
}

/// Whether a diagnostic repeats the verdict.
fn says(diagnostic: &ReportDiagnostic, verdict: &ReportVerdict) -> bool {
    diagnostic.severity >= ERROR && !diagnostic.text.is_empty() && verdict.text.contains(&diagnostic.text)
}

/// The problems as text, at most `most` kinds of diagnostics.
pub(crate) fn problems(summary: &ReportSummary, most: usize) -> String {
    let mut groups: Vec<(&ReportDiagnostic, usize)> = Vec::new();
    for diagnostic in own(summary) {
        let same = |g: &&mut (&ReportDiagnostic, usize)| {
            let what =
                |d: &'_ ReportDiagnostic| (d.number, d.channel, d.origin.as_ref().map(|o| (o.file.clone(), o.line)));
            what(g.0) == what(diagnostic) && g.0.text == diagnostic.text
        };
        match groups.iter_mut().find(same) {
            Some(group) => group.1 += 1,
            None => groups.push((diagnostic, 1)),
        }
    }
    groups.sort_by_key(|(diagnostic, _)| std::cmp::Reverse(class(diagnostic.severity)));
    let errors = groups.iter().filter(|(d, _)| d.severity >= ERROR).count();
    let (errors, others) = groups.split_at(errors);
    let several = summary.channels.iter().filter(|c| !c.program.is_empty()).count() > 1;
    let mut out = String::new();
    let mut explained = Vec::new();
    let errors_so_far = before_verdict(summary, errors).min(most);
    for (diagnostic, count) in errors.iter().take(errors_so_far) {
        out.push_str(&one(diagnostic, *count, several, &mut explained));
    }
    if let Some(verdict) = &summary.verdict {
        out.push_str(&judged(summary, verdict, several));
    }
    for (diagnostic, count) in errors.iter().take(most).skip(errors_so_far) {
        out.push_str(&one(diagnostic, *count, several, &mut explained));
    }
    for (diagnostic, count) in others.iter().take(most.saturating_sub(errors.len())) {
        out.push_str(&one(diagnostic, *count, several, &mut explained));
    }
    more(&mut out, groups.len(), most, "kinds of diagnostics");
    if out.is_empty() {
        return out;
    }
    let hint = "`counterpoint explain NUMBER` explains a diagnostic";
    format!("{out}\n  {}\n\n", styled(DIM, hint))
}

/// Prints the errors of a job, with its warnings if they count as errors, on standard error; nothing without any.
pub(crate) fn say_errors(mut summary: ReportSummary, warnings: bool) {
    let least = if warnings { WARNING } else { ERROR };
    summary.diagnostics.retain(|diagnostic| diagnostic.severity >= least);
    let text = problems(&summary, usize::MAX);
    if !text.is_empty() {
        say::status_line(text.trim_end());
    }
}

/// How many of the errors were reported before the verdict.
fn before_verdict(summary: &ReportSummary, errors: &[(&ReportDiagnostic, usize)]) -> usize {
    let Some(verdict) = &summary.verdict else { return errors.len() };
    let Some(at) = summary.diagnostics.iter().position(|d| says(d, verdict)) else { return errors.len() };
    let later = summary.diagnostics.get(at..).unwrap_or_default();
    errors.iter().take_while(|(error, _)| !later.iter().any(|d| std::ptr::eq(d, *error))).count()
}

/// Errors, warnings, notes.
fn class(severity: u32) -> u8 {
    match severity {
        0..WARNING => 0,
        WARNING..ERROR => 1,
        _ => 2,
    }
}

fn one(d: &ReportDiagnostic, count: usize, several: bool, explained: &mut Vec<u32>) -> String {
    let (word, style) = severity::word(d.severity);
    let channel = if several && d.channel > 0 { format!("channel {} ", d.channel) } else { String::new() };
    let place = if d.line == 0 { String::new() } else { format!("{}:{}: ", d.file, d.line) };
    let times = if count > 1 { format!(" ({count} times)") } else { String::new() };
    let head = styled(style, format_args!("{word} {}", d.number));
    let origin = d.origin.as_ref().map(|o| format!(" ({}:{})", o.file, o.line)).unwrap_or_default();
    let mut out = format!("  {head} {channel}{place}{}{origin}{times}\n", d.text);
    // Many texts quote their block.
    if !d.block.is_empty() && !d.text.contains(&d.block) {
        let _ = writeln!(out, "      {}", styled(DIM, &d.block));
    }
    if d.severity >= WARNING && !explained.contains(&d.number) {
        explained.push(d.number);
        advise(&mut out, remedy(d.number));
    }
    out
}

fn advise(out: &mut String, remedy: Option<String>) {
    if let Some(remedy) = remedy {
        let _ = writeln!(out, "      {}", styled(DIM, format_args!("remedy: {remedy}")));
    }
}

/// The verdict with the blocks at which its channels stopped.
fn judged(summary: &ReportSummary, verdict: &ReportVerdict, several: bool) -> String {
    let number = summary.diagnostics.iter().find(|d| says(d, verdict)).map(|d| d.number);
    let head = match number {
        Some(number) => format!("{} {number} ({})", kind_word(&verdict.kind), verdict.kind),
        None => format!("{} ({})", kind_word(&verdict.kind), verdict.kind),
    };
    let mut out = format!("  {} {}\n", styled(BAD, head), verdict.text);
    let quoted =
        |m: &&ReportMember| m.line > 0 && !m.block.is_empty() && !verdict.text.contains(&format!("'{}'", m.block));
    for member in verdict.members.iter().filter(quoted) {
        let channel = if several { format!("channel {} ", member.channel) } else { String::new() };
        let block = format_args!("{channel}{}:{}: {}", member.file, member.line, member.block);
        let _ = writeln!(out, "      {}", styled(DIM, block));
    }
    if let Some(number) = number {
        advise(&mut out, remedy_for(number, &verdict.kind));
    }
    out
}

/// The word for a kind of verdict: `limit` if the job has reached a limit, otherwise `deadlock`.
fn kind_word(kind: &str) -> &'static str {
    if kind.eq_ignore_ascii_case(LIMIT) { LIMIT } else { "deadlock" }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn summary(text: &str) -> ReportSummary {
        serde_json::from_str(text).unwrap()
    }

    fn plain(text: &str) -> String {
        anstream::adapter::strip_str(text).to_string()
    }

    #[test]
    fn the_cause_comes_first_and_the_verdict_once() {
        let summary = summary(
            r#"{"state":"FAILED","channels":[{"channel":1,"program":"a"},{"channel":2,"program":"b"}],
            "verdict":{"kind":"PARTNER_ALARMED","text":"channel 2 waits for channel 1",
                "members":[{"channel":2,"file":"b","line":3,"block":"M101 P12"}]},
            "diagnostics":[
                {"number":2001005,"severity":4,"channel":1,"file":"a","line":2,"block":"X5 Q","text":"Q not recognised"},
                {"number":2900061,"severity":12,"channel":1,"file":"a","line":5,"block":"\#1=1/0",
                    "text":"division by zero in '\#1=1/0'"},
                {"number":2900071,"severity":16,"channel":0,"file":"a","line":5,"text":"channel 2 waits for channel 1"}]}"#
                .replace("\\#", "#")
                .as_str(),
        );
        assert_eq!(counts(&summary), "2 errors, 1 warning");
        let text = plain(&problems(&summary, 20));
        let lines: Vec<&str> = text.lines().filter(|line| !line.contains("remedy: ")).collect();
        assert_eq!(
            lines,
            [
                "  error 2900061 channel 1 a:5: division by zero in '#1=1/0'",
                "  deadlock 2900071 (PARTNER_ALARMED) channel 2 waits for channel 1",
                "      channel 2 b:3: M101 P12",
                "  warning 2001005 channel 1 a:2: Q not recognised",
                "      X5 Q",
                "",
                "  `counterpoint explain NUMBER` explains a diagnostic",
                "",
            ],
            "{text}"
        );
        assert_eq!(text.matches("remedy: ").count(), 3, "{text}");
        assert!(text.contains("remedy: Correct the alarm of the other channel first\n"), "{text}");
        assert!(!text.contains("channel 0"), "{text}");
    }

    #[test]
    fn a_later_verdict_follows_the_first_one() {
        let summary = summary(
            r#"{"state":"FAILED","channels":[{"channel":1,"program":"a"},{"channel":2,"program":"b"}],
            "verdict":{"kind":"CYCLE","text":"channels 1 and 2 wait for each other","members":[]},
            "diagnostics":[
                {"number":2900061,"severity":12,"channel":4,"text":"an alarm before"},
                {"number":2900071,"severity":16,"channel":0,"text":"channels 1 and 2 wait for each other"},
                {"number":2900071,"severity":16,"channel":0,"text":"channel 3 waits for channel 1"},
                {"number":2001005,"severity":4,"channel":3,"text":"a warning"}]}"#,
        );
        let text = plain(&problems(&summary, 20));
        let at = |part: &str| text.find(part).unwrap();
        let order =
            ["an alarm before", "deadlock 2900071 (CYCLE)", "channel 3 waits for channel 1", "a warning"].map(at);
        assert!(order.is_sorted(), "{text}");
    }

    #[test]
    fn an_alarm_of_all_channels_is_one_error() {
        let summary = summary(
            r#"{"channels":[{"channel":1,"program":"a"},{"channel":2,"program":"b"}],
            "verdict":{"kind":"MISMATCH","text":"codes do not match","members":[]},
            "diagnostics":[{"number":2900050,"severity":12,"channel":2,"text":"codes do not match"},
                {"number":2900050,"severity":12,"channel":1,"text":"codes do not match"}]}"#,
        );
        assert_eq!(counts(&summary), "1 error");
        assert_eq!(problems(&summary, 20).matches("codes do not match").count(), 1);
    }

    #[test]
    fn the_remedy_of_a_number_is_given_once() {
        let summary = summary(
            r#"{"channels":[{"channel":1,"program":"a"}],"diagnostics":[
            {"number":2001005,"severity":4,"channel":1,"file":"a","line":2,"text":"Q not recognised"},
            {"number":2001005,"severity":4,"channel":1,"file":"a","line":3,"text":"R not recognised"},
            {"number":2001005,"severity":4,"channel":1,"file":"a","line":4,"text":"R not recognised"}]}"#,
        );
        let text = plain(&problems(&summary, 20));
        assert_eq!((text.matches("remedy: ").count(), text.matches("(2 times)").count()), (1, 1), "{text}");
        assert!(text.contains("  warning 2001005 a:2: Q not recognised\n"), "one channel is not named: {text}");
        assert!(plain(&problems(&summary, 1)).contains("and 1 more kinds of diagnostics"));
    }
}
