//! Short meanings of identifiers.
//!
//! An own identifier has its meaning in its row, the others in `meanings.tsv`, where a star is the rest of a name and
//! `{}` that rest. *Invariant:* every built-in identifier has a meaning; without a row it is its name in plain words.

/// Identifier and meaning, a line each.
const MEANINGS: &str = include_str!("meanings.tsv");

/// Parts of names that are not words.
const WORDS: &[(&str, &str)] = &[
    ("CALSUB", "call of a subprogram"),
    ("CCLW", "counter-clockwise"),
    ("CLW", "clockwise"),
    ("COMP", "compensation"),
    ("COOLNT", "with coolant"),
    ("DIAM", "diameter"),
    ("ID", "number"),
    ("INTERP", "interpolation"),
    ("REG", "register"),
    ("RPM", "per minute"),
    ("UPM", "per minute"),
    ("UPR", "per revolution"),
];

/// The meaning of a built-in code or of built-in data; none of other names.
#[must_use]
pub fn of(name: &str) -> Option<String> {
    let (name, own) =
        match (super::code(name).and_then(super::code_facts), super::data(name).and_then(super::data_facts)) {
            (Some(code), _) => (code.name, code.meaning),
            (None, Some(data)) => (data.name, data.meaning),
            (None, None) => return None,
        };
    let own = own.trim_start_matches(": ");
    if !own.is_empty() {
        return Some(own.to_owned());
    }
    Some(row(name).unwrap_or_else(|| in_words(name)))
}

/// The meaning in the table: of the name itself, otherwise of the longest beginning of it.
fn row(name: &str) -> Option<String> {
    let rows = || MEANINGS.lines().filter_map(|line| line.split_once('\t'));
    if let Some((_, meaning)) = rows().find(|(row, _)| *row == name) {
        return Some(meaning.to_owned());
    }
    let rest = |row: &str| name.strip_prefix(row.strip_suffix('*')?);
    let (row, meaning) = rows().filter(|(row, _)| rest(row).is_some()).max_by_key(|(row, _)| row.len())?;
    let rest = rest(row).unwrap_or_default().replace('_', " ");
    Some(meaning.replace("{}", if rest.contains(' ') { rest.to_lowercase() } else { rest }.as_str()))
}

/// The name without its prefix in plain words.
fn in_words(name: &str) -> String {
    let parts = name.split('_').skip(1).map(|part| {
        let known = WORDS.iter().find(|(short, _)| *short == part);
        known.map_or_else(|| part.to_ascii_lowercase(), |(_, word)| (*word).to_owned())
    });
    parts.collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::super::{codes, data};
    use super::*;

    #[test]
    fn every_row_is_of_an_identifier_and_every_identifier_has_a_meaning() {
        let names = || codes::TABLE.iter().map(|facts| facts.name).chain(data::TABLE.iter().map(|facts| facts.name));
        for line in MEANINGS.lines() {
            let (row, meaning) = line.split_once('\t').expect("a tab");
            let of = |name: &str| row.strip_suffix('*').map_or(name == row, |start| name.starts_with(start));
            assert!(names().any(of) && !meaning.is_empty(), "{line}");
            assert_eq!(row.ends_with('*'), meaning.contains("{}"), "{line}");
        }
        for name in names() {
            let meaning = of(name).expect("a built-in name");
            assert!(!meaning.is_empty() && !meaning.contains('{'), "{name}");
        }
    }

    #[test]
    fn meanings_come_from_rows_beginnings_and_names() {
        assert_eq!(of("CODE_THREAD_MULTI").as_deref(), Some("threading cycle, all passes"));
        assert_eq!(
            of("code_position_preset").as_deref(),
            Some("preset of the work frame (Fanuc G50/G92 with axis words)")
        );
        assert_eq!(of("CODE_CLAMP_CT2").as_deref(), Some("clamps the axis CT2"));
        assert_eq!(of("CODE_SPINDLE01_CCLW").as_deref(), Some("spindle01 counter-clockwise"));
        assert_eq!(of("DATA_LCS_TRANS_X").as_deref(), Some("shift along X"));
        assert_eq!(of("CODE_NO_SUCH"), None);
    }
}
