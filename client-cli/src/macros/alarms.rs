//! Alarms of controls by number, from the list of alarms.
//!
//! *Invariant:* an alarm that a shipped machine shows is in the list; the test compares both.

use super::explain::{page, without_links};

const LIST: &str = include_str!("../../../docs/alarms.md");

/// Rows of the list that name an alarm, with the pages of their diagnostics.
pub(super) fn listed(what: &str) -> Option<String> {
    let what = what.trim();
    let asked = what.to_uppercase();
    let long = asked.bytes().filter(u8::is_ascii_digit).count() > 2;
    if !long || !asked.bytes().all(|byte| byte.is_ascii_alphanumeric()) {
        return None;
    }
    let mut out = String::new();
    let mut known: Vec<u32> = Vec::new();
    for line in LIST.lines().filter(|line| line.starts_with('|')) {
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        let [first, about, here] = cells.as_slice() else { continue };
        let found = names(first, &asked) || !first.starts_with(|c: char| c.is_ascii_digit()) && names(about, &asked);
        if !found {
            continue;
        }
        out.push_str(&format!("{first}: {about}: {}\n\n", without_links(here)));
        let numbers = here.split("diagnostics/").skip(1).filter_map(|link| link.get(..8)?.parse::<u32>().ok());
        for number in numbers {
            if !known.contains(&number) {
                known.push(number);
            }
        }
    }
    for text in known.iter().filter_map(|number| page(&number.to_string())) {
        out.push_str(&text);
        out.push('\n');
    }
    (!out.is_empty()).then_some(out)
}

/// The text has the alarm as a word, or within a range (`10740 to 10747`).
fn names(text: &str, asked: &str) -> bool {
    let words: Vec<&str> = text.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty()).collect();
    let within = |range: &[&str]| {
        let [from, "to", to] = range else { return false };
        let (letters, number) = parts(asked);
        let ends = [parts(from), parts(to)];
        let same = ends.iter().all(|(of, _)| *of == letters);
        same && matches!((ends[0].1, number, ends[1].1), (Some(from), Some(at), Some(to)) if from <= at && at <= to)
    };
    words.contains(&asked) || words.windows(3).any(within)
}

/// Letters and number of an alarm.
fn parts(alarm: &str) -> (&str, Option<u32>) {
    let digits = alarm.trim_start_matches(|c: char| c.is_ascii_alphabetic());
    (alarm.strip_suffix(digits).unwrap_or_default(), digits.parse().ok())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::local_machine::all_shipped;
    use crate::macros::explanation;

    #[test]
    fn every_alarm_of_a_shipped_machine_can_be_explained() {
        let mut missing = Vec::new();
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
                if is_number && explanation(&alarm).is_none() {
                    missing.push(format!("{name}: {alarm}"));
                }
            }
        }
        missing.sort();
        missing.dedup();
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
            ("ps0160", "waiting codes"),
        ] {
            assert!(listed(alarm).is_some_and(|text| text.contains(says)), "{alarm}");
        }
        assert!(listed("99999").is_none() && listed("10").is_none() && listed("no-feed").is_none());
    }
}
