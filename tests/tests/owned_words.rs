//! Every code of every shipped machine beside a word of every axis: nothing moves in such a block unless the table here
//! says so.
//!
//! A code that takes some axis words must not leave others to the active motion code. The table lists the codes that
//! leave axis words to it, as their controls do, and those that move by themselves. *Invariant:* a code that is added
//! to a machine and moves something is either right, and gets a row, or is a mistake.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use counterpoint_kernel::log::event::Kind;
use counterpoint_kernel::machine::Machine;
use counterpoint_kernel::machine::package::shipped_names;
use counterpoint_kernel::machine::rows::{CodeForm, CodeRow};
use counterpoint_kernel::options::{JobLimits, JobOptions};
use counterpoint_tests::{Work, cases, machine};

/// Codes in whose blocks axes may move; a star is the rest of a name.
const MOVES: &[&str] = &[
    // They move as the program says, or by themselves: cycles, threads, reference points, probing.
    "CODE_RAPID",
    "CODE_INTERP_*",
    "CODE_CYCLE_*",
    "CODE_THREAD_*",
    "CODE_TURN_*",
    "CODE_GOHOME*",
    "CODE_RAPID_ONE_WAY",
    "CODE_RETRACT_TOOL",
    "CODE_AXES_BESIDE",
    "CODE_OKUMA_GROOVE",
    "CODE_OKUMA_TAP",
    "CODE_TERN_PARTOFF",
    "CODE_TERN_PROBE",
    // Modes of the motion that may be in its block.
    "CODE_ANGLES_*",
    "CODE_C2P_CART_*",
    "CODE_CONTOUR_*",
    "CODE_CORNER_*",
    "CODE_EXACTSTOP*",
    "CODE_TAPPING_MODE",
    "CODE_TURRET_*",
    "CODE_STORED_LIMIT_OFF",
    "CODE_WORK_AREA_OFF",
    "CODE_WORK_AREA_ON",
    "CODE_FEED_*",
    "CODE_PLANE_*",
    "CODE_POLAR_WORDS_*",
    "CODE_POSITION_ABSOLUTE",
    "CODE_POSITION_MACHINE",
    "CODE_POSITION_RELATIVE",
    "CODE_SMOOTH_IN_*",
    "CODE_SMOOTH_SIDE_*",
    "CODE_UNITS_*",
    "CODE_XAXIS_*",
    // Offsets, compensation and tool centre point control that act in the block of a move.
    "CODE_COMP_*",
    "CODE_RIGID_ON",
    "CODE_RTCP_*",
    "CODE_TILT_CANCEL",
    "CODE_TILT_MOVE",
    "CODE_TILT_NEGATIVE",
    "CODE_TILT_OFF",
    "CODE_TILT_POSITIVE",
    "CODE_TILT_TABLE",
    "CODE_TILT_TURN",
    // The ends of a rotation and of a scale may be beside a move (Fanuc G69, G50).
    "CODE_LCS_ROTATE_OFF",
    "CODE_LCS_SCALE_OFF",
    // Functions of the machine, stops and calls.
    "CODE_CALSUB_RETURN",
    "CODE_CHUCK_*",
    "CODE_COOLANT_*",
    "CODE_COUPLE_SPINDLES*",
    "CODE_END",
    "CODE_FIXED_STOP_*",
    "CODE_FUNCTION",
    "CODE_GOODWAY_*",
    "CODE_HEAD_*",
    "CODE_MORI_*",
    "CODE_OPSTOP",
    "CODE_PART_CUT_OFF",
    "CODE_REWIND",
    "CODE_SPINDLE*",
    "CODE_STOP",
    "CODE_SUBSPINDLE_*",
    "CODE_SWISS_*",
    "CODE_SYNC_*",
    "CODE_TNC_*",
    "CODE_TOOL_*",
    "CODE_TWIN_*",
    // Modes and functions of single controls.
    "CODE_SIEMENS_*",
    "CODE_OKUMA_FACE",
    "CODE_OKUMA_FACE_LINE",
    "CODE_OKUMA_GROUP",
    "CODE_OKUMA_INFEED",
    "CODE_OKUMA_KEYWAY_WORD",
    "CODE_OKUMA_LIVE_SPEED",
    "CODE_OKUMA_LONG_ARC",
    "CODE_OKUMA_NCYL",
    "CODE_OKUMA_OFFSET_GROUP",
    "CODE_OKUMA_RETURN",
    "CODE_OKUMA_RSTRT",
    "CODE_OKUMA_SIDE_END",
    "CODE_OKUMA_SIDE_PLANE",
    "CODE_OKUMA_STEPS",
    "CODE_OKUMA_TOOL",
    "CODE_OKUMA_TURN_OFF",
    "CODE_OKUMA_WORK_ONCE",
];

