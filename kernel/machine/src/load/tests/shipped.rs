//! The machines shipped with the project.

use super::*;
use crate::ident::{codes, data};
use crate::index::places;
use crate::model::{AlarmScope, CallForm, Machine, MachineKind, MainReturn, PathsForm};
use crate::model::{RewindStop, SyncDialect};
use crate::package;
use crate::rows::CodeForm;
use crate::show::{Show, show};
use counterpoint_event::MachineUnit;

fn shipped(name: &str) -> Machine {
    let loaded = load(&package::shipped(), name);
    assert_eq!(loaded.findings, [], "{name}");
    loaded.machine.unwrap()
}

/// The code a word means when no other word is in the block.
fn meaning(machine: &Machine, letter: char, value: f64) -> Vec<&str> {
    let (register, _) = machine.tables.letter[letter as usize].unwrap();
    let rows = machine.tables.code(register, value);
    rows.iter().map(|row| machine.code_name(machine.codes[*row].id)).collect()
}

#[test]
fn all_machines_load_without_a_finding() {
    assert_eq!(
        package::shipped_names(),
        [
            "biglia-b",
            "citizen-3system",
            "citizen-k16",
            "composite-millturn",
            "fanuc-2path-lathe",
            "fanuc-3path-lathe",
            "fanuc-horizontal",
            "fanuc-lathe",
            "fanuc-lathe-b",
            "fanuc-lathe-c",
            "fanuc-lathe-subspindle",
            "fanuc-mill",
            "fanuc-mill-4axis",
            "fanuc-mill-5axis",
            "fanuc-swiss-goodway",
            "fanuc-swiss-hanwha",
            "fanuc-twin-head",
            "fanuc-twin-spindle",
            "grbl-router",
            "grblhal-router-4axis",
            "haas-lathe",
            "haas-lathe-ds",
            "haas-mill",
            "haas-mill-4axis",
            "haas-mill-turn",
            "heidenhain-mill",
            "heidenhain-mill-5axis",
            "isg-3channel",
            "linuxcnc-mill",
            "mazak-eia-lathe",
            "mazak-eia-mill",
            "mazak-horizontal",
            "mazak-integrex",
            "merging-lathe",
            "mitsubishi-mill",
            "okuma-2turret",
            "okuma-horizontal",
            "okuma-lathe",
            "okuma-lathe-subspindle",
            "okuma-mill",
            "siemens-2channel",
            "siemens-lathe",
            "siemens-mill",
            "siemens-mill-5axis",
            "tern-bar-lathe",
        ]
    );
    for name in package::shipped_names() {
        assert_eq!(shipped(&name).name, name);
    }
}

#[test]
fn families_say_that_they_are_families_and_nothing_else() {
    for name in [
        "fanuc-common",
        "fanuc-turning",
        "fanuc-swiss",
        "fanuc-milling",
        "haas-milling",
        "haas-turning",
        "mitsubishi-milling",
        "siemens-common",
        "siemens-milling",
        "siemens-turning",
        "heidenhain-milling",
        "isg-common",
        "rs274-common",
        "linuxcnc-common",
        "okuma-common",
        "okuma-milling",
        "okuma-turning",
    ] {
        let loaded = load(&package::shipped(), name);
        assert!(loaded.machine.is_none());
        assert_eq!(loaded.findings.len(), 1, "{:?}", loaded.findings);
        assert!(loaded.findings[0].text.contains("is a family"));
    }
}

