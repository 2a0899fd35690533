//! Asks the operator at the terminal to answer the dialogs of a running job.
//!
//! *Invariant:* questions go to standard error and answers are read line by line from standard input; an empty line
//! accepts the value in brackets; the end of the input declines the dialog. A prompt ends at once when another client
//! has answered its question.

use std::collections::{BTreeMap, VecDeque};
use std::io::{BufRead as _, Write as _};

use counterpoint_proto::v1;
use counterpoint_proto::v1::attend_request::Content as Say;
use counterpoint_proto::v1::attend_response::Content;
use counterpoint_proto::v1::dialog_field::Kind;
use counterpoint_proto::v1::dialog_value::Value;
use tokio::sync::mpsc;
use tokio_stream::wrappers::ReceiverStream;

use crate::client::ServerSession;
use crate::error::Error;
use crate::say::{self, BAD, DIM, WARN, styled};

/// A connection that answers the dialogs of a job.
pub(crate) struct Attendant {
    say: mpsc::Sender<v1::AttendRequest>,
    heard: tonic::Streaming<v1::AttendResponse>,
    waiting: VecDeque<v1::Question>,
    ended: Option<v1::JobStatus>,
    /// Lines of standard input; reading starts with the first question.
    lines: Option<mpsc::UnboundedReceiver<String>>,
}

/// The next item.
pub(crate) enum AttendEvent {
    /// A dialog is open.
    Question(v1::Question),
    /// The job has ended.
    Ended(Box<v1::JobStatus>),
}

/// Result of a prompt.
enum PromptOutcome {
    Line(String),
    /// The input has ended.
    End,
    /// Another client has answered.
    Closed,
    /// No client answered in time.
    Expired,
}

/// A question that the server has closed.
struct ClosedQuestion {
    id: u64,
    /// No client answered in time.
    expired: bool,
}

impl Attendant {
    /// Connects to the dialogs of a job.
    pub(crate) async fn start(client: &ServerSession, job: &str) -> Result<Self, Error> {
        let (say, requests) = mpsc::channel(4);
        let first = v1::AttendRequest { content: Some(Say::JobId(job.to_owned())) };
        say.send(first).await.map_err(|_| gone())?;
        let heard = client.operator().attend(ReceiverStream::new(requests)).await?.into_inner();
        Ok(Self { say, heard, waiting: VecDeque::new(), ended: None, lines: None })
    }

    /// The next question, or the end of the job. May be dropped and called again.
    pub(crate) async fn next(&mut self) -> Result<AttendEvent, Error> {
        loop {
            if let Some(question) = self.waiting.pop_front() {
                return Ok(AttendEvent::Question(question));
            }
            if let Some(status) = &self.ended {
                return Ok(AttendEvent::Ended(Box::new(status.clone())));
            }
            self.listen().await?;
        }
    }

    /// Receives one message; returns the question that it closes.
    async fn listen(&mut self) -> Result<Option<ClosedQuestion>, Error> {
        let message = self.heard.message().await?.unwrap_or_default();
        match message.content {
            Some(Content::Question(question)) => self.waiting.push_back(question),
            Some(Content::Closed(id)) => {
                self.waiting.retain(|question| question.id != id);
                return Ok(Some(ClosedQuestion { id, expired: message.expired }));
            }
            Some(Content::Ended(status)) => self.ended = Some(status),
            None if self.ended.is_some() => std::future::pending().await,
            None => return Err(gone()),
        }
        Ok(None)
    }

    /// Asks a question and sends the answer.
    pub(crate) async fn answer(&mut self, question: v1::Question) -> Result<(), Error> {
        let id = question.id;
        let dialog = question.dialog.unwrap_or_default();
        let who = if question.channel == 0 { "the master".to_owned() } else { format!("channel {}", question.channel) };
        say::status_line(format_args!(
            "{} {}",
            styled(WARN, &dialog.title),
            styled(DIM, format!("({who}{})", place(&question.file, question.line)))
        ));
        if !question.problem.is_empty() {
            say::status_line(styled(BAD, &question.problem));
        }
        let mut values = Values::new();
        for field in &dialog.fields {
            let Some(kind) = &field.kind else {
                say::status_line(format_args!("  {}", field.label));
                continue;
            };
            if !is_enabled(field, &values, &question.values) {
                continue;
            }
            let start = question.values.get(&field.variable).and_then(|value| value.value.as_ref());
            let prompt =
                format!("  {}{} [{}]: ", field.label, hint(kind), start.map_or_else(String::new, |v| shown(kind, v)));
            loop {
                match self.entry(&prompt, id).await? {
                    PromptOutcome::Line(line) if line.is_empty() => break,
                    PromptOutcome::Line(line) => match read(kind, &line) {
                        Ok(value) => {
                            values.insert(field.variable.clone(), v1::DialogValue { value: Some(value) });
                            break;
                        }
                        Err(why) => say::status_line(styled(BAD, why)),
                    },
                    PromptOutcome::End => return self.send(Say::Declined(id)).await,
                    PromptOutcome::Closed | PromptOutcome::Expired => return Ok(()),
                }
            }
        }
        let button = match self.button(&dialog, id).await? {
            PromptOutcome::Line(label) => label,
            PromptOutcome::End => return self.send(Say::Declined(id)).await,
            PromptOutcome::Closed | PromptOutcome::Expired => return Ok(()),
        };
        let answer = v1::DialogAnswer { dialog: dialog.name, button, values };
        self.send(Say::Answer(v1::QuestionAnswer { question_id: id, answer: Some(answer) })).await
    }

