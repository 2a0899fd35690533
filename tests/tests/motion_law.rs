//! The law of motion: every motion has a law, laws keep the limits of the machine, and recording changes nothing else.
//!
//! Positions are compared with the limits by differences of positions alone: speeds and accelerations of the axes come
//! from the machine definition, feeds from the program.

use counterpoint_kernel::log::event::{Event, Kind, Motion, MotionKind, MotionLaw, UnknownLaw};
use counterpoint_kernel::log::info::JobAxis;
use counterpoint_kernel::log::instant::position;
use counterpoint_kernel::machine::Machine;
use counterpoint_kernel::options::{JobLimits, JobOptions, MoveTiming, TimeModel};
use counterpoint_tests::{Done, Work, cases, machine};

/// Samples along a motion.
const STEPS: u32 = 60;

/// A time in which speeds change only slightly, seconds.
const INSTANT: f64 = 1e-7;

/// Times that all machines of the test have in common.
const TIMES: &str = "[time]\nlook_ahead = 12\ncorner_deviation = 0.05\n";

const MILL: &str = "
[[axes]]
name = \"X\"
rapid = 24000
acceleration = 1500
[[axes]]
name = \"Y\"
rapid = 30000
acceleration = 2000
[[axes]]
name = \"Z\"
rapid = 15000
acceleration = 900
";

fn options(law: bool, threads: u16, model: TimeModel) -> JobOptions {
    let limits = JobLimits { blocks: 20_000, zero_time_blocks: 5_000, events: 200_000, ..JobLimits::default() };
    JobOptions { limits, threads, timing: MoveTiming { model, law }, ..JobOptions::default() }
}

/// A milling program: rapids, lines and arcs with feed per minute, per revolution and in inverse time.
fn mill(random: &mut fastrand::Rng) -> String {
    let mut text = String::from("O1\nG90 G17 G94 G64 F800\nM3 S1200\nG0 X0 Y0 Z5.\nG1 Z0\n");
    for _ in 0..40 {
        let [x, y, z] = [(); 3].map(|()| random.i32(-40..=40));
        let feed = random.u16(50..6000);
        text.push_str(&match random.u8(0..12) {
            0..=1 => format!("G0 X{x}. Y{y}.\n"),
            2 => format!("G0 X{x}. Y{y}. Z{z}.\n"),
            3..=5 => format!("G1 X{x}. Y{y}. F{feed}\n"),
            6 => format!("G91 G2 X{}. Y0 I{}. J0 F{feed}\nG90\n", 2 * (x | 1), x | 1),
            7 => format!("G91 G3 I{}. J{}. Z{z}. F{feed}\nG90\n", x | 1, y),
            8 => format!("G95\nG1 X{x}. Z{z}. F0.{}\nG94 F{feed}\n", random.u8(1..9)),
            9 => format!("G93 G1 X{x}. Y{y}. F{}\nG94 F{feed}\n", random.u8(2..60)),
            10 => format!("G61\nG1 X{x}. F{feed}\nG64\n"),
            _ => "G4 P100\n".to_owned(),
        });
    }
    text.push_str("M30\n");
    text
}

/// A turning program: facing and turning under constant surface speed, arcs, threads.
fn lathe(random: &mut fastrand::Rng) -> String {
    let mut text = String::from("O1\nG28 U0 W0\nT0101\nG50 S2500\nG96 S180 M3\nG99 G0 X60. Z5.\n");
    for _ in 0..30 {
        let (x, z) = (random.u8(0..120), random.i32(-60..=5));
        let feed = random.u8(5..40);
        text.push_str(&match random.u8(0..10) {
            0..=1 => format!("G0 X{x}. Z{z}.\n"),
            2..=4 => format!("G1 X{x}. Z{z}. F0.{feed:02}\n"),
            5 => format!("G1 X{x}. F0.{feed:02}\n"),
            6 => format!("G{} U{}. W-{}. R{}.\n", random.u8(2..=3), 2 * (feed / 2), feed / 2, feed / 2 + 1),
            7 => "G97 S900\nG0 X40.\nG32 Z-30. F1.5\nG96 S150\n".to_owned(),
            8 => format!("G98\nG1 X{x}. F{}\nG99 F0.2\n", 20 * u16::from(feed)),
            _ => "G4 P200\n".to_owned(),
        });
    }
    text.push_str("M30\n");
    text
}

