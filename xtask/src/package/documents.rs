//! The documents of a package: the documentation and all files that it refers to, at their paths in the repository.
//!
//! *Invariant:* no relative link of a packaged page is dead; files that `.gitignore` names are not packaged.

use std::path::Path;

/// Documents that are single files.
const FILES: [&str; 7] = [
    "README.md",
    "CHANGELOG.md",
    "LICENSE-MIT",
    "LICENSE-APACHE",
    "ARCHITECTURE.md",
    "CONTRIBUTING.md",
    "tests/public/README.md",
];
/// Folders whose files are all packaged: the contract for clients in other languages, the Python client, monitoring
/// rules and dashboards, examples, machine definitions, and specification pages.
const FOLDERS: [&str; 8] =
    ["docs", "deploy", "proto/counterpoint", "clients/python", "examples", "machines", "tests/spec", "tests/scenarios"];

/// A line of a `.gitignore`, and the folder that it applies to.
struct Rule {
    folder: String,
    pattern: String,
}

impl Rule {
    /// Whether the rule names a path. A pattern with a slash before its end is a path; otherwise it is a name, which
    /// may begin with `*`.
    fn names(&self, path: &str) -> bool {
        let Some(inside) = path.strip_prefix(&self.folder).and_then(|rest| rest.strip_prefix('/')) else {
            return false;
        };
        let pattern = self.pattern.trim_end_matches('/');
        let name = inside.rsplit('/').next().unwrap_or(inside);
        match pattern.strip_prefix('*') {
            _ if pattern.contains('/') => inside == pattern.trim_start_matches('/'),
            Some(end) => name.ends_with(end),
            None => name == pattern,
        }
    }
}

/// Paths of all documents, relative to the repository.
///
/// # Errors
/// A folder cannot be read.
pub(super) fn all(root: &Path) -> Result<Vec<String>, String> {
    let mut found: Vec<String> = FILES.map(str::to_owned).to_vec();
    let mut rules = Vec::new();
    FOLDERS.iter().try_for_each(|folder| below(root, folder, &mut rules, &mut found))?;
    Ok(found)
}

/// Adds all files below a folder.
fn below(root: &Path, folder: &str, rules: &mut Vec<Rule>, found: &mut Vec<String>) -> Result<(), String> {
    let wrong = |error: std::io::Error| format!("{folder}: {error}");
    let ignored = std::fs::read_to_string(root.join(folder).join(".gitignore")).unwrap_or_default();
    let before = rules.len();
    rules.extend(ignored.lines().map(|line| Rule { folder: folder.to_owned(), pattern: line.trim().to_owned() }));
    for entry in std::fs::read_dir(root.join(folder)).map_err(wrong)? {
        let entry = entry.map_err(wrong)?;
        let name = entry.file_name().to_string_lossy().into_owned();
        let path = format!("{folder}/{name}");
        if name.starts_with('.') || name == "__pycache__" || rules.iter().any(|rule| rule.names(&path)) {
            continue;
        }
        match entry.file_type().map_err(wrong)?.is_dir() {
            true => below(root, &path, rules, found)?,
            false => found.push(path),
        }
    }
    rules.truncate(before);
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::path::PathBuf;

    use super::*;

    fn root() -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
    }

    /// Targets of the relative links in a page, without those in code.
    fn links(page: &str) -> Vec<&str> {
        let prose = page.split("```").step_by(2).flat_map(|part| part.split("](").skip(1));
        let targets = prose.filter_map(|rest| rest.split([')', ' ', '\n']).next());
        let targets = targets.map(|target| target.split('#').next().unwrap_or_default());
        targets.filter(|target| !target.is_empty() && !target.contains(':')).collect()
    }

    /// A path with its `..` resolved.
    fn resolved(page: &str, link: &str) -> String {
        let mut parts: Vec<&str> = page.split('/').collect();
        parts.pop();
        for part in link.split('/').filter(|part| !part.is_empty() && *part != ".") {
            if part == ".." {
                parts.pop();
            } else {
                parts.push(part);
            }
        }
        parts.join("/")
    }

    #[test]
    fn no_link_of_a_packaged_page_is_dead() {
        let files: BTreeSet<String> = all(&root()).unwrap().into_iter().collect();
        let folders: BTreeSet<&str> =
            files.iter().flat_map(|file| file.match_indices('/').filter_map(|(at, _)| file.get(..at))).collect();
        let (mut dead, mut count) = (BTreeSet::new(), 0);
        for page in files.iter().filter(|file| Path::new(file).extension().is_some_and(|end| end == "md")) {
            let text = std::fs::read_to_string(root().join(page)).unwrap();
            for link in links(&text) {
                count += 1;
                let target = resolved(page, link);
                if !files.contains(&target) && !folders.contains(target.as_str()) {
                    dead.insert(format!("{page}: {link}"));
                }
            }
        }
        assert!(dead.is_empty(), "{} dead links of {count}: {dead:#?}", dead.len());
        assert!(count > 300, "{count} links");
    }

    #[test]
    fn files_for_clients_and_monitoring_are_packaged_and_generated_ones_are_not() {
        let files = all(&root()).unwrap();
        for file in [
            "proto/counterpoint/v1/jobs.proto",
            "clients/python/pyproject.toml",
            "clients/python/counterpoint/client.py",
            "deploy/prometheus/rules.yaml",
            "deploy/grafana/counterpoint.json",
            "examples/two-turret/upper.nc",
        ] {
            assert!(files.iter().any(|name| name == file), "{file}");
        }
        let rule = |pattern: &str| Rule { folder: "a/b".to_owned(), pattern: pattern.to_owned() };
        assert!(rule("c/v1/").names("a/b/c/v1") && rule("/v1/").names("a/b/v1") && !rule("/v1/").names("a/b/c/v1"));
        assert!(rule("node_modules/").names("a/b/c/node_modules") && !rule("gen/").names("other/gen"));
        assert!(rule("*.egg-info/").names("a/b/x.egg-info"));
    }
}