/// Words that a control takes without effect on path or time, and that leave axis words to the motion code, beside
/// those with M.
const IGNORED: &[&str] = &[
    "AXIS POS",
    "BRISK",
    "CDOF",
    "CDOF2",
    "COMPCAD",
    "COMPCURV",
    "COMPOF",
    "COMPON",
    "COMPSURF",
    "COORD ROT",
    "CPRECOF",
    "CPRECON",
    "CUTCONOF",
    "DIAMCYCOF",
    "DIAMOF",
    "DRFOF",
    "DRIVE",
    "DYNFINISH",
    "DYNNORM",
    "DYNPOS",
    "DYNPREC",
    "DYNROUGH",
    "DYNSEMIFIN",
    "FENDNORM",
    "FFWOF",
    "FFWON",
    "FIFOCTRL",
    "FNORM",
    "G103",
    "G11",
    "G110",
    "G114.1",
    "G13",
    "G130",
    "G140",
    "G15",
    "G187",
    "G25",
    "G26",
    "G290",
    "G37",
    "G40.1",
    "G460",
    "G49",
    "G5",
    "G50.2",
    "G600",
    "G601",
    "G61.1",
    "G61.2",
    "G64",
    "G69",
    "G8",
    "G80",
    "G84",
    "G900",
    "NEWCONF",
    "ORIAXES",
    "ORIC",
    "ORICONCCW",
    "ORICONCW",
    "ORICONIO",
    "ORICONTO",
    "ORID",
    "ORIEULER",
    "ORIPATH",
    "ORIPATHS",
    "ORIPLANE",
    "ORIRPY",
    "ORISOF",
    "ORISON",
    "ORIVECT",
    "OSC",
    "OSD",
    "OSOF",
    "OSS",
    "OSSE",
    "OST",
    "PAROTOF",
    "PATHCTRL AXIS",
    "PATHCTRL VECTOR",
    "REFPNT CENTER- CENTER",
    "REFPNT TIP- CENTER",
    "REFPNT TIP- TIP",
    "RTLIOF",
    "RTLION",
    "SC_SWIVEL",
    "SOFT",
    "SPATH",
    "SPCOF",
    "SPCON",
    "STARTFIFO",
    "STAY",
    "STOPFIFO",
    "TCOABS",
    "TOWSTD",
    "UPATH",
    "WALCS0",
];

/// A row that fits the code, or the word of an ignored one.
fn row_of(id: &str, code: &str) -> Option<&'static str> {
    let mut rows = MOVES.iter().chain(IGNORED).copied();
    if id == "CODE_IGNORE" {
        return if code.starts_with('M') { Some("M") } else { rows.find(|row| *row == code) };
    }
    rows.find(|row| row.strip_suffix('*').map_or(*row == id, |start| id.starts_with(start)))
}

/// How a row is written, with its smallest value.
fn written(machine: &Machine, row: &CodeRow) -> Option<String> {
    match &row.form {
        CodeForm::NotApplicable => None,
        CodeForm::Text(text) => Some(text.clone()),
        CodeForm::Register { register, min, .. } | CodeForm::RegisterAsData { register, min, .. } => {
            Some(format!("{}{min}", machine.registers[*register].before))
        }
    }
}

/// Words of the axes of the first channel: their registers, once each.
fn axis_words(machine: &Machine) -> BTreeSet<String> {
    let channel = machine.channels.first().expect("a machine has channels");
    let ids: Vec<_> = channel.axes.iter().map(|&axis| machine.axes[axis].data).collect();
    let rows = machine.data.iter().filter(|row| row.enable && ids.contains(&row.id));
    rows.filter_map(|row| row.register).map(|register| machine.registers[register].before.clone()).collect()
}

/// The word of the spindle's speed, if the machine has one.
fn speed_word(machine: &Machine) -> Option<String> {
    let row = machine.data.iter().find(|row| row.enable && machine.data_name(row.id) == "REG_SPINDLE_RPM")?;
    row.register.map(|register| machine.registers[register].before.clone())
}

/// A program with these blocks, and the line of the first one.
fn program(machine: &Machine, blocks: &[String]) -> (String, u32) {
    let (head, end, line) = match machine.preprocessor.row().name {
        "heidenhain" => ("BEGIN PGM T MM\nL X+0 R0 F100\n", "END PGM T MM\n", 3),
        "siemens" => ("G1 F100\n", "M30\n", 2),
        _ => ("O1\nG1 F100\n", "M30\n", 3),
    };
    (format!("{head}{}\n{end}", blocks.join("\n")), line)
}

