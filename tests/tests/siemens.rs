//! Programs of the 840D made at random: every one ends, within its limits, with the same log however it is scheduled.

use std::sync::Arc;

use counterpoint_kernel::files::MemoryFiles;
use counterpoint_kernel::log::event::Kind;
use counterpoint_kernel::machine::package::Overlay;
use counterpoint_kernel::machine::{Machine, load};
use counterpoint_kernel::options::{JobLimits, JobOptions};
use counterpoint_tests::{Done, Work, cases};
use proptest::prelude::*;

fn machine() -> Arc<Machine> {
    let mut user = MemoryFiles::default();
    let text = "extends = \"fanuc-2path-lathe-exact\"\n\n[ce]\nname = \"random\"\npreprocessor = \"siemens\"\n\n[format]\n\
                rws = \"\"\nrws_at = \"none\"\ncomment = [\";\", \"\"]\n\n[[codes]]\nid = \"CODE_LCS_TRANSLATE_ON\"\n\
                text = \"TRANS\"\n";
    user.insert("random/machine.toml", text);
    let loaded = load(&Overlay::new(user, counterpoint_tests::library()), "random");
    loaded.machine.map(Arc::new).expect("a machine")
}

fn work(texts: &[impl AsRef<[u8]>], threads: u16) -> Work {
    let limits = JobLimits { blocks: 4_000, zero_time_blocks: 2_000, events: 20_000, ..JobLimits::default() };
    let mut work = Work::texts(machine(), texts, JobOptions { limits, threads, ..JobOptions::default() });
    work.files
        .insert("sub.spf", "PROC SUB(REAL ONE, VAR INT TWO, STRING[5] TEXT=\"a\") SAVE\nTWO=TWO+ONE\nX=ONE\nRET\n");
    work.files.insert("L5.SPF", "G91 X1\nAGAIN: R7=R7+1\nIF R7<3 GOTOB AGAIN\nM17\n");
    work.files.insert("deep.spf", "DEEP\n");
    work
}

fn run(text: impl AsRef<[u8]>) -> Done {
    work(&[text], 1).run(None).expect("the job can be prepared")
}

fn numbers(done: &Done) -> Vec<u32> {
    done.summary.diagnostics.iter().map(|d| d.number).collect()
}

#[test]
fn calls_without_end_come_to_the_levels_of_the_control() {
    assert_eq!(numbers(&run("DEEP\nM30\n")), [2900352]);
    assert_eq!(numbers(&run("ONE: MSG(\"a\")\nREPEAT ONE TWO\nTWO: M30\n")), [2900352]);
}

#[test]
fn loops_without_end_come_to_a_limit() {
    for text in [
        "LOOP\nENDLOOP\n",
        "A: GOTOB A\n",
        "WHILE TRUE\nENDWHILE\n",
        "GOTOS\n",
        "REPEAT\nUNTIL FALSE\n",
        "FOR R1=1 TO 1EX300\nENDFOR\n",
    ] {
        assert_eq!(numbers(&run(text)), [2900070], "{text}");
    }
}

#[test]
fn a_variable_that_nobody_changes_is_not_waited_for() {
    assert_eq!(numbers(&run("DEF NCK INT NN\nA: IF NN==0 GOTOB A\n")), [2900071]);
}

#[test]
fn huge_and_deep_texts_are_told() {
    for text in [
        format!("R1={}1{}\n", "(".repeat(2000), ")".repeat(2000)),
        format!("R1={}1\n", "-".repeat(4000)),
        format!("R1={}1\n", "1+".repeat(3000)),
        format!("R1={}1{}\n", "SIN(".repeat(1500), ")".repeat(1500)),
        format!("R1={}1{}\n", "R[".repeat(2000), "]".repeat(2000)),
        "DEF STRING[400] TT=\"aaaaaaaaaa\"\nLOOP\nTT=TT<<TT<<TT<<TT<<TT<<TT<<TT<<TT\nMSG(TT<<TT<<TT)\nENDLOOP\n".into(),
        "R1=1EX9999\n".into(),
        "R1=1EX300*1EX300\n".into(),
        "R1=R[2147483648]\n".into(),
        "DEF INT AA[100000]\nDEF INT BB[100000,100000]\n".into(),
        "R1=1 DIV 0\n".into(),
        "R1=-9223372036854775808 DIV -1\n".into(),
    ] {
        let done = run(&text);
        assert!(!numbers(&done).is_empty(), "{text}");
    }
}

