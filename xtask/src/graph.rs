//! The crates of the build, as cargo reports them.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

use serde::Deserialize;

/// A crate of the build.
#[derive(Debug, Clone, Deserialize)]
pub(crate) struct Package {
    pub(crate) name: String,
    pub(crate) version: String,
    pub(crate) license: Option<String>,
    /// Registry or repository it comes from, none for a crate of the workspace.
    pub(crate) source: Option<String>,
    pub(crate) dependencies: Vec<Dependency>,
}

/// A line of a crate's dependencies.
#[derive(Debug, Clone, Deserialize)]
pub(crate) struct Dependency {
    pub(crate) name: String,
    /// `dev`, `build`, or none.
    pub(crate) kind: Option<String>,
    /// Version requirement.
    pub(crate) req: String,
    /// Folder of a crate of the workspace.
    pub(crate) path: Option<String>,
}

#[derive(Deserialize)]
struct Metadata {
    packages: Vec<Package>,
}

/// A crate that is linked into a program.
#[derive(Debug, Clone, Deserialize)]
pub(crate) struct Linked {
    id: String,
    pub(crate) name: String,
    pub(crate) version: String,
    pub(crate) license: Option<String>,
    pub(crate) source: Option<String>,
    pub(crate) repository: Option<String>,
    pub(crate) authors: Vec<String>,
    pub(crate) manifest_path: PathBuf,
}

#[derive(Deserialize)]
struct Resolved {
    packages: Vec<Linked>,
    resolve: Resolve,
}

#[derive(Deserialize)]
struct Resolve {
    nodes: Vec<Node>,
}

#[derive(Deserialize)]
struct Node {
    id: String,
    deps: Vec<Edge>,
}

#[derive(Deserialize)]
struct Edge {
    pkg: String,
    dep_kinds: Vec<EdgeKind>,
}

#[derive(Deserialize)]
struct EdgeKind {
    kind: Option<String>,
}

/// Output of `cargo metadata`.
fn metadata<T: serde::de::DeserializeOwned>(root: &Path, arguments: &[&str]) -> Result<T, String> {
    // `CARGO` names the cargo that runs this program.
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.args(["metadata", "--format-version", "1", "--locked"]).args(arguments).current_dir(root);
    let output = command.output().map_err(|error| format!("cargo metadata cannot be started: {error}"))?;
    if !output.status.success() {
        return Err(String::from_utf8_lossy(&output.stderr).into_owned());
    }
    serde_json::from_slice(&output.stdout).map_err(|error| format!("cargo metadata: {error}"))
}

/// All crates that any feature needs, by `cargo metadata`.
pub(crate) fn packages(root: &Path) -> Result<Vec<Package>, String> {
    metadata::<Metadata>(root, &["--all-features"]).map(|metadata| metadata.packages)
}

/// Name of this kind of computer.
fn host() -> Result<String, String> {
    let output = Command::new("rustc").arg("-vV").output().map_err(|error| format!("rustc: {error}"))?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let host = text.lines().find_map(|line| line.strip_prefix("host: ")).map(str::to_owned);
    host.ok_or_else(|| format!("rustc -vV names no host: {text}"))
}

/// The crates that some crates of the workspace need on this computer when they run, sorted by name and version.
pub(crate) fn linked(root: &Path, of: &[&str]) -> Result<Vec<Linked>, String> {
    let Resolved { packages, resolve } = metadata(root, &["--filter-platform", &host()?])?;
    let nodes: BTreeMap<&str, &Node> = resolve.nodes.iter().map(|node| (node.id.as_str(), node)).collect();
    let first = packages.iter().filter(|one| one.source.is_none() && of.contains(&one.name.as_str()));
    let mut open: Vec<&str> = first.map(|one| one.id.as_str()).collect();
    let mut seen = BTreeSet::new();
    while let Some(id) = open.pop() {
        if let Some(node) = nodes.get(id).filter(|_| seen.insert(id)) {
            let needed = node.deps.iter().filter(|edge| edge.dep_kinds.iter().any(|one| one.kind.is_none()));
            open.extend(needed.map(|edge| edge.pkg.as_str()));
        }
    }
    let mut linked: Vec<Linked> = packages.iter().filter(|one| seen.contains(one.id.as_str())).cloned().collect();
    linked.sort_by(|a, b| (&a.name, &a.version).cmp(&(&b.name, &b.version)));
    Ok(linked)
}
