//! Call `Operator.Debug`: one client that steps through one job.
//!
//! Invariant: at most this many commands are in progress, and each has one answer, so a client that sends without
//! reading holds back itself and nothing else.

use std::sync::Arc;

use counterpoint_kernel::operator::{
    BreakLocation, Breakpoint, ChannelReport, StepCalls, StepCommand, StepReply, StepReport, Whom,
};
use counterpoint_proto::v1;
use counterpoint_proto::v1::breakpoint::At;
use counterpoint_proto::v1::debug_command::What;
use counterpoint_proto::v1::debug_request::Content as Told;
use counterpoint_proto::v1::debug_response::Content;
use tokio::sync::mpsc;
use tokio_stream::wrappers::ReceiverStream;
use tonic::{Response, Status, Streaming};
use tracing::Instrument as _;

use super::submit::small;
use super::{door, first, job};
use crate::access::Caller;
use crate::jobs::Core;
use crate::jobs::describe::status;
use crate::jobs::live::LiveJob;
use crate::jobs::operator::value;
use crate::jobs::progress::wire;
use crate::reason::Refusal;

/// The answers to the client.
pub(super) type Answers = ReceiverStream<Result<v1::DebugResponse, Status>>;

/// Commands without an answer at most.
const UNDER_WAY: usize = 16;

/// Most bytes of a text in a command.
const TEXT: usize = 1000;

/// Lets a client step through a job.
pub(super) async fn debug(
    core: &Arc<Core>,
    caller: Caller,
    mut told: Streaming<v1::DebugRequest>,
) -> Result<Response<Answers>, Status> {
    let Some(Told::JobId(id)) = first(core, &mut told).await?.and_then(|first| first.content) else {
        return Err(Refusal::field("content", "the first message must name the job (job_id)").into());
    };
    door::id("job_id", &id)?;
    let record = job(core, &caller, &id)?;
    if !record.stepped {
        return Err(Refusal::NotStepped(id).into());
    }
    let (send, receive) = mpsc::channel(4);
    match core.live(&id) {
        None => drop(send.try_send(Ok(message(Content::Ended(status(record)))))),
        Some(live) => {
            let Some(said) = live.stepping().come() else { return Err(Refusal::SteppedAlready(id).into()) };
            let span = tracing::info_span!("debug", job = id);
            let debug = Debug { core: core.clone(), live, send, said, under_way: 0, welcomed: false };
            tokio::spawn(debug.run(told).instrument(span));
        }
    }
    Ok(Response::new(ReceiverStream::new(receive)))
}

fn message(content: Content) -> v1::DebugResponse {
    v1::DebugResponse { content: Some(content) }
}

/// A client that steps.
struct Debug {
    core: Arc<Core>,
    live: Arc<LiveJob>,
    send: mpsc::Sender<Result<v1::DebugResponse, Status>>,
    /// The answers of the run.
    said: mpsc::UnboundedReceiver<StepReply>,
    /// Commands without an answer.
    under_way: usize,
    /// The first stop, which answers no command of this client, has been received.
    welcomed: bool,
}

impl Debug {
    async fn run(mut self, told: Streaming<v1::DebugRequest>) {
        if let Err(refusal) = self.talk(told).await {
            let _ = self.send.send(Err(refusal.into())).await;
        }
    }

    /// Runs until the job ends or the client leaves. A client that has detached receives the end of the job, even if it
    /// closes its side of the stream. Any other client that closes its side first receives the answers to its commands.
    async fn talk(&mut self, mut told: Streaming<v1::DebugRequest>) -> Result<(), Refusal> {
        let mut state = self.live.follow();
        let mut drain = self.core.drain.follow();
        let (mut detached, mut leaves) = (false, false);
        loop {
            if leaves && self.under_way == 0 {
                return Ok(());
            }
            if state.borrow_and_update().ended() {
                let _ = self.send.send(Ok(message(Content::Ended(status(self.live.record()))))).await;
                return Ok(());
            }
            let next = tokio::select! {
                biased;
                Some(said) = self.said.recv() => DebugInput::Said(Box::new(said)),
                changed = state.changed() => if changed.is_err() { return Ok(()) } else { continue },
                _ = drain.wait_for(|begun| *begun) => return Err(Refusal::Draining { cursor: 0 }),
                () = self.send.closed() => return Ok(()),
                next = told.message(), if !detached && !leaves && self.under_way < UNDER_WAY => DebugInput::Told(next),
            };
            match next {
                DebugInput::Said(said) => {
                    let welcome =
                        matches!(*said, StepReply::Stopped(_)) && !std::mem::replace(&mut self.welcomed, true);
                    self.under_way = self.under_way.saturating_sub(usize::from(!welcome));
                    if self.send.send(Ok(message(answer(*said)))).await.is_err() {
                        return Ok(());
                    }
                }
                DebugInput::Told(told) => {
                    let told = told.map_err(|status| Refusal::of_transport(&status))?;
                    let command = match told.and_then(|told| told.content) {
                        None => {
                            leaves = true;
                            continue;
                        }
                        Some(Told::JobId(_)) => {
                            return Err(Refusal::field("job_id", "may be given in the first message only"));
                        }
                        Some(Told::Command(of)) => command(of)?,
                    };
                    detached = command == StepCommand::Detach;
                    self.under_way += 1;
                    self.live.stepping().command(command);
                }
            }
        }
    }
}

