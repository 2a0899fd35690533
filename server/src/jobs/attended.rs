//! The operator of a run: the desk of its job, and the ledger that keeps the outcomes of its questions.
//!
//! *Invariant:* the kernel continues after a question only when the outcome is stored, or when the run is to end. A
//! repeated run therefore gets the same outcomes.

use std::sync::Arc;
use std::time::Duration;

use counterpoint_kernel::dialog::answers::DialogAnswer;
use counterpoint_kernel::dialog::operator::{DialogOperator, OpenDialog, Silence};

use super::operator::{Desk, QuestionOutcome};
use crate::ledger::Ledger;
use crate::ledger::settled::Settled;

/// Time between two attempts to store that a question was not answered.
const PAUSE: Duration = Duration::from_millis(50);

/// The operator of the run of a job.
pub(super) struct DeskOperator {
    pub(super) ledger: Arc<dyn Ledger>,
    pub(super) desk: Arc<Desk>,
    /// Id of the job.
    pub(super) job: String,
}

impl DialogOperator for DeskOperator {
    fn ask(&self, question: &OpenDialog<'_>) -> Result<DialogAnswer, Silence> {
        match self.desk.put(question) {
            QuestionOutcome::Answered(answer) => answer,
            QuestionOutcome::Unanswered(number) => {
                let answer = Err(Silence::Late);
                self.store(&Settled { channel: question.channel, question: number, answer });
                Err(Silence::Late)
            }
            QuestionOutcome::Closed => Err(Silence::Closed),
        }
    }
}

impl DeskOperator {
    /// Stores an outcome. While the ledger cannot be written, the kernel waits, unless the run is to end.
    fn store(&self, settled: &Settled) {
        while let Err(error) = self.ledger.answered_blocking(self.job.clone(), settled.clone()) {
            if self.desk.is_closed() {
                return;
            }
            tracing::debug!(%error, "the outcome of a question is stored later");
            std::thread::sleep(PAUSE);
        }
    }
}
