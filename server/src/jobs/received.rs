//! Storage for the answers of operators.
//!
//! *Invariant:* the answers to the questions of a job count as storage of its tenant from their arrival until the job
//! has ended. After that, the row of the job in the ledger counts.

use counterpoint_kernel::dialog::answers::{DialogAnswer, DialogValue};
use counterpoint_kernel::dialog::operator::Silence;

use super::Core;
use super::growing::Growing;
use crate::reason::Refusal;

/// Maximum size of all answers to the questions of one job, bytes: each further answer stores all of them again.
const MOST: u64 = 4 << 20;
/// Bytes of an answer or a value besides its texts.
const EACH: usize = 16;

/// The size of an answer, bytes.
fn size(answer: &DialogAnswer) -> u64 {
    let texts = answer.values.iter().map(|(name, value)| {
        let text = if let DialogValue::Text(text) = value { text.len() } else { 0 };
        EACH + name.len() + text
    });
    (EACH + answer.button.as_ref().map_or(0, String::len) + texts.sum::<usize>()) as u64
}

/// Counts an answer that is about to be stored, or refuses it. `field` is its place in the request, and `most` the
/// number of bytes that the job may store. Returns the size of the answer.
pub(crate) fn receive(
    core: &Core,
    received: &mut Option<Growing>,
    (tenant, most): (&str, u64),
    (field, answer): (&str, &DialogAnswer),
) -> Result<u64, Refusal> {
    let (size, most) = (size(answer), MOST.min(most));
    let received = received.get_or_insert_with(|| core.growing(tenant));
    if received.bytes().saturating_add(size) > most {
        let rule = format!("must fit into the {most} bytes allowed for all answers to the questions of a job");
        return Err(Refusal::field(format!("{field}.values"), rule));
    }
    core.grow(received, size)?;
    Ok(size)
}

/// The bytes of the answers that earlier runs of a job have received.
pub(super) fn received_before(core: &Core, tenant: &str, answers: &[(u16, Result<DialogAnswer, Silence>)]) -> Growing {
    let bytes = answers.iter().filter_map(|(_, answer)| answer.as_ref().ok()).map(size).sum();
    let mut growing = core.growing(tenant);
    growing.add(bytes);
    growing
}
