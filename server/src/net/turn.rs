//! When a call may continue: at once, when it is its turn, or not at all.
//!
//! *Invariant:* a call that waits holds a timer and its own request, no thread and no lock; it ends at once when the
//! client gives it up or the server drains.

use std::future::Future;
use std::time::Duration;

use http::{Request, Response};
use hyper::body::Incoming;
use tokio::time::{Instant, sleep_until};
use tonic::body::Body;

use super::Peer;
use crate::access::{Admitted, Caller, LONGEST};
use crate::connections::ActiveCall;
use crate::reason::Refusal;

/// Lets a call pass with its caller when it is its turn, or answers it. A caller that calls so often that its calls
/// cannot even wait is not listened to for a while.
#[allow(clippy::result_large_err, reason = "the answer is sent as it is, once a refused call")]
pub(super) async fn admitted(
    request: &mut Request<Incoming>,
    peer: &Peer,
    call: &ActiveCall,
    deadline: Option<Instant>,
) -> Result<Option<Caller>, Response<Body>> {
    let (caller, refusal) = match peer.gate.admit(request, &peer.names) {
        Err((caller, refusal)) => {
            let refusal = peer.gate.too_often(peer.address, refusal);
            let alone = caller.as_ref().map_or_else(|| call.of_a_stranger(), |caller| call.by(&caller.identity));
            if let Refusal::RateLimited(wait) | Refusal::RefusedTooOften(wait) = &refusal
                && alone
                // The last frames of a connection that is closed are read.
                && !*peer.drain.borrow()
                && peer.pause.begin((*wait).min(LONGEST))
            {
                peer.gate.rates().pauses.inc();
            }
            (caller, refusal)
        }
        Ok(Admitted { caller, wait }) => {
            if let Some(caller) = &caller {
                call.by(&caller.identity);
            }
            let Some((wait, held)) = wait else { return Ok(caller) };
            let waiting = peer.gate.rates().hold();
            let mut drain = peer.drain.clone();
            let drained = async move { drop(drain.wait_for(|begun| *begun).await) };
            let turn = turn(wait, deadline, drained).await;
            drop((waiting, held));
            match turn {
                Ok(()) => return Ok(caller),
                Err(refusal) => (caller, refusal),
            }
        }
    };
    Err(peer.gate.refuse(peer.address, caller.as_ref(), request.uri().path(), refusal))
}

/// Waits for the turn of a call, unless its deadline or the drain of the server comes first.
async fn turn(wait: Duration, deadline: Option<Instant>, drained: impl Future<Output = ()>) -> Result<(), Refusal> {
    let turn = Instant::now() + wait;
    tokio::select! {
        biased;
        () = drained => Err(Refusal::Draining { cursor: 0 }),
        () = sleep_until(deadline.map_or(turn, |deadline| deadline.min(turn))) => match deadline {
            Some(deadline) if deadline < turn => Err(Refusal::CallDeadline),
            _ => Ok(()),
        },
    }
}

#[cfg(test)]
mod tests {
    use std::future::{pending, ready};

    use super::*;

    const LONG: Duration = Duration::from_secs(3600);
    const SHORT: Duration = Duration::from_millis(20);

    /// A call that takes an hour would never be answered here.
    #[tokio::test]
    async fn a_call_waits_for_its_turn_its_deadline_or_the_drain() {
        let begin = Instant::now();
        assert_eq!(turn(SHORT, None, pending()).await, Ok(()));
        assert!(begin.elapsed() >= SHORT);
        assert_eq!(turn(SHORT, Some(begin + LONG), pending()).await, Ok(()));
        assert_eq!(turn(LONG, Some(begin + SHORT), pending()).await, Err(Refusal::CallDeadline));
        assert_eq!(turn(LONG, None, ready(())).await, Err(Refusal::Draining { cursor: 0 }));
    }
}
