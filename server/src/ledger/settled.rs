//! Outcomes of the questions to the operator of a job.
//!
//! *Invariant:* the work of a job has one outcome for each question that is over, in the order of the questions of each
//! channel.

use counterpoint_kernel::dialog::answers::Answer;

use super::record::Work;

/// The outcome of a question to the operator.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Settled {
    pub(crate) channel: u16,
    /// Number of the question within the channel, from 1.
    pub(crate) question: u64,
    /// `None`: the operator declined, or did not answer in time.
    pub(crate) answer: Option<Answer>,
}

impl Work {
    /// Adds the outcome of a question. It replaces an outcome that was stored for the question but not acknowledged.
    pub(crate) fn settle(&mut self, Settled { channel, question, answer }: Settled) {
        let mut number = 0;
        self.answers.retain(|(of, _)| {
            number += u64::from(*of == channel);
            *of != channel || number < question
        });
        self.answers.push((channel, answer));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ledger::record::tests::work;

    #[test]
    fn the_outcome_of_a_question_replaces_one_that_was_not_acknowledged() {
        let mut work = work();
        let answer = |button: &str| Some(Answer { button: Some(button.into()), ..Answer::default() });
        for (channel, question, answer) in
            [(1, 1, answer("a")), (2, 1, None), (1, 2, answer("b")), (1, 2, None), (2, 2, answer("c"))]
        {
            work.settle(Settled { channel, question, answer });
        }
        assert_eq!(work.answers, [(1, answer("a")), (2, None), (1, None), (2, answer("c"))]);
    }
}
