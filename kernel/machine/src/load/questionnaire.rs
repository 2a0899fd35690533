//! `[questionnaire]`: the meanings of words, by subject; the answers become rows.
//!
//! Invariant: a row that the file gives itself wins over an answer, and every row made here carries the place of its
//! answer, so that findings and tables name it. Facts: reference control-emulator.md 1.1.

use super::questions::{AnswerConversion, ControlQuestion, SUBJECTS};
use super::row_name::row_name;
use crate::toml::check::FindingCollector;
use crate::toml::node::{DefinitionPlace, Node, TomlEntry, TomlTable, TomlValue};
use crate::toml::section::TableReader;

/// Takes the questionnaire out of the file and adds the rows of its answers.
pub(super) fn expand(table: &mut TomlTable, check: &FindingCollector) {
    let Some(node) = table.get("questionnaire").cloned() else { return };
    table.remove("questionnaire");
    let TomlValue::Table(answers) = &node.value else {
        check.error(&node.place, format!("`questionnaire` must be a table, not {}", node.value.kind()));
        return;
    };
    let mut made = AnswerRows { codes: Vec::new(), data: Vec::new(), check };
    let mut start = Vec::new();
    let mut section = TableReader::new(answers, node.place.clone(), "[questionnaire]", check);
    for subject in SUBJECTS {
        let Some(mut part) = section.table(subject.key, subject.title) else { continue };
        for question in subject.questions {
            if let Some(answer) = part.node(question.key) {
                made.answer(question, answer);
            }
        }
        part.finish();
    }
    for (name, place) in section.texts("start").unwrap_or_default() {
        start.extend(start_code(name, place, check));
    }
    section.finish();
    add(table, "codes", made.codes);
    add(table, "data", made.data);
    if table.get("initial").is_none() && !start.is_empty() {
        table.entries.push(entry("initial", &node.place, TomlValue::Array(start)));
    }
}

/// Rows made so far.
struct AnswerRows<'a> {
    codes: Vec<Node>,
    data: Vec<Node>,
    check: &'a FindingCollector,
}

impl AnswerRows<'_> {
    /// One word, a table with a word and further keys of a row, or a list of them; empty = the control has none.
    fn answer(&mut self, question: &ControlQuestion, node: &Node) {
        match &node.value {
            TomlValue::Array(items) => items.iter().for_each(|item| self.answer(question, item)),
            TomlValue::Text(text) if text.is_empty() => {}
            TomlValue::Text(text) => self.rows(question, (form(question.kind, None), text), &[], &node.place),
            TomlValue::Table(table) => {
                let key = form(question.kind, Some(table));
                let (known, rest): (Vec<_>, Vec<_>) = table.entries.iter().cloned().partition(|e| e.key == key);
                match known.first().map(|entry| &entry.node.value) {
                    Some(TomlValue::Text(text)) => self.rows(question, (key, text), &rest, &node.place),
                    _ => {
                        let text = format!("an answer to `{}` that is a table needs `{key}`", question.key);
                        self.check.error(&node.place, text);
                    }
                }
            }
            other => {
                let text =
                    format!("`{}` must be a word in quotes, a table or a list, not {}", question.key, other.kind());
                self.check.error(&node.place, text);
            }
        }
    }

    fn rows(
        &mut self,
        question: &ControlQuestion,
        (form, text): (&str, &str),
        rest: &[TomlEntry],
        place: &DefinitionPlace,
    ) {
        let word = TomlValue::Text(text.to_owned());
        let row = |id: &str, key: &str, more: Vec<TomlEntry>| {
            let mut entries = vec![entry("id", place, TomlValue::Text(id.to_owned())), entry(key, place, word.clone())];
            let given = |e: &TomlEntry| !rest.iter().any(|r| r.key == e.key);
            entries.extend(more.into_iter().filter(given));
            entries.extend(rest.iter().cloned());
            Node { place: place.clone(), value: TomlValue::Table(TomlTable { entries }) }
        };
        let as_data = |data: &str| entry("as_data", place, TomlValue::Text(data.to_owned()));
        match question.kind {
            AnswerConversion::Code(id) => self.codes.push(row(id, form, Vec::new())),
            AnswerConversion::AsData(id, data) => self.codes.push(row(id, form, vec![as_data(data)])),
            AnswerConversion::Numbered(id, data) => {
                let add = ends(text).map_or(0.0, |(_, first, _)| 1.0 - first);
                self.codes.push(row(id, form, vec![as_data(data), entry("add", place, TomlValue::Float(add))]));
            }
            AnswerConversion::Data(ids) => self.data.extend(ids.iter().map(|id| row(id, form, Vec::new()))),
        }
    }
}

