//! `machine show --sort`, `--filter` and the part `undefined`: views of the data of a machine.
//!
//! *Invariant:* rows are omitted or reordered, but never changed.

use std::cmp::Ordering;

use counterpoint_kernel::machine::ident::{codes, data, meaning, takes};
use counterpoint_lang::ident;
use serde_json::{Value, json};

use crate::error::Error;
use crate::fields::JsonFields as _;
use crate::say;
use crate::text::table;

/// How to show the rows of tables.
#[derive(Debug, Default)]
pub(crate) struct TableView {
    /// Heading of the column by which rows are sorted.
    pub(crate) sort: Option<String>,
    /// Text that a row must contain, in any letter case.
    pub(crate) filter: Option<String>,
}

/// Keys of the JSON form that differ from the headings of the tables.
const KEYS: [(&str, &str); 6] =
    [("code", "id"), ("data", "id"), ("axis", "name"), ("macro", "id"), ("channel", "number"), ("register", "name")];

impl TableView {
    fn changes_nothing(&self) -> bool {
        self.sort.is_none() && self.filter.is_none()
    }

    /// Tables with aligned columns, blank lines between them.
    pub(crate) fn text(&self, text: &str) -> Result<String, Error> {
        if self.changes_nothing() {
            return Ok(text.to_owned());
        }
        let tables: Vec<Vec<&str>> = text.split("\n\n").map(|table| table.lines().collect()).collect();
        if let Some(sort) = &self.sort {
            let heads = tables.iter().filter_map(|table| table.first()).filter(|head| !is_summary(head));
            let mut headings: Vec<String> = heads.flat_map(|line| headings(line)).map(|(name, _)| name).collect();
            let mut seen = std::collections::BTreeSet::new();
            headings.retain(|name| seen.insert(name.clone()));
            if !headings.iter().any(|heading| heading == column(sort)) {
                return Err(no_column(sort, &headings));
            }
        }
        let shown = tables.into_iter().filter_map(|mut lines| {
            let head = lines.first().copied()?;
            let mut rows = lines.split_off(1);
            if let Some(filter) = &self.filter {
                rows.retain(|row| has(row, filter));
                if rows.is_empty() {
                    return None;
                }
            }
            if let Some((start, end)) =
                self.sort.as_deref().filter(|_| !is_summary(head)).and_then(|sort| span(head, column(sort)))
            {
                rows.sort_by(|a, b| natural(&cell(a, start, end), &cell(b, start, end)));
            }
            Some(std::iter::once(head).chain(rows).map(|line| format!("{line}\n")).collect::<String>())
        });
        Ok(shown.collect::<Vec<_>>().join("\n"))
    }

    /// Lists of rows; values that are not lists of rows stay unchanged. Also whether a row passed the filter.
    pub(crate) fn json(&self, text: &str) -> Result<(String, bool), Error> {
        let Ok(mut value) = serde_json::from_str::<Value>(text) else { return Ok((text.to_owned(), true)) };
        if self.changes_nothing() {
            return Ok((text.to_owned(), true));
        }
        let (mut sorted, mut any) = (self.sort.is_none(), self.filter.is_none());
        for part in value.as_object_mut().into_iter().flat_map(|object| object.values_mut()) {
            let Some(rows) = part.as_array_mut().filter(|rows| rows.iter().any(Value::is_object)) else { continue };
            if let Some(filter) = &self.filter {
                rows.retain(|row| has(&row.to_string(), filter));
                any |= !rows.is_empty();
            }
            if let Some(sort) = &self.sort {
                let key = key_of(rows, sort);
                sorted |= key.is_some();
                if let Some(key) = key {
                    rows.sort_by(|a, b| natural(&plain(a, key), &plain(b, key)));
                }
            }
        }
        if !sorted {
            return Err(no_column(self.sort.as_deref().unwrap_or_default(), &[]));
        }
        Ok((format!("{}\n", serde_json::to_string_pretty(&value).unwrap_or_default()), any))
    }
}

/// Exit code of a filter that no row passes.
pub(crate) fn no_row(filter: &str) -> u8 {
    say::status_line(format_args!("--filter: no row has '{filter}'"));
    1
}

/// Whether the first table has names and values instead of columns.
fn is_summary(head: &str) -> bool {
    head.starts_with("machine ")
}

/// `file` is the column of files and lines.
fn column(sort: &str) -> &str {
    if sort == "file" { "defined" } else { sort }
}

pub(crate) fn no_column(sort: &str, headings: &[String]) -> Error {
    let near = ident::nearest(sort, headings.iter().map(String::as_str));
    let near = near.map(|near| format!("; did you mean {near}?")).unwrap_or_default();
    let list = if headings.is_empty() { String::new() } else { format!("; columns are {}", headings.join(", ")) };
    Error::Usage(format!("--sort: no column '{sort}'{near}{list}"))
}

