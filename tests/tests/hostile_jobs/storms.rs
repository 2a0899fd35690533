//! Storms: jobs that do one ordinary thing without end, or with the largest numbers there are.

use std::sync::Arc;

use counterpoint_kernel::dialog::answers::{DialogAnswer, DialogValue};
use counterpoint_kernel::dialog::operator::{DialogOperator, OpenDialog, Silence};

use counterpoint_kernel::options::JobOptions;

use super::cases::{
    Case, HEIDENHAIN, LIMIT, LONG, OKUMA, SIEMENS, STEPS, block_macro, dialect, endless, fanuc, machine,
};

/// Codes and texts that the machine does not have.
const UNKNOWN: &[u32] = &[2_900_320, 2_900_321, 2_900_016, 2_900_018];
/// Files that are too large.
const FILES: u32 = 2_900_086;
/// Dialog that fails, and the error of the macro that it is.
const DIALOG: u32 = 2_910_068;
/// Variables that the control does not have.
const VARIABLE: &[u32] = &[2_900_061, 2_900_062, 2_900_063, 2_900_016, 2_900_350, 2_900_351];

/// All of them.
pub fn all() -> Vec<Case> {
    let mut all = of_macros();
    all.append(&mut of_programs());
    all.append(&mut of_lathes());
    all.append(&mut of_long_programs());
    all
}

/// All channels have one set of common variables.
const SHARES: &str = "[variables]\nshared = [[100, 199], [500, 999]]\nchannel = []\n\n";

const QUESTION: &str = "[[dialogs]]\nname = \"Q\"\n[[dialogs.fields]]\nkind = \"text\"\nvariable = \"%G05\"\nlabel = \"A\"\n\
     [[dialogs.fields]]\nkind = \"number\"\nvariable = \"%G06\"\nlabel = \"B\"\nmin = 1\nmax = 9\ndefault = 3\n";

fn asking(name: &'static str, ends_with: &'static [u32]) -> Case {
    let text = endless("", "B=$FDIALOG('Q')");
    let machine = machine(
        "fanuc-mill-exact",
        &format!("{QUESTION}[macros]\nblock_startup = \"m.mac\"\n"),
        &[("m.mac", text.as_str())],
    );
    Case::new(name, machine, vec!["N1 G90\nG91\nGOTO1\n".to_owned()], ends_with)
}

/// Answers as fast as it can, but never so that a field takes it.
struct Wrong;

impl DialogOperator for Wrong {
    fn ask(&self, _: &OpenDialog<'_>) -> Result<DialogAnswer, Silence> {
        let text = DialogValue::Text("x".repeat(1 << 20));
        let values = vec![("%G05".to_owned(), text), ("%G06".to_owned(), DialogValue::Number(1e300))];
        Ok(DialogAnswer { dialog: "Q".to_owned(), button: Some("OK".to_owned()), values: values.into_iter().collect() })
    }
}

/// Answers as fast as it can.
struct Quick;

impl DialogOperator for Quick {
    fn ask(&self, _: &OpenDialog<'_>) -> Result<DialogAnswer, Silence> {
        Ok(DialogAnswer { dialog: "Q".to_owned(), ..DialogAnswer::default() })
    }
}

fn of_macros() -> Vec<Case> {
    vec![
        asking("macro: dialogs without an answer", &[DIALOG]),
        asking("macro: a storm of dialogs", &[STEPS, LIMIT]).attended(Arc::new(Quick)),
        asking("macro: dialogs with wrong answers", &[DIALOG, STEPS, LIMIT]).attended(Arc::new(Wrong)),
        block_macro(
            "macro: keys of a store without end",
            &endless("N=0\nH=$FMRU_OPEN('a')", "N=N+1\nB=$FMRU_SETPARAM(H,N,'p','0123456789')\nK=$FMRU_GETKEYS(H)"),
            &[STEPS, LIMIT, FILES],
        ),
        block_macro(
            "macro: stores without end",
            &endless("N=0", "N=N+1\nH=$FMRU_OPEN($FSWRIT('f!(*)',N))\nB=$FMRU_SETPARAM(H,1,'p',N)\nC=$FMRU_CLOSE(H)"),
            &[STEPS, LIMIT, FILES],
        ),
        block_macro(
            "macro: files that are opened and closed",
            &endless("N=0", "N=N+1\nOPEN/20,$FSWRIT('f!(*)',N)\nWRITE/20,'!(*)',N\nCLOSE/20"),
            &[STEPS, LIMIT, FILES],
        ),
        block_macro(
            "macro: a file that is read again and again",
            &endless(
                "OPEN/20,'a'\nDO/I=1,2000\nWRITE/20,'!(*)',I\nENDOF/DO\nCLOSE/20",
                "OPEN/20,'a'\nREAD/20,B\nCLOSE/20",
            ),
            &[STEPS, LIMIT, FILES],
        ),
        block_macro("macro: blocks that are left for later", "EXEC/NEXT,'G90'\nEXEC/NEXT,'G91'\n", &[LIMIT]),
        block_macro(
            "macro: blocks that are put in at once",
            &endless("", "EXEC/NOW,'G91 X1'"),
            &[STEPS, LIMIT, 2_900_081],
        ),
        block_macro("macro: a shared variable in a loop", &endless("DECLAR/GLOBAL,N", "N=N+1"), &[STEPS, LIMIT]),
    ]
}