fn work(seed: u64, law: bool, threads: u16) -> Work {
    let mut random = fastrand::Rng::with_seed(seed);
    let time = if seed.is_multiple_of(5) { TimeModel::Simple } else { TimeModel::Full };
    if seed.is_multiple_of(2) {
        let rapid = if random.bool() { "rapid = \"linear\"\n" } else { "" };
        let machine = machine("fanuc-mill", &format!("{TIMES}{rapid}{MILL}"));
        Work::texts(machine, &[mill(&mut random)], options(law, threads, time))
    } else {
        let texts = [lathe(&mut random), lathe(&mut random)];
        Work::texts(machine("fanuc-2path-lathe", ""), &texts, options(law, threads, time))
    }
}

/// The laws of a channel with their motions.
fn laws(done: &Done, channel: u16) -> Vec<(Event, Motion, MotionLaw)> {
    let mut events = done.events.iter().filter(|event| event.channel == channel).peekable();
    let mut laws = Vec::new();
    while let Some(event) = events.next() {
        let Kind::Motion(motion) = event.kind else {
            assert!(!matches!(event.kind, Kind::Law(_)), "a law without a motion: {event:?}");
            continue;
        };
        if event.dur_ns == 0 {
            continue;
        }
        let law = events.next().expect("a law follows each motion");
        let Kind::Law(of) = law.kind else { panic!("no law after {event:?} but {law:?}") };
        assert_eq!((law.t_ns, law.dur_ns, law.line, law.file), (event.t_ns, event.dur_ns, event.line, event.file));
        laws.push((event.clone(), motion, of));
    }
    laws
}

/// Positions at equal steps of time, in geometry units.
fn samples(axes: &[JobAxis], motion: &Motion, law: &MotionLaw) -> Vec<Vec<f64>> {
    let at = |step| {
        let place = position(motion, law, axes, f64::from(step) / f64::from(STEPS)).expect("a known law");
        axes.iter().zip(place).map(|(axis, value)| if axis.diameter { value / 2.0 } else { value }).collect()
    };
    (0..=STEPS).map(at).collect()
}

/// Limits of an axis of a machine: rate per second and acceleration.
fn limits(machine: &Machine, channel: u16, axis: usize) -> (f64, f64) {
    let channel = machine.channels.iter().find(|of| of.number == channel).expect("a channel");
    let axis = &machine.axes[*channel.axes.iter().nth(axis).expect("an axis")];
    (axis.rapid / 60.0, axis.dynamics.acceleration.unwrap_or(f64::INFINITY))
}

/// Speeds and accelerations of the axes stay within their limits, and straight moves do not turn back.
fn check(done: &Done, machine: &Machine, channel: u16, text: &str) -> usize {
    let axes = &done.info.channel(channel).expect("a channel").axes;
    let mut unknown = 0;
    for (event, motion, law) in laws(done, channel) {
        if let MotionLaw::Unknown(reason) = law {
            assert_eq!(reason, UnknownLaw::WithoutFeed, "{event:?}\n{text}");
            unknown += 1;
            continue;
        }
        assert_eq!(position(&motion, &law, axes, 0.0), Some(motion.from));
        assert_eq!(position(&motion, &law, axes, 1.0), Some(motion.to));
        let step = event.dur_ns as f64 / 1e9 / f64::from(STEPS);
        let straight = matches!(motion.kind, MotionKind::Rapid | MotionKind::Linear | MotionKind::Thread);
        let all = samples(axes, &motion, &law);
        for axis in 0..axes.len() {
            let places: Vec<f64> = all.iter().map(|place| place[axis]).collect();
            let speeds: Vec<f64> = places.windows(2).map(|pair| (pair[1] - pair[0]) / step).collect();
            let fastest = speeds.iter().fold(0.0_f64, |most, speed| most.max(speed.abs()));
            let (rate, acceleration) = limits(machine, channel, axis);
            let slack = 1.0 + 1e-6;
            if motion.kind == MotionKind::Rapid {
                assert!(fastest <= rate * slack, "{axis} at {fastest} of {rate}: {event:?} {law:?}\n{text}");
                let steepest = speeds.windows(2).map(|pair| (pair[1] - pair[0]).abs() / step).fold(0.0, f64::max);
                assert!(steepest <= acceleration * slack + 1e-3, "{axis}: {steepest} {event:?} {law:?}\n{text}");
                // The move starts at standstill, so the acceleration limits the speed in the first step.
                let first = speeds.first().copied().unwrap_or(0.0).abs();
                assert!(first <= acceleration * step * slack, "{axis}: {first} {event:?} {law:?}\n{text}");
            }
            if straight {
                let way = places[STEPS as usize] - places[0];
                assert!(speeds.iter().all(|speed| speed * way >= -1e-6), "{axis}: {event:?} {law:?}\n{text}");
            }
        }
    }
    unknown
}

