//! Numbers as text, after the string formats of the macro language (reference macro-language.md, formats).

use std::fmt::Write as _;

/// Appends `value` in the wildcard form `!(s9f9s)`: no leading or trailing zeros, point only with a fraction,
/// nine fraction digits at most: `12`, `8.5`, `-20`, `.5`, `0`.
pub fn wildcard(out: &mut String, value: f64) {
    if !value.is_finite() {
        let _ = write!(out, "{value}");
        return;
    }
    let start = out.len();
    let _ = write!(out, "{value:.9}");
    let zeros = out.len() - out.trim_end_matches('0').len();
    out.truncate(out.len() - zeros);
    if out.ends_with('.') {
        out.pop();
    }
    let text = out.split_off(start);
    match text.as_str() {
        "-0" | "" | "-" => out.push('0'),
        t => match t.strip_prefix("0.").map(|f| ("", f)).or_else(|| t.strip_prefix("-0.").map(|f| ("-", f))) {
            Some((sign, fraction)) => {
                out.push_str(sign);
                out.push('.');
                out.push_str(fraction);
            }
            None => out.push_str(t),
        },
    }
}

/// [`wildcard`] as an owned string.
#[must_use]
pub fn wildcard_text(value: f64) -> String {
    let mut out = String::new();
    wildcard(&mut out, value);
    out
}

#[cfg(test)]
mod tests {
    use super::wildcard_text;

    #[test]
    fn numbers_of_the_reference() {
        for (value, text) in [
            (12.0, "12"),
            (8.5, "8.5"),
            (-20.0, "-20"),
            (0.5, ".5"),
            (-0.5, "-.5"),
            (0.0, "0"),
            (-0.0, "0"),
            (90.0, "90"),
            (1e-12, "0"),
            (-1e-12, "0"),
            (100.0, "100"),
        ] {
            assert_eq!(wildcard_text(value), text);
        }
    }
}
