//! Levels of Heidenhain cycles: a depth that is an integer multiple of the infeed takes that many levels, with any
//! decimals.

use counterpoint_kernel::log::event::{Kind, MotionKind};
use counterpoint_kernel::options::JobOptions;
use counterpoint_tests::{Work, machine};
use proptest::prelude::*;

/// Cycles, with `{i}` for the infeed and `{d}` for the depth.
const CYCLES: [(&str, &str); 8] = [
    (
        "1",
        "CYCL DEF 1.0 P\nCYCL DEF 1.1 SET UP2\nCYCL DEF 1.2 DEPTH-{d}\nCYCL DEF 1.3 PECKG{i}\nCYCL DEF 1.4 DWELL 0\nCYCL DEF 1.5 F200\n",
    ),
    (
        "4",
        "CYCL DEF 4.0 P\nCYCL DEF 4.1 SET UP2\nCYCL DEF 4.2 DEPTH-{d}\nCYCL DEF 4.3 PLNGNG{i} F254\nCYCL DEF 4.4 X60\nCYCL DEF 4.5 Y50\nCYCL DEF 4.6 F508 DR+ RADIUS 7\n",
    ),
    (
        "5",
        "CYCL DEF 5.0 P\nCYCL DEF 5.1 SET UP2\nCYCL DEF 5.2 DEPTH-{d}\nCYCL DEF 5.3 PLNGNG{i} F254\nCYCL DEF 5.4 RADIUS 30\nCYCL DEF 5.5 F508 DR+\n",
    ),
    ("200", "CYCL DEF 200 P Q202={i} Q200=2 Q201=-{d} Q206=200 Q203=0 Q204=50 Q210=0 Q211=0\n"),
    (
        "203",
        "CYCL DEF 203 P Q202={i} Q200=2 Q201=-{d} Q206=200 Q203=0 Q204=50 Q210=0 Q211=0 Q212=0 Q213=0 Q205=0 Q208=0 Q256=0.2\n",
    ),
    (
        "251",
        "CYCL DEF 251 P Q215=1 Q218=40 Q219=30 Q220=7 Q368=0 Q224=0 Q367=0 Q207=500 Q351=1 Q369=0 Q338=0 Q370=1 Q366=0 Q385=500 Q202={i} Q200=2 Q201=-{d} Q206=200 Q203=0 Q204=50\n",
    ),
    (
        "252",
        "CYCL DEF 252 P Q215=1 Q223=40 Q368=0 Q207=500 Q351=1 Q369=0 Q338=0 Q370=1 Q366=0 Q385=500 Q202={i} Q200=2 Q201=-{d} Q206=200 Q203=0 Q204=50\n",
    ),
    (
        "253",
        "CYCL DEF 253 P Q215=1 Q218=40 Q219=12 Q368=0 Q374=0 Q367=0 Q207=500 Q351=1 Q369=0 Q338=0 Q366=0 Q385=500 Q202={i} Q200=2 Q201=-{d} Q206=200 Q203=0 Q204=50\n",
    ),
];

/// Tenths of a millimetre as programs write them.
fn tenths(value: u32) -> String {
    format!("{}.{}", value / 10, value % 10)
}

/// End levels of the downward moves at feed.
fn levels(cycle: &str, infeed: u32, times: u32) -> Vec<i64> {
    let cycle = cycle.replace("{i}", &tenths(infeed)).replace("{d}", &tenths(infeed * times));
    let text = format!(
        "BEGIN PGM A MM\nTOOL DEF 1 L0 R5\nTOOL CALL 1 Z S1000 F500\nL X0 Y0 Z2 R0 FMAX M3\n{cycle}CYCL CALL\nEND PGM A MM\n"
    );
    let done = Work::texts(machine("heidenhain-mill", ""), &[&text], JobOptions::default()).run(None).expect("a job");
    assert!(done.summary.diagnostics.is_empty(), "{text}{:?}", done.summary.diagnostics);
    let down = done.events.iter().filter_map(|event| match &event.kind {
        Kind::Motion(motion) if motion.kind != MotionKind::Rapid && motion.to[2] < motion.from[2] - 1e-9 => {
            Some(motion.to[2])
        }
        _ => None,
    });
    down.map(|level| (level * 1e4).round() as i64).collect()
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: counterpoint_tests::cases(60), failure_persistence: None, ..ProptestConfig::default()
    })]

    #[test]
    fn a_depth_takes_as_many_levels_as_infeeds(which in 0..CYCLES.len(), infeed in 3_u32..36, times in 2_u32..10) {
        let (name, cycle) = CYCLES[which];
        let expected: Vec<i64> = (1..=times).map(|level| -i64::from(level * infeed) * 1_000).collect();
        prop_assert_eq!(levels(cycle, infeed, times), expected, "cycle {}, infeed {}", name, tenths(infeed));
    }
}
