//! Common parts of the texts of several controls.

/// A block without its comment, which begins with a semicolon outside of quotation marks.
pub fn without_comment(text: &str) -> &str {
    let mut quoted = false;
    for (at, byte) in text.bytes().enumerate() {
        match byte {
            b'"' => quoted = !quoted,
            b';' if !quoted => return text.get(..at).unwrap_or_default(),
            _ => {}
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::without_comment;

    #[test]
    fn a_semicolon_inside_of_quotation_marks_is_text() {
        assert_eq!(without_comment("MSG(\"a;b\") ; c \"d\""), "MSG(\"a;b\") ");
        assert_eq!((without_comment(";"), without_comment("\"a;"), without_comment("G1")), ("", "\"a;", "G1"));
    }
}