/// Runs blocks as far as the first alarm: the places of those in which something moves, and how many have begun.
fn run(machine: &Arc<Machine>, blocks: &[String]) -> (BTreeSet<usize>, usize) {
    let limits = JobLimits { blocks: 400, ..JobLimits::default() };
    let options = JobOptions { limits, threads: 1, ..JobOptions::default() };
    let (text, first) = program(machine, blocks);
    let mut texts = vec![text];
    texts.extend((1..machine.channels.len()).map(|_| "M30\n".to_owned()));
    let Ok(done) = Work::texts(machine.clone(), &texts, options).run(None) else {
        return (BTreeSet::new(), blocks.len());
    };
    let places = |wanted: fn(&Kind) -> bool| {
        let events = done.events.iter().filter(move |event| event.channel == 1 && wanted(&event.kind));
        events
            .filter_map(move |event| usize::try_from(event.line.checked_sub(first)?).ok())
            .filter(|at| *at < blocks.len())
    };
    let begun = places(|kind| matches!(kind, Kind::Block(_))).max().map_or(1, |last| last + 1);
    (places(|kind| matches!(kind, Kind::Motion(_))).collect(), begun)
}

/// The blocks in which something moves. A block after an alarm or an end gets a program of its own.
fn moving(machine: &Arc<Machine>, blocks: &[String]) -> Vec<String> {
    let mut moving = Vec::new();
    let mut rest = blocks;
    while !rest.is_empty() {
        let (moved, begun) = run(machine, rest);
        moving.extend(moved.into_iter().filter_map(|at| rest.get(at).cloned()));
        rest = rest.get(begun..).unwrap_or_default();
    }
    moving
}

/// The blocks of one row of a machine's table of codes.
struct Task {
    machine: Arc<Machine>,
    id: String,
    code: String,
    blocks: Vec<String>,
}

/// All of them. Machines of a family share rows, and the same row beside the same word does the same; `MIXED_CASES`
/// runs them all.
fn tasks() -> Vec<Task> {
    let once = cases(0) == 0;
    let mut known: BTreeSet<(String, u32, String)> = BTreeSet::new();
    let mut tasks = Vec::new();
    for machine in shipped_names().iter().map(|name| machine(name, "")) {
        let words = axis_words(&machine);
        for row in machine.codes.iter().filter(|row| row.enable) {
            let Some(code) = written(&machine, row) else { continue };
            let new = words.iter().filter(|word| known.insert((row.file.clone(), row.line, (*word).clone())) || !once);
            let speed = speed_word(&machine).filter(|speed| !code.starts_with(&**speed));
            let with_speed = |block: &String| speed.as_ref().map(|speed| format!("{block} {speed}500"));
            let mut blocks: Vec<String> = new.map(|word| format!("{code} {word}10")).collect();
            // A row that needs a speed must not lose the axis words to the motion code either.
            blocks.extend(blocks.first().and_then(with_speed));
            tasks.push(Task { machine: machine.clone(), id: machine.code_name(row.id).to_owned(), code, blocks });
        }
    }
    tasks
}

#[test]
fn a_code_that_takes_axis_words_leaves_none_to_the_motion_code() {
    let tasks = tasks();
    let next = AtomicUsize::new(0);
    let work = || {
        let mut found = Vec::new();
        while let Some(task) = tasks.get(next.fetch_add(1, Ordering::Relaxed)) {
            found.extend(moving(&task.machine, &task.blocks).into_iter().map(|block| (task, block)));
        }
        found
    };
    let found: Vec<(&Task, String)> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..4).map(|_| scope.spawn(work)).collect();
        threads.into_iter().flat_map(|thread| thread.join().expect("no job panics")).collect()
    });
    let mut wrong = BTreeSet::new();
    let mut used: BTreeSet<&str> = BTreeSet::new();
    for (task, block) in &found {
        match row_of(&task.id, &task.code) {
            Some(row) => used.insert(row),
            None => wrong.insert(format!("{} on {}: '{block}' moves", task.id, task.machine.name)),
        };
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    // A row that nothing needs hides a mistake that comes later.
    let unused: Vec<_> = MOVES.iter().chain(IGNORED).filter(|row| !used.contains(**row)).collect();
    assert!(unused.is_empty(), "rows of the tables that no machine needs: {unused:?}");
}