fn key_of<'k>(rows: &[Value], sort: &'k str) -> Option<&'k str> {
    let has = |key: &str| rows.iter().any(|row| row.get(key).is_some());
    if sort == "defined" || sort == "file" {
        return has("file").then_some("file");
    }
    let other = KEYS.iter().find(|(heading, _)| *heading == sort).map(|(_, key)| *key);
    if has(sort) { Some(sort) } else { other.filter(|key| has(key)) }
}

/// The key of a column.
pub(crate) fn key(column: &str) -> &str {
    match column {
        "defined" => "file",
        // Rows of codes and data have an identifier and a name.
        "code" | "data" => "id",
        _ => column,
    }
}

/// A value as text; files with their lines.
fn plain(row: &Value, key: &str) -> String {
    let text = |value: &Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
    if key == "file" {
        return format!("{}:{}", text(row.at("file")), text(row.at("line")));
    }
    text(row.at(key))
}

pub(crate) fn has(row: &str, filter: &str) -> bool {
    row.to_lowercase().contains(&filter.to_lowercase())
}

/// Names of columns with the characters at which they begin.
fn headings(line: &str) -> Vec<(String, usize)> {
    let mut found: Vec<(String, usize)> = Vec::new();
    let (mut blanks, mut begun) = (2, false);
    for (at, c) in line.chars().enumerate() {
        if c == ' ' {
            blanks += 1;
            begun &= blanks < 2;
            continue;
        }
        if !begun {
            found.push((String::new(), at));
            begun = true;
        } else if blanks > 0
            && let Some((name, _)) = found.last_mut()
        {
            name.push(' ');
        }
        blanks = 0;
        if let Some((name, _)) = found.last_mut() {
            name.push(c);
        }
    }
    found
}

/// The start of a column and of the next one.
fn span(head: &str, column: &str) -> Option<(usize, usize)> {
    let headings = headings(head);
    let at = headings.iter().position(|(name, _)| name == column)?;
    let start = headings.get(at)?.1;
    Some((start, headings.get(at + 1).map_or(usize::MAX, |(_, next)| *next)))
}

fn cell(row: &str, start: usize, end: usize) -> String {
    row.chars().skip(start).take(end.saturating_sub(start)).collect::<String>().trim().to_owned()
}

/// Compares numbers inside texts by value: G9 before G17, line 9 before line 17.
pub(crate) fn natural(a: &str, b: &str) -> Ordering {
    parts(a).cmp(&parts(b))
}

/// Alternating texts and numbers.
fn parts(text: &str) -> Vec<(String, u64)> {
    let mut parts = Vec::new();
    let mut rest = text;
    while !rest.is_empty() {
        let end = rest.find(|c: char| c.is_ascii_digit()).unwrap_or(rest.len());
        let (before, after) = rest.split_at(end);
        let digits = after.find(|c: char| !c.is_ascii_digit()).unwrap_or(after.len());
        let (number, next) = after.split_at(digits);
        parts.push((before.to_owned(), number.parse().unwrap_or(0)));
        rest = next;
    }
    parts
}

/// Identifiers of the built-in tables without a row of the machine (as JSON); on a composite those of each component,
/// with its name.
pub(crate) fn undefined(machine: &Value) -> Value {
    let components = machine.at("components").as_array().into_iter().flatten();
    let components: Vec<&str> = components.filter_map(|row| row.at("designator").as_str()).collect();
    if components.is_empty() {
        return undefined_of(machine, None);
    }
    let (mut codes, mut data, mut letters) = (Vec::new(), Vec::new(), Vec::new());
    for component in components {
        let found = undefined_of(machine, Some(component));
        for (key, all) in [("codes", &mut codes), ("data", &mut data)] {
            for row in found.at(key).as_array().into_iter().flatten() {
                let mut row = row.clone();
                row.set("component", json!(component));
                all.push(row);
            }
        }
        letters.push(json!({ "component": component, "letters": found.at("letters") }));
    }
    json!({ "codes": codes, "data": data, "letters": letters })
}

fn undefined_of(machine: &Value, component: Option<&str>) -> Value {
    let all = |key: &str| {
        let rows = machine.at(key).as_array().into_iter().flatten();
        rows.filter(|row| row.at("component").as_str() == component)
    };
    let rows = |key: &str| all(key).filter_map(|row| row.at("id").as_str());
    let (has_codes, has_data): (Vec<&str>, Vec<&str>) = (rows("codes").collect(), rows("data").collect());
    let own = codes::TABLE.iter().filter(|facts| !has_codes.contains(&facts.name)).map(|facts| {
        json!({
            "id": facts.name, "meaning": meaning::of(facts.name), "built_in": facts.built_in,
            "with": takes::data_of(facts.name),
        })
    });
    let read = data::TABLE.iter().filter(|facts| !has_data.contains(&facts.name)).map(|facts| {
        let readers: Vec<&str> =
            takes::codes_of(facts.name).into_iter().filter(|code| has_codes.contains(code)).collect();
        json!({
            "id": facts.name, "meaning": meaning::of(facts.name), "built_in": facts.built_in, "with": readers,
        })
    });
    let names: Vec<&str> =
        all("registers").flat_map(|row| [row.at("name"), row.at("second")]).filter_map(Value::as_str).collect();
    let letters: Vec<String> =
        ('A'..='Z').map(String::from).filter(|letter| !names.contains(&letter.as_str())).collect();
    json!({ "codes": own.collect::<Vec<_>>(), "data": read.collect::<Vec<_>>(), "letters": letters })
}

