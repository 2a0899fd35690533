//! The machines a server knows: shipped ones and those put there.
//!
//! A machine put there has a revision, the digest of its files; a job keeps the revision it was submitted with.
//! Invariant: a stored machine has passed the check of this server.

mod candidates;

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, LazyLock};

use counterpoint_kernel::files::MemoryFiles;
use counterpoint_kernel::machine::Machine;
use counterpoint_kernel::machine::finding::Finding;
use counterpoint_kernel::machine::package::Overlay;
use counterpoint_kernel::machine::{load, package};
use dashmap::DashMap;
use serde::{Deserialize, Serialize};

use crate::blobs::{Blobs, digest};
use crate::reason::Refusal;
use crate::tenant;

pub(crate) use candidates::candidates;

/// A machine as the ledger keeps it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct MachineRecord {
    /// Its folder.
    pub(crate) name: String,
    /// Path → digest; empty for a shipped machine.
    pub(crate) files: BTreeMap<String, String>,
    /// Tenant that it belongs to; shipped machines belong to all.
    #[serde(default = "tenant::default", skip_serializing_if = "tenant::is_default")]
    pub(crate) tenant: String,
    /// Shipped, or put there by an administrator: its macros may start commands where that is allowed at all.
    #[serde(default)]
    pub(crate) trusted: bool,
}

impl MachineRecord {
    pub(crate) fn shipped(name: &str) -> Self {
        Self { name: name.to_owned(), files: BTreeMap::new(), tenant: tenant::default(), trusted: true }
    }

    /// Digest of the files, 16 hexadecimal digits; empty for a shipped machine.
    pub(crate) fn revision(&self) -> String {
        revision_of(&self.files)
    }
}

/// The machine of a job without its files.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(from = "StoredMachine")]
pub struct Pinned {
    /// Its folder.
    pub name: String,
    /// Digest of its files; empty for a shipped machine.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub revision: String,
    /// Shipped, or put there by an administrator.
    pub trusted: bool,
}

/// The machine in the row of a job; before schema 8 it has its files instead of their digest.
#[derive(Deserialize)]
struct StoredMachine {
    name: String,
    #[serde(default)]
    revision: String,
    #[serde(default)]
    trusted: bool,
    #[serde(default)]
    files: BTreeMap<String, String>,
}

impl From<StoredMachine> for Pinned {
    fn from(StoredMachine { name, revision, trusted, files }: StoredMachine) -> Self {
        let revision = if files.is_empty() { revision } else { revision_of(&files) };
        Self { name, revision, trusted }
    }
}

impl From<&MachineRecord> for Pinned {
    fn from(machine: &MachineRecord) -> Self {
        Self { name: machine.name.clone(), revision: machine.revision(), trusted: machine.trusted }
    }
}

impl Pinned {
    /// Name with the revision; the name alone of a shipped machine.
    pub(crate) fn full_name(&self) -> String {
        match self.revision.as_str() {
            "" => self.name.clone(),
            revision => format!("{}@{revision}", self.name),
        }
    }
}

/// Digest of the files of a machine, 16 hexadecimal digits; empty without files.
fn revision_of(files: &BTreeMap<String, String>) -> String {
    if files.is_empty() {
        return String::new();
    }
    let text: String = files.iter().map(|(path, digest)| format!("{path}\0{digest}\n")).collect();
    digest(text.as_bytes()).get(..16).unwrap_or_default().to_owned()
}

/// Whether a text can be the name of a machine.
pub(crate) fn is_name(text: &str) -> bool {
    (1..=64).contains(&text.len())
        && !text.starts_with('.')
        && text.bytes().all(|b| b.is_ascii_alphanumeric() || b"._-".contains(&b))
}

static NAMES: LazyLock<Vec<String>> = LazyLock::new(package::shipped_names);

/// Names of the shipped machines, sorted.
pub(crate) fn shipped() -> &'static [String] {
    &NAMES
}

pub(crate) fn is_shipped(name: &str) -> bool {
    NAMES.iter().any(|shipped| shipped == name)
}

/// A loaded machine, if it can be used, with the findings of its check.
#[derive(Debug, Clone)]
pub(crate) struct CheckedMachine {
    pub(crate) machine: Option<Arc<Machine>>,
    pub(crate) findings: Vec<Finding>,
}

/// Loads machines and keeps those in use.
#[derive(Debug)]
pub(crate) struct MachineCache {
    blobs: Arc<dyn Blobs>,
    most: u64,
    loaded: DashMap<(String, String), CheckedMachine>,
    /// Bytes of the files of those.
    bytes: AtomicU64,
}

/// Machines kept loaded; beyond that the memory is emptied.
const KEPT: usize = 64;
/// Bytes of their files beyond which it is emptied too.
const KEPT_BYTES: u64 = 256 << 20;

impl MachineCache {
    /// Machines with files of at most `most` bytes.
    pub(crate) fn new(blobs: Arc<dyn Blobs>, most: u64) -> Self {
        Self { blobs, most, loaded: DashMap::new(), bytes: AtomicU64::new(0) }
    }

    /// Bytes of all files of a definition, each name counted.
    fn bytes(&self, blobs: &dyn Blobs, definition: &MachineRecord) -> Result<u64, Refusal> {
        let sizes = definition.files.values().map(|digest| blobs.size(digest));
        let bytes = sizes.fold(0, u64::saturating_add);
        if bytes > self.most { Err(Refusal::MachineTooLarge(self.most)) } else { Ok(bytes) }
    }

    /// Loads and checks a definition; all its blobs must be there.
    pub(crate) fn load(&self, definition: &MachineRecord) -> Result<CheckedMachine, Refusal> {
        let blobs = self.blobs.of(&definition.tenant);
        let key = (tenant::key(&definition.tenant, &definition.name), definition.revision());
        if let Some(known) = self.loaded.get(&key) {
            return Ok(known.clone());
        }
        let bytes = self.bytes(&*blobs, definition)?;
        let mut files = MemoryFiles::default();
        let mut contents: BTreeMap<&str, _> = BTreeMap::new();
        for (path, digest) in &definition.files {
            let content = match contents.get(digest.as_str()) {
                Some(content) => Clone::clone(content),
                None => blobs.read(digest)?,
            };
            contents.insert(digest, content.clone());
            files.0.insert(path.clone(), content);
        }
        let loaded = load(&Overlay::over_shipped(files), &definition.name);
        let checked = CheckedMachine { machine: loaded.machine.map(Arc::new), findings: loaded.findings };
        let kept = self.bytes.fetch_add(bytes, Ordering::Relaxed) + bytes;
        if self.loaded.len() >= KEPT || kept > KEPT_BYTES {
            self.loaded.clear();
            self.bytes.store(bytes, Ordering::Relaxed);
        }
        self.loaded.insert(key, checked.clone());
        Ok(checked)
    }
}