/// Key of the written form in an answer: a register for data, a word for codes, or a text for those without a value.
fn form(kind: AnswerConversion, table: Option<&TomlTable>) -> &'static str {
    match kind {
        AnswerConversion::Data(_) => "register",
        AnswerConversion::Code(_) if table.is_some_and(|table| table.get("text").is_some()) => "text",
        _ => "word",
    }
}

/// The code that `subject.question` names.
fn start_code(name: &str, place: &DefinitionPlace, check: &FindingCollector) -> Option<Node> {
    let (subject, key) = name.split_once('.').unwrap_or(("", name));
    let questions = SUBJECTS.iter().filter(|s| s.key == subject).flat_map(|s| s.questions);
    match questions.clone().find(|q| q.key == key).map(|q| q.kind) {
        Some(AnswerConversion::Code(id) | AnswerConversion::AsData(id, _) | AnswerConversion::Numbered(id, _)) => {
            Some(Node { place: place.clone(), value: TomlValue::Text(id.to_owned()) })
        }
        _ => {
            let text = "`start` names questions that stand for codes, like \"motion.rapid\"";
            check.error(place, format!("{text}, not \"{}\"", name.escape_debug()));
            None
        }
    }
}

fn entry(key: &str, place: &DefinitionPlace, value: TomlValue) -> TomlEntry {
    TomlEntry { key: key.to_owned(), place: place.clone(), node: Node { place: place.clone(), value } }
}

/// Adds the rows that the file does not give itself, after its own.
fn add(table: &mut TomlTable, key: &str, made: Vec<Node>) {
    if made.is_empty() {
        return;
    }
    if table.get(key).is_none() {
        let Some(place) = made.first().map(|row| row.place.clone()) else { return };
        table.entries.push(entry(key, &place, TomlValue::Array(Vec::new())));
    }
    let rows = table.entries.iter_mut().find(|e| e.key == key).map(|e| &mut e.node.value);
    if let Some(TomlValue::Array(rows)) = rows {
        let explicit = rows.len();
        for row in made {
            let own = rows.iter().take(explicit).any(|own| overrides(key, own, &row));
            if !own {
                rows.push(row);
            }
        }
    }
}

/// Whether a row of the file replaces a generated row with the same name, or a generated code row without conditions
/// for the same word.
fn overrides(key: &str, own: &Node, made: &Node) -> bool {
    let (TomlValue::Table(own), TomlValue::Table(made)) = (&own.value, &made.value) else { return false };
    let name = row_name(key, made);
    if name.is_some() && row_name(key, own) == name {
        return true;
    }
    let free = own.get("with").is_none() && own.get("without").is_none();
    let word = |table: &TomlTable| table.text("word").and_then(ends);
    key == "codes" && free && word(own).is_some() && word(own) == word(made)
}

/// Letters and both numbers of a code word, as far as it is one.
fn ends(word: &str) -> Option<(String, f64, f64)> {
    let letters = |text: &str| text.trim_end_matches(|c: char| c.is_ascii_digit() || c == '.').to_owned();
    let number = |text: &str| text.get(letters(text).len()..)?.parse::<f64>().ok();
    let (first, last) = word.split_once('-').unwrap_or((word, word));
    (letters(first) == letters(last)).then_some(())?;
    Some((letters(first), number(first)?, number(last)?))
}
