//! Near misses: the name that was probably meant.
//!
//! Invariant: a suggestion is always one of the names offered.

/// Longest name that is compared.
const MAX_NAME: usize = 64;

/// `; did you mean "…"?` for the nearest of the names, or nothing when none is near.
pub(crate) fn did_you_mean<'n>(name: &str, names: impl IntoIterator<Item = &'n str>) -> String {
    nearest(name, names).map_or(String::new(), |near| format!("; did you mean \"{near}\"?"))
}

/// The nearest of the names, when it is near enough to be meant.
pub(crate) fn nearest<'n>(name: &str, names: impl IntoIterator<Item = &'n str>) -> Option<&'n str> {
    let wanted: Vec<char> = name.chars().take(MAX_NAME).map(|c| c.to_ascii_uppercase()).collect();
    let limit = limit(&wanted);
    names
        .into_iter()
        .map(|candidate| (score(&wanted, candidate), candidate))
        .filter(|(score, candidate)| *score <= limit && *score < candidate.len())
        .min_by_key(|(score, _)| *score)
        .map(|(_, candidate)| candidate)
}

/// Similar names, at most `most`, the nearest first. If none is near, the names that begin with `name`.
#[must_use]
pub fn similar<'n>(name: &str, names: &[&'n str], most: usize) -> Vec<&'n str> {
    /// Minimum length of such a beginning.
    const FEWEST: usize = 3;
    let wanted: Vec<char> = name.chars().take(MAX_NAME).map(|c| c.to_ascii_uppercase()).collect();
    let scored = |candidate: &&'n str| (score(&wanted, candidate), candidate.len(), *candidate);
    let mut found: Vec<_> = names.iter().map(scored).filter(|(score, ..)| *score <= limit(&wanted)).collect();
    if found.is_empty() && wanted.len() >= FEWEST {
        let begins = |candidate: &&&'n str| candidate.get(..name.len()).is_some_and(|b| b.eq_ignore_ascii_case(name));
        found = names.iter().filter(begins).map(|candidate| (0, candidate.len(), *candidate)).collect();
    }
    found.sort_unstable();
    found.into_iter().take(most).map(|(.., candidate)| candidate).collect()
}

/// Maximum number of mistakes for a name to be suggested.
fn limit(wanted: &[char]) -> usize {
    (wanted.len() / 4).clamp(1, 4)
}

/// Distance; a missing `CODE_` or `REG_` counts as one mistake.
fn score(wanted: &[char], candidate: &str) -> usize {
    let upper = candidate.to_ascii_uppercase();
    let bare = upper.strip_prefix("CODE_").or_else(|| upper.strip_prefix("REG_"));
    let full = distance(wanted, &upper);
    bare.map_or(full, |bare| full.min(1 + distance(wanted, bare)))
}

/// Insertions, deletions, replacements and swaps of neighbours that turn one name into the other.
fn distance(a: &[char], b: &str) -> usize {
    let b: Vec<char> = b.chars().take(MAX_NAME).collect();
    let mut two_back: Vec<usize> = Vec::new();
    let mut back: Vec<usize> = (0..=b.len()).collect();
    let mut previous_a = None;
    for (i, &ca) in a.iter().enumerate() {
        let mut row = Vec::with_capacity(back.len());
        row.push(i + 1);
        let mut previous_b = None;
        for (j, &cb) in b.iter().enumerate() {
            let at = |row: &[usize], k: usize| row.get(k).copied().unwrap_or(usize::MAX / 2);
            let mut best = (at(&back, j) + usize::from(ca != cb)).min(at(&back, j + 1) + 1).min(at(&row, j) + 1);
            if previous_a == Some(cb) && previous_b == Some(ca) && j >= 1 {
                best = best.min(at(&two_back, j - 1) + 1);
            }
            row.push(best);
            previous_b = Some(cb);
        }
        previous_a = Some(ca);
        two_back = std::mem::replace(&mut back, row);
    }
    back.last().copied().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_the_name_that_was_meant() {
        assert_eq!(nearest("CODE_RAPDI", ["CODE_RAPID", "CODE_STOP"]), Some("CODE_RAPID"));
        assert_eq!(nearest("rapid", ["CODE_RAPID", "CODE_STOP"]), Some("CODE_RAPID"));
        assert_eq!(nearest("ordr", ["order", "group"]), Some("order"));
        assert_eq!(nearest("banana", ["order", "group"]), None);
        assert_eq!(nearest("Q", ["X", "Z"]), None);
        assert_eq!(nearest("", ["order"]), None);
    }

    #[test]
    fn similar_names_are_near_or_begin_alike() {
        let names = ["mill-5axis", "mill", "lathe", "lathe-b", "lathe-c"];
        assert_eq!(similar("mil", &names, 3), ["mill"]);
        assert_eq!(similar("lathe-d", &names, 2), ["lathe-b", "lathe-c"]);
        assert_eq!(similar("LAT", &names, 2), ["lathe", "lathe-b"]);
        assert!(similar("banana", &names, 3).is_empty() && similar("la", &names, 3).is_empty());
    }
}
