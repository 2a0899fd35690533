//! Alarms of Siemens controls: each program runs into its alarm, the text names its number, the channel stops, nothing
//! of the block has moved, and the job is FAILED. Programs beside them that are allowed run to their end.
//!
//! The numbers are those of the list of alarms of the 840D.

use std::fmt::Write as _;

use counterpoint_kernel::log::event::Kind;
use counterpoint_kernel::log::summary::JobOutcome;
use counterpoint_kernel::options::JobOptions;
use counterpoint_tests::{Done, Work, machine};

const MILL: &str = "siemens-mill";
const FIVE: &str = "siemens-mill-5axis";
const LATHE: &str = "siemens-lathe";
const CHANNELS: &str = "siemens-2channel";

/// Number of the alarm, machine, program: the alarm comes in its last line.
const CASES: &[(&str, &str, &str)] = &[
    ("10750", MILL, "G0 X0\nG41 G1 X5 F100"),
    ("10762", MILL, "$TC_DP6[1,1]=5\nT1 M6\nG0 X0 Y0\nG41 G1 X5 Y0 F100\nX10\nM8\nM9\nM8\nM9\nY30"),
    ("10762", MILL, "$TC_DP6[1,1]=5\nT1 M6\nG0 X0 Y0\nG41 G1 X5 Y0 F100\nX10\nZ1\nZ2\nZ3\nZ4\nY30"),
    ("10860", MILL, "G1 X5"),
    ("12000", MILL, "G0 X5 X6"),
    ("12000", MILL, "G1 X5 F100 F200"),
    ("12010", MILL, "T1 T2"),
    ("12060", MILL, "G0 G1 X5 F100"),
    ("12080", MILL, "R1=5+"),
    ("12080", MILL, "MCALL CYCLE81(5,0,1,-3) Y20"),
    ("12080", MILL, "MCALL Y20"),
    ("12550", MILL, "MCALL NOPE"),
    ("12550", MILL, "MCALL NOPE(1,2)"),
    ("12170", MILL, "DEF INT A\nDEF REAL A"),
    ("12290", MILL, "R99999=1"),
    ("12340", MILL, "%_N_MAIN_MPF\nSUB(1,2)\n%_N_SUB_SPF\nPROC SUB(REAL A)\nM17"),
    ("12470", MILL, "G999 X1"),
    ("12550", MILL, "FOO=7"),
    ("12550", MILL, "R1=FOO+1"),
    ("12640", MILL, "IF R1==1"),
    ("14011", MILL, "L77"),
    ("14013", MILL, "%_N_MAIN_MPF\nL20 P0\n%_N_L20_SPF\nM17"),
    ("14051", MILL, "R2=5/R1"),
    ("14051", MILL, "R2=SQRT(-1)"),
    ("14080", MILL, "GOTOF NOWHERE"),
    ("14200", MILL, "G0 RP=-5 AP=0"),
    ("14210", MILL, "G0 RP=5 AP=400"),
    ("14500", MILL, "G0 X1\nDEF REAL A"),
    ("14500", MILL, "G0 X5 DEF INT I"),
    ("14750", MILL, "M7 M8 M9 M10 M11 M12 G0 X1"),
    ("14750", MILL, "H1=1 H2=2 H3=3 H4=4"),
    ("14900", MILL, "F100\nG2 X10 Y0 I5 J0 CR=5"),
    ("14900", MILL, "F100\nG2 X10 Y0 I5 J0 AR=180"),
    ("14910", MILL, "F100\nG2 I5 J0 AR=400"),
    ("16420", MILL, "POS[X]=5 POS[X]=6"),
    ("16500", MILL, "G1 F100 X10 RND=-2"),
    ("16720", LATHE, "G95 S100 M3\nG33 Z-5 K0"),
    ("16800", MILL, "G0 X=DC(5)"),
    ("16810", MILL, "G0 X=ACP(5)"),
    ("16820", MILL, "G0 X=ACN(5)"),
    ("16830", FIVE, "G0 C=DC(400)"),
    ("17020", MILL, "DEF INT A[3]\nA[7]=1"),
];

