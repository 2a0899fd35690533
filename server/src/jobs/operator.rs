//! The desk of a job: dialogs that wait for the operator.
//!
//! Invariants:
//! * A question is answered once, by the first client.
//! * Every outcome of a question is stored before the kernel gets it, even if no client answered in time. A repeated
//!   run gets the outcomes of the earlier run in the same order, so it gives the same log.
//! * A question has the same id in every run, so a repeated answer reaches no other question.
//! * No question outlives the run, and none waits longer than the patience of the server.

use std::collections::{BTreeMap, HashMap, VecDeque};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use counterpoint_kernel::dialog::answers::{DialogAnswer, DialogValue};
use counterpoint_kernel::dialog::operator::{OpenDialog, Silence};
use counterpoint_kernel::dialog::{Button, ButtonKind, Dialog, DialogField, FieldKind};
use counterpoint_proto::v1;
use tokio::sync::watch;

use super::growing::Growing;
use super::lock::lock;
use crate::clock::now_ms;

/// Where dialogs wait.
#[derive(Debug)]
pub(crate) struct Desk {
    inner: Mutex<DeskState>,
    /// For kernels: something was answered, or nothing will be.
    answered: Condvar,
    /// For attending clients: counts changes.
    changes: watch::Sender<u64>,
    /// Storage for the answers of operators.
    received: Mutex<Option<Growing>>,
}

#[derive(Debug, Default)]
struct DeskState {
    /// Answers of runs before, by channel.
    recorded: HashMap<u16, VecDeque<Result<DialogAnswer, Silence>>>,
    open: BTreeMap<u64, OpenQuestion>,
    /// Number of questions of the run so far, by channel.
    asked: HashMap<u16, u64>,
    /// The latest questions that no client answered in time.
    expired: VecDeque<u64>,
    patience: Duration,
    closed: bool,
}

/// Maximum number of expired questions that the desk remembers.
const MAX_EXPIRED: usize = 64;

/// A question that is open.
#[derive(Debug)]
struct OpenQuestion {
    channel: u16,
    question: v1::Question,
    /// When it was asked, ms since 1970.
    since_ms: i64,
    /// An answer is being made durable.
    claimed: bool,
    answer: Option<Result<DialogAnswer, Silence>>,
}

impl DeskState {
    /// The id of the channel's next question: its number within the channel in the lower half, the channel in the upper
    /// half. There channel 1 is 0 and the master is 1.
    fn next_id(&mut self, channel: u16) -> u64 {
        let asked = self.asked.entry(channel).or_default();
        *asked += 1;
        let upper = if channel < 2 { 1 - channel } else { channel };
        u64::from(upper) << 32 | *asked
    }
}

impl Desk {
    /// Creates an empty desk.
    pub(crate) fn new() -> Self {
        let (inner, received) = (Mutex::default(), Mutex::default());
        Self { inner, answered: Condvar::new(), changes: watch::Sender::new(0), received }
    }

    /// The job will be run again from its start.
    pub(crate) fn begin_again(&self) {
        *lock(&self.inner) = DeskState::default();
        self.tell();
    }

    /// Sets the answers that earlier runs have received, for the run that begins now.
    pub(crate) fn record(&self, answers: Vec<(u16, Result<DialogAnswer, Silence>)>) {
        let mut inner = lock(&self.inner);
        inner.recorded.clear();
        for (channel, answer) in answers {
            inner.recorded.entry(channel).or_default().push_back(answer);
        }
    }

    /// How long a question waits.
    pub(crate) fn set_patience(&self, patience: Duration) {
        lock(&self.inner).patience = patience;
    }

    /// No question is answered any more.
    pub(crate) fn close(&self) {
        lock(&self.inner).closed = true;
        self.answered.notify_all();
        self.tell();
    }

    /// Counts changes of the open questions.
    pub(crate) fn follow(&self) -> watch::Receiver<u64> {
        self.changes.subscribe()
    }

    /// Questions that no client has taken yet, in their order.
    pub(crate) fn questions(&self) -> Vec<v1::Question> {
        let inner = lock(&self.inner);
        inner.open.values().filter(|open| !open.claimed).map(|open| open.question.clone()).collect()
    }

