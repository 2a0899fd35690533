//! Texts of blocks without their marks and comments.

use counterpoint_control_api::text::without_comment;

/// A block as the search sees it: without marks of optional skip and comment.
pub(super) fn bare(text: &str) -> &str {
    without_comment(unmarked(text))
}

pub(super) fn unmarked(text: &str) -> &str {
    let mut text = text.trim_start();
    while let Some(rest) = text.strip_prefix('/') {
        text = rest.strip_prefix(|c: char| c.is_ascii_digit()).unwrap_or(rest).trim_start();
    }
    text
}
