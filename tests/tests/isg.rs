//! Random programs for the ISG pre-processor and its signals: for any text the run ends within its limits, and neither
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
    let names = ["P1", "PP1", "P[P1]", "P2[1]", "V.P.A", "V.L.B", "V.E.C", "V.E.D[2]", "V.A.ABS.X", "1", "-2.5", "0"];
    let leaf = prop::sample::select(names.to_vec()).prop_map(str::to_owned);
    leaf.prop_recursive(4, 12, 3, |inner| {
        let operators = ["+", "-", "*", "/", " MOD ", "==", "!=", "<", "**", " AND ", "||", "&", "|", "^"];
        let functions = ["", "-", "!", "SIN", "TAN", "SQRT", "INT", "ROUND", "EXP", "LN", "DEXP", "ACOS"];
        prop_oneof![
            (inner.clone(), prop::sample::select(operators.to_vec()), inner.clone())
                .prop_map(|(a, operator, b)| format!("{a}{operator}{b}")),
            (prop::sample::select(functions.to_vec()), inner).prop_map(|(name, a)| format!("{name}[{a}]")),
        ]
    })
}

/// Signals of few numbers between two channels, so that they meet.
fn signal() -> impl Strategy<Value = String> {
    let words = ["#SIGNAL ", "#SIGNAL SYN ", "#WAIT ", "#WAIT SYN ", "#SIGNAL READ ", "#SIGNAL REMOVE "];
    let lists =
        ["", " CH1", " CH2", " CH1 CH2", " CH9", " COUNT 2", " COUNT 2 CH2", " AHEAD", " P[0]=P1", " P[1]=5 CH2"];
    (prop::sample::select(words.to_vec()), 1..3_u8, prop::sample::select(lists.to_vec()))
        .prop_map(|(word, number, list)| format!("{word}[ID{number}{list}]"))
}

/// Blocks, good and bad.
fn block() -> impl Strategy<Value = String> {
    let fixed = [
        "G0 X1 Z2",
        "G1 X5. F100",
        "G04 X0.01",
        "$GOTO N1",
        "$GOTO [A]",
        "N1: G0",
        "[A] Y2",
        "$ELSE",
        "$ENDIF",
        "$WHILE P1 < 3",
        "$ENDWHILE",
        "$FOR P1 = 1, 3, 1",
        "$ENDFOR",
        "$DO",
        "$ENDDO",
        "$REPEAT",
        "$BREAK",
        "$CONTINUE",
        "$DEFAULT",
        "$ENDSWITCH",
        "LL SUB",
        "L OTHER",
        "M17",
        "%NEXT",
        "%L SUB2",
        "#VAR",
        "#MSG [\"A\"]",
        "#FLUSH WAIT",
        "(A (B) C) X3 ; D",
        "(OPEN",
        "/2 X3.",
        "M30",
    ];
    prop_oneof![
        3 => prop::sample::select(fixed.to_vec()).prop_map(str::to_owned),
        3 => signal(),
        2 => value().prop_map(|value| format!("P1={value}")),
        2 => value().prop_map(|value| format!("V.E.C = {value}")),
        1 => value().prop_map(|value| format!("V.P.A = {value}")),
        2 => value().prop_map(|value| format!("X[{value}] Z={value}")),
        1 => value().prop_map(|value| format!("$IF {value}")),
        1 => value().prop_map(|value| format!("$IF {value} $GOTO N1")),
        1 => value().prop_map(|value| format!("$SWITCH {value}\n$CASE {value}")),
        1 => value().prop_map(|value| format!("#TIME {value}")),
        1 => "[A-Z0-9=\\[\\]+*/,.() $#%&|-]{0,16}",
        1 => any::<String>(),
    ]
}

fn program() -> impl Strategy<Value = String> {
    prop::collection::vec(block(), 1..25)
        .prop_map(|blocks| format!("%L SUB\nP5=1\nG0 XP5\nM17\n%MAIN\nP1=1\n{}\nM30\n", blocks.join("\n")))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(150), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_programs_end_in_one_way(one in program(), two in program(), three in program(), stays in any::<bool>()) {
        let broadcast = if stays { "stays" } else { "each" };
        let overlay = format!(
            "[sync]\nsignals = 8\n[[waits]]\nstatement = \"SIGNAL\"\nprimitive = \"signal\"\nact = \"signal\"\n\
             broadcast = \"{broadcast}\"\n"
        );
        let machine = machine("isg-3ch", &overlay);
        let work = |threads| Work::texts(machine.clone(), &[&one, &two, &three], options(threads));
        // A job that cannot start has no log.
        if let Ok(one) = work(1).run(None) {
            let many = work(0).run(None).unwrap();
            prop_assert_eq!(&one.events, &many.events);
            let (results, ..) = work(0).results(None).unwrap();
            prop_assert_eq!(one.summary, results.summary);
        }
    }
}
