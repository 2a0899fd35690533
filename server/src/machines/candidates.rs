//! The machines that may be guessed for a job of a tenant: the shipped ones and its own with signs.
//!
//! *Invariant:* a tenant's machine counts only for that tenant, and only if its own file has `[signs]`.

use std::sync::{Arc, LazyLock};

use counterpoint_kernel::files::MemoryFiles;
use counterpoint_kernel::machine::package::Overlay;
use counterpoint_kernel::machine::signs::MachineCandidate;
use counterpoint_kernel::machine::{candidates as with_signs, package};

use super::{MachineRecord, is_shipped};
use crate::blobs::Blobs;
use crate::reason::Refusal;

static SHIPPED: LazyLock<Vec<MachineCandidate>> =
    LazyLock::new(|| with_signs(&package::shipped(), &package::shipped_names()));

/// The candidates for a tenant that has these machines.
pub(crate) fn candidates(blobs: &Arc<dyn Blobs>, own: &[MachineRecord]) -> Result<Vec<MachineCandidate>, Refusal> {
    let mut all = SHIPPED.clone();
    for definition in own.iter().filter(|definition| !is_shipped(&definition.name)) {
        let blobs = blobs.of(&definition.tenant);
        let file = format!("{}/machine.toml", definition.name);
        let Some(digest) = definition.files.get(&file) else { continue };
        let text = blobs.read(digest)?;
        if !text.windows(6).any(|part| part == b"[signs") {
            continue;
        }
        let mut files = MemoryFiles::default();
        for (path, digest) in definition.files.iter().filter(|(path, _)| path.ends_with("/machine.toml")) {
            files.insert(path.clone(), blobs.read(digest)?);
        }
        all.extend(with_signs(&Overlay::over_shipped(files), std::slice::from_ref(&definition.name)));
    }
    Ok(all)
}