    /// Asks for the button to press, unless there is only one.
    async fn button(&mut self, dialog: &v1::Dialog, id: u64) -> Result<PromptOutcome, Error> {
        let labels: Vec<&str> = dialog.buttons.iter().map(|button| button.label.as_str()).collect();
        let first = dialog.buttons.iter().find(|button| button.kind() == v1::ButtonKind::Ok);
        let first = first.map_or("OK", |button| button.label.as_str());
        if labels.len() <= 1 {
            return Ok(PromptOutcome::Line(first.to_owned()));
        }
        loop {
            match self.entry(&format!("  button, {} [{first}]: ", labels.join(", ")), id).await? {
                PromptOutcome::Line(line) if line.is_empty() => return Ok(PromptOutcome::Line(first.to_owned())),
                PromptOutcome::Line(line) if labels.iter().any(|label| label.eq_ignore_ascii_case(&line)) => {
                    return Ok(PromptOutcome::Line(line));
                }
                PromptOutcome::Line(line) => {
                    let one_of = labels.join(", ");
                    say::status_line(styled(BAD, format!("button '{line}' not found: expected one of {one_of}")));
                }
                other => return Ok(other),
            }
        }
    }

    /// Prompts for a line.
    async fn entry(&mut self, prompt: &str, id: u64) -> Result<PromptOutcome, Error> {
        let mut out = anstream::stderr();
        let _ = out.write_all(prompt.as_bytes()).and_then(|()| out.flush());
        let mut lines = self.lines.take().unwrap_or_else(lines);
        let entry = loop {
            tokio::select! {
                line = lines.recv() => break line.map_or(PromptOutcome::End, |line| PromptOutcome::Line(line.trim().to_owned())),
                closed = self.listen() => match closed? {
                    Some(closed) if closed.id == id && closed.expired => break PromptOutcome::Expired,
                    Some(closed) if closed.id == id => break PromptOutcome::Closed,
                    _ if self.ended.is_some() => break PromptOutcome::Closed,
                    _ => {}
                },
            }
        };
        self.lines = Some(lines);
        match entry {
            PromptOutcome::Closed => {
                say::status_line(styled(DIM, "\n  closed: another client has answered, or the run was stopped"))
            }
            PromptOutcome::Expired => say::status_line(styled(WARN, EXPIRED)),
            PromptOutcome::End => say::status_line(styled(DIM, "\n  declined: end of input")),
            PromptOutcome::Line(_) => {}
        }
        Ok(entry)
    }

    async fn send(&mut self, content: Say) -> Result<(), Error> {
        self.say.send(v1::AttendRequest { content: Some(content) }).await.map_err(|_| gone())
    }
}

/// The message about a question that no client has answered.
const EXPIRED: &str = "\n  too late: the time for an answer has run out (operator_wait_s of the server), so the dialog has failed \
    (2910073)";

/// The place of a question; a question before the first block has no line.
fn place(file: &str, line: u32) -> String {
    match (file, line) {
        ("", _) => String::new(),
        (file, 0) => format!(", {file}"),
        (file, line) => format!(", {file} line {line}"),
    }
}

/// The connection is lost.
pub(crate) fn gone() -> Error {
    Error::Connection("the server ended the stream".to_owned())
}

/// Reads standard input on a separate thread, so that the command can end without waiting for input.
pub(crate) fn lines() -> mpsc::UnboundedReceiver<String> {
    let (send, receive) = mpsc::unbounded_channel();
    let read = move || {
        for line in std::io::stdin().lock().lines() {
            let Ok(line) = line else { break };
            if send.send(line).is_err() {
                break;
            }
        }
    };
    // If the thread cannot be started, the input counts as ended.
    let _ = std::thread::Builder::new().name("input".to_owned()).spawn(read);
    receive
}

