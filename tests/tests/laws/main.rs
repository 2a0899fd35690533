//! Laws that every control obeys: a program written in another way makes the same moves.
//!
//! Random programs of lines, circles, holes, contours, calls and jumps are written for four controls, each in a plain
//! and in another style. A shift of the zero shifts every position, a mirrored program mirrors them. The unit, absolute
//! or incremental words, numbers of blocks, comments and blanks change nothing. A style combines these laws at random.
//!
//! *Invariant:* a program and its style depend on its number only, so that a failure comes again.

mod fanuc;
mod heidenhain;
mod okuma;
mod program;
mod siemens;
mod writer;

use counterpoint_kernel::log::event::{Kind, MotionKind};
use counterpoint_kernel::options::JobOptions;
use counterpoint_tests::{Work, cases, machine};
use fastrand::Rng;
use program::{GRID_MM, Place, Step};
use writer::{Numbers, Style};

/// A control: its machine, and how it writes a program.
struct Control {
    machine: &'static str,
    text: fn(&[Step], &Style) -> String,
    /// Whether programs can mirror by a code.
    mirrors: bool,
    /// Changes the machine to inches, on a control whose programs do not select the unit.
    inches: Option<&'static str>,
}

const FANUC: Control = Control { machine: "fanuc-mill-quiet", text: fanuc::text, mirrors: true, inches: None };
const SIEMENS: Control = Control { machine: "siemens-mill-quiet", text: siemens::text, mirrors: true, inches: None };
const OKUMA: Control =
    Control { machine: "okuma-mill-quiet", text: okuma::text, mirrors: false, inches: Some(okuma::INCHES) };
const HEIDENHAIN: Control =
    Control { machine: "heidenhain-mill-quiet", text: heidenhain::text, mirrors: true, inches: None };

/// Travel is not tested; the tool has a radius.
const OVERLAY: &str = "[[diagnostics]]\nnumber = 2900023\nenable = false\n\n[[tool.offsets]]\nnumber = 1\nradius = 2\n";

/// Millimetres per inch.
const INCH: f64 = 25.4;

/// An event, apart from its line and its time.
#[derive(Debug, Clone, PartialEq)]
enum Happened {
    /// Kind, end in machine coordinates and feed, in millimetres.
    Moved(MotionKind, [f64; 3], f64),
    Complaint(u32),
    Other(String),
}

/// An event with its duration, ns.
type Timed = (Happened, i64);

fn run(control: &Control, text: &str, inches: bool) -> Vec<Timed> {
    let of_machine = control.inches.filter(|_| inches);
    let (overlay, unit) = of_machine.map_or((OVERLAY, 1.0), |overlay| (overlay, INCH));
    let work =
        Work::texts(machine(control.machine, overlay), &[text], JobOptions { threads: 1, ..JobOptions::default() });
    let done = work.run(None).expect("the job can be prepared");
    let mut shift = [0.0; 3];
    let mut happened = Vec::new();
    for event in &done.events {
        let one = match &event.kind {
            Kind::Frame(frame) => {
                shift = [frame.shift[0], frame.shift[1], frame.shift[2]];
                continue;
            }
            Kind::Motion(motion) => {
                let to = [0, 1, 2].map(|axis| (motion.to[axis] + shift[axis]) * unit);
                Happened::Moved(motion.kind, to, motion.feed * unit)
            }
            Kind::Diagnostic(told) => Happened::Complaint(told.number),
            Kind::Dwell(_) | Kind::Spindle(_) | Kind::Coolant(_) | Kind::Tool(_) | Kind::Stop(_) => {
                Happened::Other(format!("{:?}", event.kind))
            }
            _ => continue,
        };
        happened.push((one, event.dur_ns));
    }
    happened
}

/// The event that `style` demands for an event of the plain program.
fn changed(event: &Happened, style: &Style) -> Happened {
    let Happened::Moved(kind, to, feed) = event else { return event.clone() };
    let mirrored = style.mirrored != style.by_code;
    let kind = match kind {
        MotionKind::ArcCw if mirrored => MotionKind::ArcCcw,
        MotionKind::ArcCcw if mirrored => MotionKind::ArcCw,
        kind => *kind,
    };
    let x = if mirrored { -to[0] } else { to[0] };
    let by = |axis: usize| f64::from(style.offset[axis] + style.shift[axis]) * GRID_MM;
    Happened::Moved(kind, [x + by(0), to[1] + by(1), to[2] + by(2)], *feed)
}

