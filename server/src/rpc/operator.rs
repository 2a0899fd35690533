//! Service `OperatorService`: clients that attend a job, with a stream of their own or without; `Debug` is in a separate file.
//!
//! Invariant: an answer is in the ledger before the kernel gets it, so a run that dies is run again with it.

use std::collections::BTreeSet;
use std::sync::Arc;

use counterpoint_kernel::dialog::answers::DialogAnswer;
use counterpoint_kernel::dialog::operator::Silence;
use counterpoint_proto::v1;
use counterpoint_proto::v1::attend_request::Content as Said;
use counterpoint_proto::v1::attend_response::Content;
use counterpoint_proto::v1::operator_server::Operator as Service;
use tokio::sync::mpsc;
use tokio_stream::wrappers::ReceiverStream;
use tokio_stream::{Stream, StreamExt as _};
use tonic::{Request, Response, Status, Streaming};
use tracing::Instrument as _;

use super::{OperatorService, answers, door, first, job, submit, to_the_end};
use crate::JobRecord;
use crate::access::Caller;
use crate::jobs::Core;
use crate::jobs::describe::status;
use crate::jobs::live::LiveJob;
use crate::jobs::operator::Claimed;
use crate::jobs::received;
use crate::ledger::settled::Settled;
use crate::reason::Refusal;

type Heard = Result<v1::AttendResponse, Status>;
/// Messages to a client that only watches.
type Questions =
    tokio_stream::adapters::Map<ReceiverStream<Heard>, fn(Heard) -> Result<v1::WatchQuestionsResponse, Status>>;

#[tonic::async_trait]
impl Service for OperatorService {
    type AttendStream = ReceiverStream<Heard>;
    type WatchQuestionsStream = Questions;
    type DebugStream = super::debug::Answers;

    async fn attend(
        &self,
        request: Request<Streaming<v1::AttendRequest>>,
    ) -> Result<Response<Self::AttendStream>, Status> {
        let (caller, mut said) = (Caller::of(&request)?, request.into_inner());
        let Some(Said::JobId(id)) = first(&self.0, &mut said).await?.and_then(|first| first.content) else {
            return Err(Refusal::field("content", "the first message must name the job (job_id)").into());
        };
        door::id("job_id", &id)?;
        Ok(Response::new(attend(&self.0, &caller, &id, said)?))
    }

    async fn watch_questions(
        &self,
        request: Request<v1::WatchQuestionsRequest>,
    ) -> Result<Response<Self::WatchQuestionsStream>, Status> {
        let (caller, v1::WatchQuestionsRequest { job_id }) = door::enter(request)?;
        let heard = attend(&self.0, &caller, &job_id, tokio_stream::pending())?;
        let question: fn(_) -> _ = |message: Result<v1::AttendResponse, _>| message.map(watched);
        Ok(Response::new(heard.map(question)))
    }

