//! Guesses by the signs of the shipped machines: the guessed machine, and refused programs.

use std::ops::RangeInclusive;
use std::sync::LazyLock;

use counterpoint_ports::files::Bytes;
use counterpoint_signs::{ExaminedProgram, Guess, MachineCandidate, guess};

use super::*;
use crate::load::candidates;
use crate::package;

static SHIPPED: LazyLock<Vec<MachineCandidate>> =
    LazyLock::new(|| candidates(&package::shipped(), &package::shipped_names()));

fn shipped() -> &'static [MachineCandidate] {
    &SHIPPED
}

fn of_files(files: &[(&str, &str)], waits: Option<&RangeInclusive<u32>>) -> Result<Guess, String> {
    let program = |(name, text): &(&str, &str)| ExaminedProgram {
        name: (*name).to_owned(),
        content: Bytes::from(text.as_bytes().to_vec()),
        number: None,
        part: false,
    };
    guess(shipped(), &files.iter().map(program).collect::<Vec<_>>(), waits, &|| false)
}

fn machine(name: &str, text: &str) -> Result<String, String> {
    of_files(&[(name, text)], None).map(|guess| guess.machine)
}

const PROGRAMS: &[(&str, &str)] = &[
    ("%\nO1\nT1 M6\nG90 G54 G0 X1. Y2.\nG43 H1 Z5.\nM30\n", "fanuc-mill"),
    ("G90 G0 X10. Y5.\nG1 X20. F100.\nM30\n", "fanuc-mill"),
    ("G90 G94 G1 X2. F100\nM30\n", "fanuc-mill"),
    // A post-processor without a speed: a length offset is for a tool, not for a laser.
    ("N40 G0 G90 X0.0 Y8.29 S0 M03\nN50 G43 Z.43 H00\nN70 G1 Z-.23 F9.8\nN80 X7.9 Y7.95\nM30\n", "fanuc-mill"),
    ("O1\nG50 S2500\nG96 S200 M3\nT0101\nG0 X52. Z2.\nM30\n", "fanuc-lathe"),
    ("O1\nT0101\nG0 X52. Z2.\nG1 W-20. F0.2\nU4.\nM30\n", "fanuc-lathe"),
    ("O1\nG71 U2. R1.\nG71 P10 Q20 U0.5 W0.1 F0.2\nM30\n", "fanuc-lathe"),
    ("G50 S2000\nG96 S180\n(T1 M6 G43 H1 Y5.)\nM30\n", "fanuc-lathe"),
    // Only X and Z move, an arc in XZ, feeds per revolution.
    ("O1\nG0 X205. Z10.\nG1 Z0. F0.1\nX192.7\nG3 X193.8 Z-.3 R.6\nG1 X199.9 Z-7.5\nM30\n", "fanuc-lathe"),
    ("O301\nG21 G18 G40 G54\nG90 G95\nG92 S2500\nT0101\nG96 S200 M3\nG0 X52. Z2.\nG91 G1 X2. F0.3\n", "fanuc-lathe-b"),
    ("G71 G40\nG90 G95\nT0101\nG96 S200 M3\nG0 X52. Z2.\nG20 X48. Z-20. F0.2\n", "fanuc-lathe-c"),
    ("O1\nG50 S3000\nT0101\nG97 S1000 M3\nM213 S1000\nM169\nG0 B-400.\nM168\nM30\n", "fanuc-lathe-subspindle"),
    ("O1\nG50 S3000\nT101\nG97 S1000 M3\nM154\nG199 R0.\nM111\nG0 B-400.\nM110\nG198\nM30\n", "haas-lathe-ds"),
    ("O1\nT101\nG71 P10 Q20 U0.5 W0.1 D2.5 F0.2\nM30\n", "haas-lathe"),
    ("T101;\nG97 S1000 M3;\nG0 X50. Z2.;\nM30;\n", "haas-lathe"),
    ("T101;\nG97 S1000 M3;\nG0 X50. Y0;\nM155;\nM30;\n", "haas-mill-turn"),
    ("%_N_PART_MPF\nG17 G90 T1 M6\nG0 X1 Y2\n", "siemens-mill"),
    ("O1\nT001.01\nG97 S500 M3\nG0 X50. Z2.\n", "mazak-eia-lathe"),
    ("O1\nT0101\nG0 X50. Z2.\nG290 X46. Z-20. F0.2\n", "mazak-eia-lathe"),
    ("N10 TRAORI(1)\nN20 G1 X1 A=-20 C10\n", "siemens-mill-5axis"),
    ("%_N_PART_MPF\nG1 X1 A3=0 B3=1 C3=0\n", "siemens-mill-5axis"),
    ("N10 T1 M6\nN20 CYCLE800(1,\"TC1\")\nN30 G0 X1 Y2\n", "siemens-mill-5axis"),
    ("N10 G18 G95 DIAMON\nN20 TRANSMIT\nN30 G1 X1 Y2\n", "siemens-lathe"),
    ("0 BEGIN PGM PART MM\n1 L X+10 A+20 R0 FMAX M128\n", "heidenhain-mill-5axis"),
    ("0 BEGIN PGM PART MM\n1 M128\n2 L X+10 R0 FMAX\n", "heidenhain-mill-5axis"),
    ("0 BEGIN PGM PART MM\n1 L X+10 R0 FMAX\n2 PLANE SPATIAL SPA+0 SPB+0 SPC+30 STAY\n", "heidenhain-mill-5axis"),
    ("0 BEGIN PGM PART MM\n1 FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS\n", "heidenhain-mill-5axis"),
    ("O1\nT1 M6\nG43.4 H1 Z50.\nG1 X1. A-20. F100.\n", "fanuc-mill-5axis"),
    ("O500\nG90 G54 G0 B0\nT1 M6\nG43 H1 Z100.\nX0 Y0\nG55 B90.\n", "fanuc-horizontal"),
    ("$P.MIN%\nG15 H1\nG0 B90.\nT1 M6\nG56 H1 Z100.\nX0 Y0\n", "okuma-horizontal"),
    ("T1 T2 M6\nG0 G54 B90.\nG43 H1 Z100.\nX0 Y0\nM60\n", "mazak-horizontal"),
    ("O1\nT1 M6\nG43 H1 Z50.\nG0 X1. A90.\nG1 Y2. F100.\n", "fanuc-mill-4axis"),
    ("O1\nT1 M6\nG43 H1 Z50.\nG0 X1. A90.\nG154 P2 Y2.\n", "haas-mill-4axis"),
    ("O1\nT1 M6\nG43 H1 Z50.\nG0 X1. A90. C30.\nG1 Y2. F100.\n", "fanuc-mill-5axis"),
    ("DIAMON\nG96 S200 LIMS=3000 M4\nG0 X40 Z2\n", "siemens-lathe"),
    ("0 BEGIN PGM PART MM\n1 L X+10 R0 FMAX\n", "heidenhain-mill"),
    ("O1\nT0101\nM130\nM99\nO2\nT0202\nM130\nM99\n", "fanuc-2path-lathe"),
    (
        "$SHAFT.MIN%\nG00 X300 Z300\nG50 S2500\nT010101\nG96 S180 M03 M42\nG00 X60 Z2\nG01 Z-30 F0.2\nM02\n",
        "okuma-lathe",
    ),
    ("NLAP1 G81\n", "okuma-lathe"),
    ("$P.MIN%\nG50 S2500\nT010101\nG141\nM249\nG22 W-100 D10 F100\nM248\nM02\n", "okuma-lathe-subspindle"),
    ("O1\nG92 S3000\nG96 S180 M203\nG0 X52. Z2.\nM511\nM306\nM307\nM513\nM30\n", "mazak-integrex"),
    ("G15 H1\nT1 M6\n", "okuma-mill"),
    ("O1\nG13\nM110\nG14 (B)\nO2\n", "okuma-2turret"),
    ("O1\n$1\nG50 S2500\nM30\n$2\nM30\n", "citizen-3system"),
    ("$0\n#814=10\n$1\nT1 M6\n", "citizen-3system"),
    ("O1\nG50 S2500\n!2L1\nG0 X5. Z1.\n", "citizen-3system"),
    // Pocket milling of a Haas, its second spindle and the end of polar interpolation are not turrets.
    ("G13 I5. D1 F100.\nG14\nT1 M6\n", "haas-mill"),
    ("T1 M6\nG154 P3 X0 Y0\n", "haas-mill"),
    ("T1 M6\nM97 P100 L2\n", "haas-mill"),
    ("T1 M6\nG70 I20. J0 L6\n", "haas-mill"),
    ("G13.1\nG50 S900\n", "fanuc-lathe"),
    ("T1 M6\nG103 P1\nG43 H1 Z1.\n", "haas-mill"),
    ("T1 M6\nG110 G0 X1. Y1.\n", "haas-mill"),
    ("T1 M6\nG150 P2 X0 Y0 Z-1. Q.1 K.1 J.1 D1 F10.\n", "haas-mill"),
    ("T1 M6\nG47 P0 X0 Y0 I0 J.5 R.1 Z-.01 F10. E5.\n", "haas-mill"),
    // A at a threading cycle is the angle of the thread.
    ("T101;\nM155;\nG50 S900;\nG0 X50. Y0;\nG1 C90. F1.;\nG76 X45. Z-20. K.5 D.1 F1. A60;\n", "haas-mill-turn"),
    // Two T words on a tool change, the sequence number of a call in Q.
    ("O1\nT1 T2 M6\nG90 G54 G0 X1. Y2.\nG43 H1 Z5.\n", "mazak-eia-mill"),
    ("T1 M6\nG43 H1 Z5.\nM98 P2 Q10 L2\n", "mazak-eia-mill"),
    // The sequence number of a call in H, patterns of holes.
    ("O1\nT1 M6\nG43 H1 Z5.\nM98 P2 H10\n", "mitsubishi-mill"),
    ("T1 M6\nG81 Z-5. R1. K0 F100\nG34 X0 Y0 I50. J0 K6\n", "mitsubishi-mill"),
    ("T1 M6\nIF [#1 EQ 1]\nG0 X1.\nENDIF\n", "mitsubishi-mill"),
    // ,R1 beside a tap is its kind, beside a line a corner.
    ("O1\nG90 G54 G0 X0 Y0 S500 M3\nG98G84X10.Y-30.Z-12.R5.F500.,R1\nG80\nM30\n", "mitsubishi-mill"),
    ("O1\nG90 G54 G0 X0 Y0 S500 M3\nG84 Z-12. R5. F500.\nG1 X9. ,R1.\nY9.\nT1 M6\n", "fanuc-mill"),
    // Statements of custom macros are blocks.
    ("O1\n#1=#2 MOD 3\nWHILE[#1LT5]DO1\n#1=#1+1\nEND1\nGOTO 10\nPOPEN\nN10 T1 M6\n", "fanuc-mill"),
];