    /// A question that no client has taken yet.
    pub(crate) fn question(&self, id: u64) -> Option<v1::Question> {
        lock(&self.inner).open.get(&id).filter(|open| !open.claimed).map(|open| open.question.clone())
    }

    /// Storage for the answers of operators; none until it is counted.
    pub(crate) fn received(&self) -> MutexGuard<'_, Option<Growing>> {
        lock(&self.received)
    }

    /// Channels that wait for an answer.
    pub(crate) fn asking(&self) -> usize {
        lock(&self.inner).open.values().filter(|open| open.answer.is_none()).count()
    }

    /// Start and end of the wait of the first of the open questions, ms since 1970.
    pub(super) fn wait(&self) -> Option<(i64, i64)> {
        let inner = lock(&self.inner);
        let since = inner.open.values().filter(|open| open.answer.is_none()).map(|open| open.since_ms).min()?;
        Some((since, end_ms(since, inner.patience)))
    }

    /// Whether a question was closed because no client answered it in time.
    pub(crate) fn is_expired(&self, id: u64) -> bool {
        lock(&self.inner).expired.contains(&id)
    }

    /// Claims a question in order to answer it; `None` if the question is closed.
    pub(crate) fn claim(&self, id: u64) -> Option<Claimed> {
        let mut inner = lock(&self.inner);
        let open = inner.open.get_mut(&id).filter(|open| !open.claimed)?;
        open.claimed = true;
        let dialog = open.question.dialog.as_ref().map_or_else(String::new, |dialog| dialog.name.clone());
        let claimed = Claimed { channel: open.channel, question: number(id), dialog };
        drop(inner);
        self.tell();
        Some(claimed)
    }

    /// Opens a claimed question again after its answer could not be stored.
    pub(crate) fn release(&self, id: u64) {
        if let Some(open) = lock(&self.inner).open.get_mut(&id) {
            open.claimed = false;
        }
        self.answered.notify_all();
        self.tell();
    }

    /// Gives the answer to a question that was claimed.
    pub(crate) fn answer(&self, id: u64, answer: Result<DialogAnswer, Silence>) {
        if let Some(open) = lock(&self.inner).open.get_mut(&id) {
            open.answer = Some(answer);
        }
        self.answered.notify_all();
    }

    fn tell(&self) {
        self.changes.send_modify(|changes| *changes += 1);
    }
}

/// The end of a wait, ms since 1970.
pub(super) fn end_ms(since_ms: i64, patience: Duration) -> i64 {
    since_ms.saturating_add(i64::try_from(patience.as_millis()).unwrap_or(i64::MAX))
}

/// The number of a question within its channel, from 1.
fn number(id: u64) -> u64 {
    id & u64::from(u32::MAX)
}

/// A question that a client has claimed.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Claimed {
    pub(crate) channel: u16,
    /// Number of the question within the channel, from 1.
    pub(crate) question: u64,
    /// The name of its dialog.
    pub(crate) dialog: String,
}

/// How a question ends for its kernel.
#[derive(Debug, PartialEq)]
pub(super) enum QuestionOutcome {
    /// The stored answer.
    Answered(Result<DialogAnswer, Silence>),
    /// No client answered in time; this is not stored yet. The number is that of the question within its channel.
    Unanswered(u64),
    /// The run is to end.
    Closed,
}

impl Desk {
    /// Whether the run is to end.
    pub(super) fn is_closed(&self) -> bool {
        lock(&self.inner).closed
    }

