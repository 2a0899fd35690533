//! Values of options that must not be empty.
//!
//! *Invariant:* an empty value is refused, never ignored. It usually comes from an unset shell variable, and a filter
//! without its condition selects the jobs of others.

/// The end of the message about an empty value.
pub(super) const EMPTY: &str = "the value is empty: give a value or omit the option (is a variable unset?)";

/// Refuses an empty text.
pub(super) fn filled(text: &str) -> Result<String, String> {
    if text.is_empty() { Err(EMPTY.to_owned()) } else { Ok(text.to_owned()) }
}
