//! `[format]`: the shape of program text.
//!
//! Invariant: a delimiter that is there is not empty. Facts: reference control-emulator.md 5.5, 5.6.

use crate::model::{ProgramTextFormat, RewindStop};
use crate::preprocessor::Preprocessor;
use crate::toml::check::FindingCollector;
use crate::toml::section::TableReader;

/// Reads the section; a machine without it has plain text without comments.
pub(super) fn read(
    top: &mut TableReader<'_>,
    check: &FindingCollector,
    preprocessor: Preprocessor,
) -> ProgramTextFormat {
    let mut format = ProgramTextFormat {
        rws: String::new(),
        rws_inline: false,
        long_comments: false,
        rws_at: RewindStop::None,
        comment: None,
        message: None,
        opskip_mark: None,
        opskip_default: 1,
        eob: None,
    };
    let Some(mut section) = top.table("format", "[format]") else { return format };
    let (comments, named_stops) = (preprocessor.row().semicolon_comments, preprocessor.row().named_stops);
    format.eob = section.character("eob").flatten().filter(|eob| *eob != ';' || !comments);
    format.rws = section.text("rws").unwrap_or_default().to_owned();
    if !format.rws.is_empty() && section.node("rws_at").is_none() {
        let text =
            "`rws` has no effect without `rws_at`, the place of the rewind-stop; \"start\" or \"optional\" is expected";
        check.idle(section.place_of("rws"), text);
    }
    let places = [("none", RewindStop::None), ("start", RewindStop::Start), ("optional", RewindStop::Optional)];
    format.rws_at = section.choice("rws_at", &places).unwrap_or(RewindStop::None);
    if format.rws.is_empty() && format.rws_at != RewindStop::None {
        section.error("rws_at", "`rws_at` expects a rewind-stop, but `rws` has no text");
    }
    // A machine that takes the rewind-stop of its family away, or has another pre-processor, says nothing about this.
    let inline = section.flag("rws_inline").unwrap_or(false);
    format.rws_inline = inline && !format.rws.is_empty() && !named_stops;
    format.comment = delimiters(&mut section, "comment");
    format.message = delimiters(&mut section, "message");
    let lines = [("one", false), ("any", true)];
    format.long_comments = section.choice("comment_lines", &lines).unwrap_or(false);
    if let (Some((comment, _)), Some((message, _))) = (&format.comment, &format.message)
        && comment == message
    {
        let place = section.place_of("message");
        check.warning(place, "comments and messages start with the same text; both are read as comments");
    }
    let begins =
        |pair: &Option<(String, String)>, eob: char| pair.as_ref().is_some_and(|(start, _)| start.starts_with(eob));
    // A character that opens a comment does not end a block.
    format.eob = format.eob.filter(|eob| !begins(&format.comment, *eob) && !begins(&format.message, *eob));
    if let Some(mut opskip) = section.table("opskip", "opskip of [format]") {
        format.opskip_mark = opskip.character("mark").flatten();
        format.opskip_default = opskip.integer("default", 1..=9).unwrap_or(1) as u8;
        if opskip.node("mark").is_none() && opskip.node("default").is_some() {
            check.idle(opskip.place_of("default"), "`default` has no effect without `mark`, the mark of optional skip");
        }
        opskip.finish();
    }
    clashes(&section, &format, check);
    section.finish();
    format
}

/// Characters that end blocks or mark optional skip, and are read as something else.
fn clashes(section: &TableReader<'_>, format: &ProgramTextFormat, check: &FindingCollector) {
    let of_words = |c: char| c.is_ascii_alphanumeric() || matches!(c, '.' | '+' | '-');
    let starts = [("comment", &format.comment), ("message", &format.message)];
    let starts = |c: char| starts.iter().find(|(_, text)| text.as_ref().is_some_and(|(start, _)| start.starts_with(c)));
    for (key, what, character) in [
        ("eob", "the character that ends blocks", format.eob),
        ("opskip", "the mark of optional skip", format.opskip_mark),
    ] {
        let Some(c) = character else { continue };
        let place = section.place_of(key);
        if of_words(c) {
            check.error(place, format!("'{c}' is part of words, it cannot be {what}"));
        } else if let Some((other, _)) = starts(c).filter(|_| key == "opskip") {
            check.error(place, format!("'{c}' begins a `{other}` too, it cannot be {what}"));
        }
    }
    for (key, text) in [("comment", &format.comment), ("message", &format.message)] {
        if let Some((start, _)) = text
            && start.len() == 1
            && start.starts_with(of_words)
        {
            check.error(section.place_of(key), format!("\"{start}\" begins words, it cannot begin a `{key}`"));
        }
    }
    if format.eob.is_some() && format.eob == format.opskip_mark {
        check.error(section.place_of("eob"), "the character that ends blocks is the mark of optional skip too");
    }
}

fn delimiters(section: &mut TableReader<'_>, key: &'static str) -> Option<(String, String)> {
    let texts = section.texts(key)?;
    match texts.as_slice() {
        [] => None,
        [(start, _), (end, _)] if !start.is_empty() => Some(((*start).to_owned(), (*end).to_owned())),
        _ => {
            let expected = "start and end, the end empty for the end of the block, or [] for none";
            section.error(key, format!("`{key}` must be a list of two texts, {expected}"));
            None
        }
    }
}
