//! Small helpers of the pictures: escaped text, short numbers, round ticks.
//!
//! *Invariant:* all output of this module is well-formed XML and the same on every platform.

use std::fmt::Write as _;

/// Font of all pictures.
pub(crate) const FONT: &str = "Helvetica, Arial, sans-serif";

/// Text as XML content or attribute value; characters that XML cannot hold become a question mark.
pub(crate) fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\t' | '\n' => out.push(' '),
            '\u{0}'..='\u{1f}' | '\u{fffe}' | '\u{ffff}' => out.push('?'),
            c => out.push(c),
        }
    }
    out
}

/// A text element. `anchor`: `start`, `middle` or `end`.
pub(crate) fn text(out: &mut String, at: (f64, f64), size: u8, anchor: &str, color: &str, text: &str) {
    let ((x, y), text) = (at, escape(text));
    let _ = writeln!(
        out,
        r#"<text x="{x:.1}" y="{y:.1}" font-size="{size}" text-anchor="{anchor}" fill="{color}">{text}</text>"#
    );
}

/// Width of a text in pixels, as wide as any usual font draws it.
pub(crate) fn width(text: &str, size: u8) -> f64 {
    text.chars().count() as f64 * f64::from(size) * 0.62
}

/// A text of at most this many pixels, cut with an ellipsis; empty when not even two letters fit.
pub(crate) fn fit(text: &str, size: u8, room: f64) -> String {
    if width(text, size) <= room {
        return text.to_owned();
    }
    let most = (room / (f64::from(size) * 0.62)) as usize;
    match most {
        0..3 => String::new(),
        most => text.chars().take(most - 1).collect::<String>().trim_end().chars().chain(['…']).collect(),
    }
}

/// Opening of a picture with a white ground.
pub(crate) fn open(out: &mut String, width: f64, height: f64) {
    let _ = write!(
        out,
        concat!(
            r#"<svg xmlns="http://www.w3.org/2000/svg" width="{w:.0}" height="{h:.0}" viewBox="0 0 {w:.0} {h:.0}" "#,
            r#"font-family="{font}">"#,
            "\n",
            r##"<rect width="{w:.0}" height="{h:.0}" fill="#ffffff"/>"##,
            "\n"
        ),
        w = width,
        h = height,
        font = FONT
    );
}

/// Appends a number in hundredths in its shortest form: `12`, `1.5`, `-.05`; with a leading blank unless `first` or
/// the sign separates it.
pub(crate) fn hundredths(out: &mut String, value: i64, first: bool) {
    if value < 0 {
        out.push('-');
    } else if !first {
        out.push(' ');
    }
    let value = value.unsigned_abs();
    let (whole, rest) = (value / 100, value % 100);
    let mut digits = [0_u8; 24];
    let mut at = digits.len();
    let mut left = whole;
    while left > 0 || (whole == 0 && rest == 0 && at == digits.len()) {
        at -= 1;
        if let Some(slot) = digits.get_mut(at) {
            *slot = b'0' + (left % 10) as u8;
        }
        left /= 10;
    }
    for digit in digits.get(at..).unwrap_or_default() {
        out.push(char::from(*digit));
    }
    if rest > 0 {
        out.push('.');
        out.push(char::from(b'0' + (rest / 10) as u8));
        if rest % 10 > 0 {
            out.push(char::from(b'0' + (rest % 10) as u8));
        }
    }
}

/// Pixels as hundredths.
pub(crate) fn px(value: f64) -> i64 {
    (value * 100.0).round() as i64
}

/// A step of 1, 2 or 5 times a power of ten that divides `span` into at most `most` parts.
pub(crate) fn round_step(span: f64, most: f64) -> f64 {
    if !(span > 0.0 && span.is_finite()) {
        return 1.0;
    }
    let rough = span / most.max(1.0);
    let power = 10_f64.powf(rough.log10().floor());
    [1.0, 2.0, 5.0].map(|f| f * power).into_iter().find(|step| *step >= rough * 0.999_999).unwrap_or(10.0 * power)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let mut out = String::new();
        for (index, value) in [0, 5, -5, 150, -1234, 100].into_iter().enumerate() {
            hundredths(&mut out, value, index == 0);
        }
        assert_eq!(out, "0 .05-.05 1.5-12.34 1");
    }

    #[test]
    fn steps_are_round() {
        assert_eq!([round_step(100.0, 10.0), round_step(101.0, 10.0), round_step(0.3, 4.0)], [10.0, 20.0, 0.1]);
        assert_eq!(round_step(0.0, 4.0), 1.0);
    }

    #[test]
    fn long_texts_end_with_an_ellipsis() {
        assert_eq!(fit("UPPER", 12, 100.0), "UPPER");
        assert_eq!(fit("MAIN SPINDLE TURRET", 10, 62.0), "MAIN SPIN…");
        assert_eq!(fit("MAIN SPINDLE", 10, 37.5), "MAIN…", "no blank before it");
        assert_eq!(fit("MAIN", 10, 15.0), "");
    }

    #[test]
    fn text_is_escaped() {
        assert_eq!(escape("a<b>&\"c\u{1}"), "a&lt;b&gt;&amp;&quot;c?");
    }
}