/// Pieces of blocks, good and bad.
fn piece() -> impl Strategy<Value = String> {
    let texts = [
        "R1=R1+1",
        "R2=R1*2-R[1]",
        "R3=SQRT(R1)",
        "R[R1]=5",
        "R4=1/R1",
        "R5=TAN(90)",
        "X=R1",
        "X=IC(R1)",
        "Z=AC(5)",
        "X=DC(370)",
        "F=100",
        "S1=500",
        "G1",
        "G0 X1",
        "G91",
        "G90",
        "M8",
        "M30",
        "M17",
        "RET",
        "SUB(R1,II)",
        "SUB(1)",
        "SUB(R1,R2) P2",
        "L5",
        "L5 P3",
        "L6",
        "DEEP",
        "MCALL L5",
        "MCALL SUB(1,II)",
        "MCALL DEEP",
        "IF R1<1 GOTOF AGAIN IF R1>1 GOTOB AGAIN X1",
        "SETAL(67000,\"a\"<<R1)",
        "TRANS",
        "TRANS X1",
        "MSG($P_TOOLNO)",
        "MCALL",
        "IF R1<3",
        "IF (R1<3) AND (R2>1)",
        "ELSE",
        "ENDIF",
        "LOOP",
        "ENDLOOP",
        "FOR II=1 TO 4",
        "ENDFOR",
        "WHILE R1<5",
        "ENDWHILE",
        "REPEAT",
        "UNTIL R1>4",
        "GOTOF AA",
        "GOTOB BB",
        "GOTO N10",
        "GOTOC CC",
        "GOTOS",
        "IF R1>2 GOTOF AA",
        "AA:",
        "BB:",
        "N10",
        ":20",
        "/",
        "/3",
        "REPEAT AA P=2",
        "REPEAT AA BB",
        "REPEATB BB P=R1",
        "ENDLABEL:",
        "CASE R1 OF 1 GOTOF AA 2 GOTOB BB",
        "DEF INT II",
        "DEF NCK INT NN=1",
        "NN=NN+1",
        "IF NN<5 GOTOB BB",
        "DEF REAL AR[2,2]=SET(1,2,3)",
        "AR[1,R1]=2",
        "AR[0,0]=REP(R1)",
        "DEF STRING[8] TT=\"ab\"",
        "TT=TT<<R1",
        "MSG(TT<<R1)",
        "MSG(",
        "DEF FRAME FF=CTRANS(X,R1)",
        "$P_PFRAME=FF:CROT(Z,R1)",
        "$P_PFRAME=CTRANS(X,1)",
        "$P_UIFR[1,X,TR]=R1",
        "R1=$AA_IM[X]",
        "R1=$P_EP[Q]",
        "$AC_TIMER[1]=0",
        "R1=$AC_TIMER[1]",
        "DEFINE M8 AS M9",
        "DEFINE XX AS X=R1",
        "XX",
        "PROC MAIN(INT AA)",
        "EXTERN SUB(REAL)",
        "CALL \"sub\"",
        "CALL BLOCK AA TO BB",
        "PCALL SUB(1)",
        "WAITM(1,1,2)",
        "CYCLE81(R1,,2)",
        "SETAL(1)",
        "STOPRE",
        "%_N_SUB_SPF",
        "\n",
        "\n",
        "\n",
        "\n",
        "\n",
        "\n",
    ];
    prop_oneof![
        9 => prop::sample::select(texts.to_vec()).prop_map(str::to_owned),
        2 => Just("\n".to_owned()),
        1 => "[A-Z$_]{1,3}[0-9]{0,2}[=(\\[]?[-0-9.,RX\"')\\]<>:+*/]{0,8}",
        1 => any::<char>().prop_map(|c| c.to_string()),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(200), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_programs_end_the_same_way_in_both_modes(
        first in prop::collection::vec(piece(), 1..60),
        second in prop::collection::vec(piece(), 1..60),
    ) {
        let head = "DEF INT II\nDEF NCK INT NN\nDEF REAL AR[2,2]\nDEF STRING[8] TT\nDEF FRAME FF=CTRANS(X,5)\nF100\n";
        let texts = [first, second].map(|pieces| format!("{head}{}\nM30\n", pieces.join(" ").replace("\n ", "\n")));
        if let Ok(parallel) = work(&texts, 0).run(None) {
            let sequential = work(&texts, 1).run(None).unwrap();
            prop_assert_eq!(&parallel.events, &sequential.events);
            for event in &parallel.events {
                if let Kind::Motion(motion) = &event.kind {
                    prop_assert!(motion.to.iter().all(|value| value.is_finite()), "{motion:?}");
                }
            }
        }
    }

    #[test]
    fn random_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 1..1000)) {
        let _ = work(&[bytes], 1).run(None);
    }
}