    /// Asks a question and waits for its outcome.
    pub(super) fn put(&self, question: &OpenDialog<'_>) -> QuestionOutcome {
        let mut inner = lock(&self.inner);
        let id = inner.next_id(question.channel);
        let recorded = inner.recorded.get_mut(&question.channel).and_then(VecDeque::pop_front);
        if let Some(answer) = recorded {
            return QuestionOutcome::Answered(answer);
        }
        // Do not publish questions after the desk has closed.
        if inner.closed {
            return QuestionOutcome::Closed;
        }
        let (channel, question) = (question.channel, wire(id, question));
        let open = OpenQuestion { channel, question, since_ms: now_ms(), claimed: false, answer: None };
        inner.open.insert(id, open);
        let until = Instant::now() + inner.patience;
        drop(inner);
        self.tell();
        let mut inner = lock(&self.inner);
        loop {
            let open = inner.open.get_mut(&id);
            let (answer, claimed) = open.map_or((None, false), |open| (open.answer.take(), open.claimed));
            let left = until.saturating_duration_since(Instant::now());
            // An answer that is being made durable is waited for: the record and the run must agree.
            let outcome = match answer {
                Some(answer) => Some(QuestionOutcome::Answered(answer)),
                None if inner.closed => Some(QuestionOutcome::Closed),
                None => (left.is_zero() && !claimed).then(|| QuestionOutcome::Unanswered(number(id))),
            };
            if let Some(outcome) = outcome {
                inner.open.remove(&id);
                if matches!(outcome, QuestionOutcome::Unanswered(_)) {
                    inner.expired.truncate(MAX_EXPIRED - 1);
                    inner.expired.push_front(id);
                }
                drop(inner);
                self.tell();
                return outcome;
            }
            let wait = if claimed { Duration::from_secs(1) } else { left };
            inner = self.answered.wait_timeout(inner, wait).unwrap_or_else(PoisonError::into_inner).0;
        }
    }
}

/// A question on the wire.
fn wire(id: u64, question: &OpenDialog<'_>) -> v1::Question {
    v1::Question {
        id,
        channel: u32::from(question.channel),
        file: question.file.to_owned(),
        line: question.line,
        dialog: Some(dialog(question.dialog)),
        values: question.values.iter().map(|(variable, v)| (variable.clone(), value(v))).collect(),
        problem: question.problem.unwrap_or_default().to_owned(),
    }
}

/// A value on the wire.
pub(crate) fn value(value: &DialogValue) -> v1::DialogValue {
    use v1::dialog_value::Value as Wire;
    let value = match value {
        DialogValue::Flag(flag) => Wire::Flag(*flag),
        DialogValue::Number(number) => Wire::Number(*number),
        DialogValue::Text(text) => Wire::Text(text.clone()),
    };
    v1::DialogValue { value: Some(value) }
}

fn dialog(dialog: &Dialog) -> v1::Dialog {
    v1::Dialog {
        name: dialog.name.clone(),
        title: dialog.title.clone(),
        fields: dialog.fields.iter().map(field).collect(),
        buttons: dialog.buttons.iter().map(button).collect(),
    }
}

fn field(field: &DialogField) -> v1::DialogField {
    use v1::dialog_field::Kind;
    let choice = |(label, v): &(String, DialogValue)| v1::Choice { label: label.clone(), value: Some(value(v)) };
    let kind = match &field.kind {
        FieldKind::Label => None,
        FieldKind::Text { longest } => Some(Kind::LongestText(u32::try_from(*longest).unwrap_or(u32::MAX))),
        FieldKind::Number { min, max, whole } => {
            Some(Kind::Number(v1::NumberField { min: *min, max: *max, whole: *whole }))
        }
        FieldKind::Check => Some(Kind::Check(v1::CheckField {})),
        FieldKind::Choice(choices) => {
            Some(Kind::Choice(v1::ChoiceField { choices: choices.iter().map(choice).collect() }))
        }
    };
    let (enabled_by, wanted) = field.enabled.clone().unwrap_or((String::new(), true));
    v1::DialogField {
        label: field.label.clone(),
        variable: field.variable.clone(),
        required: field.required,
        kind,
        enabled_by,
        enabled_unless: !wanted,
    }
}

fn button(button: &Button) -> v1::DialogButton {
    let kind = match button.kind {
        ButtonKind::Ok => v1::ButtonKind::Ok,
        ButtonKind::Cancel => v1::ButtonKind::Cancel,
        ButtonKind::Reset => v1::ButtonKind::Reset,
        ButtonKind::Call(_) => v1::ButtonKind::Call,
    };
    v1::DialogButton { label: button.label.clone(), kind: kind.into() }
}

#[cfg(test)]
mod tests;