fn of_programs() -> Vec<Case> {
    vec![
        fanuc(
            "fanuc: a cycle that is repeated",
            "G90 G0 X0 Y0 Z10.\nN1 G91 G81 X1. Z-1. R-1. F100. K9999\nGOTO1\n".into(),
            &[LIMIT],
        ),
        fanuc(
            "fanuc: a cycle that goes nowhere",
            "G90 G0 X0 Y0 Z0\nN1 G81 X0 Y0 Z0 R0 F100. K99999\nGOTO1\n".into(),
            &[LIMIT],
        ),
        fanuc("fanuc: endless pecks", "G90 G0 X0 Y0 Z10.\nG83 Z-99999. R0. Q0.001 F1000.\nM30\n".into(), &[2_900_092]),
        fanuc("fanuc: tools without end", "#1=0\nN1 #1=#1+1\nT#1 M6\nGOTO1\n".into(), &[LIMIT]),
        fanuc("fanuc: two tools without end", "N1 T1 M6\nT2 M6\nGOTO1\n".into(), &[LIMIT]),
        fanuc("fanuc: printing without end", "POPEN\nN1 #1=#1+1\nDPRNT[X#1[99] Y#1[53]]\nGOTO1\n".into(), &[LIMIT, FILES, 2_900_060]),
        fanuc("fanuc: a message of a megabyte", format!("N1 (MSG, {})\nGOTO1\n", "x".repeat(1_000_000)), &[LONG]),
        fanuc("fanuc: messages on one line", format!("N1 {}\nGOTO1\n", "(MSG,x)".repeat(1000)), &[LIMIT]),
        fanuc("fanuc: numbers of variables that are too large", "N1 #99999999999=1\n#[#0-1]=1\nGOTO1\n".into(), VARIABLE),
        fanuc("fanuc: every number of a variable", "#1=500\nN1 #[#1]=1\n#1=#1+1\nGOTO1\n".into(), VARIABLE),
        fanuc("fanuc: calls without end", "O1\nN1 M98 P9990002\nGOTO1\nO2\nM99\n".into(), &[LIMIT]),
        fanuc("fanuc: macro calls without end", "O1\nN1 G65 P2 A1. B2. L9999\nGOTO1\nO2\n#3=#1+#2\nM99\n".into(), &[LIMIT]),
        fanuc("fanuc: scaled, turned and mirrored without end", "N1 G68 X0 Y0 R1.\nG51 X0 Y0 P2000\nG0 X1.\nGOTO1\n".into(), &[LIMIT, 2_900_320]),
        fanuc("fanuc: a contour that never ends", contour(), &[LIMIT]),
        fanuc("fanuc: codes on one line", format!("N1 {}\nGOTO1\n", "G90G91".repeat(1200)), &[2_900_320, 2_900_350]),
        texts_on_one_line(),
        many_rules(),
        dialect("siemens: messages without end", SIEMENS, format!("LOOP\nMSG(\"{}\")\nENDLOOP\n", "x".repeat(8000)), &[LIMIT, 2_900_200]),
        dialect("siemens: repeated labels", SIEMENS, "A: R1=R1+1\nB: R2=1\nREPEAT A B P=9999\nREPEAT A P=9999\nM30\n".into(), &[LIMIT]),
        dialect("siemens: loops within loops", SIEMENS, format!("{}R1=R1+1\n{}M30\n", "FOR R9=1 TO 9999999\n".repeat(8), "ENDFOR\n".repeat(8)), &[LIMIT, 2_900_016, 2_900_064]),
        dialect("siemens: pattern of holes", SIEMENS, "MCALL CYCLE81(10,0,2,-5)\nAGAIN: HOLES1(0,0,0,1,1,99999999)\nGOTOB AGAIN\n".into(), UNKNOWN),
        dialect("okuma: drilling without end", OKUMA, "N1 G180\nG181 X1 Z-1 C0 Q9999\nGOTO N1\n".into(), &[LIMIT, 2_900_320, 2_900_321]),
        dialect("okuma: calls without end", OKUMA, "O1\nN1 CALL OSUB Q9999\nGOTO N1\nM02\nOSUB\nVC1=VC1+1\nRTS\n".into(), &[LIMIT]),
        dialect("heidenhain: cycles without end", &drilling(), "BEGIN PGM A MM\nCYCL DEF 200 DRILLING Q200=+2 Q201=-9999 Q206=120\nL Z+10 FMAX\nLBL 1\nL IX+1 FMAX M99\nFN 9: IF +1 EQU +1 GOTO LBL 1\n".into(), &[LIMIT]),
        dialect("heidenhain: prints without end", HEIDENHAIN, "BEGIN PGM A MM\nLBL 1\nFN 38: SEND /\"%F %F\"/Q200/Q201\nFN 9: IF +1 EQU +1 GOTO LBL 1\n".into(), &[LIMIT]),
        dialect("heidenhain: corners without end", &conversational(), "BEGIN PGM A MM\nL X+0 Y+0 F100\nLBL 1\nL IX+1\nCHF 0.1\nL IY+1\nCHF 0.1\nFN 9: IF +1 EQU +1 GOTO LBL 1\n".into(), &[LIMIT, 2_900_016]),
    ]
}