#[test]
fn the_two_path_lathe_has_these_codes() {
    let lathe = shipped("fanuc-2path-lathe");
    let expected = "\
G0 CODE_RAPID 500 1
G1 CODE_INTERP_LINEAR 500 1
G2 CODE_INTERP_ARC_CLW 500 1
G3 CODE_INTERP_ARC_CCLW 500 1
G4 CODE_DELAY 300 0
G5 CODE_IGNORE 999 0
G5.1 CODE_IGNORE 999 0
G7.1 CODE_CYLINDER_ON 100 26
G8 CODE_IGNORE 999 0
G9 CODE_EXACTSTOP 100 15
G10 CODE_OFFSET_SET 100 0
G11 CODE_IGNORE 999 0
G12.1 CODE_C2P_CART_ON 100 26
G13.1 CODE_C2P_CART_OFF 100 26
G17 CODE_PLANE_XY 100 2
G18 CODE_PLANE_ZX 100 2
G19 CODE_PLANE_YZ 100 2
G20 CODE_UNITS_SECONDARY 100 6
G21 CODE_UNITS_PRIMARY 100 6
G22 CODE_STORED_LIMIT_ON 100 152
G23 CODE_STORED_LIMIT_OFF 100 152
G25 CODE_IGNORE 999 0
G26 CODE_IGNORE 999 0
G27 CODE_GOHOME_CHECK 450 0
G28 CODE_GOHOME 450 0
G29 CODE_GOHOME_RETURN 450 0
G30 CODE_GOHOME_NTH 450 0
G30.1 CODE_GOHOME_FLOATING 450 0
G31 CODE_FIXED_STOP_MOVE 450 0
G31 CODE_INTERP_SKIP 500 1
G32 CODE_INTERP_THREAD 500 1
G34 CODE_INTERP_THREAD_VAR 500 1
G35 CODE_INTERP_THREAD_ARC_CLW 500 1
G36 CODE_TOOL_MEASURE 450 0
G36 CODE_INTERP_THREAD_ARC_CCLW 500 1
G37 CODE_TOOL_MEASURE 450 0
G40 CODE_COMP_DIAM_OFF 100 7
G41 CODE_COMP_DIAM_LEFT 100 7
G42 CODE_COMP_DIAM_RIGHT 100 7
G49 CODE_IGNORE 999 0
G50 CODE_SPINDLE_MAXRPM 100 0
G50 CODE_POSITION_PRESET 450 0
G50.2 CODE_POLYGON_OFF 100 120
G50.3 CODE_POSITION_PRESET_OFF 450 0
G50.4 CODE_COUPLE_SYNCHRONOUS_OFF 100 0
G50.5 CODE_COUPLE_COMPOSITE_OFF 100 0
G50.6 CODE_COUPLE_SUPERIMPOSED_OFF 100 0
G51.2 CODE_POLYGON_ON 100 120
G51.4 CODE_COUPLE_SYNCHRONOUS 100 0
G51.5 CODE_COUPLE_COMPOSITE 100 0
G51.6 CODE_COUPLE_SUPERIMPOSED 100 0
G52 CODE_LCS_TRANSLATE_ON 100 17
G53 CODE_POSITION_MACHINE 100 0
G54 CODE_COMP_EXTFIXT 100 14
G54-G59 CODE_COMP_WORKP_ON 100 14
G54.1 CODE_COMP_EXTFIXT 100 14
G61 CODE_EXACTSTOP_ON 100 15
G64 CODE_EXACTSTOP_OFF 100 15
G68 CODE_BALANCE_ON 100 0
G68.1 CODE_LCS_ROTATE_ON 100 16
G69 CODE_BALANCE_OFF 100 0
G69 CODE_IGNORE 999 0
G69.1 CODE_LCS_ROTATE_OFF 100 16
G70 CODE_TURN_FINISH 500 1
G71 CODE_TURN_ROUGH 500 1
G72 CODE_TURN_ROUGH_FACE 500 1
G73 CODE_TURN_PATTERN 500 1
G74 CODE_TURN_PECK 500 1
G75 CODE_TURN_GROOVE 500 1
G76 CODE_THREAD_MULTI 500 1
G80 CODE_CYCLE_OFF 400 9
G83 CODE_CYCLE_DEEP 400 9
G84 CODE_CYCLE_TAP 400 9
G85 CODE_CYCLE_REAM_DWELL 400 9
G87 CODE_CYCLE_DEEP 400 9
G88 CODE_CYCLE_TAP 400 9
G89 CODE_CYCLE_REAM_DWELL 400 9
G90 CODE_TURN_SINGLE 500 1
G92 CODE_THREAD_SINGLE 500 1
G94 CODE_TURN_SINGLE_FACE 500 1
G96 CODE_SPINDLE_CSS 299 13
G97 CODE_SPINDLE_RPM 100 13
G98 CODE_FEED_UPM 100 5
G99 CODE_FEED_UPR 100 5
G107 CODE_CYLINDER_ON 100 26
G112 CODE_C2P_CART_ON 100 26
G113 CODE_C2P_CART_OFF 100 26
T0-T99999999 CODE_TOOL_LOAD 95 0
M0 CODE_STOP 900 0
M1 CODE_OPSTOP 900 0
M2 CODE_END 900 0
M3 CODE_SPINDLE_CLW 300 64
M4 CODE_SPINDLE_CCLW 300 64
M5 CODE_SPINDLE_OFF 700 64
M7 CODE_IGNORE 999 0
M8 CODE_COOLANT_FLOOD 300 54
M9 CODE_COOLANT_OFF 700 54
M10-M12 CODE_IGNORE 999 0
M15-M17 CODE_IGNORE 999 0
M18 CODE_IGNORE 999 0
M19 CODE_SPINDLE_ORIENT 700 64
M20-M28 CODE_IGNORE 999 0
M29 CODE_RIGID_ON 399 101
M30 CODE_REWIND 900 0
M31-M39 CODE_IGNORE 999 0
M40-M45 CODE_IGNORE 999 0
M46 CODE_IGNORE 999 0
M48-M52 CODE_IGNORE 999 0
M53-M60 CODE_IGNORE 999 0
M61-M62 CODE_IGNORE 999 0
M68-M69 CODE_IGNORE 999 0
M70-M89 CODE_IGNORE 999 0
M98 CODE_CALSUB_ID 300 0
M99 CODE_CALSUB_RETURN 300 0
M100-M199 CODE_SYNC_REG 100 0
M198 CODE_CALSUB_ID 300 0
";
    let table = show(&lathe, Show::Codes);
    let rows: String = table
        .lines()
        .skip(1)
        .map(|line| line.split_whitespace().take(4).collect::<Vec<_>>().join(" ") + "\n")
        .collect();
    assert_eq!(rows, expected);
}