/// The same as tables.
pub(crate) fn undefined_text(undefined: &Value) -> String {
    let tables =
        [("codes", ["code", "action", "meaning", "reads"]), ("data", ["data", "action", "meaning", "read by"])];
    let list = |value: &Value| {
        let all = value.as_array().into_iter().flatten().filter_map(Value::as_str).collect::<Vec<_>>();
        if all.is_empty() { "-".to_owned() } else { all.join(" ") }
    };
    let mut out: Vec<String> = tables
        .iter()
        .map(|(key, heading)| {
            let mut rows = vec![heading.map(str::to_owned).to_vec()];
            rows.extend(undefined.at(key).as_array().into_iter().flatten().map(|row| {
                let text = |key: &str| row.at(key).as_str().unwrap_or_default().to_owned();
                let action = if row.at("built_in") == true { "built-in" } else { "none" };
                let mut cells = vec![text("id"), action.to_owned(), text("meaning"), list(row.at("with"))];
                if row.at("component").is_string() {
                    cells.insert(0, text("component"));
                }
                cells
            }));
            let columns = rows.iter().map(Vec::len).max().unwrap_or(heading.len());
            if columns > heading.len()
                && let Some(head) = rows.first_mut()
            {
                head.insert(0, "component".to_owned());
            }
            let table = table(&rows, columns);
            table.lines().map(|line| format!("{}\n", line.strip_prefix("  ").unwrap_or(line))).collect()
        })
        .collect();
    let letters = undefined.at("letters").as_array().into_iter().flatten();
    let of_components = letters.filter_map(|row| row.at("component").as_str().map(|name| (name, row.at("letters"))));
    let of_components: Vec<String> =
        of_components.map(|(component, letters)| format!("{component}: {}\n", list(letters))).collect();
    let letters = match of_components.as_slice() {
        [] => format!("{}\n", list(undefined.at("letters"))),
        all => all.concat(),
    };
    out.push(format!("letters without a register\n{letters}"));
    out.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLES: &str = "word  code  max rev/min  defined\nG17   B     2            m.toml:17\nG9    A     10           m.toml:9\n\nname  x\nq     1\n";

    fn view(sort: Option<&str>, filter: Option<&str>) -> Result<String, Error> {
        TableView { sort: sort.map(str::to_owned), filter: filter.map(str::to_owned) }.text(TABLES)
    }

    #[test]
    fn rows_are_sorted_by_a_column_and_numbers_count_as_numbers() {
        let words = |text: String| {
            let lines = text.lines().skip(1).map(|line| line.split(' ').next().unwrap_or("").to_owned());
            lines.take(2).collect::<Vec<_>>()
        };
        for sort in ["word", "code", "file", "defined"] {
            assert_eq!(words(view(Some(sort), None).expect("a column")), ["G9", "G17"], "{sort}");
        }
        assert_eq!(words(view(Some("max rev/min"), None).expect("a column")), ["G17", "G9"]);
        let wrong = view(Some("cod"), None).expect_err("no column").to_string();
        assert!(wrong.contains("did you mean code?") && wrong.contains("word, code, max rev/min, defined"), "{wrong}");
    }

    #[test]
    fn tables_without_a_row_are_left_out() {
        let found = view(None, Some("g17")).expect("a table");
        assert_eq!(found.lines().count(), 2, "{found}");
        assert_eq!(view(None, None).ok().as_deref(), Some(TABLES));
        let json = TableView { sort: Some("code".into()), filter: None };
        let (rows, _) = json.json(r#"{"codes":[{"id":"B9"},{"id":"B10"},{"id":"A1"}],"name":"x"}"#).expect("rows");
        let value: Value = serde_json::from_str(&rows).expect("JSON");
        assert_eq!(value["codes"], json!([{ "id": "A1" }, { "id": "B9" }, { "id": "B10" }]));
    }

    #[test]
    fn built_in_identifiers_without_a_row_are_undefined() {
        let machine = json!({ "codes": [{ "id": "CODE_DELAY" }], "data": [{ "id": "REG_TOOL" }], "registers": [{ "name": "X" }] });
        let found = undefined(&machine);
        let has =
            |key: &str, id: &str| found[key].as_array().is_some_and(|rows| rows.iter().any(|row| row["id"] == id));
        assert!(has("codes", "CODE_RAPID") && !has("codes", "CODE_DELAY"));
        assert!(has("data", "REG_DELAY") && !has("data", "REG_TOOL"));
        assert!(undefined_text(&found).contains("REG_DELAY") && undefined_text(&found).contains("A B C"));
    }
}
