//! Names of a family of variables written as one: `$[L]{XYZ}M`.
//!
//! Invariant: the names come in the order of the pattern, each once.

/// All names of a pattern: `[ab]` is left out or one of a and b, `{ab}` is one of them.
pub(super) fn expand(pattern: &str) -> Vec<String> {
    let mut names = vec![String::new()];
    let mut rest = pattern;
    while let Some(first) = rest.chars().next() {
        let close = match first {
            '[' => Some(']'),
            '{' => Some('}'),
            _ => None,
        };
        let inside = close.and_then(|close| rest.get(1..)?.split_once(close));
        let choices: Vec<String> = match inside {
            Some((letters, after)) => {
                rest = after;
                let none = (first == '[').then(String::new);
                none.into_iter().chain(letters.chars().map(String::from)).collect()
            }
            None => {
                rest = rest.get(first.len_utf8()..).unwrap_or("");
                vec![first.to_string()]
            }
        };
        names = names.iter().flat_map(|name| choices.iter().map(move |choice| format!("{name}{choice}"))).collect();
    }
    names
}

#[cfg(test)]
mod tests {
    use super::expand;

    #[test]
    fn patterns_become_names() {
        assert_eq!(expand("$TAPEN"), ["$TAPEN"]);
        assert_eq!(expand("$[L]{XY}M"), ["$XM", "$YM", "$LXM", "$LYM"]);
        assert_eq!(expand("${A}[TH]M"), ["$AM", "$ATM", "$AHM"]);
    }
}