#[test]
fn the_two_path_lathe_has_these_data() {
    let lathe = shipped("fanuc-2path-lathe");
    let rows: Vec<String> = show(&lathe, Show::Data)
        .lines()
        .skip(1)
        .map(|line| {
            let cells: Vec<&str> = line.split_whitespace().collect();
            [cells[0], cells[1], cells[2], cells[5], cells[6]].join(" ")
        })
        .collect();
    let expected = [
        "O REG_DEFSUB_ID - - none",
        "N REG_SEQNO - - none",
        "X REG_AXIS_X yes - length",
        "X REG_DELAY - - time",
        "X REG_STORED_LIMIT_X - - length",
        "X REG_TURN_ALLOWANCE_X - - length",
        "X REG_TURN_DEPTH_X - - length",
        "X REG_LCS_TRANS_X - - length",
        "X REG_LCS_ROT_CENTER_X - - length",
        "Y REG_AXIS_Y yes - length",
        "Y REG_STORED_LIMIT_Y - - length",
        "Y REG_LCS_TRANS_Y - - length",
        "Y REG_LCS_ROT_CENTER_Y - - length",
        "Z REG_AXIS_Z yes - length",
        "Z REG_STORED_LIMIT_Z - - length",
        "Z REG_TURN_ALLOWANCE_Z - - length",
        "Z REG_TURN_DEPTH_Z - - length",
        "Z REG_LCS_TRANS_Z - - length",
        "Z REG_LCS_ROT_CENTER_Z - - length",
        "A REG_THREAD_MULTI_ANGLE - - angle",
        "C REG_AXIS_CT yes - angle",
        "C REG_C2P_INTERP_Y - - length",
        "C REG_CORNER_SIDE - - length",
        "I REG_ARC_CENTER_X - - length",
        "I REG_STORED_LIMIT_END_X - - length",
        "I REG_THREAD_MULTI_TAPER_X - - length",
        "I REG_TURN_RELIEF_X - - length",
        "I REG_TURN_STEP_X - - length",
        "I REG_TURN_TAPER_X - - length",
        "I REG_LCS_ROT_ANGLE_X - - angle",
        "I REG_CORNER_SIDE_X - - length",
        "J REG_ARC_CENTER_Y - - length",
        "J REG_STORED_LIMIT_END_Y - - length",
        "J REG_LCS_ROT_ANGLE_Y - - angle",
        "K REG_ARC_CENTER_Z - - length",
        "K REG_STORED_LIMIT_END_Z - - length",
        "K REG_INTERP_THREAD_PITCH_VAR - - length",
        "K REG_THREAD_MULTI_HEIGHT_X - - length",
        "K REG_TURN_RELIEF_Z - - length",
        "K REG_TURN_STEP_Z - - length",
        "K REG_TURN_TAPER_Z - - length",
        "K REG_CYCLE_REPEAT - - none",
        "K REG_LCS_ROT_ANGLE_Z - - angle",
        "K REG_CORNER_SIDE_Z - - length",
        "R REG_ARC_RADIUS - - length",
        "R REG_OFFSET_VALUE - - length",
        "R REG_THREAD_SINGLE_TAPER_X - - length",
        "R REG_THREAD_MULTI_FINISH_X - - length",
        "R REG_THREAD_MULTI_TAPER_X - - length",
        "R REG_TURN_RETRACT - - length",
        "R REG_TURN_REPEATS - - none",
        "R REG_TURN_TAPER_X - - length",
        "R REG_TURN_TAPER_Z - - length",
        "R REG_CYCLE_CLEAR - - length",
        "R REG_LCS_ROT_ANGLE - - angle",
        "R REG_CORNER_SIDE_ROUND - - length",
        "P REG_DELAY - *0.001 time",
        "P REG_GOHOME_NTH - - none",
        "P REG_CALSUB_ID - - none",
        "P REG_COMP_EXTFIXT_REG - - none",
        "P REG_OFFSET_NUMBER - - none",
        "P REG_THREAD_MULTI_PWORD - - none",
        "P REG_THREAD_MULTI_HEIGHT_X - *0.001 increments",
        "P REG_THREAD_MULTI_INFEED - - none",
        "P REG_TURN_FIRST - - none",
        "P REG_TURN_STEP_X - *0.001 increments",
        "P REG_CYCLE_DWELL - *0.001 time",
        "P REG_SYNC_PATHS - - none",
        "P REG_COUPLE_MASTER - - none",
        "Q REG_FIXED_STOP_CHECK - - none",
        "Q REG_CALSUB_SEQUENCE - - none",
        "Q REG_OFFSET_TIP - - none",
        "Q REG_INTERP_THREAD_ANGLE - *0.001 angle",
        "Q REG_THREAD_MULTI_STEP_MIN - *0.001 increments",
        "Q REG_THREAD_MULTI_STEP_X - *0.001 increments",
        "Q REG_TURN_LAST - - none",
        "Q REG_TURN_STEP_Z - *0.001 increments",
        "Q REG_CYCLE_STEP - *0.001 increments",
        "Q REG_COUPLE_SLAVE - - none",
        "L REG_CALSUB_REPEAT - - none",
        "L REG_OFFSET_KIND - - none",
        "L REG_CYCLE_REPEAT - - none",
        "L REG_COUPLE_PARKING - - none",
        "F REG_FEED_UPM yes - feed",
        "F REG_FEED_UPR yes - feed",
        "F REG_INTERP_THREAD_PITCH yes - length",
        "S REG_SPINDLE_RPM yes - none",
        "S REG_SPINDLE_CSS yes - surface-speed",
        "S REG_SPINDLE_RPM_MAX yes - none",
        "D REG_THREAD_MULTI_STEP_X - - length",
        "D REG_TURN_DEPTH - *0.001 increments",
        "D REG_TURN_REPEATS - - none",
        ",C REG_CORNER_LEGS - - length",
        ",R REG_CORNER_ROUND - - length",
        ",A REG_LINE_ANGLE - - angle",
    ];
    assert_eq!(rows, expected);
}

