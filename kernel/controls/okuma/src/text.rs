//! The text of a block without its comments, and the messages in it.
//!
//! Decisions: brackets of expressions are square, so a round bracket always opens a comment. After MSG it opens a
//! message, and a comment that starts with `MSG,` is also a message. Invariant: places in the resulting text are places
//! in the block.

use super::quick_look::is_message;

/// A block made ready for reading.
#[derive(Debug, Default)]
pub(super) struct PreparedText {
    /// Comments and messages blanked.
    pub(super) plain: Vec<u8>,
    /// The same in capitals.
    pub(super) upper: Vec<u8>,
    /// Messages to the operator.
    pub(super) messages: Vec<String>,
    /// A comment or message is not closed.
    pub(super) open: bool,
}

/// Prepares a block.
pub(super) fn prepare(text: &[u8]) -> PreparedText {
    let mut plain: Vec<u8> = text.iter().map(|&byte| if byte == b'\t' { b' ' } else { byte }).collect();
    let (mut messages, mut open, mut at) = (Vec::new(), false, 0);
    while let Some(start) = memchr::memchr(b'(', plain.get(at..).unwrap_or_default()).map(|found| at + found) {
        let before = plain.get(..start).unwrap_or_default();
        if memchr::memchr_iter(b'\'', before).count() % 2 == 1 && memchr::memchr(b'=', before).is_some() {
            // It is in a text.
            at = start + 1;
            continue;
        }
        let statement = is_behind_msg(before);
        let inside = text.get(start + 1..).unwrap_or_default();
        let close = if statement { memchr::memrchr(b')', inside) } else { memchr::memchr(b')', inside) };
        open |= close.is_none();
        let inside = inside.get(..close.unwrap_or(inside.len())).unwrap_or_default();
        let message = match memchr::memchr(b',', inside) {
            _ if statement => Some(inside),
            Some(comma) if is_message(inside) => inside.get(comma + 1..),
            _ => None,
        };
        messages.extend(message.map(|message| String::from_utf8_lossy(message).trim().to_owned()));
        let end = close.map_or(text.len(), |close| start + 1 + close + 1);
        plain.get_mut(start..end).unwrap_or_default().fill(b' ');
        at = end;
    }
    let upper = plain.to_ascii_uppercase();
    PreparedText { plain, upper, messages, open }
}

/// Whether a text ends with the statement MSG.
fn is_behind_msg(before: &[u8]) -> bool {
    let before = before.trim_ascii_end();
    let Some((head, word)) = before.split_last_chunk::<3>() else { return false };
    word.eq_ignore_ascii_case(b"MSG") && !head.last().is_some_and(u8::is_ascii_alphabetic)
}

#[cfg(test)]
mod tests {
    use super::prepare;

    #[test]
    fn comments_and_messages_are_blanked() {
        let made = prepare(b"n1 LA1=5 (a) Z=3 (b");
        assert_eq!(made.upper, b"N1 LA1=5     Z=3   ");
        assert_eq!(made.plain, b"n1 LA1=5     Z=3   ");
        assert!(made.open && made.messages.is_empty());
        let made = prepare(b"MSG (Say it (now))");
        assert_eq!((made.messages, made.upper.trim_ascii()), (vec!["Say it (now)".to_owned()], b"MSG".as_slice()));
        let made = prepare(b"(MSG, one)(two)");
        assert_eq!(made.messages, ["one"]);
        assert!(!made.open);
    }
}