/// The next item.
enum DebugInput {
    /// From the run.
    Said(Box<StepReply>),
    /// From the client.
    Told(Result<Option<v1::DebugRequest>, Status>),
}

fn channel(field: &str, number: u32) -> Result<u16, Refusal> {
    small(&format!("command.{field}"), u64::from(number), 0, 9999)
}

fn command(command: v1::DebugCommand) -> Result<StepCommand, Refusal> {
    Ok(match command.what.ok_or_else(|| Refusal::field("command.what", "is missing"))? {
        What::Step(v1::DebugStep { all, channel: number, blocks, calls }) => {
            let whom = match (all, number) {
                (true, 0) => Whom::All,
                (true, _) => return Err(Refusal::field("command.step.all", "and a channel exclude each other")),
                (false, 0) => Whom::Next,
                (false, number) => Whom::One(channel("step.channel", number)?),
            };
            let calls = match v1::StepCalls::try_from(calls) {
                Ok(v1::StepCalls::Unspecified | v1::StepCalls::Into) => StepCalls::Into,
                Ok(v1::StepCalls::Over) => StepCalls::Over,
                Ok(v1::StepCalls::Out) => StepCalls::Out,
                Err(_) => return Err(Refusal::field("command.step.calls", "is not a value of StepCalls")),
            };
            StepCommand::Step { whom, blocks, calls }
        }
        What::Action(action) => match v1::DebugAction::try_from(action) {
            Ok(v1::DebugAction::Continue) => StepCommand::Continue,
            Ok(v1::DebugAction::Pause) => StepCommand::Pause,
            Ok(v1::DebugAction::Show) => StepCommand::Show,
            Ok(v1::DebugAction::Detach) => StepCommand::Detach,
            Ok(v1::DebugAction::Unspecified) | Err(_) => {
                return Err(Refusal::field("command.action", "is not a value of DebugAction"));
            }
        },
        What::Add(breakpoint) => StepCommand::Add(added(breakpoint)?),
        What::Remove(id) => StepCommand::Remove(id),
        What::Hold(number) => StepCommand::Hold(channel("hold", number)?),
        What::Resume(number) => StepCommand::Resume(channel("resume", number)?),
        What::Reset(number) => StepCommand::Reset(channel("reset", number)?),
    })
}

fn added(breakpoint: v1::Breakpoint) -> Result<Breakpoint, Refusal> {
    let v1::Breakpoint { at, count, once, .. } = breakpoint;
    let short = |field: &str, text: String| door::place(&format!("command.add.{field}"), &text, TEXT).map(|()| text);
    let spot = match at.ok_or_else(|| Refusal::field("command.add.at", "is missing"))? {
        At::Wait(key) => BreakLocation::Wait(short("wait", key)?),
        At::Write(name) => BreakLocation::Write(short("write", name)?),
        At::Line(v1::BreakLine { file, line }) => BreakLocation::Line { file: short("line.file", file)?, line },
        At::TNs(ns) => BreakLocation::Time(ns),
    };
    Ok(Breakpoint { id: 0, spot, count, once })
}

fn answer(said: StepReply) -> Content {
    match said {
        StepReply::Stopped(report) => Content::Stopped(state(report)),
        StepReply::State(report) => Content::State(state(report)),
        StepReply::Added(breakpoint) => Content::Added(shown(breakpoint)),
        StepReply::Refused(text) => Content::Refused(text),
    }
}

fn shown(breakpoint: Breakpoint) -> v1::Breakpoint {
    let Breakpoint { id, spot, count, once } = breakpoint;
    let at = match spot {
        BreakLocation::Wait(key) => At::Wait(key),
        BreakLocation::Write(name) => At::Write(name),
        BreakLocation::Line { file, line } => At::Line(v1::BreakLine { file, line }),
        BreakLocation::Time(ns) => At::TNs(ns),
    };
    v1::Breakpoint { id, at: Some(at), count, once }
}

fn state(report: StepReport) -> v1::DebugState {
    let StepReport { reason, channel, channels, variables, breakpoints } = report;
    v1::DebugState {
        reason,
        channel: u32::from(channel),
        channels: channels.into_iter().map(channel_state).collect(),
        variables: variables.iter().map(|(name, of)| variable(name, value(of))).collect(),
        breakpoints: breakpoints.into_iter().map(shown).collect(),
    }
}

fn variable(name: &str, value: v1::DialogValue) -> v1::DebugVariable {
    v1::DebugVariable { name: name.to_owned(), value: Some(value) }
}

fn channel_state(report: ChannelReport) -> v1::DebugChannel {
    use v1::dialog_value::Value::Number;
    let number = |of: f64| v1::DialogValue { value: Some(Number(of)) };
    v1::DebugChannel {
        channel: u32::from(report.channel),
        state: wire(report.state).into(),
        file: report.file,
        line: report.line,
        block: report.block,
        t_ns: report.t_ns,
        waiting_for: report.wait.as_ref().map_or_else(String::new, |wait| wait.key.to_string()),
        held: report.held,
        in_block: report.in_block,
        words: report.words.iter().map(|(letter, of)| variable(letter.encode_utf8(&mut [0; 4]), number(*of))).collect(),
        positions: report.positions.iter().map(|(axis, of)| variable(axis, number(*of))).collect(),
        variables: report.variables.iter().map(|(name, of)| variable(name, value(of))).collect(),
    }
}
