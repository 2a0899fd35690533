//! Alarms of the control on the shipped Fanuc families: each program runs into its alarm, the channel stops, nothing of
//! the block has moved, and the job is FAILED. The table of docs/alarms.md names every alarm that is raised here.

use std::fmt::Write as _;

use counterpoint_kernel::log::event::{Dwell, Kind};
use counterpoint_kernel::log::summary::{ChannelState, JobOutcome};
use counterpoint_kernel::options::JobOptions;
use counterpoint_tests::{Work, machine};

/// An alarm: as the control shows it, the number of its diagnostic, machine, rows over it, program (the alarm comes in
/// its last line but two, `G0 X99.` and `M30` follow).
struct Case(&'static str, u32, &'static str, &'static str, &'static str);

/// Parameter 3403#5.
const CIR: &str = "[arcs]\nwithout_center = \"error\"\n";
const MILL: &str = "fanuc-mill-exact";
const LATHE: &str = "fanuc-2path-lathe-exact";
const LIMITS: &str = "[[axes]]\nname = \"X\"\nrapid = 6000\nlimits = [-10, 10]\n";
const OFFSET: &str = "[[tool.offsets]]\nnumber = 1\nradius = 5\n";

const CASES: &[Case] = &[
    Case("PS0003", 2_900_006, MILL, "", "G1 X1234567. F100"),
    Case("PS0003", 2_900_006, MILL, "", "#1=1\nG0 X#1 Y1234567."),
    Case("PS0004", 2_900_321, MILL, "", "G0 X1. ?"),
    Case("PS0004", 2_900_321, LATHE, "", "G1 X50.,D2."),
    Case("PS0005", 2_900_321, MILL, "", "G0 X1. Y"),
    Case("PS0006", 2_900_381, MILL, "", "G1 X10. F-100"),
    Case("PS0006", 2_900_381, MILL, "", "#1=-5\nG1 X10. F#1"),
    Case("PS0006", 2_900_381, LATHE, "", "G4 P-100"),
    Case("PS0006", 2_900_381, MILL, "", "G0 X1. S-100"),
    Case("PS0007", 2_900_382, MILL, "", "G0 X1. S1000."),
    Case("PS0007", 2_900_382, MILL, "", "G43 Z10. H1."),
    Case("PS0007", 2_900_382, LATHE, "", "G4 P1.5"),
    Case("PS0007", 2_900_382, MILL, "", "F100\nG82 X10. Z-5. R2. P500."),
    Case("PS0007", 2_900_382, LATHE, "", "G97 M3 S500 F0.1\nG83 Z-5. P500."),
    Case("PS0007", 2_900_382, LATHE, "", "G97 M3 S500 F0.1\nG87 X20. P500\nC90. P0.5"),
    Case("PS0007", 2_900_380, LATHE, "", "G97 M3 S500 F0.1\nG0 X50. Z2.\nG74 R1.\nG74 Z-15. Q2000."),
    Case("PS0007", 2_900_382, LATHE, "", "G97 M3 S500 F0.1\nG0 X50. Z2.\nG75 R1.\nG75 X30. P3000."),
    Case(
        "PS0007",
        2_900_380,
        LATHE,
        "",
        "G97 M3 S500\nG0 X50. Z2.\nG76 P021060 Q100 R0.1\nG76 X40. Z-10. P920 Q300. F1.5",
    ),
    Case("PS0007", 2_900_382, LATHE, "", "N1.5 G0 X10."),
    Case("PS0007", 2_900_382, LATHE, "", "G51.2 P1.5 Q1"),
    Case("PS0007", 2_900_382, MILL, "", "M98 P100."),
    Case("PS0007", 2_900_382, MILL, "", "G65 P100. A1."),
    Case("PS0007", 2_900_382, MILL, "", "G65 P100 L2. A1."),
    Case("PS0007", 2_900_382, MILL, "", "G66 P100. A1."),
    Case("PS0007", 2_900_382, MILL, "", "G10 L2 P1. X10."),
    Case("PS0007", 2_900_382, MILL, "", "G10 L2. P1 X10."),
    Case("PS0007", 2_900_382, MILL, "", "G54.1 P1."),
    Case("PS0007", 2_900_382, MILL, "", "G30 P2. Z0."),
    Case("PS0007", 2_900_382, MILL, "", "M99 P2."),
    Case("PS0007", 2_900_382, LATHE, "", "G10 P1. X10."),
    Case("PS0007", 2_900_382, LATHE, "", "G96 S100 P1."),
    Case("PS0007", 2_900_382, LATHE, "", "G30 P2. U0."),
    Case("PS0007", 2_900_382, LATHE, "", "M98 P100."),
    Case("PS0007", 2_900_321, MILL, "", "G0 X1.2.3"),
    Case("PS0009", 2_900_321, MILL, "", "G0 X1. E3."),
    Case("PS0009", 2_900_028, LATHE, "", "G0 X10. Y5."),
    Case("PS0010", 2_900_320, LATHE, "", "G77 X10. Z-5."),
    Case("PS0010", 2_900_320, MILL, "", "G190 X1."),
    Case("PS0010", 2_900_320, MILL, "", "G191 X1. D1"),
    Case("PS0011", 2_019_001, MILL, "", "G1 X10."),
    Case("PS0011", 2_019_001, LATHE, "", "M3 S500\nG1 X10."),
    Case("PS0011", 2_019_001, MILL, "", "G0 X1.\nX5.\nG2 X10. Y5. R5."),
    Case("PS0011", 2_019_001, MILL, "", "G81 X10. Y5. Z-5. R2."),
    Case("PS0011", 2_019_001, MILL, "", "G94 F100\nG1 X1.\nG93 G1 X10."),
    Case("PS0011", 2_019_001, MILL, OFFSET, "G41 D1 G0 X1. Y1.\nG1 X10."),
    Case("PS0011", 2_019_001, MILL, "", "G31 X5."),
    Case("PS0011", 2_019_002, MILL, "", "G1 X10. F0"),
    Case("PS0011", 2_019_002, MILL, "", "G1 X1. F100\nG81 X10. Y5. Z-5. R2. F0"),
    Case("PS0011", 2_900_383, LATHE, "", "M3 S500\nG32 Z-10."),
    Case("PS0011", 2_900_383, LATHE, "", "M3 S500\nG92 X10. Z-10."),
    Case("PS0020", 2_900_020, MILL, "", "F100\nG2 X10. Y0. I4. J0."),
    Case("PS0020", 2_007_020, MILL, "", "F100\nG2 X10. Y0. R3."),
    Case("PS0020", 2_900_020, MILL, OFFSET, "F100\nG41 D1 G1 X5. Y5.\nX10.\nG2 X20. Y5. I4."),
    Case("PS0021", 2_007_001, LATHE, "", "F100 G98\nG17\nG2 X10. Z5. R20."),
    Case("PS0021", 2_900_380, MILL, "", "F100\nG2 X10. Y0. K5."),
    Case("PS0021", 2_900_380, MILL, "", "F100 G18\nG3 X10. Z1. J5."),
    Case("PS0021", 2_900_380, MILL, "", "F100 G19\nG3 Y10. Z1. I5."),
    Case("PS0022", 2_900_384, MILL, CIR, "F100\nG2 X10. Y5."),
    Case("PS0022", 2_900_384, MILL, CIR, "F100\nG2 X10. Y0. I5.\nX20. Y5."),
    Case("PS0023", 2_900_380, LATHE, "", "M3 S500 F0.1\nG2 X10. Z5. R-20."),
    Case("PS0030", 2_900_380, MILL, "", "G43 Z10. H401"),
    Case("PS0030", 2_900_380, MILL, "", "G41 X10. D999"),
    Case("PS0031", 2_900_380, MILL, "", "G10 L10 R1."),
    Case("PS0032", 2_900_380, MILL, "", "G10 L10 P1 R1000."),
    Case("PS0032", 2_900_460, MILL, "", "#2001=99999."),
    Case("PS0034", 2_018_005, MILL, OFFSET, "F100\nG41 D1\nG2 X10. Y0. I5."),
    Case("PS0034", 2_018_006, MILL, OFFSET, "F100\nG41 D1\nG1 X10. Y10.\nX20.\nG40\nG2 X30. Y10. I5."),
    Case("PS0035", 2_900_380, MILL, OFFSET, "F100\nG41 D1 G1 X5. Y5.\nG31 X10."),
    Case("PS0037", 2_900_380, MILL, OFFSET, "F100\nG41 D1 G1 X5. Y5.\nX10.\nG18"),
    Case("PS0037", 2_900_380, MILL, "", "G41\nG19"),
    Case("PS0039", 2_900_402, MILL, OFFSET, "F100\nG41 D1 G1 X5. Y5. ,R1."),
    Case("PS0041", 2_900_133, MILL, OFFSET, "F100\nG41 D1 G1 X0. Y10.\nX20.\nG3 X22. Y12. R2."),
    Case("PS0042", 2_900_380, MILL, OFFSET, "G41 D1\nG45 X20."),
    Case("PS0042", 2_900_380, MILL, OFFSET, "F100\nG42 D1 G1 X5. Y5.\nX10.\nG48 X20. D1"),
    Case("PS0044", 2_900_380, MILL, "", "F100\nG81 X10. Z-5. R2.\nG28 Z0."),
    Case("PS0044", 2_900_380, MILL, "", "F100\nG81 X10. Z-5. R2.\nG91 G30 Z0."),
    Case("PS0044", 2_900_380, LATHE, "", "M3 S500\nG83 Z-5. F0.1\nG28 U0. W0."),
    Case("PS0045", 2_900_380, MILL, "", "F100\nG83 X10. Z-5. R2."),
    Case("PS0045", 2_900_380, MILL, "", "F100\nG73 X10. Z-5. R2. Q0"),
    Case("PS0046", 2_900_380, MILL, "", "G30 P5 Z0."),
    Case("PS0050", 2_900_380, LATHE, "", "M3 S500\nG32 Z-10. ,C1. F1."),
    Case("PS0051", 2_900_395, LATHE, "", "M3 S500 F0.1\nG1 Z-10. I2.\nX50."),
    Case("PS0052", 2_900_396, MILL, "", "F100\nG1 X10. ,R1.\nG0 Y10."),
    Case("PS0053", 2_900_397, MILL, "", "F100\nG1 X10. ,R1. ,C1."),
    Case("PS0054", 2_900_398, LATHE, "", "M3 S500 F0.1\nG1 Z-10. I2.\nX50. Z-20."),
    Case("PS0055", 2_900_399, MILL, "", "F100\nG1 X1. ,R5.\nY10."),
    Case("PS0056", 2_900_400, MILL, "", "F100\nG1 ,A45.\nX10. Y0."),
    Case("PS0057", 2_900_401, MILL, "", "F100\nG1 X10. ,A90."),
    Case(
        "PS0061",
        2_900_405,
        LATHE,
        "",
        "M3 S500 F0.1\nG0 X40. Z2.\nN10 G0 X30.\nG1 Z-5.\nN20 X40.\nG0 Z2.\nG71 P10 U1.",
    ),
    Case(
        "PS0062",
        2_900_406,
        LATHE,
        "",
        "M3 S500 F0.1\nG0 X40. Z2.\nN10 G0 X30.\nG1 Z-5.\nN20 X40.\nG0 Z2.\nG71 P10 Q20",
    ),
    Case(
        "PS0063",
        2_900_407,
        LATHE,
        "",
        "M3 S500 F0.1\nG0 X40. Z2.\nN10 G0 X30.\nG1 Z-5.\nN20 X40.\nG0 Z2.\nG71 U2. R1.\nG71 P10 Q21",
    ),
    Case(
        "PS0064",
        2_900_408,
        LATHE,
        "",
        "M3 S500 F0.1\nG0 X40. Z2.\nN10 G0 X30.\nG1 Z-5.\nX32. Z-3.\nN20 X40.\nG0 Z2.\nG71 U2. R1.\nG71 P10 Q20",
    ),
    Case(
        "PS0065",
        2_900_409,
        LATHE,
        "",
        "M3 S500 F0.1\nG0 X40. Z2.\nN10 G0 X30.\nG1 Z-5.\nN20 X40.\nG0 Z2.\nG71 U2. R1.\nG71 P10 Q10",
    ),
    Case("PS0076", 2_900_040, MILL, "", "M98 P77"),
    Case("PS0076", 2_900_040, MILL, "", "G65 P77"),
    Case("PS0077", 2_900_352, MILL, "", "O7\nM98 P7"),
    Case("PS0078", 2_900_042, MILL, "", "GOTO 9"),
    Case("PS0082", 2_900_380, MILL, "", "F100\nG37 Z-10. H1"),
    Case("PS0082", 2_900_380, LATHE, "", "G36 X50. T0101"),
    Case("PS0092", 2_900_490, MILL, "", "G91 G28 X0\nG90 G27 X0.5"),
    Case("PS0092", 2_900_490, LATHE, "", "G27 X123. Z7."),
    Case("PS0109", 2_900_380, MILL, "", "G8 P2"),
    Case("PS0111", 2_900_359, MILL, "", "#1=EXP[800]"),
    Case("PS0112", 2_900_061, MILL, "", "#1=1/0"),
    Case("PS0114", 2_900_060, MILL, "", "#1=[1"),
    Case("PS0114", 2_900_060, MILL, "", "#1=4\nN#1 G0 X5."),
    Case("PS0114", 2_900_060, MILL, "", "IF[1 EQ 1]THEN #1=5 #2=3"),
    Case("PS0115", 2_900_063, MILL, "", "#77777=1"),
    Case("PS0116", 2_900_063, MILL, "", "#5021=0"),
    Case("PS0118", 2_900_354, MILL, "", "#1=[[[[[[1]]]]]]"),
    Case("PS0119", 2_900_062, MILL, "", "#1=SQRT[-1]"),
    Case("PS0119", 2_900_062, MILL, "", "#1=BIN[26]"),
    Case("PS0124", 2_900_064, MILL, "", "WHILE [1 EQ 1] DO 1"),
    Case("PS0126", 2_900_064, MILL, "", "END 1"),
    Case("PS0127", 2_900_357, MILL, "", "X1. G65 P1"),
    Case("PS0128", 2_900_042, MILL, "", "#1=7\nGOTO #1"),
    Case("PS0129", 2_900_356, MILL, "", "G65 P1 G1"),
    Case("PS0142", 2_900_380, MILL, "", "G51 X0. Y0. P0"),
    Case("PS0144", 2_900_380, MILL, "", "G68 X0. Y0. R30.\nG18"),
    Case("PS0145", 2_900_380, LATHE, "", "G41\nG12.1"),
    Case("PS0146", 2_900_380, LATHE, "", "G12.1\nG28 U0."),
    Case("PS0161", 2_900_051, "fanuc-3path-lathe-exact", "", "M101 P19"),
    Case("PS0175", 2_900_380, LATHE, "", "G41\nG7.1 C10."),
    Case("PS0176", 2_900_380, LATHE, "", "G7.1 C10.\nG28 U0."),
    Case("PS0190", 2_900_380, LATHE, "", "G96 S100 P7"),
    Case("PS0200", 2_900_642, MILL, "", "S0 M3\nM29\nG84 X10. Z-5. R2. F500"),
    Case("PS0203", 2_900_380, MILL, "", "M29 S500\nS600"),
    Case("PS0203", 2_900_380, MILL, "", "M29 S500\nG84 X10. Z-5. R2. F500\nM29 S300"),
    Case("PS0203", 2_900_380, LATHE, "", "M29 S500\nS600"),
    Case("PS0204", 2_900_380, MILL, "", "M29 S500\nX5."),
    Case("PS0204", 2_900_380, LATHE, "", "M29 S500\nG0 Z5."),
    Case("PS0206", 2_900_380, MILL, "", "M29 S500\nG84 X10. Z-5. R2. F500\nG18"),
    Case("PS0217", 2_900_380, LATHE, "", "G51.2 P1 Q2\nG51.2 P1 Q2"),
    Case("PS0218", 2_900_380, LATHE, "", "G51.2 P1"),
    Case("PS0218", 2_900_380, LATHE, "", "G51.2 Q1"),
    Case("PS0218", 2_900_380, LATHE, "", "G51.2 P0 Q1"),
    Case("PS0219", 2_900_380, LATHE, "", "G51.2 P1 Q1 X5."),
    Case("PS0219", 2_900_380, LATHE, "", "G51.2 P1 Q1\nG50.2 M8"),
    Case("PS0245", 2_900_380, LATHE, "", "G50 X100. Z50. T0101"),
    Case("PS0245", 2_900_380, LATHE, "", "G4 X1. T0101"),
    Case("PS0300", 2_900_380, MILL, "", "G51 X0. Y0. P2000\nG28 Z0."),
    Case("PS0304", 2_900_025, MILL, "", "G30 P2 Z5."),
    Case("PS0305", 2_900_029, MILL, "", "G29 X5."),
    Case("PS0312", 2_900_404, MILL, "", "G0 X10. ,C1."),
    Case("PS0313", 2_900_112, LATHE, "", "M3 S500\nG34 Z-100. F1. K-0.1"),
    Case("PS0315", 2_900_641, LATHE, "", "M3 S500\nG76 P010045 Q100 R0.05"),
    Case("PS0316", 2_900_480, LATHE, "", "M3 S500\nG0 X40. Z2.\nG76 P010060 Q100 R1.\nG76 X36. Z-20. P920 Q300 F1.5"),
    Case("PS0316", 2_900_480, LATHE, "", "M3 S500\nG0 X40. Z2.\nG76 P010060 Q1000 R0.1\nG76 X36. Z-20. P920 Q300 F1.5"),
    Case("PS0317", 2_900_380, LATHE, "", "M3 S500\nG76 P010060 Q100 R0.1\nG76 X10. Z-20. Q300 F1.5"),
    Case("PS0317", 2_900_380, LATHE, "", "M3 S500\nG76 P010060 Q100 R0.1\nG76 X10. Z-20. P900 Q0 F1.5"),
    Case("PS0320", 2_900_412, LATHE, "", "M3 S500 F0.1\nG0 X40. Z2.\nG74 Z-30. Q-2000"),
    Case(
        "PS0321",
        2_900_413,
        LATHE,
        "",
        "M3 S500 F0.1\nG0 X40. Z2.\nN10 G0 X30.\nG1 Z-5.\nN20 X40.\nG0 Z2.\nG73 U6. W3. R0\nG73 P10 Q20",
    ),
    Case(
        "PS0322",
        2_900_411,
        LATHE,
        "",
        "M3 S500 F0.1\nG0 X40. Z2.\nN10 G0 X30.\nG1 Z-5.\nX44.\nN20 Z-8.\nG0 X40. Z2.\nG71 U2. R1.\nG71 P10 Q20",
    ),
    Case(
        "PS0325",
        2_900_410,
        LATHE,
        "",
        "M3 S500 F0.1\nG0 X40. Z2.\nG71 U2. R1.\nG71 P10 Q20\nN10 G0 X30.\nG1 Z-5.\nN20 M98 P5",
    ),
    Case("PS0330", 2_900_380, LATHE, "", "M3 S500\nG92 X10. Z-20. C5. F1.5"),
    Case("PS0335", 2_900_380, MILL, "", "M3 M8 M48 M10 S100"),
    Case("PS0347", 2_900_380, LATHE, "", "T0101 T0202"),
    Case("PS0369", 2_900_380, MILL, "", "F100\nG31"),
    Case("PS0370", 2_900_380, MILL, "", "F100\nG31 X5. P9"),
    Case("PS0900", 2_900_491, MILL, "", "O1\nG72.1 P100 L2 X0 Y0 R90.\nM30\nO200\nM99\nO100\nG72.1 P200 L2 X0 Y0 R90."),
    Case("PS0901", 2_900_491, MILL, "", "O1\nG72.2 P100 L2 I5.\nM30\nO200\nM99\nO100\nG72.2 P200 L2 J5."),
    Case("MC3007", 2_900_065, MILL, "", "#3000=7(NO PART)"),
    Case("OT0502", 2_900_482, MILL, "", "G22 X100. Y100. Z100. I50. J-100. K-100.\nG90 G0 X40. Z10.\nX60."),
    Case("OT0503", 2_900_482, MILL, "", "G22 X-50. Y100. Z100. I-100. J-100. K-100.\nG90 G0 X-40. Z10.\nX-60."),
    Case("OT0502", 2_900_482, LATHE, "", "G0 X40. Z10.\nG22 X100. Z100. I50. K-100.\nX60."),
    Case("OT0510", 2_900_023, MILL, LIMITS, "G0 X5.\nX11."),
    Case("OT0510", 2_900_023, MILL, LIMITS, "F100\nG1 X5.\nX-11."),
];