/// The first difference between the other program and the events that its style demands.
fn difference(plain: &[Timed], other: &[Timed], style: &Style) -> Option<String> {
    // The length of the first move depends on the zero.
    let mut moved = style.offset == [0; 3] && style.shift == [0; 3];
    for (at, ((one, took), (two, takes))) in plain.iter().zip(other).enumerate() {
        let wanted = changed(one, style);
        let alike = match (&wanted, two) {
            (Happened::Moved(kind, to, feed), Happened::Moved(other, place, also)) => {
                let near = to.iter().zip(place).all(|(one, two)| (one - two).abs() < 2e-6);
                kind == other && near && (feed - also).abs() < 1e-6
            }
            (one, two) => one == two,
        };
        let is_move = matches!(one, Happened::Moved(..));
        let on_time = is_move && !moved || (took - takes).abs() < 1_000;
        moved |= is_move;
        if !alike || !on_time {
            return Some(format!("event {at}: wanted {wanted:?} in {took} ns, not {two:?} in {takes} ns"));
        }
    }
    (plain.len() != other.len()).then(|| format!("{} and {} events", plain.len(), other.len()))
}

/// All laws, each with an even chance.
fn random_style(rng: &mut Rng, control: &Control) -> Style {
    let by = |rng: &mut Rng| if rng.bool() { [(); 3].map(|()| rng.i32(-500..=500)) } else { Place::default() };
    let numbers = Numbers::Every(rng.u32(1..90), rng.u32(1..20));
    Style {
        inches: rng.bool(),
        relative: rng.bool(),
        numbers: if rng.bool() { numbers } else { Numbers::Needed },
        filler: rng.bool().then(|| rng.u64(..)),
        mirrored: rng.bool(),
        by_code: control.mirrors && rng.bool(),
        offset: by(rng),
        shift: by(rng),
    }
}

/// Styles with one law of `style` each: they show which law fails.
fn single_laws(style: &Style) -> [Style; 8] {
    let plain = Style::default;
    [
        Style { inches: style.inches, ..plain() },
        Style { relative: style.relative, ..plain() },
        Style { numbers: style.numbers, ..plain() },
        Style { filler: style.filler, ..plain() },
        Style { mirrored: style.mirrored, ..plain() },
        Style { by_code: style.by_code, ..plain() },
        Style { offset: style.offset, ..plain() },
        Style { shift: style.shift, ..plain() },
    ]
}

fn laws_hold(control: &Control) {
    let mut without_complaint = 0;
    for number in 0..cases(200) {
        let mut rng = Rng::with_seed(u64::from(number));
        let steps = program::random(&mut rng);
        let style = random_style(&mut rng, control);
        let plain_text = (control.text)(&steps, &Style::default());
        let plain = run(control, &plain_text, false);
        let written = |style: &Style| {
            let text = (control.text)(&steps, style);
            difference(&plain, &run(control, &text, style.inches), style).map(|found| (text, found))
        };
        without_complaint += u32::from(!plain.iter().any(|(event, _)| matches!(event, Happened::Complaint(_))));
        if let Some((text, found)) = written(&style) {
            let failing: Vec<Style> = single_laws(&style).into_iter().filter(|one| written(one).is_some()).collect();
            panic!(
                "program {number} of {}: {found}\n{style:?}\nfails by itself: {failing:?}\n{plain_text}\n{text}",
                control.machine
            );
        }
    }
    assert!(without_complaint * 5 > cases(200) * 4, "{without_complaint} programs without a complaint");
}

#[test]
fn fanuc_mills() {
    laws_hold(&FANUC);
}

#[test]
fn siemens_mills() {
    laws_hold(&SIEMENS);
}

#[test]
fn okuma_mills() {
    laws_hold(&OKUMA);
}

#[test]
fn heidenhain_mills() {
    laws_hold(&HEIDENHAIN);
}