    async fn answer_question(
        &self,
        request: Request<v1::AnswerQuestionRequest>,
    ) -> Result<Response<v1::AnswerQuestionResponse>, Status> {
        let (caller, v1::AnswerQuestionRequest { job_id, question_id, answer }) = door::enter(request)?;
        attended(&self.0, &caller, &job_id)?;
        let accepted = match self.0.live(&job_id) {
            None => false,
            Some(live) => {
                let core = self.0.clone();
                let given = answer.map(|answer| ("answer", answer));
                let settle = async move { settle(&core, &live, question_id, given).await };
                to_the_end(&caller, settle).await?
            }
        };
        Ok(Response::new(v1::AnswerQuestionResponse { accepted }))
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
    v1::AttendResponse { content: Some(content), expired: false }
}

/// The message for a client that only watches.
fn watched(message: v1::AttendResponse) -> v1::WatchQuestionsResponse {
    use v1::watch_questions_response::Content as Watched;
    let content = message.content.map(|content| match content {
        Content::Question(question) => Watched::Question(question),
        Content::Closed(id) => Watched::Closed(id),
        Content::Ended(status) => Watched::Ended(status),
    });
    v1::WatchQuestionsResponse { content, expired: message.expired }
}

/// A job of the caller's tenant that an operator attends.
fn attended(core: &Core, caller: &Caller, id: &str) -> Result<JobRecord, Refusal> {
    let record = job(core, caller, id)?;
    if record.attended { Ok(record) } else { Err(Refusal::NotAttended(id.to_owned())) }
}

/// Begins to attend a job; `said` are the messages of the client.
fn attend(
    core: &Arc<Core>,
    caller: &Caller,
    id: &str,
    said: impl Stream<Item = Result<v1::AttendRequest, Status>> + Send + Unpin + 'static,
) -> Result<ReceiverStream<Heard>, Refusal> {
    let record = attended(core, caller, id)?;
    let (send, receive) = mpsc::channel(4);
    match core.live(id) {
        None => drop(send.try_send(Ok(message(Content::Ended(status(record)))))),
        Some(live) => {
            let span = tracing::info_span!("attend", job = id);
            let attend = Attend { core: core.clone(), live, shown: BTreeSet::new(), send };
            tokio::spawn(attend.run(said).instrument(span));
        }
    }
    Ok(ReceiverStream::new(receive))
}

/// An answer, with its place in the request.
type Given = (&'static str, v1::DialogAnswer);

/// Answers a question, or declines it if there is no answer; false if the question is closed. If the dialog does not
/// accept the answer, or the answer cannot be stored, the question stays open.
async fn settle(core: &Core, live: &LiveJob, id: u64, given: Option<Given>) -> Result<bool, Refusal> {
    if let (Some((field, answer)), Some(question)) = (&given, live.desk().question(id)) {
        answers::check(field, &question, answer)?;
    }
    let Some(Claimed { channel, question, dialog }) = live.desk().claim(id) else { return Ok(false) };
    let field = given.as_ref().map_or("", |(field, _)| field);
    let answer = given.map(|(_, answer)| DialogAnswer { dialog, ..submit::answer(answer) }).ok_or(Silence::Declined);
    let counted = answer.as_ref().map_or(Ok(0), |answer| {
        let tenant = live.peek(|record| record.tenant.clone());
        received::receive(core, &mut live.desk().received(), (&tenant, live.most_bytes()), (field, answer))
    });
    let size = counted.inspect_err(|_| live.desk().release(id))?;
    let settled = Settled { channel, question, answer: answer.clone() };
    core.ledger.answered(live.id.clone(), settled).await.inspect_err(|_| {
        live.desk().received().iter_mut().for_each(|received| received.remove(size));
        live.desk().release(id);
    })?;
    live.desk().answer(id, answer);
    Ok(true)
}

/// A client that attends.
struct Attend {
    core: Arc<Core>,
    live: Arc<LiveJob>,
    /// Questions it knows as open.
    shown: BTreeSet<u64>,
    send: mpsc::Sender<Heard>,
}

impl Attend {
    async fn run(mut self, said: impl Stream<Item = Result<v1::AttendRequest, Status>> + Unpin) {
        if let Err(refusal) = self.talk(said).await {
            let _ = self.send.send(Err(refusal.into())).await;
        }
    }

    /// Until the job ends or the client leaves.
    async fn talk(
        &mut self,
        mut said: impl Stream<Item = Result<v1::AttendRequest, Status>> + Unpin,
    ) -> Result<(), Refusal> {
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
                next = said.next() => next.transpose(),
                () = self.send.closed() => return Ok(()),
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
            let expired = self.live.desk().is_expired(id);
            let closed = v1::AttendResponse { expired, ..message(Content::Closed(id)) };
            self.send.send(Ok(closed)).await.map_err(drop)?;
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
            Said::Answer(v1::QuestionAnswer { question_id, answer }) => (question_id, Some(answer)),
        };
        // A question that another client has answered is reported as closed.
        let Err(refusal) = self.settle(id, answer).await else { return Ok(()) };
        let Some(question) = self.live.desk().question(id) else { return Ok(()) };
        // The client asks again: one wrong answer ends neither the stream nor the question.
        let question = v1::Question { problem: Status::from(refusal).message().to_owned(), ..question };
        // The loop notices that the client has disconnected.
        let _ = self.send.send(Ok(message(Content::Question(question)))).await;
        Ok(())
    }

    /// Answers a question (`Some`) or declines it.
    async fn settle(&self, id: u64, given: Option<Option<v1::DialogAnswer>>) -> Result<bool, Refusal> {
        const FIELD: &str = "answer.answer";
        let given = match given {
            None => None,
            Some(None) => return Err(Refusal::field(FIELD, "is missing")),
            Some(Some(answer)) => {
                door::answer(FIELD, &answer)?;
                Some((FIELD, answer))
            }
        };
        settle(&self.core, &self.live, id, given).await
    }
}