/// The error of a case.
fn fault(case: &Case) -> Option<String> {
    let &Case(alarm, number, on, rows, program) = case;
    let blocks = format!("{program}\nG0 X99.\nM30\n");
    let line = program.lines().count() as u32;
    let mut texts = vec![blocks];
    let machine = machine(on, rows);
    texts.extend((1..machine.channels.len()).map(|_| "M30\n".to_owned()));
    let work = Work::texts(machine, &texts, JobOptions::default());
    let done = work.run(None).expect("the job can be prepared");
    let (results, ..) = work.results(None).expect("the job can be prepared");
    let mut wrong = String::new();
    if results.summary != done.summary {
        wrong.push_str(" results without a log differ;");
    }
    let state = done.summary.channels[0].state;
    if done.summary.state != JobOutcome::Failed || state != ChannelState::Alarmed {
        let _ = write!(wrong, " ends {:?}, its channel {state:?};", done.summary.state);
    }
    let raised = done.summary.diagnostics.iter().find(|one| one.number == number && one.severity >= 8);
    match raised {
        Some(one) if one.line == line => {
            let titled = counterpoint_kernel::diag::ALL.iter().any(|f| f.number == number && f.title.contains(alarm));
            let spoken = one.text.contains(alarm) || titled || FREE.contains(&alarm);
            // The actions of a channel that continues do not happen here.
            let promises = ["reached straight", "timed as rapid", "is used", "goes on the contour"];
            if !spoken || promises.iter().any(|promise| one.text.contains(promise)) {
                let _ = write!(wrong, " says '{}';", one.text);
            }
        }
        Some(one) => {
            let _ = write!(wrong, " raised in line {};", one.line);
        }
        None => wrong.push_str(" is not raised;"),
    }
    let moved = done.events.iter().filter(|event| event.channel == 1 && event.line >= line);
    let moved = moved.filter(|event| matches!(event.kind, Kind::Motion(_) | Kind::Dwell(Dwell))).count();
    if moved > usize::from(AFTER_ITS_MOVE.contains(&alarm)) {
        let _ = write!(wrong, " {moved} moves of its block and later ones;");
    }
    if wrong.is_empty() {
        return None;
    }
    Some(format!("{alarm} on {on}, '{program}':{wrong}\n  {:?}\n", done.summary.diagnostics))
}

