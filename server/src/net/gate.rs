//! The checks of every connection and every call: encryption, identity, audit.
//!
//! Invariant: a call reaches its service only after [`AccessControl`] has let it pass.

use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use http::header::AUTHORIZATION;
use http::{HeaderMap, Request, Response};
use hyper::body::Incoming;
use tonic::body::Body;
use tonic::{Code, Status};
use tonic_types::StatusExt as _;

use super::held::Ended;
use super::tls::Tls;
use super::unanswered::CallEnd;
use super::web::Web;
use crate::access::audit::{Audit, changes};
use crate::access::calls::Needs;
use crate::access::fair::{CallTurn, LongCall};
use crate::access::strangers::SPAN;
use crate::access::{AccessControl, Admitted, Caller, CertificateNames, Identity, calls};
use crate::jobs::Core;
use crate::metrics::{Metrics, RateLimitMetrics};
use crate::options::ServerOptions;
use crate::reason::Refusal;

/// The gate of a server.
#[derive(Debug)]
pub(crate) struct Gate {
    access: AccessControl,
    audit: Option<Audit>,
    metrics: Arc<Metrics>,
    pub(super) tls: Option<Tls>,
    pub(super) web: Option<Web>,
}

impl Gate {
    /// Reads the files that the options name, and refuses an address that strangers can reach without protection.
    pub(crate) fn open(options: &ServerOptions, metrics: Arc<Metrics>) -> Result<Self, String> {
        let guard = &options.guard;
        let tls = Tls::open(guard)?;
        let identities = !guard.access.as_os_str().is_empty();
        if !options.listen.ip().is_loopback() && !guard.insecure && (tls.is_none() || !identities) {
            return Err(format!(
                "{} can be reached from other machines: give tls_cert, tls_key and access (docs/security.md), or \
                 --insecure to let every caller that reaches it do everything",
                options.listen
            ));
        }
        let audit = match guard.audit.as_os_str().is_empty() {
            true => None,
            false => Some(Audit::open(&guard.audit).map_err(|error| {
                let file = guard.audit.display();
                format!("the audit log '{file}' (option audit) cannot be opened: {error}; its folder must exist")
            })?),
        };
        Ok(Self { access: AccessControl::open(guard)?, audit, metrics, tls, web: Web::open(guard) })
    }

    /// Reads files of identities and certificates again, and reopens the audit log. Files that cannot be read keep
    /// their previous content.
    pub(crate) fn reload(&self) {
        let done = |what: &str, result: Result<(), String>| match result {
            Ok(()) => tracing::info!("{what} read again"),
            Err(error) => tracing::error!(error, "{what} cannot be read again, the old ones stay"),
        };
        done("identities", self.access.reload());
        if let Some(tls) = &self.tls {
            done("certificates", tls.reload());
        }
        if let Some(Err(error)) = self.audit.as_ref().map(Audit::reopen) {
            tracing::error!(%error, "the audit log cannot be opened again");
        }
    }

    /// Notes the refused calls of strangers that have no line in the audit log yet, until the server ends.
    pub(crate) async fn note_left_out(self: Arc<Self>) {
        let mut minutes = tokio::time::interval(SPAN);
        loop {
            minutes.tick().await;
            self.note_all_left_out(false);
        }
    }

    /// Notes these calls now; at the end of the server, those of all addresses.
    pub(crate) fn note_all_left_out(&self, end: bool) {
        self.audit.iter().for_each(|audit| audit.note_left_out(end));
    }

    /// Whether connections are encrypted.
    pub(crate) fn encrypts(&self) -> bool {
        self.tls.is_some()
    }

    /// Lets a call pass with its caller, at once or when it is its turn.
    pub(super) fn admit(
        &self,
        request: &mut Request<Incoming>,
        names: &CertificateNames,
    ) -> Result<Admitted, (Option<Caller>, Refusal)> {
        let admitted = self.access.admit(request.uri().path(), request.headers(), names)?;
        if let Some(caller) = &admitted.caller {
            request.extensions_mut().insert(caller.clone());
        }
        Ok(admitted)
    }

    /// Returns when a call that may last for hours has lost its rights; `None` for other calls.
    pub(super) fn rights(
        self: &Arc<Self>,
        headers: &HeaderMap,
        names: &CertificateNames,
        caller: Option<&Caller>,
        path: &str,
    ) -> Option<Ended> {
        let caller = caller.filter(|_| calls::ends_with_rights(path))?;
        let Needs::Role(needs) = calls::needs(path) else { return None };
        let rights = self.access.rights(headers.get(AUTHORIZATION), names, (caller, needs));
        let gate = self.clone();
        Some(Box::pin(async move { Status::from(gate.access.ended(rights).await) }))
    }

    /// Refuses calls without a known identity that come too often with the time until the next one is answered.
    pub(super) fn too_often(&self, peer: SocketAddr, refusal: Refusal) -> Refusal {
        let stranger = matches!(refusal, Refusal::Unauthenticated(_));
        let wait = stranger.then(|| self.access.refused(peer.ip())).flatten();
        wait.map_or(refusal, Refusal::RefusedTooOften)
    }

