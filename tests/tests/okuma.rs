//! Random programs for the Okuma pre-processor: for any text the run ends within its limits, and neither
//! scheduling nor the lack of a log changes anything.

use counterpoint_kernel::options::{JobLimits, JobOptions};
use counterpoint_tests::{Work, cases, machine};
use proptest::prelude::*;

fn options(threads: u16) -> JobOptions {
    let limits = JobLimits { blocks: 3_000, zero_time_blocks: 1_000, events: 30_000, ..JobLimits::default() };
    JobOptions { limits, threads, ..JobOptions::default() }
}

/// Values and conditions.
fn value() -> impl Strategy<Value = String> {
    let names = ["LA1", "LB", "VC1", "VC[LA1]", "V2", "VSIOX", "VZOFX", "EMPTY", "1", "-2.5", "0", "1E9", "HALF[2]"];
    let leaf = prop::sample::select(names.to_vec()).prop_map(str::to_owned);
    leaf.prop_recursive(4, 12, 3, |inner| {
        let operators = ["+", "-", "*", "/", " MOD ", " EQ ", " NE ", " LT ", " AND ", " OR ", " EOR "];
        let functions = ["", "-", "NOT ", "SIN", "TAN", "SQRT", "FIX", "DROUND", "EXP", "LN", "BCD", "ACOS"];
        prop_oneof![
            (inner.clone(), prop::sample::select(operators.to_vec()), inner.clone())
                .prop_map(|(a, operator, b)| format!("{a}{operator}{b}")),
            (prop::sample::select(functions.to_vec()), inner.clone()).prop_map(|(name, a)| format!("{name}[{a}]")),
            (inner.clone(), inner).prop_map(|(a, b)| format!("ATAN2[{a},{b}]")),
        ]
    })
}

/// Blocks, good and bad.
fn block() -> impl Strategy<Value = String> {
    let fixed = [
        "G0 X1 Z2",
        "G1 X5. F100",
        "G4 P10",
        "GOTO N1",
        "GOTO NA",
        "MODOUT",
        "RTS",
        "O2",
        "OSUB",
        "M30",
        "N1",
        "NA G0",
        "N5 /2 X3.",
        "MSG (HI",
        "(MSG, A)",
        "$X.MIN%",
        "$ X5",
        "$",
        "VUACM[1]='A (B'",
        "VUACM[1]='OPEN",
        "VDOUT[992]=1",
        "X=#1FH Z=$7",
        "NOEX",
        "%",
        "CALL O2",
        "M98 P2",
        "MODIN OSUB",
    ];
    prop_oneof![
        3 => prop::sample::select(fixed.to_vec()).prop_map(str::to_owned),
        2 => value().prop_map(|value| format!("LA1={value}")),
        2 => value().prop_map(|value| format!("VC1={value} LB=LB+1")),
        2 => value().prop_map(|value| format!("X={value} Z[{value}]")),
        1 => value().prop_map(|value| format!("IF [{value}] N1")),
        1 => value().prop_map(|value| format!("IF [{value}] GOTO NA")),
        1 => value().prop_map(|value| format!("CALL OSUB Q[{value}] LB={value}")),
        1 => value().prop_map(|value| format!("GOTO N[{value}]")),
        1 => "[A-Z0-9=\\[\\]+*/,.() $%-]{0,16}",
        1 => any::<String>(),
    ]
}

fn program() -> impl Strategy<Value = String> {
    prop::collection::vec(block(), 1..25).prop_map(|blocks| format!("{}\nM30\nOSUB\nX=LB\nRTS\n", blocks.join("\n")))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(150), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_programs_end_in_one_way(upper in program(), lower in program(), own in any::<bool>()) {
        let overlay = format!("preprocessor = \"okuma\"\n[variables]\nown_common = {own}\n");
        let machine = machine("fanuc-2path-lathe-exact", &overlay);
        let work = |threads| Work::texts(machine.clone(), &[&upper, &lower], options(threads));
        // A job that cannot start has no log.
        if let Ok(one) = work(1).run(None) {
            let many = work(0).run(None).unwrap();
            prop_assert_eq!(&one.events, &many.events);
            let (results, ..) = work(0).results(None).unwrap();
            prop_assert_eq!(one.summary, results.summary);
        }
    }
}