/// Moves beside a contour with nothing between them that ends the look ahead.
fn contour() -> String {
    let mut text = "G90 G0 X0 Y0\nG10 L12 P1 R5.\nG41 D1 G1 X1. F1000.\nN1 G91\n".to_owned();
    (0..5000).for_each(|_| text.push_str("G1 X0.001\nM8\nG4 P0\n"));
    text + "GOTO1\n"
}

/// A machine with codes that are single characters, many of them in a block.
fn texts_on_one_line() -> Case {
    let code = |text: &str, id: &str| format!("[[codes]]\nid = \"{id}\"\ntext = \"{text}\"\n");
    let toml = code("@", "CODE_POSITION_ABSOLUTE")
        + &code("&", "CODE_UNITS_PRIMARY")
        + "[control]\nunknown_code = \"warn\"\nstops = false\n";
    let program = format!("N1 {}\nGOTO1\n", "@&".repeat(1000));
    Case::new("a line of codes of one character", machine("fanuc-mill-exact", &toml, &[]), vec![program], &[LIMIT])
}

/// As many rules of the tape editor as there may be, all of which change the longest text there may be.
fn many_rules() -> Case {
    let rules = "[[tape_editor]]\nfind = \"X\"\nreplace = \"X\"\n".repeat(250);
    let program = format!("N1 ({})\nGOTO1\n", "X".repeat(1_000_000));
    Case::new("tape editor: many rules on a megabyte", machine("fanuc-mill-exact", &rules, &[]), vec![program], &[LONG])
}

/// Straight moves of conversational programs.
fn conversational() -> String {
    let mut toml = HEIDENHAIN.to_owned();
    for (index, name) in ["X", "Y", "Z"].into_iter().enumerate() {
        toml += &format!("[[registers]]\nindex = {}\nname = \"{name}\"\nsecond = \"I{name}\"\n", index + 4);
        toml += "whole = 5\nfrac = 3\npoint = \"keep\"\nsigned = true\n";
    }
    toml + "[[codes]]\nid = \"CODE_INTERP_LINEAR\"\ntext = \"L\"\n[[codes]]\nid = \"CODE_RAPID\"\ntext = \"FMAX\"\norder = 490\n\
            modality = \"non-modal\"\n[[codes]]\nid = \"CODE_INTERP_ARC_RADIUS\"\ntext = \"CR\"\n"
}

