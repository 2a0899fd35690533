//! Tests of the listing; the layouts are those of the reference.

use super::*;
use crate::testing::*;
use counterpoint_event::event::{
    BlockEvent, Dwell, FeedUnit, FrameShift, Motion, MotionKind, Phase, SpindleChange, SpindleDirection, ToolAction,
    ToolChange,
};

const S: i64 = 1_000_000_000;

fn summary_of(info: &std::sync::Arc<Info>, events: &[Event]) -> Summary {
    results(info, events, &outcome(events.len())).summary
}

fn listing(info: &std::sync::Arc<Info>, channel: u16, events: &[Event]) -> String {
    let mut out = Vec::new();
    let summary = summary_of(info, events);
    render(info, channel, &summary, &mut (1..).zip(events.iter().cloned()), &mut out).unwrap();
    String::from_utf8(out).unwrap()
}

/// One tool turns a diameter, then stops for a while.
fn turning() -> Vec<Event> {
    let spindle = SpindleChange {
        spindle: 1,
        direction: SpindleDirection::Clockwise,
        css: false,
        speed: 950.0,
        limit: f64::INFINITY,
        angle: 0.0,
    };
    let cut = |from: &[f64], to: &[f64], feed| Motion {
        feed,
        feed_unit: FeedUnit::PerRevolution,
        ..motion(MotionKind::Linear, from, to)
    };
    vec![
        at(1, 1, 0, 0, Kind::Block(BlockEvent { number: 1, unit_named: false })),
        at(1, 1, 0, 0, Kind::Frame(FrameShift { shift: Box::new(position(&[1.5, -100.0])) })),
        at(1, 2, 0, 0, Kind::Block(BlockEvent { number: 2, unit_named: false })),
        at(1, 2, 0, 4 * S, Kind::Tool(ToolChange { action: ToolAction::Load, tool: 3, offset: 3 })),
        at(1, 2, 4 * S, 0, Kind::Spindle(spindle)),
        at(1, 2, 4 * S, 12 * S, Kind::Motion(motion(MotionKind::Rapid, &[60.5, 250.0, 0.0], &[0.0, 0.0, 90.5]))),
        diagnostic(1, 2, 16 * S, 2_001_005, 4, "Q7 not recognised in 'N60 G1 X15. Q7'"),
        at(1, 3, 16 * S, 0, Kind::Block(BlockEvent { number: 3, unit_named: false })),
        at(1, 3, 16 * S, 100 * S, Kind::Motion(cut(&[0.0, 0.0, 90.5], &[18.0, -20.0, 90.5], 0.15))),
        at(1, 3, 116 * S, 90 * S, Kind::Motion(cut(&[18.0, -20.0, 90.5], &[18.0, 0.0, 90.5], 0.3))),
        life(1, 206 * S, Phase::ProgramEnd),
    ]
}

#[test]
fn the_whole_listing_of_one_channel() {
    let info = lathe(&["%\nN10 G21 G90\n  N20 G1 X18. Z6.5 F.3 S950 M3 (FIRST CUT)"]);
    let expected = "\
Counterpoint
(c) the Counterpoint project, MIT or Apache-2.0

Control Emulator Counterpoint Version 0.1.0

Input:        jobs/p1.nc
CE:           lathe2,2.260;1
Database:     lathe2/machine.toml

1! %
2! N10 G21 G90
Warning: Q7 not recognised in 'N60 G1 X15. Q7'
  SEVERITY(04) LINE(00002) ERRNUM(02001005) INPUT(p1.nc)
3!   N20 G1 X18. Z6.5 F.3 S950 M3 (FIRST CUT)

TOOLING SUMMARY:

     TOOL  NAME              DIAMETER    RADIUS  LENGTH-OFFSETS  DIAM-OFFSETS
        3  NA                      NA        NA               3            NA

     TOOL   MIN-FEED   MAX-FEED  MIN-RPM  MAX-RPM      FEED     RAPID      MISC     TOTAL
        3     0.1500     0.3000      950      950  00:03:10  00:00:12  00:00:04  00:03:26

TRAVEL SUMMARY (FEED):

AXIS        MINIMUM      MAXIMUM        TOTAL        ACCUM

X            1.5000      19.5000      18.0000      18.0000
Z         -120.0000    -100.0000      20.0000      40.0000

TRAVEL SUMMARY (RAPID):

AXIS        MINIMUM      MAXIMUM        TOTAL        ACCUM

X            1.5000      62.0000      60.5000      60.5000
Z         -100.0000     150.0000     250.0000     250.0000
C            0.000       90.500       90.500       90.500

TRAVEL SUMMARY (TOTAL):

AXIS        MINIMUM      MAXIMUM        TOTAL        ACCUM

X            1.5000      62.0000      60.5000      78.5000
Z         -120.0000     150.0000     270.0000     290.0000
C            0.000       90.500       90.500       90.500

TYPE       HH:MM:SS      PERCENT

FEED       00:03:10       92.233
RAPID      00:00:12        5.825
MISC       00:00:04        1.942

TOTAL      00:03:26

TYPE      TOTAL

MESSAGE       0
WARNING       1
ERROR         0
FATAL         0

TOTAL         1
";
    assert_eq!(listing(&info, 1, &turning()), expected.replace("0.1.0", env!("CARGO_PKG_VERSION")));
}

