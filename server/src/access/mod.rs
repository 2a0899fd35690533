//! Access control: identities with tenant and role, from tokens, signed tokens and client certificates.
//!
//! `AccessControl` is asked before a call reaches its service. Invariants: a tenant comes from the identity only, never from
//! a request; a call that the table of `calls` does not know is refused; without a file of identities every caller
//! is the administrator of the tenant `default`, which is allowed on loopback only unless the owner insists.

pub(crate) mod audit;
pub(crate) mod calls;
pub mod edit;
pub(crate) mod fair;
mod file;
mod jwt;
mod rate;
mod refused;
mod rights;
pub(crate) mod strangers;
pub mod token;
pub mod token_commands;

use std::collections::HashMap;
use std::net::IpAddr;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError, RwLock};
use std::time::{Duration, Instant};

use http::{HeaderMap, HeaderValue};
use serde::{Deserialize, Serialize};
use tokio::sync::watch;
use tonic::{Request, Status};

use crate::options::Guard;
use crate::reason::Refusal;
use crate::tenant;
use calls::Needs;
use fair::Fair;
use file::KnownIdentities;
pub(crate) use rate::{DeferredCall, LONGEST};
use rate::{IdentityRateLimiter, RateDecision};
use refused::AddressRateLimiter;

/// Rights of an identity; each role also has the rights of those before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Role {
    /// See jobs, results and machines of its tenant
    Read,
    /// Upload files, submit, cancel and delete jobs, put machines
    Submit,
    /// Answer the dialogs of jobs
    Operate,
    /// Put machines that may start commands of the operating system; look after the server
    Admin,
}

impl std::fmt::Display for Role {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Read => "read",
            Self::Submit => "submit",
            Self::Operate => "operate",
            Self::Admin => "admin",
        })
    }
}

/// The caller.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) struct Identity {
    pub(crate) name: String,
    pub(crate) tenant: String,
    pub(crate) role: Role,
}

impl Identity {
    /// Text that no other identity has.
    pub(crate) fn key(&self) -> String {
        format!("{}/{}", self.tenant, self.name)
    }
}

/// Most characters of the subject of a call in the audit log.
const TARGET: usize = 128;

/// An identity within one call, and the subject of the call for the audit log.
#[derive(Debug, Clone)]
pub(crate) struct Caller {
    pub(crate) identity: Arc<Identity>,
    targets: Arc<Targets>,
}

/// Writes the changes that a call is about to make to the audit log.
type Asked = Box<dyn Fn(&[String]) + Send + Sync>;

/// Writes the end of a call with its targets to the audit log.
type Note = Box<dyn FnOnce(Vec<String>) + Send>;

/// The targets of a call. If the call ended without an answer, also its note, which is written when its work is over.
#[derive(Default)]
struct Targets {
    ids: Mutex<Vec<String>>,
    asked: OnceLock<Asked>,
    /// Whether the call has begun to change something.
    begun: AtomicBool,
    note: Mutex<Option<Note>>,
}

impl std::fmt::Debug for Targets {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.ids.fmt(f)
    }
}

impl Drop for Targets {
    fn drop(&mut self) {
        let ids = std::mem::take(self.ids.get_mut().unwrap_or_else(PoisonError::into_inner));
        if let Some(note) = self.note.get_mut().unwrap_or_else(PoisonError::into_inner).take() {
            note(if *self.begun.get_mut() { ids } else { Vec::new() });
        }
    }
}

impl Caller {
    fn new(identity: Arc<Identity>) -> Self {
        Self { identity, targets: Arc::default() }
    }

    /// The caller of a request that has passed [`AccessControl::admit`].
    pub(crate) fn of<T>(request: &Request<T>) -> Result<Self, Status> {
        let nobody = || Refusal::Unauthenticated("the call has no identity".to_owned()).into();
        request.extensions().get().cloned().ok_or_else(nobody)
    }

    pub(crate) fn tenant(&self) -> &str {
        &self.identity.tenant
    }

    /// Records the subject of the call; the last one counts.
    pub(crate) fn about(&self, target: &str) {
        let end = target.char_indices().nth(TARGET).map_or(target.len(), |(at, _)| at);
        *self.lock() = vec![target.get(..end).unwrap_or_default().to_owned()];
    }