#[test]
fn the_two_path_lathe_is_set_up_like_this() {
    let lathe = shipped("fanuc-2path-lathe");
    assert_eq!((lathe.kind, lathe.unit, lathe.preprocessor.row().name), (MachineKind::Lathe, MachineUnit::Mm, "fanuc"));
    let channels: Vec<_> = lathe
        .channels
        .iter()
        .map(|c| (c.number, c.name.as_str(), places(c.axes.as_slice()), c.spindle.map(|id| lathe.spindles[id].number)))
        .collect();
    assert_eq!(channels, [(1, "UPPER", vec![0, 1, 2], Some(1)), (2, "LOWER", vec![3, 4], Some(1))]);
    assert_eq!((lathe.sync.dialect, lathe.sync.paths), (SyncDialect::Fanuc, PathsForm::Either));
    assert_eq!((lathe.sync.alarm_scope, lathe.sync.release_ns, lathe.sync.poll_ns), (AlarmScope::Own, 0, 1_000_000));
    assert_eq!((lathe.format.rws.as_str(), lathe.format.rws_at), ("%", RewindStop::Optional));
    assert!(lathe.format.rws_inline);
    assert_eq!(lathe.format.comment, Some(("(".to_owned(), ")".to_owned())));
    assert_eq!((lathe.format.opskip_mark, lathe.format.opskip_default), (Some('/'), 1));
    assert_eq!((lathe.subprograms.call, lathe.subprograms.main_return), (CallForm::RepeatAndNumber, MainReturn::End));
    assert_eq!(lathe.variables.shared, []);
    assert_eq!(lathe.variables.channel, [(100, 199), (500, 999)]);
    assert_eq!(lathe.tool.offset_digits, 2);
    assert_eq!(lathe.home(&lathe.channels[0])[..3], [0.0, 0.0, 0.0]);
    let part_zeros: Vec<f64> = lathe.axes.iter().map(|axis| axis.positioning.part_zero).collect();
    assert_eq!(part_zeros, [-300.0, -500.0, 0.0, -300.0, -500.0]);
    assert!(lathe.codes.iter().all(|row| row.seconds == 0.0));
    let limited = |axis: &crate::model::Axis| axis.limits.is_some() != axis.role.is_rotary();
    assert!(lathe.axes.iter().all(|axis| axis.dynamics.acceleration.is_some() && limited(axis)));
    let initial: Vec<&str> = lathe.initial.iter().map(|id| lathe.code_name(*id)).collect();
    assert_eq!(initial[..3], ["CODE_RAPID", "CODE_PLANE_ZX", "CODE_FEED_UPR"]);
    assert_eq!(lathe.tables.letter[usize::from(b'U')].map(|(_, incremental)| incremental), Some(true));
    assert_eq!(lathe.tables.letter[usize::from(b'H')].map(|(_, incremental)| incremental), Some(true));
}