#[test]
fn programs_show_what_they_are_for() {
    for (text, expected) in PROGRAMS {
        assert_eq!(machine("p.nc", text).as_deref(), Ok(*expected), "{text}");
    }
    for (name, text, expected) in [
        ("p.MIN", "G50 S2500\nT010101\n", "okuma-lathe"),
        ("p.min", "G14\nG96 S150\n", "okuma-2turret"),
        ("p.mpf", "G54 G90 G95\nG0 X50 Z2\nG1 Z-20 F0.2\nM30\n", "siemens-lathe"),
        ("p.eia", "O1\nT1 M6\nG90 G54 G0 X1. Y2.\n", "mazak-eia-mill"),
        ("p.EIA", "O1\nT0101\nG96 S200 M3\nG0 X50. Z2.\n", "mazak-eia-lathe"),
        // In a job archive numbers other than 0 are data.
        ("a.txt", "%_N_1_0_MPF\nG96 S100 M3\nM30\n%_N_2_0_MPF\nM30\n%_N_1_50_MPF\nR1=5\nM30\n", "siemens-2channel"),
        ("a.txt", "%_N_PART_MPF\nT1 M6\nL10\nM30\n%_N_L10_SPF\nG1 Y2 F100\nM17\n", "siemens-mill"),
        ("p.nc", "T1 M6 G43 H1 X1. Y1.", "fanuc-mill"),
        ("p.nc", "O1\r\nT1 M6\nG43 H1 Z5.\r\nG0 X1. Y2.\rM30\r\n", "fanuc-mill"),
        // Waits of an archive with two main programs need two channels, with any other signs.
        (
            "a.arc",
            "%_N_CH1_MPF\nWAITM(1,1,2)\nG0 X10\nM30\n%_N_CH2_MPF\nWAITM(1,1,2)\nG0 X10\nM30\n",
            "siemens-2channel",
        ),
        ("p.i", "%NEW G71 *\nN10 G30 G17 X+0 Y+0 Z-40*\nN40 G00 G40 G90 Z+250 M3*\n", "heidenhain-mill"),
        ("p.i", "N10 G30 G17 X+0 Y+0 Z-40*\nN20 T5 G17 S5000*\nN30 G00 G40 G90 Z+250 M3*\n", "heidenhain-mill"),
        ("p.nc", "%PART G71 *\nN10 G00 X1*\n", "heidenhain-mill"),
        ("p.nc", "%PART G70 *\nN10 G00 X+1 M128*\n", "heidenhain-mill-5axis"),
        ("a.arc", "%_N_A_1_MPF\nDIAMON\nM30\n%_N_A_2_MPF\nM30\n%_N_B_SPF\nM17\n", "siemens-2channel"),
    ] {
        assert_eq!(machine(name, text).as_deref(), Ok(expected), "{name} {text}");
    }
}

