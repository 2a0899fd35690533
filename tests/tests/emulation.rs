//! Effects of single blocks, by the reference or the real control.

use counterpoint_kernel::job::ProgramSelection;
use counterpoint_kernel::log::event::{Event, FrameShift, Kind, MotionKind, OperatorMessage};
use counterpoint_kernel::options::{JobOptions, MoveTiming};
use counterpoint_tests::{Done, Work, machine, processors};

fn run_on(name: &str, overlay: &str, text: &str, options: JobOptions) -> Done {
    Work::texts(machine(name, overlay), &[text], options).run(None).expect("the job can be prepared")
}

fn lathe(text: &str) -> Done {
    run_on("fanuc-2path-lathe-exact", "", text, JobOptions::default())
}

fn mill(text: &str) -> Done {
    run_on("fanuc-mill-exact", "", text, JobOptions::default())
}

/// Kind, end by axis and duration in seconds of every motion.
fn motions(done: &Done) -> Vec<(MotionKind, [f64; 3], f64)> {
    let motion = |e: &Event| match &e.kind {
        Kind::Motion(m) => Some((m.kind, [m.to[0], m.to[1], m.to[2]], e.dur_ns as f64 / 1e9)),
        _ => None,
    };
    done.events.iter().filter_map(motion).collect()
}

fn ends(done: &Done) -> Vec<[f64; 3]> {
    motions(done).into_iter().map(|(_, to, _)| to).collect()
}

fn seconds(done: &Done) -> f64 {
    done.summary.channels[0].end_ns as f64 / 1e9
}

fn numbers(done: &Done) -> Vec<u32> {
    done.summary.diagnostics.iter().map(|d| d.number).collect()
}

fn close(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-6, "found {found}, expected {expected}");
}

#[test]
fn optional_skip_by_level() {
    let text = "/G4P1000\nG4P2000\n/2G4P500\n/3G4P100\nM30\n";
    for (levels, expected) in [(vec![], 3.6), (vec![1], 2.6), (vec![2], 3.1), (vec![1, 2, 3], 2.0)] {
        let options = JobOptions { opskip: levels, ..JobOptions::default() };
        close(seconds(&run_on("fanuc-2path-lathe-exact", "", text, options)), expected);
    }
}

#[test]
fn a_skip_mark_inside_a_block_cuts_its_rest() {
    let text = "G98 F600.\nG0 X0. Z0.\nG1 Z-10. /2 X20.\nM30\n";
    let on = JobOptions { opskip: vec![2], ..JobOptions::default() };
    assert_eq!(ends(&run_on("fanuc-2path-lathe-exact", "", text, on)).last(), Some(&[0.0, -10.0, 0.0]));
    assert_eq!(ends(&lathe(text)).last(), Some(&[20.0, -10.0, 0.0]));
}

#[test]
fn incremental_letters_and_modes() {
    let done = lathe("G0 X50. Z10.\nU-4. W-5.\nG1 G98 F1000. X40. W-1.\nM30\n");
    assert_eq!(ends(&done)[1..], [[46.0, 5.0, 0.0], [40.0, 4.0, 0.0]]);
    let done = mill("G0 X10. Y10. Z10.\nG91 X5. Y-5.\nG90 X0.\nM30\n");
    assert_eq!(ends(&done)[1..], [[15.0, 5.0, 10.0], [0.0, 5.0, 10.0]]);
}

#[test]
fn diameters_count_half_in_geometry() {
    // 20 mm in diameter are 10 mm of cut: 1 s at 600 mm/min.
    let done = lathe("G98 F600.\nG0 X50. Z0.\nG1 X30.\nM30\n");
    let (_, _, time) = motions(&done)[1];
    close(time, 1.0);
}

#[test]
fn arcs_by_centre_and_radius_in_all_planes() {
    let quarter = std::f64::consts::FRAC_PI_2 * 10.0 / 600.0 * 60.0;
    for (plane, start, arc) in [
        ("G17", "X0. Y0. Z0.", "G2 X10. Y10. I10. J0."),
        ("G17", "X0. Y0. Z0.", "G3 X10. Y10. R10."),
        ("G18", "X0. Y0. Z0.", "G2 X10. Z10. I0. K10."),
        ("G19", "X0. Y0. Z0.", "G3 Y10. Z10. J0. K10."),
    ] {
        let done = mill(&format!("{plane} G94 F600.\nG0 {start}\n{arc}\nM30\n"));
        assert_eq!(numbers(&done), [0_u32; 0], "{plane} {arc}");
        let (_, _, time) = *motions(&done).last().unwrap();
        close(time, quarter);
    }
    let full = mill("G17 G94 F600.\nG0 X10. Y0. Z0.\nG2 I-10.\nM30\n");
    close(motions(&full).last().unwrap().2, 4.0 * quarter);
    let long_way = mill("G17 G94 F600.\nG0 X0. Y0. Z0.\nG3 X10. Y10. R-10.\nM30\n");
    close(motions(&long_way).last().unwrap().2, 3.0 * quarter);
}