    /// Records the jobs of a call for many.
    pub(crate) fn about_jobs(&self, ids: &[String]) {
        *self.lock() = ids.to_vec();
    }

    /// The targets of the call; empty if unknown.
    pub(crate) fn targets(&self) -> Vec<String> {
        self.lock().clone()
    }

    /// Records that the call is about to change its targets.
    pub(crate) fn begins(&self) {
        self.targets.begun.store(true, Ordering::SeqCst);
        self.asks(&self.targets());
    }

    /// Writes these targets to the audit log before the call changes them.
    pub(crate) fn asks(&self, targets: &[String]) {
        if let Some(asked) = self.targets.asked.get() {
            asked(targets);
        }
    }

    /// Calls `asked` with the targets of each change before it is made.
    pub(crate) fn note_before(&self, asked: impl Fn(&[String]) + Send + Sync + 'static) {
        let _ = self.targets.asked.set(Box::new(asked));
    }

    /// Calls `note` with the targets when all work of the call is over, or with no targets if no change has begun.
    pub(crate) fn note_at_the_end(&self, note: impl FnOnce(Vec<String>) + Send + 'static) {
        *self.targets.note.lock().unwrap_or_else(PoisonError::into_inner) = Some(Box::new(note));
    }

    fn lock(&self) -> MutexGuard<'_, Vec<String>> {
        self.targets.ids.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The refusal of a call that needs a higher role.
fn too_low(needs: Role) -> Refusal {
    Refusal::PermissionDenied(format!("the call needs the role '{needs}'"))
}

/// A call that may be made.
#[derive(Debug)]
pub(crate) struct Admitted {
    /// `None` for a call that needs no identity.
    pub(crate) caller: Option<Caller>,
    /// Time until its turn; it counts as waiting while the second part lives.
    pub(crate) wait: Option<(Duration, DeferredCall)>,
}

/// Names in the certificate that the client of a connection has shown.
#[derive(Debug, Clone, Default)]
pub(crate) struct CertificateNames(pub(crate) Arc<[String]>);

/// Signed tokens that have been verified, so that each is verified once.
type Verified = HashMap<[u8; 32], (Arc<Identity>, u64)>;
/// Most of them.
const MOST_VERIFIED: usize = 4096;

/// Decides about calls.
#[derive(Debug)]
pub(crate) struct AccessControl {
    path: Option<PathBuf>,
    /// `None` = every caller is the administrator.
    known: RwLock<Option<Arc<KnownIdentities>>>,
    verified: Mutex<Verified>,
    rates: IdentityRateLimiter,
    refused: Mutex<AddressRateLimiter>,
    pub(crate) fair: Fair,
    anonymous: Arc<Identity>,
    /// How often the file of identities was read again.
    reloads: watch::Sender<u64>,
}

impl AccessControl {
    /// Reads the file of identities, if there is one.
    pub(crate) fn open(options: &Guard) -> Result<Self, String> {
        let path = Some(options.access.clone()).filter(|path| !path.as_os_str().is_empty());
        let known = path.as_ref().map(|path| KnownIdentities::read(path).map(Arc::new)).transpose()?;
        let anonymous = Identity { name: "anonymous".to_owned(), tenant: tenant::default(), role: Role::Admin };
        Ok(Self {
            path,
            known: RwLock::new(known),
            verified: Mutex::default(),
            rates: IdentityRateLimiter::new(options.max_calls_per_s),
            refused: Mutex::new(AddressRateLimiter::new(options.max_refused_per_s)),
            fair: Fair::default(),
            anonymous: Arc::new(anonymous),
            reloads: watch::Sender::new(0),
        })
    }

    /// Reads the file of identities again; the old ones stay when it has an error.
    pub(crate) fn reload(&self) -> Result<(), String> {
        let Some(path) = &self.path else { return Ok(()) };
        let known = Arc::new(KnownIdentities::read(path)?);
        *self.known.write().unwrap_or_else(PoisonError::into_inner) = Some(known);
        self.verified.lock().unwrap_or_else(PoisonError::into_inner).clear();
        self.reloads.send_modify(|reloads| *reloads += 1);
        Ok(())
    }