/// No guess changes by a comment in the form of the control with any text, by a file in capitals or with other line
/// ends, by block skip or by block numbers.
/// A program is not guessed for a machine that refuses the axes by which it was guessed (2900028).
#[test]
fn a_machine_without_the_axes_of_the_program_is_refused() {
    for (text, moved) in [
        ("O1\nT1 M6\nG90 G54 G0 X0 Y0 B0 C0\nG43 H1 Z50.\nG1 X1. B-20. F100.\nM30\n", "B and C"),
        ("O1\nT1 M6\nG43.4 H1 Z50.\nG1 X1. A-20. F100.\nB10.\nM30\n", "A and B"),
        ("O1\nT1 M6\nG43.4 H1 Z50.\nG1 X1. B-20. F100.\nM30\n", "B"),
    ] {
        let refusal = machine("part.nc", text).unwrap_err();
        assert!(refusal.starts_with(&format!("the program moves {moved} (")), "{refusal}");
        let machine = format!(
            "no shipped machine of its kind has {moved}; fanuc-mill-5axis has A and C. Make a machine of your own from it \
             (counterpoint machine new DIR --from fanuc-mill-5axis)"
        );
        assert!(refusal.contains(&machine), "{refusal}");
    }
    let haas = machine("part.nc", "O1\nT1 M6\nG154 P2 X1. Y2.\nG43 H1 Z50.\nG1 X1. C20. F100.\nM30\n").unwrap_err();
    let why = "no shipped machine of its kind has C; haas-mill has no rotary axis. Make a machine of your own from it";
    assert!(haas.starts_with("the program moves C (C20. and T1 M6 (line 5))") && haas.contains(why), "{haas}");
    let table = "O1\nT1 M6\nG90 G54 G0 X1. Y2.\nG43 H1 Z50.\nC90.\nG1 X2. F100.\nM30\n";
    assert_eq!(machine("part.nc", table).as_deref(), Ok("fanuc-mill-5axis"), "its table C is the only rotary axis");
    let chamfer = table.replace("C90.", "G1 X3. ,C1.");
    assert_eq!(machine("part.nc", &chamfer).as_deref(), Ok("fanuc-mill"), "a chamfer");
    let turned = "O1\nG50 S2500\nG96 S200 M3\nT0101\nG0 X52. Z2.\nG1 X60. C1. F0.2\nM30\n";
    assert_eq!(machine("part.nc", turned).as_deref(), Ok("fanuc-lathe"), "a chamfer of a lathe");
    let tilted = "O1\nT1 M6\nG43 H1 Z50.\nG1 X1. A-20. C90. F100.\nM30\n";
    assert_eq!(machine("part.nc", tilted).as_deref(), Ok("fanuc-mill-5axis"));
    let call = "O1\nT1 M6\nG43.4 H1 Z50.\nG1 X1. A-20. C90. F100.\nG65 P9 B1.\nM30\n";
    assert_eq!(machine("part.nc", call).as_deref(), Ok("fanuc-mill-5axis"), "B is an argument");
}

