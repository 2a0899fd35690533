//! The rows of a machine that a program word selects.
//!
//! *Invariant:* the rows are those that the scanner finds for the word alone; conditions on other words are shown but
//! not tested.

use counterpoint_kernel::machine::Machine;
use counterpoint_kernel::machine::ident;
use counterpoint_kernel::machine::index::{CodeRowId, DataRowId, RegisterId};
use counterpoint_kernel::machine::rows::{CodeForm, Register};
use counterpoint_kernel::machine::tables::form_range;

/// The meaning of a word on a machine.
#[derive(Debug, Default, PartialEq)]
pub(super) struct WordMeaning {
    pub(super) word: String,
    pub(super) codes: Vec<CodeRowId>,
    pub(super) data: Vec<DataRowId>,
    /// The register, and the value that the word has.
    pub(super) register: Option<(RegisterId, Option<f64>)>,
}

/// The rows of a word, a text or an identifier; none if the machine has none of them.
pub(super) fn find(machine: &Machine, word: &str) -> Option<WordMeaning> {
    let joined = || registered(machine, &joined(word)?);
    let found = identifier(machine, word)
        .or_else(|| text(machine, word))
        .or_else(|| registered(machine, word))
        .or_else(joined)?;
    let rows = !found.codes.is_empty() || !found.data.is_empty();
    // A letter alone has codes without a separate row.
    let letter = found.register.is_some_and(|(register, value)| value.is_none() && machine.tables.has_codes(register));
    (rows || letter).then_some(found)
}

/// A name of several words as one, as the tables write it: `TOOL CALL` is `TOOLCALL`.
fn joined(word: &str) -> Option<String> {
    let parts: Vec<&str> = word.split_whitespace().collect();
    let is_name = |part: &&str| part.len() > 2 && part.bytes().all(|b| b.is_ascii_alphabetic());
    (parts.len() > 1 && parts.iter().all(is_name)).then(|| parts.concat())
}

/// The register of a word, also where it has no rows.
pub(super) fn register_of(machine: &Machine, word: &str) -> Option<WordMeaning> {
    registered(machine, word)
}

/// `CODE_RAPID`, `REG_AXIS_X`.
fn identifier(machine: &Machine, word: &str) -> Option<WordMeaning> {
    let is = |name: &str, built_in: Option<&str>| name.eq_ignore_ascii_case(built_in.unwrap_or(word));
    let code = ident::code(word).and_then(ident::code_facts).map(|facts| facts.name);
    let data = ident::data(word).and_then(ident::data_facts).map(|facts| facts.name);
    let codes = machine.codes.entries().filter(|(_, row)| is(machine.code_name(row.id), code)).map(|(id, _)| id);
    let rows = machine.data.entries().filter(|(_, row)| is(machine.data_name(row.id), data)).map(|(id, _)| id);
    let (codes, data): (Vec<_>, Vec<_>) = (codes.collect(), rows.collect());
    let none = codes.is_empty() && data.is_empty();
    (!none).then(|| WordMeaning { word: word.to_ascii_uppercase(), codes, data, register: None })
}

/// A word of several letters without a number.
fn text(machine: &Machine, word: &str) -> Option<WordMeaning> {
    let is = |form: &CodeForm| matches!(form, CodeForm::Text(text) if text.trim().eq_ignore_ascii_case(word));
    let codes: Vec<_> = machine.codes.entries().filter(|(_, row)| is(&row.form)).map(|(id, _)| id).collect();
    // A text may be the letter of an axis, too: `X` of `TOOL CALL 1 X`.
    let data = registered(machine, word).map(|found| (found.data, found.register));
    let (data, register) = data.unwrap_or_default();
    (!codes.is_empty()).then(|| WordMeaning { word: word.to_ascii_uppercase(), codes, data, register })
}

/// A register with or without a value.
fn registered(machine: &Machine, word: &str) -> Option<WordMeaning> {
    let mut named = machine.registers.entries().filter_map(|(id, register)| Some((id, value_of(register, word)?)));
    let first = named.next()?;
    let longest = |(id, _): &(RegisterId, Option<f64>)| machine.registers[*id].before.len();
    let (id, value) = named.fold(first, |best, next| if longest(&next) > longest(&best) { next } else { best });
    let data = machine.tables.data_of(id).to_vec();
    let Some(number) = value else {
        let word = word.to_ascii_uppercase();
        return Some(WordMeaning { word, codes: Vec::new(), data, register: Some((id, None)) });
    };
    let mut codes = machine.tables.code(id, number).to_vec();
    if codes.is_empty() {
        // Disabled rows are shown if there are no others.
        let covers =
            |form: &CodeForm| form_range(form).is_some_and(|(of, min, max)| of == id && (min..=max).contains(&number));
        codes = machine.codes.entries().filter(|(_, row)| covers(&row.form)).map(|(id, _)| id).collect();
    }
    Some(WordMeaning { word: word.to_ascii_uppercase(), codes, data, register: Some((id, value)) })
}

/// The value of a word with this register: its own name, its second one, or its texts around a number.
fn value_of(register: &Register, word: &str) -> Option<Option<f64>> {
    let cut = |name: &str| -> Option<String> {
        let start = word.get(..name.len()).filter(|start| start.eq_ignore_ascii_case(name) && !name.is_empty())?;
        word.strip_prefix(start).map(|rest| rest.trim().to_owned())
    };
    let names = [register.before.as_str(), register.name.as_str(), register.second.as_deref().unwrap_or_default()];
    if names.iter().any(|name| name.trim().eq_ignore_ascii_case(word)) {
        return Some(None);
    }
    names.iter().find_map(|name| {
        let rest = cut(name)?;
        let number = rest.strip_suffix(register.after.as_str()).unwrap_or(&rest).trim();
        if number.is_empty() {
            return Some(None);
        }
        let plain = number.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '.' | '-' | '+'));
        plain.then(|| number.parse().ok()).flatten().map(Some)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::local_machine::LocalMachine;

    fn codes(machine: &str, word: &str) -> Vec<String> {
        let machine = LocalMachine::shipped(machine).load().unwrap_or_else(|error| panic!("{error}"));
        let found = find(&machine, word).unwrap_or_default();
        found.codes.iter().map(|row| machine.code_name(machine.codes[*row].id).to_owned()).collect()
    }

    #[test]
    fn words_texts_and_identifiers_are_found() {
        assert_eq!(codes("haas-lathe", "g76"), ["CODE_THREAD_MULTI"]);
        assert_eq!(codes("heidenhain-mill", "CYCL DEF 7"), ["CODE_LCS_TRANSLATE_ON"]);
        assert_eq!(codes("heidenhain-mill", "plane reset stay"), ["CODE_IGNORE"]);
        assert_eq!(codes("fanuc-mill", "code_rapid"), ["CODE_RAPID"]);
        assert!(codes("fanuc-mill", "G411").is_empty() && codes("fanuc-mill", "FOO").is_empty());
    }

    #[test]
    fn a_letter_alone_and_a_letter_with_a_value_have_data() {
        let machine = LocalMachine::shipped("fanuc-mill").load().unwrap_or_else(|error| panic!("{error}"));
        for (word, value) in [("X", None), ("X-12.5", Some(-12.5)), ("x1.", Some(1.0))] {
            let found = find(&machine, word).unwrap_or_default();
            assert!(!found.data.is_empty() && found.codes.is_empty(), "{word}");
            assert_eq!(found.register.and_then(|(_, value)| value), value, "{word}");
        }
        assert!(find(&machine, "G").is_some_and(|found| found.codes.is_empty()));
    }
}
