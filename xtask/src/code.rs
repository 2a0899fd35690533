//! The source files of a crate, parsed. Code that only tests see does not count.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// A file of a crate.
pub(crate) struct Code {
    /// Path from the root of the repository, with slashes.
    pub(crate) path: String,
    /// Path of its module in the crate: `channel::scan` for `src/channel/scan.rs`.
    pub(crate) module: Vec<String>,
    pub(crate) text: String,
    pub(crate) file: syn::File,
}

/// The folders of the workspace's crates that have code of their own.
pub(crate) fn crates(root: &Path) -> Result<Vec<String>, String> {
    let path = root.join("Cargo.toml");
    let text = std::fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    let manifest: toml::Table = text.parse().map_err(|error| format!("{}: {error}", path.display()))?;
    let members = manifest.get("workspace").and_then(|w| w.get("members")).and_then(toml::Value::as_array);
    let names = members.into_iter().flatten().filter_map(toml::Value::as_str);
    Ok(names.filter(|name| !matches!(*name, "tests" | "xtask")).map(str::to_owned).collect())
}

/// Whether an item is compiled for tests only.
pub(crate) fn is_test(attributes: &[syn::Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        let syn::Meta::List(list) = &attribute.meta else { return false };
        list.path.is_ident("cfg") && list.tokens.to_string().split(|c: char| !c.is_alphanumeric()).any(|w| w == "test")
    })
}

/// All files of a crate below `src`, in order of their paths.
pub(crate) fn files(root: &Path, crate_: &str) -> Result<Vec<Code>, String> {
    let source = root.join(crate_).join("src");
    let mut open = vec![source.clone()];
    let mut paths: Vec<PathBuf> = Vec::new();
    while let Some(folder) = open.pop() {
        let entries = std::fs::read_dir(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
        for entry in entries.flatten() {
            let path = entry.path();
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                paths.push(path);
            }
        }
    }
    paths.sort();
    let mut codes = Vec::new();
    for path in paths {
        let text = std::fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
        let file = syn::parse_file(&text).map_err(|error| format!("{}: {error}", path.display()))?;
        let relative = path.strip_prefix(&source).unwrap_or(&path).with_extension("");
        let mut module: Vec<String> =
            relative.components().map(|part| part.as_os_str().to_string_lossy().into_owned()).collect();
        if matches!(module.last().map(String::as_str), Some("mod" | "lib" | "main")) {
            module.pop();
        }
        let shown = path.strip_prefix(root).unwrap_or(&path).to_string_lossy().replace('\\', "/");
        codes.push(Code { path: shown, module, text, file });
    }
    // Modules that are declared for tests only, with all below them.
    let tests: Vec<Vec<String>> = codes.iter().flat_map(test_modules).collect();
    codes.retain(|code| !tests.iter().any(|test| code.module.starts_with(test)));
    Ok(codes)
}

fn test_modules(code: &Code) -> Vec<Vec<String>> {
    let declared = code.file.items.iter().filter_map(|item| match item {
        syn::Item::Mod(module) if module.content.is_none() && is_test(&module.attrs) => Some(module.ident.to_string()),
        _ => None,
    });
    declared.map(|name| [code.module.clone(), vec![name]].concat()).collect()
}

/// Folders that hold no text of the project.
const FOREIGN: [&str; 4] = ["target", "node_modules", ".git", "out"];

/// Text files of the repository with these extensions, by their paths with slashes.
pub(crate) fn texts(root: &Path, ends: &[&str]) -> Result<BTreeMap<String, String>, String> {
    let mut open = vec![root.to_owned()];
    let mut texts = BTreeMap::new();
    while let Some(folder) = open.pop() {
        let entries = std::fs::read_dir(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
        for path in entries.flatten().map(|entry| entry.path()) {
            let foreign = path.file_name().is_some_and(|name| FOREIGN.iter().any(|foreign| name == *foreign));
            if path.is_dir() && !foreign {
                open.push(path);
            } else if path.extension().is_some_and(|end| ends.iter().any(|known| end == *known)) {
                // A file that is not UTF-8 is read only by a machine.
                let text = String::from_utf8_lossy(
                    &std::fs::read(&path).map_err(|error| format!("{}: {error}", path.display()))?,
                )
                .into_owned();
                let shown = path.strip_prefix(root).unwrap_or(&path).to_string_lossy().replace('\\', "/");
                texts.insert(shown, text);
            }
        }
    }
    Ok(texts)
}

/// Names of the machines of the repository.
pub(crate) fn machines(root: &Path) -> Result<BTreeSet<String>, String> {
    let folder = root.join("machines");
    let entries = std::fs::read_dir(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let folders = entries.flatten().filter(|entry| entry.path().is_dir());
    Ok(folders.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect())
}
