//! The audit log: caller, call and outcome, one JSON object per line.
//!
//! Calls that change something and refused ones are in it; of the refused calls of a stranger only the first ones of a
//! minute. Contents of files and tokens never are. Invariants: a line is written completely before the answer is sent;
//! each target of a change has a line before the change is made.

use std::fs::{File, OpenOptions};
use std::io::Write as _;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use serde::Serialize;
use tonic::Code;

use super::strangers::{LeftOut, Strangers};
use super::{Caller, Identity, Role, calls};
use crate::clock::now_ms;

/// Most bytes of the path of a call.
const CALL: usize = 128;
/// Maximum bytes of the reason of a refusal, which may contain text of the client.
const REASON: usize = 256;

/// Code of lines about changes that have not been made yet.
const ASKED: &str = "Asked";

/// The log.
#[derive(Debug)]
pub(crate) struct Audit {
    path: PathBuf,
    file: Mutex<File>,
    failed: AtomicBool,
    strangers: Mutex<Strangers>,
}

#[derive(Clone, Serialize)]
struct AuditLine<'a> {
    time_ms: i64,
    /// Of several calls without lines, the address or network alone.
    peer: &'a str,
    identity: Option<&'a str>,
    tenant: Option<&'a str>,
    role: Option<Role>,
    call: &'a str,
    #[serde(skip_serializing_if = "str::is_empty")]
    target: &'a str,
    code: String,
    /// Reason of the refusal.
    #[serde(skip_serializing_if = "str::is_empty")]
    reason: &'a str,
    /// Refused calls of the same address before this one that have no line.
    #[serde(skip_serializing_if = "is_zero")]
    left_out: u64,
}

impl<'a> AuditLine<'a> {
    /// A line of a call with the current time.
    fn of(identity: Option<&'a Identity>, call: &'a str) -> Self {
        Self {
            time_ms: now_ms(),
            peer: "",
            identity: identity.map(|identity| identity.name.as_str()),
            tenant: identity.map(|identity| identity.tenant.as_str()),
            role: identity.map(|identity| identity.role),
            call: cut(call, CALL),
            target: "",
            code: String::new(),
            reason: "",
            left_out: 0,
        }
    }
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde asks with a reference")]
fn is_zero(number: &u64) -> bool {
    *number == 0
}

/// The beginning of a text.
fn cut(text: &str, most: usize) -> &str {
    text.get(..text.floor_char_boundary(most)).unwrap_or_default()
}

fn open(path: &Path) -> std::io::Result<File> {
    let mut options = OpenOptions::new();
    options.append(true).create(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    options.open(path)
}

/// Whether a call changes something.
pub(crate) fn changes(call: &str) -> bool {
    matches!(calls::needs(call), calls::Needs::Role(role) if role > Role::Read)
}

impl Audit {
    /// Appends to a file, which is made if it is not there.
    pub(crate) fn open(path: &Path) -> std::io::Result<Self> {
        Ok(Self {
            path: path.to_owned(),
            file: Mutex::new(open(path)?),
            failed: AtomicBool::new(false),
            strangers: Mutex::default(),
        })
    }

    /// Opens the file again, after it has been moved away.
    pub(crate) fn reopen(&self) -> std::io::Result<()> {
        *self.file.lock().unwrap_or_else(PoisonError::into_inner) = open(&self.path)?;
        Ok(())
    }

    /// Notes a call that has ended without an answer, if it changes something.
    pub(crate) fn note_unanswered(
        &self,
        peer: SocketAddr,
        identity: Option<&Identity>,
        call: &str,
        targets: &[String],
    ) {
        if changes(call) {
            self.note_of(peer, identity, call, targets, (Code::Cancelled, ""));
        }
    }

    /// Notes a call with its code and, if it was refused, the reason.
    pub(crate) fn note(&self, peer: SocketAddr, caller: Option<&Caller>, call: &str, outcome: (Code, &str)) {
        let targets = caller.map(Caller::targets).unwrap_or_default();
        self.note_of(peer, caller.map(|caller| &*caller.identity), call, &targets, outcome);
    }

    /// Notes the targets of a change before it is made.
    pub(crate) fn note_asked(&self, peer: SocketAddr, identity: &Identity, call: &str, targets: &[String]) {
        let line = AuditLine { code: ASKED.to_owned(), ..AuditLine::of(Some(identity), call) };
        let peer = &*peer.to_string();
        targets.iter().for_each(|target| self.write(&AuditLine { peer, target, ..line.clone() }));
    }

    /// Notes a call with its targets, its code and, if it was refused, the reason.
    pub(crate) fn note_of(
        &self,
        peer: SocketAddr,
        identity: Option<&Identity>,
        call: &str,
        targets: &[String],
        (code, reason): (Code, &str),
    ) {
        if code == Code::Ok && !changes(call) {
            return;
        }
        let mut left_out = 0;
        if identity.is_none() && code != Code::Ok {
            let mut strangers = self.strangers.lock().unwrap_or_else(PoisonError::into_inner);
            match strangers.refused(peer.ip(), Instant::now()) {
                None => return,
                // The number of calls of all other addresses does not concern this address.
                Some((None, before)) if before > 0 => {
                    drop(strangers);
                    self.left_out((None, before));
                }
                Some((_, before)) => left_out = before,
            }
        }
        let (peer, reason) = (&*peer.to_string(), cut(reason, REASON));
        let line = AuditLine { peer, code: format!("{code:?}"), reason, left_out, ..AuditLine::of(identity, call) };
        let none = [String::new()];
        for target in if targets.is_empty() { &none[..] } else { targets } {
            self.write(&AuditLine { target, ..line.clone() });
        }
    }

    /// Notes the calls of strangers that have no line, a minute after their first; `all` at the end of the server.
    pub(crate) fn note_left_out(&self, all: bool) {
        let mut strangers = self.strangers.lock().unwrap_or_else(PoisonError::into_inner);
        let left_out = strangers.forget(Instant::now(), all);
        drop(strangers);
        left_out.into_iter().for_each(|calls| self.left_out(calls));
    }

    fn left_out(&self, (address, left_out): LeftOut) {
        let address = address.map(|address| address.to_string());
        let peer = address.as_deref().unwrap_or("other addresses");
        self.write(&AuditLine { peer, left_out, ..AuditLine::of(None, "") });
    }

    fn write(&self, line: &AuditLine<'_>) {
        // A failed write may have left part of its line.
        let mut text = if self.failed.load(Ordering::Relaxed) { vec![b'\n'] } else { Vec::new() };
        if serde_json::to_writer(&mut text, line).is_err() {
            return;
        }
        text.push(b'\n');
        let written = self.file.lock().unwrap_or_else(PoisonError::into_inner).write_all(&text);
        match written {
            Ok(()) => self.failed.store(false, Ordering::Relaxed),
            Err(error) if !self.failed.swap(true, Ordering::Relaxed) => {
                tracing::error!(%error, file = %self.path.display(), "the audit log cannot be written");
            }
            Err(_) => {}
        }
    }
}