#[test]
fn several_kernels_show_waits_idle_time_and_kernel_names() {
    let info = lathe(&["G4P1000\nM101\n", "M101 P12\nG4 P2000"]);
    let mut events = vec![
        at(1, 1, 0, 0, Kind::Block(BlockEvent { number: 1, unit_named: false })),
        at(1, 1, 0, 2 * S, Kind::Dwell(Dwell)),
        at(2, 1, 0, 0, Kind::Block(BlockEvent { number: 1, unit_named: false })),
        wait(2, 1, 0, "M101 P12", &[1, 2]),
        at(1, 2, 2 * S, 0, Kind::Block(BlockEvent { number: 2, unit_named: false })),
        wait(1, 2, 2 * S, "M101 P12", &[1, 2]),
        release(1, 2, 2 * S, 2 * S, "M101 P12", 1),
        release(2, 1, 0, 2 * S, "M101 P12", 1),
        diagnostic(2, 1, 2 * S, 2_900_050, 12, "alarm"),
        diagnostic(0, 0, 2 * S, 2_900_071, 16, "deadlock"),
        at(2, 2, 2 * S, 0, Kind::Block(BlockEvent { number: 2, unit_named: false })),
        wait(2, 2, 2 * S, "M102", &[1, 2]),
    ];
    let upper = listing(&info, 1, &events);
    assert!(upper.contains("\n1! G4P1000\n2! M101\nwait mark=101 until 000:02.000\nFatal: deadlock\n"), "{upper}");
    assert!(!upper.contains("alarm") && upper.contains("INPUT(-) KERNEL(MASTER)\n"));
    let lower = listing(&info, 2, &events);
    assert!(lower.contains("1! M101 P12\nwait mark=101 until 000:02.000\nError: alarm\n  SEVERITY(12) LINE(00001) ERRNUM(02900050) INPUT(p2.nc) KERNEL(LOWER)\n"), "{lower}");
    assert!(lower.contains("2! G4 P2000\nwait mark=102 never released\n\nTOOLING"), "{lower}");
    assert!(lower.contains("IDLE       00:00:02      100.000\n\nTOTAL      00:00:02\n"), "{lower}");
    assert!(lower.contains("Input:        jobs/p1.nc\nInput:        jobs/p2.nc\n"));
    events.truncate(8);
    let summary = summary_of(&info, &events);
    let mut out = Vec::new();
    render_merged(&info, &summary, &mut (1..).zip(events.iter().cloned()), &mut out).unwrap();
    let merged = String::from_utf8(out).unwrap();
    let expected = "\
K1 t=000:00.000 1! G4P1000
K2 t=000:00.000 1! M101 P12
K2 t=000:00.000 wait mark=101 until 000:02.000
K1 t=000:02.000 2! M101
K1 t=000:02.000 wait mark=101 until 000:02.000

KERNEL 1 UPPER

TYPE       HH:MM:SS      PERCENT
";
    assert!(merged.contains(expected), "{merged}");
    assert!(merged.ends_with("TOTAL      00:00:02\n\nNO DIAGNOSTICS\n"), "{merged}");
}

#[test]
fn long_texts_wrap_under_themselves() {
    let text = "word ".repeat(40);
    let listing = listing(&lathe(&["x"]), 1, &[diagnostic(1, 1, 0, 1, 0, text.trim_end())]);
    let lines: Vec<&str> = listing.lines().skip_while(|l| !l.starts_with("Message")).take(3).collect();
    assert_eq!(lines[0], format!("Message: {}", "word ".repeat(20).trim_end()));
    assert_eq!(lines[1], format!("         {}", "word ".repeat(20).trim_end()));
    assert_eq!(lines[2], "  SEVERITY(00) LINE(00001) ERRNUM(00000001) INPUT(p1.nc)");
}

#[test]
fn arcs_travel_to_their_extremes() {
    let circle =
        Motion { center: [0.0, 0.0], plane_axes: [1, 0], ..motion(MotionKind::ArcCw, &[0.0, 10.0], &[0.0, 10.0]) };
    let listing = listing(&lathe(&["x"]), 1, &[at(1, 1, 0, S, Kind::Motion(circle))]);
    assert!(listing.contains("\nX          -20.0000      20.0000      40.0000      80.0000\n"), "{listing}");
    assert!(listing.contains("\nZ          -10.0000      10.0000      20.0000      40.0000\n"), "{listing}");
}