#[test]
fn comments_and_numbers_never_change_a_guess() {
    let texts = [
        "80 DEG DIAMOND CNMG",
        "T1 M6 G43 H1 Y5.",
        "G96 S200 G50 S2500 T0101",
        "WAITM 1,1,2 TRAORI A3=1 DIAMON CYCLE81",
        "BEGIN PGM TOOL CALL 5 L X+10 FMAX M128",
        "$1 $2 !L1 NLAP1 G15 H1 G13 G14 O1",
        "E2 O100 SUB #SIGNAL V.P.X",
    ];
    for (text, expected) in PROGRAMS {
        let known = machine("p.nc", text);
        let siemens = expected.starts_with("siemens") || expected.starts_with("heidenhain");
        for comment in texts {
            let comment = if siemens { format!("; {comment}") } else { format!("({comment})") };
            for line in 0..=text.lines().count() {
                let mut lines: Vec<&str> = text.lines().collect();
                lines.insert(line, &comment);
                assert_eq!(machine("p.nc", &lines.join("\n")), known, "{comment} before line {} of {text}", line + 1);
            }
            let behind = text.lines().map(|line| format!("{line} {comment}\n")).collect::<String>();
            if !text.contains(['$', '%', '!', ';']) {
                assert_eq!(machine("p.nc", &behind), known, "{behind}");
            }
        }
        assert_eq!(machine("p.nc", &text.to_lowercase()), known, "{text}");
        assert_eq!(machine("p.nc", &text.replace('\n', "\r\n")), known, "{text}");
        let wide: Vec<u8> = text.encode_utf16().flat_map(u16::to_be_bytes).collect();
        let program = ExaminedProgram { name: "p.nc".into(), content: Bytes::from(wide), number: None, part: false };
        assert_eq!(guess(shipped(), &[program], None, &|| false).map(|guess| guess.machine), known, "UTF-16: {text}");
    }
}

