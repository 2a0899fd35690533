//! Numbers as texts of a program.

/// A number in decimal digits, at most nine after the point, without zeros at their end.
pub(super) fn shown(value: f64) -> String {
    few_decimals(value).unwrap_or_else(|| nine_decimals(value))
}

fn nine_decimals(value: f64) -> String {
    let text = format!("{value:.9}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// The same for a number with at most three decimals, as nearly all numbers have. Below 4,000,000 the decimals after
/// them are 0, because a number differs from its text by less than half a step of the ninth decimal.
fn few_decimals(value: f64) -> Option<String> {
    let thousandths = (value * 1000.0).round();
    if thousandths.abs() >= 4e9 || thousandths / 1000.0 != value {
        return None;
    }
    let (sign, count) = if thousandths < 0.0 { ("-", -thousandths as u64) } else { ("", thousandths as u64) };
    let (whole, rest) = (count / 1000, count % 1000);
    let mut text = [sign, &whole.to_string()].concat();
    if rest > 0 {
        text.push('.');
        text.push_str((1000 + rest).to_string().get(1..).unwrap_or_default());
        text.truncate(text.trim_end_matches('0').len());
    }
    Some(text)
}

/// Whether this is a number as written in a program.
pub(super) fn is_number(text: &str) -> bool {
    let digits = text.strip_prefix(['+', '-']).unwrap_or(text);
    let plain = digits.bytes().all(|byte| byte.is_ascii_digit() || byte == b'.');
    plain && digits.bytes().filter(|byte| *byte == b'.').count() < 2 && digits.bytes().any(|byte| byte.is_ascii_digit())
}

#[cfg(test)]
mod tests {
    use super::{few_decimals, nine_decimals, shown};

    #[test]
    fn both_ways_of_writing_a_number_agree() {
        for (value, text) in
            [(0.0, "0"), (-0.0, "0"), (5.0, "5"), (-0.001, "-0.001"), (12.5, "12.5"), (0.1 + 0.2, "0.3")]
        {
            assert_eq!(shown(value), text);
        }
        for step in (0..4_000_000_000_u64).step_by(1_234_567) {
            let value = step as f64 / 1000.0;
            for value in [value, -value] {
                assert_eq!(few_decimals(value), Some(nine_decimals(value)), "{value:?}");
            }
        }
        assert_eq!((few_decimals(0.000_5), few_decimals(4_000_000.0), few_decimals(f64::NAN)), (None, None, None));
    }
}
