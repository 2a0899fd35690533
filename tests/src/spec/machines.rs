//! The machine of an example: a complete machine in a fence `toml`, or a named one with the additions of a fence `toml
//! add`.
//!
//! *Invariant:* additions win: tables are merged key by key, rows of arrays come after those of the named machine,
//! every other value replaces the previous one.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::OnceLock;

use counterpoint_mdspec::Example;
use toml_edit::{ArrayOfTables, DocumentMut, Item, Table, TableLike, Value};

/// The machines with a name: files of `tests/spec/machines` without their ending.
fn named() -> &'static BTreeMap<String, String> {
    static MACHINES: OnceLock<BTreeMap<String, String>> = OnceLock::new();
    MACHINES.get_or_init(|| {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("spec/machines");
        let files = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
        let name = |path: &Path| Some(path.file_stem()?.to_string_lossy().into_owned());
        files.filter_map(|path| Some((name(&path)?, std::fs::read_to_string(&path).ok()?))).collect()
    })
}

/// The machine of an example as TOML.
///
/// # Errors
/// Line and reason, when there is no machine, no machine of that name, or TOML that cannot be read.
pub fn definition(example: &Example) -> Result<String, (usize, String)> {
    let fence = example.fence("toml");
    if let Some(fence) = fence {
        match fence.words.as_str() {
            "" => return Ok(fence.body.text.clone()),
            "add" => {}
            other => return Err((fence.line, format!("'toml {other}' means nothing; write 'toml' or 'toml add'"))),
        }
    }
    let Some(machine) = &example.machine else {
        let text =
            "this example has no machine: write 'machine: NAME' at the head of the page or section, or a fence toml";
        return Err((example.line, text.to_owned()));
    };
    let Some(base) = named().get(&machine.name) else {
        let known: Vec<&str> = named().keys().map(String::as_str).collect();
        return Err((
            machine.line,
            format!("no machine is called '{}'; known are: {}", machine.name, known.join(", ")),
        ));
    };
    let Some(fence) = fence else { return Ok(base.clone()) };
    let add = fence.body.text.parse::<DocumentMut>().map_err(|error| (fence.line, error.to_string()))?;
    let mut whole =
        base.parse::<DocumentMut>().map_err(|error| (machine.line, format!("{}.toml: {error}", machine.name)))?;
    merge(whole.as_table_mut(), add.as_table());
    Ok(whole.to_string())
}

fn merge(base: &mut dyn TableLike, add: &dyn TableLike) {
    for (key, new) in add.iter() {
        match base.get_mut(key) {
            Some(old) => merge_item(old, new),
            None => drop(base.insert(key, detached(new))),
        }
    }
}

fn merge_item(old: &mut Item, new: &Item) {
    if let (Some(old), Some(new)) = (old.as_table_like_mut(), new.as_table_like()) {
        return merge(old, new);
    }
    if let (Some(mut rows), Some(further)) = (rows(old), rows(new)) {
        rows.extend(further);
        *old = Item::ArrayOfTables(rows.into_iter().collect::<ArrayOfTables>());
        return;
    }
    *old = detached(new);
}

/// The rows of an array of tables, however it is written. An array that is empty or has other values has none.
fn rows(item: &Item) -> Option<Vec<Table>> {
    let bare = |mut table: Table| {
        table.set_position(None);
        table
    };
    match item {
        Item::ArrayOfTables(tables) => Some(tables.iter().cloned().map(bare).collect()),
        Item::Value(Value::Array(array)) if !array.is_empty() => {
            array.iter().map(|row| row.as_inline_table().map(|row| bare(row.clone().into_table()))).collect()
        }
        _ => None,
    }
}

/// An item that takes its place in another document: the place it had in its own is forgotten.
fn detached(item: &Item) -> Item {
    let mut item = item.clone();
    match &mut item {
        Item::Table(table) => forget(table),
        Item::ArrayOfTables(tables) => tables.iter_mut().for_each(forget),
        _ => {}
    }
    item
}

fn forget(table: &mut Table) {
    table.set_position(None);
    for (_, item) in table.iter_mut() {
        match item {
            Item::Table(table) => forget(table),
            Item::ArrayOfTables(tables) => tables.iter_mut().for_each(forget),
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use counterpoint_kernel::files::MemoryFiles;
    use counterpoint_kernel::machine::load;
    use counterpoint_kernel::machine::package::Overlay;
    use counterpoint_mdspec::Page;
    use toml_edit::DocumentMut;

    use super::{definition, merge, named};
    use crate::spec::FENCES;

    fn merged(base: &str, add: &str) -> String {
        let (mut base, add) = (base.parse::<DocumentMut>().unwrap(), add.parse::<DocumentMut>().unwrap());
        merge(base.as_table_mut(), add.as_table());
        base.to_string()
    }

    #[test]
    fn tables_merge_rows_append_values_replace() {
        let base = "extends = \"mill\"\n[ce]\nname = \"mill\"\n[[axes]]\nname = \"X\"\n[tool]\noffsets = [1, 2]\n";
        let add = "ce.name = \"other\"\ntool = { change = 3, offsets = [3] }\naxes = [{ name = \"Y\" }, { name = \"Z\" }]\n\
                   [[codes]]\nid = \"A\"\n";
        let whole: toml::Table = merged(base, add).parse().unwrap();
        let expected: toml::Table = "extends = \"mill\"\nce.name = \"other\"\ntool = { offsets = [3], change = 3 }\n\
            axes = [{ name = \"X\" }, { name = \"Y\" }, { name = \"Z\" }]\ncodes = [{ id = \"A\" }]\n"
            .parse()
            .unwrap();
        assert_eq!(whole, expected);
    }

    #[test]
    fn a_machine_that_is_not_there_is_named_with_its_line() {
        let page = |text: &str| Page::parse(Path::new("page.md"), text, FENCES).unwrap().examples.remove(0);
        let (line, text) = definition(&page("# Page\n\nmachine: mil\n\n```nc\nM30\n```\n")).unwrap_err();
        assert!(line == 3 && text.starts_with("no machine is called 'mil'; known are: "), "{line} {text}");
        let (line, text) = definition(&page("```nc\nM30\n```\n")).unwrap_err();
        assert!(line == 1 && text.starts_with("this example has no machine"), "{line} {text}");
        let (line, text) = definition(&page("machine: mill\n\n```toml more\n```\n")).unwrap_err();
        assert!(line == 3 && text.starts_with("'toml more' means nothing"), "{line} {text}");
    }

    #[test]
    fn every_named_machine_loads() {
        for (name, text) in named() {
            let mut folder = MemoryFiles::default();
            folder.insert("example/machine.toml", text.clone());
            let found: Vec<_> = load(&Overlay::new(folder, crate::library()), "example").findings;
            // The examples give the composite machine its components.
            let complete = !matches!(name.as_str(), "lathe" | "composite" | "siemens-composite");
            assert!(found.is_empty() || !complete, "{name}: {found:?}");
            assert!(text.contains(&format!("name = \"{name}\"")), "{name} calls itself otherwise");
        }
    }
}