#[test]
fn the_answer_names_the_signs() {
    let why = |files: &[(&str, &str)]| of_files(files, None).map(|guess| guess.why).unwrap();
    assert_eq!(why(&[("p.nc", "O1\r\nT1 M6\r\nN10 G43 H1\r\nM30\r\n")]), "T1 M6 (line 2), G43 H1 (line 3)");
    assert_eq!(
        why(&[("p.MIN", "G50 S2500\nT010101\n")]),
        "the file ending .MIN (p.MIN), T010101 (line 2), G50 S2500 (line 1)"
    );
    assert_eq!(
        why(&[("a.nc", "WAITM(1,1,2)\nM30\n"), ("b.nc", "WAITM(1,1,2)\nG96 S200\n")]),
        "2 programs with waiting codes, WAITM (a.nc line 1), G96 S200 (b.nc line 2)"
    );
    assert_eq!(
        why(&[("a.nc", "O1\nM101\nM30\n"), ("b.nc", "O2\nT0202\nM101\nM30\n")]),
        "2 programs with waiting codes, T0202 (b.nc line 2)"
    );
    assert_eq!(why(&[("p.nc", "T1 M6\nG154 P3 X0 Y0\n")]), "T1 M6 (line 1), Y0 (line 2), G154 P3 (line 2)");
}

