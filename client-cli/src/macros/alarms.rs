//! Alarms of controls by number, from the list of alarms.
//!
//! *Invariant:* an alarm that a shipped machine shows is in the list; the test compares both.

use super::links::without_links;

const LIST: &str = include_str!("../../../docs/alarms.md");

/// Rows of the list that name an alarm, and the numbers of their diagnostics. `is` compares a word with the alarm.
pub(super) fn listed(asked: &str, is: impl Fn(&str) -> bool) -> (Vec<String>, Vec<u32>) {
    // A code that a row mentions does not name an alarm.
    let is_long = asked.bytes().filter(u8::is_ascii_digit).count() > 2 && !asked.starts_with(['G', 'M']);
    let is = |word: &str| is(word) || is_long && word == asked;
    let (mut rows, mut numbers) = (Vec::new(), Vec::<u32>::new());
    for line in LIST.lines().filter(|line| line.starts_with('|')) {
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        let [first, about, here] = cells.as_slice() else { continue };
        if !names(first, asked, is) && (is_alarm(first) || !names(about, asked, is)) {
            continue;
        }
        rows.push(format!("{first}: {about}: {}", without_links(here)));
        let links = here.split("diagnostics/").skip(1).filter_map(|link| link.get(..8)?.parse::<u32>().ok());
        for number in links {
            if !numbers.contains(&number) {
                numbers.push(number);
            }
        }
    }
    (rows, numbers)
}

/// Whether the first cell of a row has alarms, not the name of a control.
fn is_alarm(cell: &str) -> bool {
    cell.starts_with("PS") || cell.starts_with(|c: char| c.is_ascii_digit())
}

/// Whether the text has the alarm as a word, or within a range (`10740 to 10747`).
fn names(text: &str, asked: &str, is: impl Fn(&str) -> bool) -> bool {
    let words: Vec<&str> = text.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty()).collect();
    let within = |range: &[&str]| {
        let [from, "to", to] = range else { return false };
        let (letters, number) = parts(asked);
        let ends = [parts(from), parts(to)];
        let same = ends.iter().all(|(of, _)| *of == letters);
        same && matches!((ends[0].1, number, ends[1].1), (Some(from), Some(at), Some(to)) if from <= at && at <= to)
    };
    words.iter().any(|word| is(word)) || words.windows(3).any(within)
}

/// Letters and number of an alarm.
fn parts(alarm: &str) -> (&str, Option<u32>) {
    let digits = alarm.trim_start_matches(|c: char| c.is_ascii_alphabetic());
    (alarm.strip_suffix(digits).unwrap_or_default(), digits.parse().ok())
}

/// Alarms of the list, each with its meaning and its diagnostics.
#[cfg(test)]
pub(crate) fn rows() -> Vec<(String, String, Vec<String>)> {
    let mut all = Vec::new();
    for line in LIST.lines().filter(|line| line.starts_with('|')) {
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        let [first, about, here] = cells.as_slice() else { continue };
        let source = if is_alarm(first) { *first } else { *about };
        let numbers: Vec<String> =
            here.split("diagnostics/").skip(1).filter_map(|link| link.get(..8).map(str::to_owned)).collect();
        for word in source.split(|c: char| !c.is_ascii_alphanumeric()) {
            let digits = word.trim_start_matches("PS");
            if digits.len() > 3 && digits.bytes().all(|b| b.is_ascii_digit()) {
                all.push((word.to_owned(), (*about).to_owned(), numbers.clone()));
            }
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use crate::local_machine::all_shipped;
    use crate::macros::explanation;

    #[test]
    fn every_alarm_of_a_shipped_machine_can_be_explained() {
        let mut alarms = BTreeMap::new();
        for (name, machine) in all_shipped() {
            let refused = machine.diagnostics.refusals.iter().map(|rule| rule.alarm.clone());
            let titled = machine.diagnostics.rules.iter().filter_map(|rule| {
                let first = rule.text.as_ref()?.split(' ').next()?.to_owned();
                (first.len() > 3 && first.bytes().all(|byte| byte.is_ascii_digit())).then_some(first)
            });
            for alarm in refused.chain(titled) {
                let alarm = alarm.split(' ').next().unwrap_or_default().to_owned();
                // Statements that a control lacks have their own names.
                let is_number =
                    alarm.len() > 3 && !alarm.starts_with('M') && alarm.ends_with(|c: char| c.is_ascii_digit());
                if is_number {
                    alarms.insert(alarm, name.clone());
                }
            }
        }
        let missing: Vec<_> = alarms.iter().filter(|(alarm, _)| explanation(alarm).is_none()).collect();
        assert!(missing.is_empty(), "{missing:?}");
    }

    #[test]
    fn alarms_and_ranges() {
        for (alarm, says) in [
            ("12550", "unknown name"),
            ("12470", "unknown G function"),
            ("10743", "soft approach"),
            ("14040", "circles"),
            ("16949", "do not correspond"),
            ("17181", "edge D"),
            ("2255", "L of an arc"),
            ("PS0201", "rigid tapping"),
            ("PS0218", "polygon turning"),
            ("ps0160", "waiting codes"),
            ("PS5", "address without a number"),
            ("P170", "offset number"),
        ] {
            assert!(explanation(alarm).is_some_and(|text| text.contains(says)), "{alarm}");
        }
        for nothing in ["99999", "9999", "PS9999"] {
            assert!(explanation(nothing).is_none(), "{nothing}");
        }
    }

    /// Every alarm of the list with its meaning and the pages of all its diagnostics.
    #[test]
    fn every_alarm_of_the_list_is_explained_with_its_meaning() {
        let rows = super::rows();
        assert!(rows.len() > 200, "{}", rows.len());
        for (alarm, about, numbers) in rows {
            let text = explanation(&alarm).unwrap_or_default();
            assert!(text.contains(&about), "{alarm}: {about} is not in {text}");
            for number in numbers {
                assert!(text.contains(&format!("# {number} `")), "{alarm} without {number}");
            }
        }
    }
}