    /// The answer to a call that does not pass.
    pub(super) fn refuse(
        &self,
        peer: SocketAddr,
        caller: Option<&Caller>,
        path: &str,
        refusal: Refusal,
    ) -> Response<Body> {
        if matches!(refusal, Refusal::RateLimited(_) | Refusal::RefusedTooOften(_)) {
            self.metrics.rates.limited.inc();
        }
        let status = Status::from(refusal);
        self.note(peer, caller, path, (status.code(), &reason(&status)));
        self.metrics.call(calls::name(path), name(status.code()), Duration::ZERO);
        status.into_http()
    }

    /// Lets the jobs of others count where identities take turns.
    pub(crate) fn mind(&self, core: &Arc<Core>) {
        let core = Arc::downgrade(core);
        let others_work = move |tenant: &str| core.upgrade().is_some_and(|core| core.others_work(tenant));
        self.access.fair.mind(Box::new(others_work));
    }

    /// Waits until it is the turn of a caller.
    pub(super) async fn turn(&self, caller: Option<&Caller>, path: &str) -> (Option<CallTurn>, Option<LongCall>) {
        let Some(caller) = caller else { return (None, None) };
        if calls::lasts(path) {
            return (None, Some(self.access.fair.stay(&caller.identity)));
        }
        let waits = || {
            self.metrics.rates.deferred.inc();
        };
        (self.access.fair.turn(&caller.identity, waits).await, None)
    }

    /// Counts of calls that come too often.
    pub(super) fn rates(&self) -> &RateLimitMetrics {
        &self.metrics.rates
    }

    /// Notes the outcome of a call that has passed.
    pub(super) fn answered(
        &self,
        peer: SocketAddr,
        caller: Option<&Caller>,
        path: &str,
        answer: &Response<Body>,
        time: Duration,
    ) {
        let code = self.counted(path, answer, time);
        let refusal = if self.audit.is_some() { Status::from_header_map(answer.headers()) } else { None };
        self.note(peer, caller, path, (code, &refusal.map_or_else(String::new, |status| reason(&status))));
    }

    /// Counts a call in the metrics; returns its code.
    pub(super) fn counted(&self, path: &str, answer: &Response<Body>, time: Duration) -> Code {
        let code = answer.headers().get("grpc-status").map_or(Code::Ok, |code| Code::from_bytes(code.as_bytes()));
        self.metrics.call(calls::name(path), name(code), time);
        code
    }

    /// Notes a call that ended before it was answered, with its targets.
    pub(super) fn unanswered(
        &self,
        peer: SocketAddr,
        identity: Option<&Identity>,
        path: &str,
        (targets, end): (&[String], CallEnd),
    ) {
        let Some(audit) = &self.audit else { return };
        match end {
            CallEnd::Client => audit.note_unanswered(peer, identity, path, targets),
            CallEnd::Deadline => {
                let status = Status::from(Refusal::CallDeadline);
                audit.note_of(peer, identity, path, targets, (status.code(), &reason(&status)));
            }
        }
    }

    /// Makes the audit log name each change of a call before it is made.
    pub(super) fn note_before(self: &Arc<Self>, peer: SocketAddr, caller: &Caller, path: &str) {
        if self.audit.is_none() || !changes(path) {
            return;
        }
        let (gate, identity, path) = (self.clone(), caller.identity.clone(), path.to_owned());
        caller.note_before(move |targets| {
            gate.audit.iter().for_each(|audit| audit.note_asked(peer, &identity, &path, targets));
        });
    }

    fn note(&self, peer: SocketAddr, caller: Option<&Caller>, path: &str, outcome: (Code, &str)) {
        if let Some(audit) = &self.audit {
            audit.note(peer, caller, path, outcome);
        }
    }
}

/// Reason of a refusal for the audit log. For an unknown or denied caller it is the message; otherwise it is the stable
/// reason, because messages may quote contents of files.
fn reason(status: &Status) -> String {
    match status.code() {
        Code::Ok => String::new(),
        Code::Unauthenticated | Code::PermissionDenied => status.message().to_owned(),
        _ => status.get_error_details().error_info().map_or_else(String::new, |info| info.reason.clone()),
    }
}

/// Name of a code.
fn name(code: Code) -> &'static str {
    match code {
        Code::Ok => "Ok",
        Code::Cancelled => "Cancelled",
        Code::Unknown => "Unknown",
        Code::InvalidArgument => "InvalidArgument",
        Code::DeadlineExceeded => "DeadlineExceeded",
        Code::NotFound => "NotFound",
        Code::AlreadyExists => "AlreadyExists",
        Code::PermissionDenied => "PermissionDenied",
        Code::ResourceExhausted => "ResourceExhausted",
        Code::FailedPrecondition => "FailedPrecondition",
        Code::Aborted => "Aborted",
        Code::OutOfRange => "OutOfRange",
        Code::Unimplemented => "Unimplemented",
        Code::Internal => "Internal",
        Code::Unavailable => "Unavailable",
        Code::DataLoss => "DataLoss",
        Code::Unauthenticated => "Unauthenticated",
    }
}