#[test]
fn a_program_that_commands_another_channel_is_for_a_machine_that_has_it() {
    let begin = "DIAMON\nG96 S200 LIMS=2000 M3\nG0 X50 Z2\n";
    let guessed = |text: &str| machine("main.mpf", &format!("{begin}{text}M30\n"));
    assert_eq!(guessed("INIT(2,\"LOWER\")\nSTART(2)\n").as_deref(), Ok("siemens-2channel"));
    assert_eq!(guessed("WAITM(1,1,2)\n").as_deref(), Ok("siemens-2channel"));
    assert_eq!(guessed("WAITE(2)\n").as_deref(), Ok("siemens-2channel"));
    assert_eq!(guessed("SETM(5)\nMSG(\"INIT(2)\")\n").as_deref(), Ok("siemens-lathe"));
    // Without signs of turning, one machine with two channels is left.
    assert_eq!(machine("main.mpf", "INIT(2,\"LOWER\")\nSTART(2)\nM30\n").as_deref(), Ok("siemens-2channel"));
}

#[test]
fn programs_of_linuxcnc_and_grbl_show_it() {
    for text in [
        "o100 sub\nG1 X10 Y5\no100 endsub\n",
        "o100 sub\nG0 X1\no100 endsub\no100 call\nM2\n",
        "G21 G90\n#<depth>=5\nG0 Z[#<depth>]\nG1 X1 Y2 F100\n",
        "G21 G90 G64 P0.01\nG1 X1 Y2 F100\n",
    ] {
        for name in ["p.ngc", "p.gcode"] {
            assert_eq!(machine(name, text).as_deref(), Ok("linuxcnc-mill"), "{name} {text}");
        }
    }
    assert_eq!(machine("p.nc", "$H\nG21 G90\nG1 X1 Y2 F100\n").as_deref(), Ok("grbl-router"));
    for text in ["G21 G90\nG1 X1 Y2 F100\n", "G21 ; mm\nM3 S1000\nG1 X1 Y2 F100\n"] {
        assert_eq!(machine("p.gcode", text).as_deref(), Ok("grbl-router"), "{text}");
    }
}

#[test]
fn what_cannot_be_guessed_is_refused() {
    let refused = |files: &[(&str, &str)], with: &str| {
        let why = of_files(files, None).unwrap_err();
        assert!(why.contains(with), "{why}");
    };
    refused(&[("p.nc", "O1\nG0 X1.\nM30\n")], "nothing in p.nc shows");
    refused(&[("p.nc", "T1 M6\nG43 H1\nG50 S1000\nG96 S100\n")], "as well as milling (T1 M6 (line 1)");
    refused(&[("p.nc", "%_N_PART_MPF\nG0 X1\n")], "the program is for a Siemens control, judging by %_N_ (line 1)");
    refused(&[("p.mpf", "G54 G90 G0 X10\nM30\n")], "a Siemens control");
    refused(&[("p.i", "N10 G00 X1*\n")], "nothing but the name shows it");
    refused(&[("a.arc", "%_N_A_MPF\nT1 M6\nWAITM(1,1,2)\n%_N_B_MPF\nWAITM(1,1,2)\n")], "show milling");
    refused(&[("a.mpf", "G96 S200\n"), ("b.mpf", "M30\n"), ("c.mpf", "M30\n")], "3 channels");
    refused(&[("a.mpf", "T1 M6\nWAITM(1,1,2)\n"), ("b.mpf", "M30\n")], "show milling");
    refused(&[("p.MIN", "G0 X50\n")], "okuma-lathe-subspindle and okuma-mill are shipped");
    refused(&[("p.MIN", "G90 G95 G0 X50\n")], "okuma-lathe-subspindle and okuma-mill are shipped");
    refused(&[("a.MIN", "T1 M6\n"), ("b.MIN", "G0 Y2\n")], "show milling");
    refused(&[("a.MIN", "G13\n"), ("b.MIN", "G14\n"), ("c.MIN", "G50 S99\n")], "3 channels");
    refused(&[("p.nc", "$1\nM30\n$2\nM30\n$4\nM30\n")], "a control with more than three systems");
    refused(&[("a.nc", "T1 M6\nG43 H1\n"), ("b.nc", "T2 M6\n")], "2 programs show milling");
    refused(&[("a", "M30"), ("b", "M30"), ("c", "M30"), ("d", "M30")], "4 channels");
    // Programs that never wait for each other are two jobs.
    refused(&[("a.nc", "O1\nT0101\nM30\n"), ("b.nc", "O2\nT0202\nM30\n")], "never wait for each other");
    let waits = ("O1\nT0101\n(M950)\nM910\nM900\nM30\n", "O2\nT0202\nM900\nM950\nM30\n");
    refused(&[("a.nc", waits.0), ("b.nc", waits.1)], "or add --set waits=900-999 if M900 is a waiting code");
    refused(&[("a.mpf", "G96 S200\n"), ("b.mpf", "G96 S200\n")], "never wait for each other");
    // Controls that no machine has.
    refused(&[("p.gcode", ";FLAVOR:Marlin\nG28\nG1 X10 Y10 Z0.3 F3000 E0\nG1 X50 E2\n")], "a 3D printer");
    // An ISG control has a machine, for three programs.
    refused(&[("p.nc", "P1 = 5\n$FOR P1=1,3,1\nG1 X1 Y2\n#TIME 2\n")], "an ISG control");
    // Marks of several controls.
    refused(&[("p.nc", "O1\nG65 P9810 Z1.\n; rough\nG1 X1. Y2.\n")], "a LinuxCNC control");
    refused(&[("p.nc", "; rough\nG1 X1. Y2.\n")], "any of several controls");
    refused(&[("p.mpf", "O1\nG65 P9810 Z1.\nT1 M6\n")], "as well as");
}

