//! How long a call may last: until its identity is revoked or expires, or its role no longer allows the call.
//!
//! Invariant: a call that waits for its end holds a timer and its own token; it looks at the identities again only after
//! they were read again and when its own expires.

use std::time::Duration;

use http::HeaderValue;
use tokio::sync::watch;
use tokio::time::sleep;

use super::{AccessControl, Caller, CertificateNames, Role, jwt};
use crate::reason::Refusal;

/// Shortest time between two looks at an identity that is about to expire.
const LOOK: Duration = Duration::from_millis(500);
/// Longest time that a timer is set for.
const LONGEST: Duration = Duration::from_secs(86_400);

/// What a caller has shown, and who it was then.
#[derive(Debug)]
pub(crate) struct Rights {
    authorization: Option<HeaderValue>,
    names: CertificateNames,
    caller: Caller,
    /// The role that the call needs.
    needs: Role,
    reloads: watch::Receiver<u64>,
}

impl AccessControl {
    /// The rights of a call that has been admitted.
    pub(crate) fn rights(
        &self,
        authorization: Option<&HeaderValue>,
        names: &CertificateNames,
        (caller, needs): (&Caller, Role),
    ) -> Rights {
        Rights {
            authorization: authorization.cloned(),
            names: names.clone(),
            caller: caller.clone(),
            needs,
            reloads: self.reloads.subscribe(),
        }
    }

    /// Waits until the identity is revoked or expires, or its role is too low for the call; returns the refusal.
    pub(crate) async fn ended(&self, mut rights: Rights) -> Refusal {
        let revoked = || Refusal::Unauthenticated("the identity of the call was revoked or has expired".to_owned());
        loop {
            rights.reloads.mark_unchanged();
            let Ok((now, until_s)) = self.identify(rights.authorization.as_ref(), &rights.names) else {
                return revoked();
            };
            if now.tenant != rights.caller.identity.tenant {
                return revoked();
            }
            if now.role < rights.needs {
                return super::too_low(rights.needs);
            }
            let left = Duration::from_secs(until_s.saturating_sub(jwt::now_s())).clamp(LOOK, LONGEST);
            tokio::select! {
                changed = rights.reloads.changed() => if changed.is_err() { return revoked() },
                () = sleep(left) => {}
            }
        }
    }
}
