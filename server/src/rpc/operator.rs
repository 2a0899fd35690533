//! Service `Operator`: one client that attends one job; `Debug` is in a separate file.
//!
//! Invariant: an answer is in the ledger before the kernel gets it, so a run that dies is run again with it.

use std::collections::BTreeSet;
use std::sync::Arc;

use counterpoint_kernel::dialog::answers::Answer;
use counterpoint_proto::v1;
use counterpoint_proto::v1::attend_request::Content as Said;
use counterpoint_proto::v1::attend_response::Content;
use counterpoint_proto::v1::operator_server::Operator as Service;
use tokio::sync::mpsc;
use tokio_stream::wrappers::ReceiverStream;
use tonic::{Request, Response, Status, Streaming};
use tracing::Instrument as _;

use super::{Operator, door, job, submit};
use crate::access::Caller;
use crate::jobs::Core;
use crate::jobs::describe::status;
use crate::jobs::live::Live;
use crate::reason::Refusal;

type Out = mpsc::Sender<Result<v1::AttendResponse, Status>>;

#[tonic::async_trait]
impl Service for Operator {
    type AttendStream = ReceiverStream<Result<v1::AttendResponse, Status>>;
    type DebugStream = super::debug::Answers;

    async fn attend(
        &self,
        request: Request<Streaming<v1::AttendRequest>>,
    ) -> Result<Response<Self::AttendStream>, Status> {
        let (caller, mut said) = (Caller::of(&request)?, request.into_inner());
        let Some(Said::JobId(id)) = said.message().await?.and_then(|first| first.content) else {
            return Err(Refusal::field("content", "the first message must name the job (job_id)").into());
        };
        door::id("job_id", &id)?;
        let record = job(&self.0, &caller, &id)?;
        if !record.attended {
            return Err(Refusal::NotAttended(id).into());
        }
        let (send, receive) = mpsc::channel(4);
        match self.0.live(&id) {
            None => drop(send.try_send(Ok(message(Content::Ended(status(record)))))),
            Some(live) => {
                let span = tracing::info_span!("attend", job = id);
                let attend = Attend { core: self.0.clone(), live, shown: BTreeSet::new(), send };
                tokio::spawn(attend.run(said).instrument(span));
            }
        }
        Ok(Response::new(ReceiverStream::new(receive)))
    }

    async fn debug(
        &self,
        request: Request<Streaming<v1::DebugRequest>>,
    ) -> Result<Response<Self::DebugStream>, Status> {
        let caller = Caller::of(&request)?;
        super::debug::debug(&self.0, caller, request.into_inner()).await
    }
}

fn message(content: Content) -> v1::AttendResponse {
    v1::AttendResponse { content: Some(content) }
}

/// A client that attends.
struct Attend {
    core: Arc<Core>,
    live: Arc<Live>,
    /// Questions it knows as open.
    shown: BTreeSet<u64>,
    send: Out,
}

impl Attend {
    async fn run(mut self, said: Streaming<v1::AttendRequest>) {
        if let Err(refusal) = self.talk(said).await {
            let _ = self.send.send(Err(refusal.into())).await;
        }
    }

    /// Until the job ends or the client leaves.
    async fn talk(&mut self, mut said: Streaming<v1::AttendRequest>) -> Result<(), Refusal> {
        let (mut changes, mut state) = (self.live.desk().follow(), self.live.follow());
        let mut drain = self.core.drain.follow();
        loop {
            if self.show().await.is_err() {
                return Ok(());
            }
            if state.borrow_and_update().ended() {
                let _ = self.send.send(Ok(message(Content::Ended(status(self.live.record()))))).await;
                return Ok(());
            }
            let next = tokio::select! {
                changed = changes.changed() => if changed.is_err() { return Ok(()) } else { continue },
                changed = state.changed() => if changed.is_err() { return Ok(()) } else { continue },
                _ = drain.wait_for(|begun| *begun) => return Err(Refusal::Draining { cursor: 0 }),
                next = said.message() => next,
            };
            let next = next.map_err(|status| Refusal::of_transport(&status))?;
            match next.and_then(|next| next.content) {
                Some(content) => self.hear(content).await?,
                None => return Ok(()),
            }
        }
    }

    /// Sends the dialogs opened and closed since the last time; an error means that the client has gone.
    async fn show(&mut self) -> Result<(), ()> {
        let questions = self.live.desk().questions();
        let open: BTreeSet<u64> = questions.iter().map(|question| question.id).collect();
        let closed: Vec<u64> = self.shown.difference(&open).copied().collect();
        for id in closed {
            self.send.send(Ok(message(Content::Closed(id)))).await.map_err(drop)?;
        }
        for question in questions.into_iter().filter(|question| !self.shown.contains(&question.id)) {
            self.send.send(Ok(message(Content::Question(question)))).await.map_err(drop)?;
        }
        self.shown = open;
        Ok(())
    }

    async fn hear(&mut self, content: Said) -> Result<(), Refusal> {
        let (id, answer) = match content {
            Said::JobId(_) => return Err(Refusal::field("job_id", "may be given in the first message only")),
            Said::Declined(id) => (id, None),
            Said::Answer(answer) => {
                let given = answer.answer.ok_or_else(|| Refusal::field("answer.answer", "is missing"))?;
                door::answer("answer.answer", &given)?;
                (answer.question_id, Some(submit::answer(given)))
            }
        };
        // A question that another client has answered is reported as closed.
        let Some((channel, dialog)) = self.live.desk().claim(id) else { return Ok(()) };
        let answer = answer.map(|answer| Answer { dialog, ..answer });
        let kept = self.core.ledger.answered(self.live.id.clone(), channel, answer.clone()).await;
        if let Err(refusal) = kept {
            self.live.desk().answer(id, None);
            return Err(refusal);
        }
        self.live.desk().answer(id, answer);
        Ok(())
    }
}