#[test]
fn impossible_arcs_are_told() {
    assert_eq!(numbers(&mill("G94 F600.\nG0 X0. Y0. Z0.\nG2 X10. Y0. R2.\nM30\n")), [2007020]);
    assert_eq!(numbers(&mill("G94 F600.\nG0 X0. Y0. Z0.\nG2 X10. Y0. I4. J0.\nM30\n")), [2900020]);
}

#[test]
fn feeds_need_a_value_and_a_turning_spindle() {
    assert_eq!(numbers(&lathe("G99\nG1 X10.\nM30\n")), [2019001]);
    assert_eq!(numbers(&lathe("G98 F0.\nG1 X10.\nM30\n")), [2019002]);
    assert_eq!(numbers(&lathe("G99 F0.2\nG1 X10.\nM30\n")), [2900021]);
    // 100 mm at 0.2 mm/rev and 1000 rev/min: 30 s.
    let done = lathe("G99 G97 S1000 M3\nG0 X50. Z100.\nG1 Z0. F0.2\nM30\n");
    close(motions(&done)[1].2, 30.0);
}

#[test]
fn inverse_time_holds_for_its_block() {
    let done = mill("G93\nG1 X10. F2.\nM30\n");
    close(motions(&done)[0].2, 30.0);
    assert_eq!(numbers(&mill("G93\nG1 X10. F2.\nX20.\nM30\n")), [2019001]);
}

#[test]
fn threads_follow_the_spindle() {
    // 21 mm at a lead of 1.5 and 900 rev/min.
    let done = lathe("G97 S900 M3\nG0 X20. Z5.\nG32 Z-16. F1.5\nM30\n");
    assert_eq!(motions(&done)[1].0, MotionKind::Thread);
    close(motions(&done)[1].2, 21.0 / 1.5 / 900.0 * 60.0);
}

#[test]
fn rapids_go_at_the_slowest_axis() {
    // X 100 mm in diameter at 20 m/min: 0.15 s; Z 240 mm at 24 m/min: 0.6 s.
    let done = lathe("G0 X200. Z260.\nM30\n");
    close(motions(&done)[0].2, 0.6);
}

#[test]
fn home_moves_via_the_programmed_point() {
    let done = lathe("G0 X50. Z10.\nG28 U0 W0\nM30\n");
    assert_eq!(ends(&done).last(), Some(&[300.0, 500.0, 0.0]));
    let done = lathe("G0 X50. Z10.\nG28 X100. Z20.\nG29 X60. Z0.\nM30\n");
    let ends = ends(&done);
    assert_eq!(ends[1..], [[100.0, 20.0, 0.0], [300.0, 500.0, 0.0], [100.0, 20.0, 0.0], [60.0, 0.0, 0.0]]);
}

#[test]
fn presets_and_work_offsets_move_the_frame_not_the_machine() {
    let offsets = "[[work_offsets]]\nnumber = 2\nvalues = { X = 100.0 }\n";
    let done =
        run_on("fanuc-mill-exact", offsets, "G0 X10. Y0. Z0.\nG55 X10.\nG92 X0.\nX5.\nM30\n", JobOptions::default());
    let machine_x: Vec<f64> = {
        let mut shift = 0.0;
        let mut out = Vec::new();
        for event in &done.events {
            match &event.kind {
                Kind::Frame(FrameShift { shift: s }) => shift = s[0],
                Kind::Motion(m) => out.push(m.to[0] + shift),
                _ => {}
            }
        }
        out
    };
    assert_eq!(machine_x, [10.0, 110.0, 115.0]);
}

#[test]
fn inches_are_converted() {
    let done = mill("G20 G94 F10.\nG0 X1. Y0. Z0.\nG1 X2.\nM30\n");
    assert_eq!(ends(&done), [[25.4, 0.0, 0.0], [50.8, 0.0, 0.0]]);
    close(motions(&done)[1].2, 6.0);
}

