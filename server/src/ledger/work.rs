//! The part of a job that only a run needs, in a row of its own.

use counterpoint_kernel::dialog::answers::DialogAnswer;
use counterpoint_kernel::options::JobOptions;
use serde::{Deserialize, Serialize};

use crate::machines::MachineRecord;

/// The part of a job that only a run needs. It may be large.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct JobWork {
    /// The machine with the digests of its files.
    pub(crate) machine: MachineRecord,
    /// Path and digest of every file.
    pub(crate) files: Vec<(String, String)>,
    /// Options, with the limits that count.
    #[serde(default)]
    pub(crate) options: JobOptions,
    /// Outcomes of the questions to the operator so far, by channel in the order of the questions; used again when the
    /// job is run again.
    #[serde(default)]
    pub(crate) answers: Vec<(u16, Option<DialogAnswer>)>,
    /// Channel and number of the questions that no operator answered in time; others without an answer were declined.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) late: Vec<(u16, u64)>,
}

impl JobWork {
    /// Maximum bytes of a work that stays in memory until the first run.
    pub(crate) const SMALL: u64 = 1024;

    /// Whether the work is small enough to stay in memory: a few files, and neither answers nor parameters.
    pub(crate) fn is_small(&self) -> bool {
        const FILE: usize = 128;
        let own = self.files.iter().map(|(path, digest)| FILE + path.len() + digest.len());
        let machine = self.machine.files.iter().map(|(path, digest)| FILE + path.len() + digest.len());
        let JobOptions { answers, parameters, warnings_off, warnings_on, ignore_waits, .. } = &self.options;
        let lists = warnings_off.len() + warnings_on.len() + ignore_waits.len();
        let plain = answers.is_empty() && parameters.is_empty() && lists == 0 && self.answers.is_empty();
        plain && (own.chain(machine).sum::<usize>() as u64) <= Self::SMALL
    }
}

#[cfg(test)]
mod tests {
    use counterpoint_kernel::dialog::answers::DialogValue;

    use super::*;
    use crate::ledger::record::tests::work;

    #[test]
    fn numbers_of_answers_come_back_as_they_were_given() {
        let mut bits = 0x9E37_79B9_7F4A_7C15_u64;
        for _ in 0..5000 {
            bits = bits.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let number = f64::from_bits(bits ^ (bits >> 29));
            if number.is_finite() {
                let stored = serde_json::to_vec(&DialogValue::Number(number)).unwrap();
                assert_eq!(serde_json::from_slice::<DialogValue>(&stored).unwrap(), DialogValue::Number(number));
            }
        }
    }

    #[test]
    fn only_a_small_work_stays_in_memory() {
        let file = |n: usize| (format!("sub/{n}.nc"), "0".repeat(64));
        let with = |files: usize| JobWork { files: (0..files).map(file).collect(), ..work() };
        assert!(work().is_small() && with(4).is_small() && !with(6).is_small());
        let answers = vec![DialogAnswer::default()];
        assert!(!JobWork { options: JobOptions { answers, ..JobOptions::default() }, ..work() }.is_small());
        let parameters = "-A".to_owned();
        assert!(!JobWork { options: JobOptions { parameters, ..JobOptions::default() }, ..work() }.is_small());
    }
}