/// Drilling by CYCL DEF 200 and M99.
fn drilling() -> String {
    let register = |index: u32, name: &str| {
        format!("[[registers]]\nindex = {index}\nname = \"{name}\"\nwhole = 5\nfrac = 3\nsigned = true\n")
    };
    let mut toml = format!("{}{}", conversational(), register(42, "CYCLDEF\"\nbefore = \"CYCL DEF "));
    for (index, (id, name)) in [("CLEAR", "Q200="), ("DEPTH_Z", "Q201="), ("UPM", "Q206=")].into_iter().enumerate() {
        toml += &register(43 + index as u32, name);
        toml += &format!("[[data]]\nid = \"REG_CYCLE_{id}\"\nregister = \"{name}\"\n");
    }
    toml + "[[codes]]\nid = \"CODE_CYCLE_DRILL\"\nword = \"CYCLDEF200\"\n[[codes]]\nid = \"CODE_CALSUB_RETURN\"\n\
            word = \"M99\"\nenable = false\n[[codes]]\nid = \"CODE_CYCLE_ON\"\nword = \"M99\"\norder = 600\n\
            modality = \"non-modal\"\n"
}

fn lathe(name: &'static str, texts: &[&str], ends_with: &'static [u32]) -> Case {
    let programs = texts.iter().map(|text| (*text).to_owned()).collect();
    Case::new(name, machine("fanuc-2path-lathe-exact", "", &[]), programs, ends_with)
}

fn of_lathes() -> Vec<Case> {
    let thread = "G97 S600 M3\nG0 X99. Z5.\nN1 G76 P990060 Q1 R0.001\nG76 X1. Z-20. P49000 Q1 F2.\nGOTO1\n";
    vec![
        lathe("lathe: threads of many passes", &[thread], &[LIMIT]),
        lathe(
            "lathe: a cycle with a long contour",
            &["G71 U1. R1.\nG71 P1 Q2 U.1 W.1 F1.\nN1 G0 X1.\nN2 X2.\n"],
            UNKNOWN,
        ),
        lathe("lathe: waits without end", &["N1 M101\nGOTO1\n"; 2], &[LIMIT]),
        lathe(
            "lathe: waits and shared variables",
            &["N1 M101\n#500=#500+1\nGOTO1\n", "N1 #500=#500-1\nM101\nGOTO1\n"],
            &[LIMIT],
        ),
        lathe(
            "lathe: polling each other",
            &["N1 IF[#500EQ1]GOTO2\n#501=1\nGOTO1\nN2 M30\n", "N1 IF[#501EQ2]GOTO2\n#502=1\nGOTO1\nN2 M30\n"],
            &[LIMIT, 2_900_071, 2_900_072],
        ),
        siemens("siemens: waits at marks without end", &["LOOP\nWAITM(1,1,2)\nSETM(2)\nENDLOOP\n"; 2], &[LIMIT]),
        siemens(
            "siemens: lists that do not correspond",
            &["LOOP\nWAITM(1,2)\nENDLOOP\n", "LOOP\nWAITM(1)\nENDLOOP\n"],
            &[2_900_387],
        ),
        siemens(
            "siemens: starts without end",
            &["%_N_A_MPF\nINIT(2,\"B\")\nLOOP\nSTART(2)\nWAITE(2)\nENDLOOP\nM30\n%_N_B_MPF\nM30\n"],
            &[LIMIT],
        ),
        siemens(
            "siemens: a loop beside an idle channel",
            &["%_N_A_MPF\nLOOP\nG1 X1 F1\nX2\nENDLOOP\nINIT(2,\"B\")\nM30\n%_N_B_MPF\nM30\n"],
            &[LIMIT],
        ),
        isg(
            "isg: signals without end",
            &["$DO\n#SIGNAL [ID1 CH2]\n#SIGNAL [ID2]\n$ENDDO\n", "G04 X1\nM30\n"],
            &[2_900_435],
        ),
        isg(
            "isg: signals there and back without end",
            &["$DO\n#SIGNAL [ID1 CH2]\n#WAIT [ID2 CH2]\n$ENDDO\n", "$DO\n#WAIT [ID1 CH1]\n#SIGNAL [ID2 CH1]\n$ENDDO\n"],
            &[LIMIT],
        ),
        isg("isg: signals that are read without end", &["$DO\n#SIGNAL READ [ID1 CH2]\n$ENDDO\n"; 2], &[LIMIT]),
        many_channels("26 channels that meet", 26, |own| format!("O{own}\nN1 M101 P67108863\nG4 P{own}\nGOTO1\n"))
            .with_options(FEW_BLOCKS),
        many_channels("32 channels that share", 32, |own| format!("O{own}\nN1 #500=#500+{own}\nGOTO1\n"))
            .with_options(FEW_BLOCKS),
        many_channels("32 channels on their own", 32, |own| format!("O{own}\nN1 G0 X{own}.\nX0\nGOTO1\n")),
    ]
}