/// Alarms whose diagnostic covers several of the control: its text says which case it is without the number.
const FREE: &[&str] =
    &["PS0076", "PS0078", "PS0112", "PS0114", "PS0115", "PS0116", "PS0119", "PS0124", "PS0126", "PS0128", "MC3007"];

#[test]
fn each_alarm_stops_the_channel_before_its_block() {
    let faults: String = CASES.iter().filter_map(fault).collect();
    assert!(faults.is_empty(), "{faults}");
}

/// Alarms that other tests raise, since they need several channels or files.
const ELSEWHERE: &[&str] = &["PS0122", "PS0160"];

/// Alarms after the move of their block: the control checks its end.
const AFTER_ITS_MOVE: &[&str] = &["PS0092"];

/// The alarms of a row: `PS0217 to PS0219`, `PS0900, PS0901`.
fn alarms_of(row: &str) -> Vec<String> {
    let number = |alarm: &str| alarm.trim_start_matches(char::is_alphabetic).parse::<u32>();
    let mut alarms = Vec::new();
    for part in row.split(", ") {
        let ends = part.split_once(" to ").map(|(first, last)| (first, number(first), number(last)));
        match ends {
            Some((first, Ok(from), Ok(to))) => {
                alarms.extend(
                    (from..=to).map(|number| format!("{}{number:04}", first.trim_end_matches(char::is_numeric))),
                );
            }
            _ => alarms.push(part.to_owned()),
        }
    }
    alarms
}