#[test]
fn words_of_the_lathe_mean_what_they_say() {
    let lathe = shipped("fanuc-2path-lathe");
    assert_eq!(meaning(&lathe, 'G', 50.0), ["CODE_SPINDLE_MAXRPM", "CODE_POSITION_PRESET"]);
    assert_eq!(meaning(&lathe, 'M', 100.0), ["CODE_SYNC_REG"]);
    assert_eq!(meaning(&lathe, 'M', 199.0), ["CODE_SYNC_REG"]);
    assert_eq!(meaning(&lathe, 'M', 200.0), [""; 0]);
    assert_eq!(meaning(&lathe, 'T', 101.0), ["CODE_TOOL_LOAD"]);
    assert_eq!(meaning(&lathe, 'X', 1.0), [""; 0]);
    let offset = lathe.codes.iter().find(|row| row.id == codes::COMP_WORKP_ON).unwrap();
    assert!(matches!(offset.form, CodeForm::RegisterAsData { data: data::COMP_WORKP, .. }));
    assert_eq!(54.0 * offset.mul + offset.add, 1.0);
}

#[test]
fn the_other_machines_differ_where_they_should() {
    let three = shipped("fanuc-3path-lathe");
    assert_eq!((three.channels.len(), three.sync.paths), (3, PathsForm::List));
    let mill = shipped("fanuc-mill");
    assert_eq!((mill.kind, mill.channels.len(), mill.sync.dialect), (MachineKind::Mill, 1, SyncDialect::None));
    assert_eq!(meaning(&mill, 'G', 91.0), ["CODE_POSITION_RELATIVE"]);
    assert_eq!(meaning(&mill, 'G', 98.0), ["CODE_CYCLE_RETRACT_INITIAL"]);
    assert_eq!(meaning(&mill, 'G', 85.0), ["CODE_CYCLE_REAM"]);
    assert_eq!(meaning(&mill, 'G', 51.0), ["CODE_LCS_SCALE_ON"]);
    assert_eq!(meaning(&mill, 'G', 51.1), ["CODE_LCS_MIRROR_ON"]);
    assert_eq!(meaning(&mill, 'G', 68.0), ["CODE_LCS_ROTATE_ON"]);
    assert_eq!(meaning(&mill, 'G', 86.0), ["CODE_CYCLE_BORE"]);
    assert_eq!(meaning(&mill, 'T', 12.0), ["CODE_TOOL_SELECT"]);
    assert_eq!(meaning(&mill, 'M', 6.0), ["CODE_TOOL_LOAD"]);
    assert_eq!(mill.tables.letter[usize::from(b'U')], None);
    let letters: String = mill.registers.iter().map(|register| register.name.as_str()).collect();
    assert_eq!(letters, "ONGXYZABCIJKRPQLFSTMHD,C,R,A");
    let axes: Vec<&str> = mill.axes.iter().map(|axis| axis.letter.as_str()).collect();
    assert_eq!(axes, ["X", "Y", "Z"]);
}