#[test]
fn surface_speed_counts_by_the_mean_of_each_motion() {
    let mut events = turning();
    let css = SpindleChange {
        spindle: 1,
        direction: SpindleDirection::Clockwise,
        css: true,
        speed: 200.0,
        limit: 3000.0,
        angle: 0.0,
    };
    events[4] = at(1, 2, 4 * S, 0, Kind::Spindle(css));
    let listing = listing(&lathe(&["x"]), 1, &events);
    // 20 mm at 0.3 mm/rev in 90 s: 44.4 rev/min.
    assert!(listing.contains("0.3000       44      108  00:03:10"), "{listing}");
}

#[test]
fn severities_have_their_words_and_are_counted_by_them() {
    let severities = [0, 3, 4, 7, 8, 15, 16, 99];
    let events: Vec<Event> = severities.iter().map(|s| diagnostic(1, 1, 0, 2_001_005, *s, "text")).collect();
    let listing = listing(&lathe(&["x"]), 1, &events);
    let words = ["Message", "Message", "Warning", "Warning", "Error", "Error", "Fatal", "Fatal"];
    for (word, severity) in words.into_iter().zip(severities) {
        let two = format!("\n{word}: text\n  SEVERITY({severity:02}) LINE(00001) ERRNUM(02001005) INPUT(p1.nc)\n");
        assert!(listing.contains(&two), "{listing}");
    }
    let counts =
        "\nTYPE      TOTAL\n\nMESSAGE       2\nWARNING       2\nERROR         2\nFATAL         2\n\nTOTAL         8\n";
    assert!(listing.ends_with(counts), "{listing}");
}

#[test]
fn the_log_file_has_diagnostics_and_summaries_but_no_trace() {
    let info = lathe(&["%\nN10 G21 G90\n  N20 G1 X18. Z6.5 F.3 S950 M3 (FIRST CUT)"]);
    let events = turning();
    let summary = summary_of(&info, &events);
    let mut out = Vec::new();
    render_log(&info, 1, &summary, &mut (1..).zip(events.iter().cloned()), &mut out).unwrap();
    let log = String::from_utf8(out).unwrap();
    let whole = listing(&info, 1, &events);
    let without: String = whole.split_inclusive('\n').filter(|l| l.get(1..3) != Some("! ")).collect();
    assert_eq!(log, without);
    assert!(log.contains("INPUT(p1.nc)\n\nTOOLING SUMMARY:\n"), "{log}");
}

#[test]
fn offsets_are_joined_by_commas_and_tools_stand_in_load_order() {
    let load = |second: i64, tool, offset| {
        at(1, 1, second * S, 0, Kind::Tool(ToolChange { action: ToolAction::Load, tool, offset }))
    };
    let listing = listing(&lathe(&["x"]), 1, &[load(0, 12, 12), load(1, 3, 3), load(2, 12, 14)]);
    let first = listing.find("       12  NA                      NA        NA           12,14            NA\n");
    let second = listing.find("        3  NA                      NA        NA               3            NA\n");
    assert!(first.is_some() && first < second, "{listing}");
    assert!(listing.contains("       12         NA         NA       NA       NA  00:00:00"), "{listing}");
}

#[test]
fn each_time_is_rounded_by_itself_and_the_total_from_the_sum() {
    let part = |number: i64, kind| at(1, 1, number * S * 2 / 5, S * 2 / 5, kind);
    let cut = Motion { feed: 100.0, ..motion(MotionKind::Linear, &[1.0], &[2.0]) };
    let rapid = motion(MotionKind::Rapid, &[0.0], &[1.0]);
    let events = [
        part(0, Kind::Motion(rapid)),
        part(1, Kind::Motion(cut)),
        part(2, Kind::Dwell(Dwell)),
        life(1, S * 6 / 5, Phase::ProgramEnd),
    ];
    let listing = listing(&lathe(&["x"]), 1, &events);
    let table = "\
TYPE       HH:MM:SS      PERCENT

FEED       00:00:00       33.333
RAPID      00:00:00       33.333
MISC       00:00:00       33.333

TOTAL      00:00:01
";
    assert!(listing.contains(table), "{listing}");
}

#[test]
fn the_operation_stands_before_the_kernel() {
    let mut event = diagnostic(2, 1, 0, 2_001_005, 4, "text");
    if let Kind::Diagnostic(diagnostic) = &mut event.kind {
        diagnostic.operation = "ROUGH".into();
        diagnostic.kernel = "TURRET".into();
    }
    let listing = listing(&lathe(&["x", "y"]), 2, &[event]);
    let line = "  SEVERITY(04) LINE(00001) ERRNUM(02001005) INPUT(p2.nc) OPER(ROUGH) KERNEL(TURRET)\n";
    assert!(listing.contains(line), "{listing}");
}