#[test]
fn the_list_of_alarms_is_complete() {
    let page = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/alarms.md");
    let page = std::fs::read_to_string(page).expect("docs/alarms.md");
    let family = page.split("## ").find(|part| part.starts_with("Fanuc families")).expect("the list");
    let rows: Vec<Vec<&str>> =
        family.lines().filter(|line| line.starts_with("| ")).map(|line| line.split(" | ").collect()).collect();
    let mut wrong = String::new();
    let shown = |alarm: &str| CASES.iter().any(|case| case.0 == alarm || alarm == "MC3nnn" && case.0 == "MC3007");
    for row in rows.iter().skip(1) {
        let (alarm, here) = (row[0].trim_start_matches("| "), row[2]);
        let raised = here.starts_with('[') || here.starts_with("rule");
        for alarm in alarms_of(alarm) {
            if raised != (shown(&alarm) || ELSEWHERE.contains(&alarm.as_str())) {
                let _ = writeln!(wrong, "{alarm}: {here}");
            }
        }
    }
    for case in CASES {
        let listed = rows.iter().any(|row| alarms_of(row[0].trim_start_matches("| ")).iter().any(|one| one == case.0));
        if !listed && case.0 != "MC3007" {
            let _ = writeln!(wrong, "{} is not listed", case.0);
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}
