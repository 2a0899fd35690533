//! The names by which rows of a child are matched with rows of its parent.
//!
//! *Invariant:* two rows of a section have the same name if and only if the later row replaces the earlier one.

use crate::toml::node::{TomlTable, TomlValue};

/// The key by which a child's row finds the row of the parent that it replaces.
pub(super) fn row_name(path: &str, row: &TomlTable) -> Option<String> {
    match path {
        "registers" | "axes" | "dialogs" | "macros.code" | "macros.data" | "tool.names" | "external" => {
            row.text("name").map(str::to_owned)
        }
        "codes" => {
            let form = row.text("word").map(|word| format!("word {word}"));
            let form = form.or_else(|| row.text("text").map(|text| format!("text {text}")));
            let depends = row.get("with").is_some() || row.get("without").is_some();
            let axis = row.text("axis").filter(|_| depends).map(|axis| format!(" axis {axis}"));
            Some(format!("{} {}{}", identifier(row)?, form.unwrap_or_default(), axis.unwrap_or_default()))
        }
        "waits" => ["word", "text", "statement"].iter().find_map(|form| row.text(form)).map(str::to_owned),
        "components" => row.text("designator").map(str::to_owned),
        "system_variables" => match &row.get("first")?.value {
            TomlValue::Integer(number) => Some(number.to_string()),
            _ => None,
        },
        "subprograms.calls" => row.text("word").map(str::to_owned),
        "refusals" => row.text("name").or_else(|| row.text("alarm")).map(str::to_owned),
        "data" => Some(format!("{} {}", identifier(row)?, row.text("register").unwrap_or_default())),
        "channels" | "spindles" | "diagnostics" | "work_offsets" | "tool.offsets" | "tool.data" => {
            match &row.get("number")?.value {
                TomlValue::Integer(number) => Some(number.to_string()),
                _ => None,
            }
        }
        _ => None,
    }
}

/// Identifier of a row, in a uniform spelling.
fn identifier(row: &TomlTable) -> Option<String> {
    use crate::ident;
    let name = row.text("id")?;
    let code = ident::code(name).and_then(ident::code_facts).map(|facts| facts.name);
    let data = ident::data(name).and_then(ident::data_facts).map(|facts| facts.name);
    Some(code.or(data).map_or_else(|| name.to_ascii_uppercase(), str::to_owned))
}