    /// Lets a call pass, at once or when it is its turn.
    pub(crate) fn admit(
        &self,
        path: &str,
        headers: &HeaderMap,
        names: &CertificateNames,
    ) -> Result<Admitted, (Option<Caller>, Refusal)> {
        let needs = calls::needs(path);
        if needs == Needs::Nothing {
            return Ok(Admitted { caller: None, wait: None });
        }
        let mut authorizations = headers.get_all(http::header::AUTHORIZATION).iter();
        let authorization = authorizations.next();
        if authorizations.next().is_some() {
            let text = "the call has more than one 'authorization' header: send only one";
            return Err((None, Refusal::Unauthenticated(text.to_owned())));
        }
        let (identity, _) = self.identify(authorization, names).map_err(|refusal| (None, refusal))?;
        let caller = Caller::new(identity);
        let role = match needs {
            Needs::Role(role) => role,
            // Answered by the service that does not know it.
            _ => Role::Read,
        };
        if caller.identity.role < role {
            return Err((Some(caller), too_low(role)));
        }
        match self.rates.take(&caller.identity, Instant::now()) {
            RateDecision::Now => Ok(Admitted { caller: Some(caller), wait: None }),
            RateDecision::After(wait, held) => Ok(Admitted { caller: Some(caller), wait: Some((wait, held)) }),
            RateDecision::Never(wait) => Err((Some(caller), Refusal::RateLimited(wait))),
        }
    }

    /// Counts a call that was refused because its identity is not known; the time until the next one of its address is
    /// answered, if they come too often.
    pub(crate) fn refused(&self, address: IpAddr) -> Option<Duration> {
        self.refused.lock().unwrap_or_else(PoisonError::into_inner).count(address, Instant::now())
    }

    /// The caller, and when that ends, seconds since 1970: a token says more than the certificate of the connection.
    fn identify(
        &self,
        authorization: Option<&HeaderValue>,
        names: &CertificateNames,
    ) -> Result<(Arc<Identity>, u64), Refusal> {
        let Some(known) = self.known.read().unwrap_or_else(PoisonError::into_inner).clone() else {
            return Ok((self.anonymous.clone(), u64::MAX));
        };
        let refuse = |text: &str| Refusal::Unauthenticated(text.to_owned());
        let Some(header) = authorization else {
            return known.certificate(&names.0).map(|identity| (identity, u64::MAX)).ok_or_else(|| {
                refuse("the call needs a token (metadata 'authorization: Bearer TOKEN') or a known client certificate")
            });
        };
        let text = header.to_str().map_err(|_| refuse("the authorization is not a text"))?;
        let token = match text.split_once(' ') {
            Some((scheme, token)) if scheme.eq_ignore_ascii_case("bearer") => token.trim(),
            _ => return Err(refuse("the authorization must be 'Bearer TOKEN'")),
        };
        match token.split('.').count() {
            3 => self.signed(&known, token),
            _ => known.token(token, jwt::now_s()).ok_or_else(|| refuse("the token is not known, or has expired")),
        }
    }

    fn signed(&self, known: &KnownIdentities, token: &str) -> Result<(Arc<Identity>, u64), Refusal> {
        let digest = token::digest(token);
        let verified = || self.verified.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((identity, until)) = verified().get(&digest)
            && jwt::now_s() < *until
        {
            return Ok((identity.clone(), *until));
        }
        let (identity, until) = known.signed(token).map_err(Refusal::Unauthenticated)?;
        let identity = Arc::new(identity);
        let mut verified = verified();
        if verified.len() >= MOST_VERIFIED {
            verified.clear();
        }
        verified.insert(digest, (identity.clone(), until));
        Ok((identity, until))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The targets in the line of a call about `job` that its client has ended.
    fn noted(work: impl FnOnce(&Caller)) -> Vec<String> {
        let identity = Identity { name: "ci".into(), tenant: "t".into(), role: Role::Submit };
        let caller = Caller::new(Arc::new(identity));
        let (note, noted) = std::sync::mpsc::channel();
        caller.about("job");
        work(&caller);
        caller.note_at_the_end(move |targets| note.send(targets).unwrap());
        assert!(noted.try_recv().is_err(), "the work of the call is not over");
        drop(caller);
        noted.recv().unwrap()
    }

    #[test]
    fn a_call_that_ends_before_its_change_begins_names_no_target() {
        assert!(noted(|_| ()).is_empty());
        assert_eq!(noted(Caller::begins), ["job"]);
    }
}
