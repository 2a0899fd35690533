//! Kernels that wait for the log: one makes more events than may be on the way while another waits at a sync point with
//! nearly as many.
//!
//! All ways of running a job end, with the same log.

use std::fmt::Write as _;

use counterpoint_kernel::log::summary::JobOutcome;
use counterpoint_kernel::options::JobOptions;
use counterpoint_tests::{Work, machine};
use proptest::prelude::*;

/// Events that may be on the way from one kernel: eight chunks of 512.
const CREDIT: usize = 8 * 512;

/// Sections of blocks, each with two events, at a feed; a wait before each section and at the end.
fn program(sections: &[(usize, u32)]) -> String {
    let mut text = String::from("G98 G0 X50. Z5.\nS500 M3\n");
    for (number, (blocks, feed)) in sections.iter().enumerate() {
        let _ = writeln!(text, "M{} P12", 101 + number);
        for block in 0..*blocks {
            let _ = writeln!(text, "G1 Z{} F{feed}.", if block % 2 == 0 { "-1." } else { "1." });
        }
    }
    let _ = writeln!(text, "M{} P12\nM30", 101 + sections.len());
    text
}

/// Runs programs on one thread, on several, and on several with one processor's worth of turns.
fn run_all_ways(texts: &[String]) {
    let mut digests = Vec::new();
    for threads in [1, 0, 2] {
        let options = JobOptions { threads, ..JobOptions::default() };
        let done = Work::texts(machine("fanuc-2path-lathe", ""), texts, options).run(None).expect("a job");
        assert_eq!(done.summary.state, JobOutcome::Succeeded, "{:?}", done.summary.diagnostics);
        digests.push(done.summary.log_digest);
    }
    digests.dedup();
    assert_eq!(digests.len(), 1, "{digests:?}");
}

/// The slow kernel has used up its chunks; the fast one needs a chunk to say that it waits.
#[test]
fn a_kernel_that_waits_with_nearly_all_its_chunks_does_not_hold_up_the_log() {
    for fast in [CREDIT / 2 - 100, CREDIT / 2 - 48, CREDIT / 2 - 8] {
        run_all_ways(&[program(&[(3000, 500)]), program(&[(fast, 3000)])]);
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: counterpoint_tests::cases(4), failure_persistence: None, ..ProptestConfig::default()
    })]

    #[test]
    fn kernels_with_any_number_of_events_end_with_one_log(
        sections in proptest::collection::vec(
            ((1_usize..4).prop_flat_map(|chunks| (chunks * 512)..(chunks * 1024)), 1_u32..8,
             (1_usize..4).prop_flat_map(|chunks| (chunks * 512)..(chunks * 1024)), 1_u32..8),
            1..3,
        ),
    ) {
        let one: Vec<_> = sections.iter().map(|(blocks, feed, ..)| (*blocks, feed * 500)).collect();
        let other: Vec<_> = sections.iter().map(|(_, _, blocks, feed)| (*blocks, feed * 500)).collect();
        run_all_ways(&[program(&one), program(&other)]);
    }
}