/// Permitted words that are close to an alarm.
const ALLOWED: &[(&str, &str)] = &[
    (MILL, "$TC_DP6[1,1]=5\nT1 M6\nG0 X0 Y0\nG41 G1 X5 Y0 F100\nX10\nM8\nM9\nM8\nY30\nG40 X20"),
    (MILL, "H1=5 H2=6\nH1=5 H2=6 H3=7 M7 M8 M9 M10 M11"),
    (MILL, "DEF INT A\n; comment\nN10 DEF REAL B=2 ; second\nG0 X=B"),
    (MILL, "M7 M8 M9 M10 M11 G0 X1"),
    (MILL, "F100\nG2 I5 J0 Z-2 AR=180"),
    (MILL, "G111 X0 Y0\nG0 RP=5 AP=-360\nRP=5 AP=350\nAP=IC(20)"),
    (MILL, "G1 F100 X10 RND=0\nY10"),
    (FIVE, "G0 C=DC(0)\nC=ACP(359.999)\nA=DC(-20)"),
    (MILL, "G0 POS[X]=5 POS[Y]=6"),
];

fn run(on: &str, program: &str) -> Done {
    let text = if program.contains("_MPF") { format!("{program}\n") } else { format!("{program}\nM30\n") };
    Work::texts(machine(on, ""), &[text], JobOptions::default()).run(None).expect("the job can be prepared")
}

#[test]
fn each_alarm_stops_the_channel_and_names_its_number() {
    let mut wrong = String::new();
    for (alarm, on, program) in CASES {
        let done = run(on, program);
        let last = program.lines().count() as u32;
        let raised = done.summary.diagnostics.iter().find(|one| one.severity >= 8 && one.text.contains(alarm));
        let moved =
            done.events.iter().filter(|event| event.line >= last && matches!(event.kind, Kind::Motion(_))).count();
        if raised.is_none() || moved > 0 || done.summary.state != JobOutcome::Failed {
            let _ = writeln!(wrong, "{alarm} '{program}': {moved} moves, {:?}", done.summary.diagnostics);
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}

/// Statements that take no axis words, on a machine that has them.
const WITHOUT_AXES: &[(&str, &str)] = &[
    (FIVE, "CYCLE800()"),
    (FIVE, "CYCLE800(0,\"TC1\",0,57,0,0,0,0,0,0,0,0,0,-1)"),
    (FIVE, "TRAORI"),
    (FIVE, "TRAORI(1)"),
    (FIVE, "TRAFOOF"),
    (FIVE, "TRAFOOF()"),
    (FIVE, "ORIRESET()"),
    (LATHE, "TRANSMIT"),
    (LATHE, "TRACYL(40)"),
    (LATHE, "SETMS(1)"),
    (LATHE, "SETMS"),
    (MILL, "CYCLE81(5,0,1,-3)"),
    (MILL, "CYCLE832(0.01,3,1)"),
    (MILL, "HOLES1(0,0,0,10,10,3)"),
    (MILL, "HOLES2(0,0,20,0,90,4)"),
    (MILL, "POCKET3(5,0,1,-3,20,20,2,0,0,0,1,0,0,100,50,0,11)"),
    (MILL, "SLOT1(5,0,1,-3)"),
    (MILL, "LONGHOLE(5,0,1,-3)"),
    (MILL, "GROUP_BEGIN(0,\"drill\",0,0)"),
    (MILL, "GROUP_END(0,0)"),
    (MILL, "WAITP(X)"),
    (MILL, "SETAL(65000)"),
    (MILL, "CANCEL(1)"),
    (MILL, "GEOAX()"),
    (MILL, "EXECUTE(TAB)"),
    (MILL, "WRITE(R1,\"F\",\"T\")"),
    (MILL, "DELETE(R1,\"F\")"),
    (CHANNELS, "WAITE(2)"),
    (CHANNELS, "START(2)"),
    (CHANNELS, "INIT(2,\"P\")"),
    (CHANNELS, "GET(X)"),
    (CHANNELS, "GETD(X)"),
    (CHANNELS, "RELEASE(X)"),
    (CHANNELS, "AXTOCHAN(X,2)"),
];

#[test]
fn a_statement_without_axes_moves_none() {
    let mut wrong = String::new();
    for (on, statement) in WITHOUT_AXES {
        for axis in ["X10", "Z=10", "C10"] {
            for block in [format!("{statement} {axis}"), format!("{axis} {statement}")] {
                let done = run(on, &block);
                let raised = done.summary.diagnostics.iter().any(|one| one.severity >= 8 && one.text.contains("12080"));
                let moves = done.events.iter().filter(|event| matches!(event.kind, Kind::Motion(_))).count();
                if !raised || moves > 0 {
                    let _ = writeln!(wrong, "{on} '{block}': {moves} moves, {:?}", done.summary.diagnostics);
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}

#[test]
fn what_is_near_to_an_alarm_runs() {
    let mut wrong = String::new();
    for (on, program) in ALLOWED {
        let done = run(on, program);
        if done.summary.state != JobOutcome::Succeeded {
            let _ = writeln!(wrong, "'{program}': {:?}", done.summary.diagnostics);
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}
