//! Storage for the answers of operators.
//!
//! *Invariant:* the answers to the questions of a job count as storage of its tenant from their arrival until the job
//! has ended. After that, the row of the job in the ledger counts.

use counterpoint_kernel::dialog::answers::{Answer, Value};

use super::Core;
use super::live::Live;
use crate::reason::Refusal;

/// Maximum size of all answers to the questions of one job, bytes: each further answer stores all of them again.
const MOST: u64 = 4 << 20;
/// Bytes of an answer or a value besides its texts.
const EACH: usize = 16;

/// The size of an answer, bytes.
fn size(answer: &Answer) -> u64 {
    let texts = answer.values.iter().map(|(name, value)| {
        let text = if let Value::Text(text) = value { text.len() } else { 0 };
        EACH + name.len() + text
    });
    (EACH + answer.button.as_ref().map_or(0, String::len) + texts.sum::<usize>()) as u64
}

impl Core {
    /// Counts an answer that is about to be stored, or refuses it; `field` is its place in the request. Returns its size.
    pub(crate) fn receive(&self, live: &Live, field: &str, answer: &Answer) -> Result<u64, Refusal> {
        let (size, most) = (size(answer), MOST.min(live.most_bytes()));
        let mut received = live.desk().received();
        let received = received.get_or_insert_with(|| self.growing(&live.peek(|record| record.tenant.clone())));
        if received.bytes().saturating_add(size) > most {
            let rule = format!("must have room in the {most} bytes for all answers to the questions of a job");
            return Err(Refusal::field(format!("{field}.values"), rule));
        }
        self.grow(received, size)?;
        Ok(size)
    }

    /// Counts the answers that earlier runs of a job have received.
    pub(super) fn received_before(&self, live: &Live, answers: &[(u16, Option<Answer>)]) {
        let bytes = answers.iter().filter_map(|(_, answer)| answer.as_ref()).map(size).sum();
        let mut growing = self.growing(&live.peek(|record| record.tenant.clone()));
        growing.add(bytes);
        *live.desk().received() = Some(growing);
    }
}