/// Texts for other machines, and texts that are not NC programs.
const ELSEWHERE: &[(&str, &str, &str)] = &[
    ("p.gcode", "M104 S210\nG28\nG1 X10 Y10 E1.2 F1500\nG1 X20 E2.4\n", "a 3D printer"),
    ("p.gcode", "G21\nG90\nM106 S255\nG1 X1 Y1 F100\nM107\n", "a 3D printer"),
    ("p.nc", "G21\nG90\nM4 S0\nG1 X10 Y10 S500 F1000\nM5\n", "a laser control"),
    ("p.nc", "G21\nG90\nM3\nG1 X10 Y10 S500 F1000\nG1 X20 S0\n", "a laser control"),
    ("p.drl", "M48\nMETRIC,TZ\nT1C0.8\n%\nG90\nG05\nT1\nX10.0Y20.0\nX11.0Y20.0\nM30\n", "a drill for circuit boards"),
    ("p.iso", "O1\nG92 X0 Y0\nG41 D1\nG1 X1. Y2. U0.5 V0.2\nM50\nM60\n", "a wire EDM control"),
    ("p.src", "DEF PART()\nPTP {A1 0,A2 -90,A3 90}\nLIN {X 100,Y 20,Z 30,A 0,B 90,C 0}\nEND\n", "no blocks"),
    ("p.mod", "MODULE Main\nPROC main()\nMoveL p10, v100, z10, tool0;\nMoveJ p20, v100, fine, tool0;\n", ""),
    ("p.plt", "IN;\nSP1;\nPU100,100;\nPD200,200;\n", "no blocks"),
    ("p.gbr", "%FSLAX24Y24*%\nG01*\nX100Y200D02*\nX200Y200D01*\n", "no blocks"),
    ("p.txt", "Dear Sir,\nthe part is X and Y. Please mill T1 M6 today.\n", "no blocks"),
    ("p.py", "import os\nfor x in range(3):\n    y = x\n", "no blocks"),
    ("p.html", "<html>G1 X1 Y1 <b>M6</b></html>\n", "no blocks"),
    ("p.stp", "HEADER;\nENDSEC;\nDATA;\n#1=CARTESIAN_POINT('',(0.,0.,0.));\n", ""),
    ("p.h", "{ \"G1\": \"X1 Y2\"}\n", "nothing but the name shows it"),
    ("p.nc", "\u{0}\u{1}\u{2}T1\u{3}M6 Y\u{1f}\u{7f}\n\u{4}\n", "no blocks"),
    ("p.nc", "", "nothing in p.nc shows"),
    ("p.eia", "O1\nM30\n", "nothing in p.eia shows"),
    ("p.nc", "T1 M6\nG90 G0 X1. Y2.\nG5 P2\n", "for mazak-eia-mill or mitsubishi-mill"),
];