/// Channels of a mill with an ISG kernel.
fn isg(name: &'static str, programs: &[&str], ends_with: &'static [u32]) -> Case {
    let programs = programs.iter().map(|program| (*program).to_owned()).collect();
    Case::new(name, machine("isg-3channel", "", &[]), programs, ends_with)
}

/// Both channels of a Siemens lathe.
fn siemens(name: &'static str, programs: &[&str], ends_with: &'static [u32]) -> Case {
    let programs = programs.iter().map(|program| (*program).to_owned()).collect();
    Case::new(name, machine("siemens-2channel-exact", "", &[]), programs, ends_with)
}

/// Where small limits are wanted, smaller ones: all channels wait for each other in each block.
const FEW_BLOCKS: fn(&mut JobOptions) = |options| {
    if options.limits.blocks < 1_000_000 {
        options.limits.blocks = 2000;
    }
};

fn many_channels(name: &'static str, channels: u16, program: fn(u16) -> String) -> Case {
    let meets = "[sync]\ndialect = \"fanuc\"\npaths = \"bits\"\n[[codes]]\nid = \"CODE_SYNC_REG\"\nword = \"M100-M199\"\n\
         as_data = \"REG_SYNC\"\n[[data]]\nid = \"REG_SYNC_PATHS\"\nregister = \"P\"\nmin = 0\n";
    // Sums of channels go to 26.
    let mut overlay = if channels > 26 { String::new() } else { meets.to_owned() };
    for number in 1..=channels {
        overlay.push_str(&format!("[[axes]]\nname = \"X{number}\"\nrapid = 10_000\nhome = 0\n"));
        overlay.push_str(&format!("[[channels]]\nnumber = {number}\naxes = [\"X{number}\"]\n"));
    }
    Case::new(
        name,
        machine("fanuc-turning", &format!("{SHARES}{overlay}"), &[]),
        (1..=channels).map(program).collect(),
        &[LIMIT],
    )
}

/// Ten megabytes of lines between a jump and where it goes to.
fn far(first: &str, line: &str, last: &str) -> String {
    format!("{first}{}{last}", line.repeat(10_000_000 / line.len()))
}

fn of_long_programs() -> Vec<Case> {
    let called: String = (1..100_000).map(|number| format!("O{number}\nM98 P{}\nM99\n", number % 9999 + 1)).collect();
    let many_files: Vec<String> = (0..60_000).map(|number| format!("f{number}.nc")).collect();
    vec![
        fanuc("fanuc: jumps over ten megabytes", far("N1 GOTO2\n", "G0 X1. (A LINE)\n", "N2 GOTO1\n"), &[LIMIT]),
        fanuc(
            "fanuc: loops over ten megabytes",
            far("WHILE[1EQ1]DO1\nIF[1EQ1]GOTO2\n", "G0 X#1 (A LINE)\n", "N2 END1\n"),
            &[LIMIT],
        ),
        dialect(
            "siemens: jumps over ten megabytes",
            SIEMENS,
            far("A: GOTOF B\n", "G0 X=R1 ; A LINE\n", "B: GOTOB A\n"),
            &[LIMIT],
        ),
        dialect(
            "okuma: jumps over ten megabytes",
            OKUMA,
            far("NA GOTO NB\n", "G0 X=VC1 (A LINE)\n", "NB GOTO NA\n"),
            &[LIMIT],
        ),
        dialect(
            "heidenhain: jumps over ten megabytes",
            HEIDENHAIN,
            far(
                "BEGIN PGM A MM\nLBL 1\nFN 9: IF +1 EQU +1 GOTO LBL 2\n",
                "L X+Q1 ; A LINE\n",
                "LBL 2\nFN 9: IF +1 EQU +1 GOTO LBL 1\n",
            ),
            &[LIMIT],
        ),
        fanuc("fanuc: a hundred thousand programs", called, &[LIMIT, 2_900_041, 2_900_352]),
        fanuc("fanuc: calls among many files", "O1\nN1 M98 P2\nGOTO1\nO2\nM99\n".into(), &[LIMIT])
            .with_files(many_files),
        fanuc("fanuc: a file of a hundred megabytes", "G0 X1. (A LINE)\n".repeat(100_000_000 / 16), &[LIMIT]),
    ]
}
