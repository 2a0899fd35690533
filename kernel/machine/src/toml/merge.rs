//! Merges a machine over the family it extends.
//!
//! Invariant: every row and value of the result still carries the place where it was written.

use super::node::{Node, TomlEntry, TomlTable, TomlValue};

/// Name of a row in the array of tables at a path; `None` when rows there have no name of their own.
pub(crate) type RowName = fn(path: &str, row: &TomlTable) -> Option<String>;

/// Child over parent: tables key by key, rows by their name, everything else replaced.
pub(crate) fn merge(parent: TomlTable, child: TomlTable, row_name: RowName) -> TomlTable {
    merge_tables(parent, child, "", row_name)
}

fn merge_tables(mut parent: TomlTable, child: TomlTable, path: &str, row_name: RowName) -> TomlTable {
    for entry in child.entries {
        let path = if path.is_empty() { entry.key.clone() } else { format!("{path}.{}", entry.key) };
        match parent.entries.iter().position(|known| known.key == entry.key) {
            None => parent.entries.push(entry),
            Some(index) => {
                let old = parent.entries.remove(index);
                parent.entries.insert(index, merge_entries(old, entry, &path, row_name));
            }
        }
    }
    parent
}

fn merge_entries(parent: TomlEntry, child: TomlEntry, path: &str, row_name: RowName) -> TomlEntry {
    let TomlEntry { key, place, node } = child;
    let value = match (parent.node.value, node.value) {
        (TomlValue::Table(old), TomlValue::Table(new)) => TomlValue::Table(merge_tables(old, new, path, row_name)),
        (TomlValue::Array(old), TomlValue::Array(new)) if has_rows(&old) || has_rows(&new) => {
            TomlValue::Array(merge_rows(old, new, path, row_name))
        }
        (_, new) => new,
    };
    TomlEntry { key, place, node: Node { place: node.place, value } }
}

fn has_rows(items: &[Node]) -> bool {
    items.iter().any(|item| matches!(item.value, TomlValue::Table(_)))
}

/// A child's row takes the place of the parent's row of the same name; two equal rows of the child both stay, and the
/// loader reports them.
fn merge_rows(parent: Vec<Node>, child: Vec<Node>, path: &str, row_name: RowName) -> Vec<Node> {
    let name_of = |node: &Node| match &node.value {
        TomlValue::Table(row) => row_name(path, row),
        _ => None,
    };
    let mut rows: Vec<(Option<String>, bool, Node)> =
        parent.into_iter().map(|node| (name_of(&node), true, node)).collect();
    for node in child {
        let name = name_of(&node);
        let old = rows.iter_mut().find(|(known, inherited, _)| *inherited && known.is_some() && *known == name);
        match old {
            Some(old) => *old = (name, false, node),
            None => rows.push((name, false, node)),
        }
    }
    rows.into_iter().map(|(_, _, node)| node).collect()
}
