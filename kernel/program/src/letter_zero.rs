//! A letter O where a zero is meant, the commonest slip of the keyboard in programs.

/// Hint for a word of the block with the letter O in place of a zero (`X5O`, `G O1`), if `left` has one.
pub fn letter_for_zero(left: &str, block: &str) -> String {
    let is_o = |c: char| matches!(c, 'O' | 'o');
    if !left.contains(is_o) {
        return String::new();
    }
    let number = |c: char| c.is_ascii_digit() || is_o(c) || matches!(c, '.' | '+' | '-');
    let mut rest = block;
    let mut before = ' ';
    while let Some(letter) = rest.chars().next() {
        let tail = rest.get(letter.len_utf8()..).unwrap_or_default();
        let address = letter.is_ascii_alphabetic() && !is_o(letter) && !before.is_ascii_alphabetic();
        if address {
            let length = tail.len() - tail.trim_start_matches(number).len();
            let (value, after) = tail.split_at(length);
            let letters = value.chars().filter(|c| is_o(*c)).count();
            let name = letters > 1 || after.starts_with(|c: char| c.is_ascii_alphabetic());
            let name = name && !value.contains(|c: char| c.is_ascii_digit());
            if letters > 0 && !name {
                return format!(": {letter}{value} has the letter O for a zero");
            }
        }
        (rest, before) = (tail, letter);
    }
    String::new()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_letter_for_a_zero_is_found_in_words() {
        let hint = |left: &str, block: &str| letter_for_zero(left, block);
        assert_eq!(hint("O", "G90 G0 X5O Y1."), ": X5O has the letter O for a zero");
        assert_eq!(hint("O.", "G1 X1O. F100"), ": X1O. has the letter O for a zero");
        assert_eq!(hint("GO", "GO X1."), ": GO has the letter O for a zero");
        assert_eq!(hint("o", "g1 z-o.5"), ": z-o.5 has the letter O for a zero");
        assert_eq!(hint("POCKET", "POCKET4(1)"), "");
        assert_eq!(hint("FOO O", "GOTO 1 FOO O"), "");
        assert_eq!(hint("NOISE", "G0 X1. NOISE"), "");
        assert_eq!(hint("Q", "G1 XO Q"), "");
    }
}