#[test]
fn texts_for_other_machines_are_refused() {
    for (name, text, with) in ELSEWHERE {
        let why = machine(name, text).unwrap_err();
        assert!(why.contains(with), "{text}: {why}");
    }
}

#[test]
fn turrets_of_two_files_need_no_wait() {
    let both = of_files(&[("a.min", "G13\nG50 S900\n"), ("b.min", "G14\nG97 S500\n")], None).unwrap();
    assert_eq!(both.machine, "okuma-2turret");
}

#[test]
fn lathes_with_two_spindles_show_it_by_words_of_their_own() {
    for (upper, lower, expected) in [
        ("O1\nT0101\nM427\nM101\nM30\n", "O2\nT0202\nM428\nM101\nM30\n", "fanuc-twin-spindle"),
        ("O1\nG361 B90. D0.\nM101\nM30\n", "O2\nT0202\nG330\nM101\nM30\n", "fanuc-twin-head"),
        (
            "O1\nG50 S900\nG300 Z1. T0100\nG0 X5. Z2.\nM500\nM30\n",
            "O2\nG310 Z175. T2100\nM500\nM30\n",
            "fanuc-swiss-hanwha",
        ),
        ("O1\nG50 S900\nM201\nM30\n", "O2\nT2900\nM82\nM201\nM30\n", "fanuc-swiss-goodway"),
        ("O1\nT0101\nM101\nM30\n", "O2\nT0202\nM101\nM30\n", "fanuc-2path-lathe"),
        ("O1\nG4 X1.\nM101\nM30\n", "O2\nG4 X4.\nM101\nM30\n", "fanuc-2path-lathe"),
    ] {
        let both = of_files(&[("a.nc", upper), ("b.nc", lower)], None);
        assert_eq!(both.as_ref().map(|guess| guess.machine.as_str()), Ok(expected), "{both:?}");
    }
}

#[test]
fn waiting_codes_are_those_of_the_settings() {
    let files = [("both.nc", "O1\nT0101\nM901\nM99\nO2\nT0202\nM901\nM99\n")];
    let of = |waits: Option<RangeInclusive<u32>>| of_files(&files, waits.as_ref()).unwrap().machine;
    assert_eq!((of(Some(900..=999)).as_str(), of(None).as_str()), ("fanuc-2path-lathe", "fanuc-lathe"));
}

#[test]
fn a_program_of_a_file_is_judged_alone() {
    let text = "O1\nT1 M6\nG43 H1\nM30\nO2\nG50 S2000\nT0101\nM30\n";
    let of = |number: u32| {
        let content = Bytes::from(text.as_bytes());
        let program = ExaminedProgram { name: "both.nc".into(), content, number: Some(number), part: true };
        guess(shipped(), &[program], None, &|| false).unwrap().machine
    };
    assert_eq!((of(1).as_str(), of(2).as_str()), ("fanuc-mill", "fanuc-lathe"));
}

#[test]
fn signs_are_checked_with_their_places() {
    let text = "extends = \"fanuc-mill\"\n[ce]\nname = \"own\"\n[signs]\ncolour = 1\n[signs.marks]\n\"!X\" = 2\n\"G1 X\" = 12\n";
    let mut files = package::shipped();
    files.insert("own/machine.toml", Bytes::from(text));
    let texts: Vec<String> = load(&files, "own").findings.iter().map(ToString::to_string).collect();
    assert_eq!(texts.len(), 3, "{texts:?}");
    assert!(
        texts.iter().any(|text| text.contains("own/machine.toml:7") && text.contains("must name a word")),
        "{texts:?}"
    );
    assert!(texts.iter().any(|text| text.contains("own/machine.toml:8") && text.contains("from 0 to 9")), "{texts:?}");
    assert!(texts.iter().any(|text| text.contains("unknown key `colour`")), "{texts:?}");
}