/// Where a path continues at feed, its speed does not jump: a move starts at the speed at which the previous one ends.
fn check_joints(done: &Done, channel: u16, text: &str) -> usize {
    let mut joints = 0;
    let laws = laws(done, channel);
    for pair in laws.windows(2) {
        let [(before, _, MotionLaw::Path(one)), (after, _, MotionLaw::Path(other))] = pair else { continue };
        let (Some(one), Some(other)) = (one.ramp, other.ramp) else { continue };
        let goes_on = before.t_ns + before.dur_ns == after.t_ns && one.exit > 0.0;
        if goes_on {
            let [last, first] = [INSTANT / one.seconds(), INSTANT / other.seconds()];
            let end = one.length * (1.0 - one.way(1.0 - last)) / INSTANT;
            let start = other.length * other.way(first) / INSTANT;
            assert!((end - start).abs() <= 1e-3 * (1.0 + end), "{end} {start}: {before:?} {one:?} {other:?}\n{text}");
            joints += 1;
        } else if before.t_ns + before.dur_ns == after.t_ns {
            assert!(other.entry == 0.0, "{before:?} {one:?} {other:?}\n{text}");
        }
    }
    joints
}

#[test]
fn every_motion_has_a_law_that_keeps_the_limits_of_the_machine() {
    let (mut motions, mut joints, mut unknown) = (0, 0, 0);
    for seed in 0..u64::from(cases(20)) {
        let job = work(seed, true, 1);
        let done = job.run(None).unwrap();
        let text = format!("seed {seed}");
        for channel in done.info.channels.iter().map(|channel| channel.number) {
            motions += laws(&done, channel).len();
            unknown += check(&done, &job.machine, channel, &text);
            joints += check_joints(&done, channel, &text);
        }
    }
    assert!(motions > 30 * 20 && joints > 50 && unknown * 10 < motions, "{motions} {joints} {unknown}");
}

#[test]
fn laws_change_neither_the_other_events_nor_the_fingerprint() {
    for seed in 0..u64::from(cases(20)) {
        let [with, without] = [true, false].map(|law| work(seed, law, 1).run(None).unwrap());
        assert_eq!(with.summary, without.summary);
        let others: Vec<&Event> = with.events.iter().filter(|event| !matches!(event.kind, Kind::Law(_))).collect();
        assert!(others.into_iter().eq(without.events.iter()));
        assert_eq!(work(seed, true, 0).run(None).unwrap().events, with.events, "any number of threads");
    }
}

/// Facing from diameter 60 to 20 at G96 S200 and 0.2 mm/rev, calculated by hand. The time is ∫ 2πr dr / (v·f) =
/// (30² − 10²)·π / (200,000·0.2) min = 0.062832 min = 3.769911 s. At half of that time the radius is √500.
#[test]
fn facing_by_hand() {
    let text = "O1\nT0101\nG50 S5000\nG96 S200 M3\nG99 G0 X60. Z0\nG1 X20. F0.2\nM30\n";
    let lathe = machine("fanuc-2path-lathe", "");
    let job = Work::texts(lathe, &[text], options(true, 1, TimeModel::Simple));
    let done = job.run(None).unwrap();
    let axes = &done.info.channel(1).unwrap().axes;
    let laws = laws(&done, 1);
    let (event, motion, law) = laws.iter().rfind(|(_, motion, _)| motion.kind == MotionKind::Linear).unwrap();
    assert_eq!(event.dur_ns, 3_769_911_184);
    let x = position(motion, law, axes, 0.5).unwrap()[0];
    assert!((x - 2.0 * 500.0_f64.sqrt()).abs() < 1e-6, "{x}");
}
