//! The machine of a submit that names none, guessed from its programs.
//!
//! *Invariants:* the search reads a bounded number of bytes, which count in the memory budget, and ends when its client
//! has disconnected.

use std::collections::BTreeMap;
use std::io::Read as _;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use bytes::Bytes;
use counterpoint_kernel::job::ProgramSelection;
use counterpoint_kernel::machine::signs;

use crate::jobs::Core;
use crate::machines::candidates;
use crate::reason::Refusal;

/// Bytes read from a file at once.
const CHUNK: usize = 64 << 10;

/// A search in progress. When it is dropped, the search stops.
#[derive(Default)]
pub(super) struct GuessSearch(Arc<AtomicBool>);

impl GuessSearch {
    /// A check whether the search must stop.
    pub(super) fn stop(&self) -> impl Fn() -> bool + Send + use<> {
        let gone = self.0.clone();
        move || gone.load(Ordering::Relaxed)
    }
}

impl Drop for GuessSearch {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// The machine guessed from the programs of a job, and the signs.
pub(super) fn guessed(
    core: &Core,
    tenant: &str,
    programs: &[ProgramSelection],
    files: &[(String, String)],
    stop: &dyn Fn() -> bool,
) -> Result<(String, String), Refusal> {
    let most = signs::searched_bytes(programs.len());
    let _taken = core.memory().take((most * programs.len()) as u64)?;
    let (mut heads, mut looked_at) = (BTreeMap::new(), Vec::with_capacity(programs.len()));
    for program in programs {
        let Some((_, digest)) = files.iter().find(|(path, _)| *path == program.file) else { continue };
        let content = match heads.get(digest) {
            Some(content) => Bytes::clone(content),
            None => {
                let content = head(core, tenant, digest, most, stop)?;
                heads.insert(digest, content.clone());
                content
            }
        };
        let part = program.number.is_some() || program.section.is_some();
        looked_at.push(signs::ExaminedProgram { name: program.file.clone(), content, number: program.number, part });
    }
    let candidates = candidates(&core.blobs, &core.ledger.machines(tenant)?)?;
    match signs::guess(&candidates, &looked_at, None, stop) {
        Ok(guess) => Ok((guess.machine, guess.why)),
        Err(why) => Err(Refusal::field("machine", format!("none is named, and {why}"))),
    }
}

/// The first bytes of a file. The file is read to its end in order to verify its checksum.
fn head(core: &Core, tenant: &str, digest: &str, most: usize, stop: &dyn Fn() -> bool) -> Result<Bytes, Refusal> {
    let mut content = core.blobs.of(tenant).open(digest)?;
    let (mut head, mut chunk) = (Vec::new(), vec![0; CHUNK]);
    loop {
        if stop() {
            return Err(Refusal::Storage(
                "the search for the machine was stopped: its client has disconnected".to_owned(),
            ));
        }
        let read = content.read(&mut chunk)?;
        if read == 0 {
            return Ok(head.into());
        }
        let room = most.saturating_sub(head.len()).min(read);
        head.extend_from_slice(chunk.get(..room).unwrap_or_default());
    }
}