#[test]
fn a_user_may_extend_a_shipped_machine_and_replace_a_family() {
    let mut user = MemoryFiles::default();
    user.insert("mine/machine.toml", "extends = \"fanuc-2path-lathe\"\n[ce]\nname = \"mine\"\n[time]\ntool_change = 2");
    let files = package::Overlay::over_shipped(user.clone());
    let mine = load(&files, "mine").machine.unwrap();
    assert_eq!((mine.name.as_str(), mine.time.tool_change, mine.channels.len()), ("mine", 2.0, 2));
    assert!(files.list().contains(&"fanuc-mill/machine.toml".to_owned()));
    user.insert("fanuc-2path-lathe/machine.toml", BASE);
    let files = package::Overlay::over_shipped(user);
    assert_eq!(load(&files, "mine").machine.unwrap().channels.len(), 1);
}

#[test]
fn the_example_of_the_documentation_is_complete() {
    let text = include_str!("../../../../../docs/machine-definition.md");
    let example = text.split("```toml\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    let mut user = MemoryFiles::default();
    user.insert("small/machine.toml", example);
    let loaded = load(&package::Overlay::over_shipped(user), "small");
    assert_eq!(loaded.findings, []);
    assert_eq!(loaded.machine.map(|machine| machine.name).as_deref(), Some("small lathe"));
}
