//! Blocks that Fanuc and Haas controls take as they are: no word of them makes a job FAILED, none is reported as left
//! over.

use std::fmt::Write as _;

use counterpoint_kernel::log::summary::JobOutcome;
use counterpoint_kernel::options::JobOptions;
use counterpoint_tests::{Work, machine};

const MILL: &[&str] = &[
    "G28 X0. Y0. Z0.",
    "G91 G28 Z0. M19",
    "G54 P1 G0 X1.",
    "G54.1 P2",
    "G90 G54 G0 X1. Y2. S1000 M3",
    "G43 Z10. H1 D1",
    "G41 X1. D1 H1 F100",
    "G41 D1 G1 X5. F100\nX10.\nG40 X20. Y5. I1. J2.",
    "G0 X1. S500",
    "G17 G3 X0. Y10. I0. J5. Z-1. K2. F100",
    "F100\nG81 X1. Y1. Z-1. R1. P500 K1",
    "F100\nG83 X1. Y1. Z-5. R1. Q1. I0. J0. L1",
    "F100\nG90 G81 X1. Z-1. R1.\nG90 G80 Z10.",
    "G80 X5. P1 Q1",
    "M98 P2 L1\nM30\nO2\nM99",
    "G4 X1.5",
    "G4 P500",
    "G4",
    "G4 S500 P100",
    "G5.1 Q1",
    "G5 P10000",
    "G8 P1",
    "F100\nG31 X5. P2",
    "T0 M6",
    "T1 M6 D1 H1",
    "G92 S2000",
    "G96 S200 P1",
    "G22 X1. Y1. Z1. I0. J0. K0.",
    "G25\nG26 P1000 Q10 R10",
    "G10 L2 P1 X1. Y2. Z3.",
    "N10 G0 X1.\nN20 Y1.",
];

const LATHE: &[&str] = &[
    "G28 U0 W0",
    "G28 U0. W0. H0.",
    "G54 P1 G0 X1.",
    "G40 X20. Z5. I1. K2.",
    "G50 S2000\nG96 S200 M3 P1",
    "G4 U1.5",
    "G4 X1.",
    "G4 P500",
    "G4",
    "G0 X50. T0101 S500",
    "M3 S500 F0.1\nG83 Z-5. R-2. Q1. P100 K1 M10",
    "M3 S500 F0.1\nG83 Z-5. R-2. L1",
    "G80 P1 Q1 K1",
    "M3 S500\nG92 X40. Z-10. F1.5 R0. Q0",
    "M98 P2 L2\nM30\nO2\nM99",
    "G10 P1 X0.1 Z0.1 R0.4",
    "F100 G98\nG31 Z5. P1",
];

fn faults(on: &str, blocks: &[&str]) -> String {
    let mut wrong = String::new();
    for block in blocks {
        let machine = machine(on, "[[tool.offsets]]\nnumber = 1\nradius = 1\n");
        let mut texts = vec![format!("O1\n{block}\nM30\n")];
        texts.extend((1..machine.channels.len()).map(|_| "M30\n".to_owned()));
        let done = Work::texts(machine, &texts, JobOptions::default()).run(None).expect("the job can be prepared");
        let told: Vec<_> = done.summary.diagnostics.iter().filter(|one| one.severity >= 8).collect();
        if done.summary.state != JobOutcome::Succeeded || !told.is_empty() {
            let _ = writeln!(wrong, "{on}, '{block}': {told:?}");
        }
    }
    wrong
}

#[test]
fn words_that_a_control_ignores_make_no_job_fail() {
    let wrong =
        [faults("fanuc-mill", MILL), faults("fanuc-2path-lathe", LATHE), faults("haas-mill-turn", LATHE)].concat();
    assert!(wrong.is_empty(), "{wrong}");
}