/// Values by variable.
type Values = BTreeMap<String, v1::DialogValue>;

/// Whether a field is enabled, by the values entered so far and the initial values of the question.
fn is_enabled(field: &v1::DialogField, entered: &Values, start: &Values) -> bool {
    if field.enabled_by.is_empty() {
        return true;
    }
    let of = |values: &Values| {
        let mut found = values.iter().filter(|(variable, _)| variable.eq_ignore_ascii_case(&field.enabled_by));
        found.next().and_then(|(_, value)| value.value.clone())
    };
    let is_set = match of(entered).or_else(|| of(start)) {
        Some(Value::Flag(flag)) => flag,
        Some(Value::Number(number)) => number != 0.0,
        Some(Value::Text(text)) => !text.is_empty(),
        None => false,
    };
    is_set != field.enabled_unless
}

/// A number field has no limit if the magnitude of its limit is at least this.
const UNLIMITED: f64 = 1e15;

/// Input that a field accepts, shown after its label.
fn hint(kind: &Kind) -> String {
    match kind {
        Kind::LongestText(longest) => format!(", up to {longest} characters"),
        Kind::Number(number) => {
            let whole = if number.whole { ", whole" } else { "" };
            match (number.min.abs() < UNLIMITED, number.max.abs() < UNLIMITED) {
                (true, true) => format!(", {} to {}{whole}", number.min, number.max),
                (true, false) => format!(", at least {}{whole}", number.min),
                (false, true) => format!(", at most {}{whole}", number.max),
                (false, false) => whole.to_owned(),
            }
        }
        Kind::Check(_) => ", yes or no".to_owned(),
        Kind::Choice(choice) => {
            let labels = choice.choices.iter().zip(1..).map(|(choice, n)| format!("{n} {}", choice.label));
            format!(", {}", labels.collect::<Vec<_>>().join(", "))
        }
    }
}

/// A value as a person would write it.
fn shown(kind: &Kind, value: &Value) -> String {
    if let Kind::Choice(choice) = kind
        && let Some(chosen) =
            choice.choices.iter().find(|c| c.value.as_ref().and_then(|v| v.value.as_ref()) == Some(value))
    {
        return chosen.label.clone();
    }
    match value {
        Value::Flag(flag) => if *flag { "yes" } else { "no" }.to_owned(),
        Value::Number(number) => number.to_string(),
        Value::Text(text) => text.clone(),
    }
}

/// A line as the value of a field.
fn read(kind: &Kind, line: &str) -> Result<Value, String> {
    match kind {
        Kind::LongestText(longest) => match line.chars().count() {
            count if count > *longest as usize => {
                Err(format!("the text has {count} characters; at most {longest} are allowed"))
            }
            _ => Ok(Value::Text(line.to_owned())),
        },
        Kind::Number(v1::NumberField { min, max, whole }) => match line.parse::<f64>().ok().filter(|n| n.is_finite()) {
            None => Err(format!("'{line}' is not a valid number")),
            Some(number) if number < *min || number > *max => Err(outside(*min, *max, number)),
            Some(number) if *whole && number.fract() != 0.0 => Err(format!("must be a whole number, not {number}")),
            Some(number) => Ok(Value::Number(number)),
        },
        Kind::Check(_) => match line.to_lowercase().as_str() {
            "y" | "yes" | "true" | "on" | "1" => Ok(Value::Flag(true)),
            "n" | "no" | "false" | "off" | "0" => Ok(Value::Flag(false)),
            _ => Err(format!("'{line}' is not yes or no")),
        },
        Kind::Choice(choice) => {
            let by_label = choice.choices.iter().find(|choice| choice.label.eq_ignore_ascii_case(line));
            let by_number = || choice.choices.get(line.parse::<usize>().ok()?.checked_sub(1)?);
            let chosen = by_label.or_else(by_number);
            let value = chosen.and_then(|choice| choice.value.clone()).and_then(|value| value.value);
            value.ok_or_else(|| format!("'{line}' is not one of the choices"))
        }
    }
}

/// The message about a number outside the limits of its field.
fn outside(min: f64, max: f64, number: f64) -> String {
    match (min.abs() < UNLIMITED, max.abs() < UNLIMITED) {
        (true, true) => format!("must be {min} to {max}, not {number}"),
        (true, false) => format!("must be at least {min}, not {number}"),
        (false, _) => format!("must be at most {max}, not {number}"),
    }
}

#[cfg(test)]
mod tests;
