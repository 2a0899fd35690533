//! Rewriting expectations in place.
//!
//! *Invariant:* bytes of a page outside of the edits stay as they are.

use std::ops::Range;

/// One change of a page.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Edit {
    /// Bytes that go.
    pub range: Range<usize>,
    /// The replacement.
    pub text: String,
}

/// The page with all edits; edits that overlap an earlier one are left out.
#[must_use]
pub fn rewritten(page: &str, edits: &[Edit]) -> String {
    let mut edits: Vec<&Edit> = edits.iter().collect();
    edits.sort_by_key(|edit| (edit.range.start, edit.range.end));
    let (mut text, mut at) = (String::with_capacity(page.len()), 0);
    for edit in edits.into_iter() {
        let Some(before) = page.get(at..edit.range.start) else { continue };
        text.push_str(before);
        text.push_str(&edit.text);
        at = edit.range.end;
    }
    text.push_str(page.get(at..).unwrap_or_default());
    text
}

#[cfg(test)]
mod tests {
    use super::{Edit, rewritten};

    #[test]
    fn only_the_edits_change() {
        let edit = |range, text: &str| Edit { range, text: text.to_owned() };
        let page = "a\r\n```events\nold\n```\n\tend";
        assert_eq!(rewritten(page, &[]), page);
        let edits = [edit(18..18, "```nc\n```\n"), edit(13..17, "new\nlines\n"), edit(14..15, "overlaps")];
        assert_eq!(rewritten(page, &edits), "a\r\n```events\nnew\nlines\n`".to_owned() + "```nc\n```\n``\n\tend");
    }
}