#[test]
fn subprograms_repeat_nest_and_return() {
    let text = "O1\nM98 P30002\nM98 P3 L2\nM30\nO2\nG4P100\nM99\nO3\nG4P1000\nM98 P2\nM99\n";
    close(seconds(&lathe(text)), 0.3 + 2.0 * 1.1);
}

#[test]
fn return_to_a_sequence_number() {
    let text = "O1\nM98 P2\nG4P5000\nN50 G4P100\nM30\nO2\nG4P10\nM99 P50\n";
    close(seconds(&lathe(text)), 0.11);
}

#[test]
fn subprogram_files_beside_the_program() {
    let mut work =
        Work::texts(machine("fanuc-2path-lathe-exact", ""), &["M98 P1234\nM98 P7\nM30\n"], JobOptions::default());
    work.files.insert("O1234.nc", "G4P100\nM99\n");
    work.files.insert("p1_7.tps", "G4P10\nM99\n");
    close(seconds(&work.run(None).unwrap()), 0.11);
}

#[test]
fn macro_calls_have_their_own_locals() {
    let text = "O1\n#1=7\nG65 P9 A250. B2\nG4P[#1]\nM30\nO9\nG4P[#1*#2]\n#1=0\nM99\n";
    close(seconds(&lathe(text)), 0.5 + 0.007);
}

#[test]
fn branches_of_the_macro_language() {
    let text =
        "#1=3\nIF[#1GT2]THEN #2=100\nIF[#1EQ3]THEN\nG4P[#2]\nELSE\nG4P9000\nENDIF\nIF[#1LT3]GOTO9\nG4P1\nN9 M30\n";
    close(seconds(&lathe(text)), 0.101);
}

#[test]
fn times_of_the_machine_table() {
    let overlay = "[time]\ntool_change = 2.0\ntool_step = 0.5\nstations = 12\n\n[time.m_codes]\n3 = 1.5\n70 = 0.25\n";
    let done = run_on(
        "fanuc-2path-lathe-exact",
        overlay,
        "T0101\nT0404\nT0404\nG97 S500 M3\nM70\nM30\n",
        JobOptions::default(),
    );
    // The machine has no tool offsets.
    assert_eq!(numbers(&done), [2900024]);
    close(seconds(&done), 2.0 + (2.0 + 3.0 * 0.5) + 1.5 + 0.25);
}

#[test]
fn acceleration_counts_for_rapids_and_exact_stop() {
    let overlay = "[[axes]]\nname = \"Z1\"\nrapid = 6000\nhome = 500\nacceleration = 1000\n";
    // 100 mm at 100 mm/s and 1000 mm/s²: 1.1 s. The feed moves speed up once and brake once; with simple times the
    // plain one takes 1.0 s, and the one with exact stop does both.
    let text = "G98 F6000.\nG0 Z400.\nG1 Z300.\nG9 G1 Z200.\nM30\n";
    let [usual, simple] = [MoveTiming::default(), MoveTiming::SIMPLE];
    for (timing, expected) in [(usual, [1.1, 1.05, 1.05]), (simple, [1.1, 1.0, 1.1])] {
        let done = run_on("fanuc-2path-lathe-exact", overlay, text, JobOptions { timing, ..JobOptions::default() });
        let times: Vec<f64> = motions(&done).into_iter().map(|(_, _, t)| t).collect();
        for (found, expected) in times.iter().zip(expected) {
            close(*found, expected);
        }
    }
}

#[test]
fn operator_messages_reach_the_log() {
    let overlay = "[format]\nmessage = [\"{\", \"}\"]\n";
    let done = run_on("fanuc-mill-exact", overlay, "G0 X1. {CHECK CLAMP} (remark)\nM30\n", JobOptions::default());
    assert_eq!(messages(&done), ["CHECK CLAMP"]);
    assert_eq!(numbers(&mill("G0 X1. (no end\nM30\n")), [2900010]);
}

fn messages(done: &Done) -> Vec<&str> {
    let events = done.events.iter();
    events
        .filter_map(|e| if let Kind::Message(OperatorMessage { text, .. }) = &e.kind { Some(&**text) } else { None })
        .collect()
}

