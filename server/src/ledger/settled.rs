//! Outcomes of the questions to the operator of a job.
//!
//! *Invariant:* the work of a job has one outcome for each question that is over, in the order of the questions of each
//! channel.

use std::collections::HashMap;

use counterpoint_kernel::dialog::answers::DialogAnswer;
use counterpoint_kernel::dialog::operator::Silence;

use super::record::JobWork;

/// The outcome of a question to the operator.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Settled {
    pub(crate) channel: u16,
    /// Number of the question within the channel, from 1.
    pub(crate) question: u64,
    pub(crate) answer: Result<DialogAnswer, Silence>,
}

impl JobWork {
    /// Adds the outcome of a question. It replaces an outcome that was stored for the question but not acknowledged.
    pub(crate) fn settle(&mut self, Settled { channel, question, answer }: Settled) {
        self.late.retain(|(of, number)| *of != channel || *number < question);
        if answer == Err(Silence::Late) {
            self.late.push((channel, question));
        }
        let mut number = 0;
        self.answers.retain(|(of, _)| {
            number += u64::from(*of == channel);
            *of != channel || number < question
        });
        self.answers.push((channel, answer.ok()));
    }

    /// The outcomes of the questions so far, by channel in the order of the questions.
    pub(crate) fn outcomes(&self) -> Vec<(u16, Result<DialogAnswer, Silence>)> {
        let mut asked: HashMap<u16, u64> = HashMap::new();
        let outcome = |(channel, answer): &(u16, Option<DialogAnswer>)| {
            let number = asked.entry(*channel).or_default();
            *number += 1;
            let silence = if self.late.contains(&(*channel, *number)) { Silence::Late } else { Silence::Declined };
            (*channel, answer.clone().ok_or(silence))
        };
        self.answers.iter().map(outcome).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ledger::record::tests::work;

    #[test]
    fn the_outcome_of_a_question_replaces_one_that_was_not_acknowledged() {
        let mut work = work();
        let answer = |button: &str| Ok(DialogAnswer { button: Some(button.into()), ..DialogAnswer::default() });
        let (declined, late) = (|| Err(Silence::Declined), || Err(Silence::Late));
        let settled = [
            (1, 1, answer("a")),
            (2, 1, late()),
            (1, 2, late()),
            (1, 2, answer("b")),
            (1, 2, declined()),
            (2, 2, answer("c")),
        ];
        for (channel, question, answer) in settled {
            work.settle(Settled { channel, question, answer });
        }
        let work: JobWork = serde_json::from_str(&serde_json::to_string(&work).unwrap()).unwrap();
        assert_eq!(work.outcomes(), [(1, answer("a")), (2, late()), (1, declined()), (2, answer("c"))]);
    }
}
