//! Steps through a job: commands are read line by line from standard input, stops and answers go to standard output.
//!
//! *Invariant:* each line is executed before the next one is read, so commands in a file have the same effect as typed
//! commands; the end of the input lets the job run to its end.

mod commands;
mod shown;

use std::cell::Cell;
use std::io::{IsTerminal as _, Write as _};

use counterpoint_proto::v1;
use counterpoint_proto::v1::debug_command::What;
use counterpoint_proto::v1::debug_request::Content as Say;
use counterpoint_proto::v1::debug_response::Content;
use tokio::sync::{Notify, mpsc};
use tokio_stream::wrappers::ReceiverStream;

use crate::attend::{gone, lines};
use crate::client::ServerSession;
use crate::error::Error;
use crate::say::{self, BAD, DIM, styled};
use commands::{HELP, StepInput};

/// A connection that steps through a job.
pub(crate) struct StepClient {
    say: mpsc::Sender<v1::DebugRequest>,
    heard: tonic::Streaming<v1::DebugResponse>,
    lines: mpsc::UnboundedReceiver<String>,
    /// Line of the input.
    line: u32,
    /// A person types the commands.
    person: bool,
    ended: Option<v1::JobStatus>,
}

/// The effect of an interrupt on a job that is stepped through.
#[derive(Debug, Default)]
pub(crate) struct Interrupt {
    /// The job runs, so an interrupt pauses it.
    running: Cell<bool>,
    pause: Notify,
}

impl Interrupt {
    /// Pauses a running job; `false` if it is stopped or no longer stepped through.
    pub(crate) fn pause(&self) -> bool {
        let runs = self.running.get();
        if runs {
            self.pause.notify_one();
        }
        runs
    }
}

impl StepClient {
    /// Connects to a job.
    pub(crate) async fn start(client: &ServerSession, job: &str) -> Result<Self, Error> {
        let (say, requests) = mpsc::channel(4);
        let first = v1::DebugRequest { content: Some(Say::JobId(job.to_owned())) };
        say.send(first).await.map_err(|_| gone())?;
        let heard = client.operator().debug(ReceiverStream::new(requests)).await?.into_inner();
        Ok(Self { say, heard, lines: lines(), line: 0, person: std::io::stdin().is_terminal(), ended: None })
    }

    /// Executes the commands until the job has ended.
    pub(crate) async fn drive(mut self, interrupt: &Interrupt) -> Result<v1::JobStatus, Error> {
        self.stop(interrupt).await?;
        while self.ended.is_none() {
            let Some(text) = self.next_line().await? else { break };
            let line = match commands::read(&text) {
                Ok(line) => line,
                Err(why) if self.person => {
                    say::status_line(styled(BAD, why));
                    continue;
                }
                Err(why) => return Err(Error::Usage(format!("line {} of the commands: {why}", self.line))),
            };
            match line {
                StepInput::Nothing => {}
                StepInput::Help => say::status_line(HELP),
                StepInput::Quit => break,
                StepInput::Until(breakpoint) => {
                    self.send(What::Add(breakpoint)).await?;
                    if self.answer(false).await? {
                        self.send(What::Action(v1::DebugAction::Continue.into())).await?;
                        self.stop(interrupt).await?;
                    }
                }
                StepInput::Show => {
                    self.send(What::Action(v1::DebugAction::Show.into())).await?;
                    self.answer(true).await?;
                }
                StepInput::Run(what) => {
                    self.send(what).await?;
                    self.stop(interrupt).await?;
                }
                StepInput::Set(what) => {
                    self.send(what).await?;
                    self.answer(false).await?;
                }
            }
        }
        self.leave().await
    }

    /// Lets the job run to its end.
    async fn leave(mut self) -> Result<v1::JobStatus, Error> {
        if self.ended.is_none() {
            // The stream says how the job has ended if it has by now.
            let _ = self.send(What::Action(v1::DebugAction::Detach.into())).await;
        }
        loop {
            if let Some(status) = self.ended.take() {
                return Ok(status);
            }
            self.listen().await?;
        }
    }

    /// The next line of the input; none at its end, or when the job has ended.
    async fn next_line(&mut self) -> Result<Option<String>, Error> {
        if self.person {
            let mut out = anstream::stderr();
            let _ = out.write_all(b"step> ").and_then(|()| out.flush());
        }
        loop {
            tokio::select! {
                line = self.lines.recv() => {
                    self.line += 1;
                    return Ok(line);
                }
                heard = self.heard.message() => {
                    self.take(heard?)?;
                    if self.ended.is_some() {
                        return Ok(None);
                    }
                }
            }
        }
    }

    /// Waits for the next stop and shows it.
    async fn stop(&mut self, interrupt: &Interrupt) -> Result<(), Error> {
        interrupt.running.set(true);
        let done = self.wait_for_stop(interrupt).await;
        interrupt.running.set(false);
        done
    }

    async fn wait_for_stop(&mut self, interrupt: &Interrupt) -> Result<(), Error> {
        loop {
            tokio::select! {
                () = interrupt.pause.notified() => self.send(What::Action(v1::DebugAction::Pause.into())).await?,
                heard = self.heard.message() => match self.take(heard?)? {
                    Some(Content::Stopped(state)) => return say::data(shown::stop(&state).as_bytes()),
                    Some(Content::Refused(why)) => {
                        say::status_line(styled(BAD, why));
                        return Ok(());
                    }
                    _ if self.ended.is_some() => return Ok(()),
                    // The answer to a pause comes before its stop.
                    _ => {}
                }
            }
        }
    }

    /// Waits for the answer to a command that does not run, and shows it; `false` if it was refused.
    async fn answer(&mut self, whole: bool) -> Result<bool, Error> {
        while self.ended.is_none() {
            match self.listen().await? {
                Some(Content::State(state)) if whole => say::data(shown::whole(&state).as_bytes())?,
                Some(Content::State(_)) => {}
                Some(Content::Added(breakpoint)) => {
                    say::status_line(styled(DIM, format_args!("breakpoint {}", shown::breakpoint(&breakpoint))));
                }
                Some(Content::Refused(why)) => {
                    say::status_line(styled(BAD, why));
                    return Ok(false);
                }
                _ => continue,
            }
            return Ok(true);
        }
        Ok(false)
    }

    async fn listen(&mut self) -> Result<Option<Content>, Error> {
        let heard = self.heard.message().await?;
        self.take(heard)
    }

    fn take(&mut self, heard: Option<v1::DebugResponse>) -> Result<Option<Content>, Error> {
        match heard.and_then(|heard| heard.content) {
            Some(Content::Ended(status)) => {
                self.ended = Some(status);
                Ok(None)
            }
            None if self.ended.is_none() => Err(gone()),
            other => Ok(other),
        }
    }

    async fn send(&mut self, what: What) -> Result<(), Error> {
        let command = v1::DebugCommand { what: Some(what) };
        self.say.send(v1::DebugRequest { content: Some(Say::Command(command)) }).await.map_err(|_| gone())
    }
}