#[test]
fn messages_of_statements_show_on_every_pass() {
    let overlay = "[format]\nmessage = [\"{\", \"}\"]\n";
    let text = "O1\n#1=0\nWHILE[#1LT3]DO1\n#1=#1+1 {COUNT}\nG0 X#1 {MOVE}\nG65 P50 A#1 {CALL}\nEND1\n\
                G65 P50 {LAST}\nM30\nO50\nG4 P1\nM99\n";
    let done = run_on("fanuc-mill-exact", overlay, text, JobOptions::default());
    let pass = ["COUNT", "MOVE", "CALL"];
    assert_eq!(messages(&done), [&pass[..], &pass, &pass, &["LAST"]].concat());
    assert_eq!(numbers(&done), [0_u32; 0]);
}

#[test]
fn words_that_nothing_uses_are_told() {
    assert_eq!(numbers(&lathe("G4 P10 Q5\nM30\n")), [2900001]);
    assert_eq!(numbers(&lathe("G777\nM30\n")), [2900320]);
    assert_eq!(numbers(&lathe("?? M777\nM30\n")), [2900320]);
    assert_eq!(numbers(&lathe("??\nM30\n")), [2900321]);
    assert_eq!(numbers(&lathe("G0 Y5.\nM30\n")), [2900028]);
}

#[test]
fn several_programs_in_one_file_go_to_the_channels() {
    let text = "%\nO1\nM98 P50\nM101\nM30\nO2\nG4P500\nM101\nM30\nO50\nG4P100\nM99\n%\n";
    let done = lathe(text);
    let programs: Vec<&str> = done.summary.channels.iter().map(|c| c.program.as_str()).collect();
    assert_eq!(programs, ["p1.nc#1", "p1.nc#2"]);
    assert_eq!(done.summary.waits[0].release_ns, Some(500_000_000));
}

/// Programs and sections of one file by their names, each to the next free channel or to its own.
#[test]
fn a_name_inside_the_file_picks_a_program_or_section() {
    let sections = "$1\nG4P100\nM30\n$2\nG4P200\nM30\n$1\nM30\n";
    let heads = "O1\nG13\nG4F1\nM02\nG14\nG4F2\nM02\n";
    let archive = "%_N_UGUD_DEF\nDEF NCK REAL A\n%_N_A_MPF\nG4F1\nM30\n%_N_B_MPF\nG4F2\nM30\n%_N_C_SPF\nM17\n";
    let picked = |machine_name: &str, text: &str, names: &[&str]| {
        let mut work = Work::texts(machine(machine_name, ""), &[text], JobOptions::default());
        let one = |name: &&str| ProgramSelection {
            file: "p1.nc".into(),
            number: None,
            section: Some((*name).into()),
            channel: None,
        };
        work.programs = names.iter().map(one).collect();
        let done = work.run(None).map_err(|error| error.findings[0].to_string())?;
        assert_eq!(format!("{:?}", done.summary.state), "Succeeded", "{:?}", done.summary.diagnostics);
        let used = done.summary.channels.iter().filter(|channel| !channel.program.is_empty());
        let ran = used.map(|channel| format!("{} {}", channel.program, channel.end_ns / 1_000_000));
        Ok::<Vec<String>, String>(ran.collect())
    };
    let ran = |machine: &str, text: &str, names: &[&str]| picked(machine, text, names).unwrap();
    assert_eq!(ran("citizen-3path-swiss", sections, &["$2"]), ["p1.nc#$2 200"]);
    assert_eq!(ran("citizen-3path-swiss", sections, &["$2", "$1"]), ["p1.nc#$1 100", "p1.nc#$2 200"]);
    assert_eq!(ran("okuma-2saddle-lathe", heads, &["g14"]), ["p1.nc#1 2000"]);
    assert_eq!(ran("siemens-2ch-millturn", archive, &["B"]), ["p1.nc#B 2000"]);
    assert_eq!(ran("siemens-2ch-millturn", archive, &["%_N_B_MPF", "a.mpf"]), ["p1.nc#B 2000", "p1.nc#A 1000"]);
    for (machine, text, name, says) in [
        ("citizen-3path-swiss", sections, "$3", "program or section $3 not found in the file, which has $1, $2"),
        ("okuma-2saddle-lathe", heads, "G15", "program or section G15 not found in the file, which has G13, G14"),
        (
            "siemens-2ch-millturn",
            archive,
            "D",
            "program or section D not found in the file, which has UGUD_DEF, A, B, C",
        ),
    ] {
        let refused = picked(machine, text, &[name]).unwrap_err();
        assert!(refused.contains(says), "{refused}");
    }
}

/// One processor, two, free and beside busy threads, with few threads and many.
#[test]
fn everywhere() {
    processors::everywhere(&processors::FEW_SETTINGS, "everywhere", &[]);
}
