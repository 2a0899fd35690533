//! Limits of travel: every linear axis of the shipped machines has some, and a move is an alarm exactly where it leaves
//! them.

use std::f64::consts::{FRAC_PI_2, TAU};
use std::sync::Arc;

use counterpoint_kernel::machine::{Machine, package};
use counterpoint_kernel::options::JobOptions;
use counterpoint_tests::{Work, machine};
use proptest::prelude::*;

/// Number of the diagnostic of a move beyond the limits.
const OVER_TRAVEL: u32 = 2_900_023;

/// Limits of both axes of the plane, programmed: a diameter on a lathe.
const LIMITS: [f64; 2] = [-40.0, 60.0];

/// Closer to a limit than this, the rounding of the program decides.
const UNDECIDED: f64 = 0.02;

#[test]
fn every_linear_axis_of_a_shipped_machine_has_limits() {
    let mut axes = 0;
    for name in package::shipped_names() {
        for axis in machine(&name, "").axes.iter().filter(|axis| !axis.role.is_rotary()) {
            let (low, high) = axis.limits.unwrap_or_else(|| panic!("{name}: axis {} has no limits", axis.name));
            assert!(
                low < axis.positioning.part_zero && high > axis.positioning.part_zero,
                "{name}: axis {}",
                axis.name
            );
            axes += 1;
        }
    }
    assert!(axes > 60, "{axes} axes");
}

/// A lathe, whose plane is Z X, or a mill, whose plane is X Y.
fn limited(lathe: bool) -> Arc<Machine> {
    let (name, second) = if lathe { ("fanuc-lathe", "Z") } else { ("fanuc-mill-quiet", "Y") };
    let [low, high] = LIMITS;
    let diameter = if lathe { "diameter = true\n" } else { "" };
    let row = |axis: &str, more: &str| {
        format!("[[axes]]\nname = \"{axis}\"\n{more}rapid = 9000\nhome = 0\nlimits = [{low}, {high}]\n\n")
    };
    machine(name, &(row("X", diameter) + &row(second, "")))
}

fn alarms(lathe: bool, text: &str) -> bool {
    let done = Work::texts(limited(lathe), &[text], JobOptions::default()).run(None).expect("a job");
    let numbers: Vec<u32> = done.summary.diagnostics.iter().map(|told| told.number).collect();
    assert!(numbers.iter().all(|number| *number == OVER_TRAVEL), "{numbers:?} in {text}");
    !numbers.is_empty()
}

/// The first message of a program.
fn message(name: &str, more: &str, text: &str) -> String {
    let done = Work::texts(machine(name, more), &[text], JobOptions::default()).run(None).expect("a job");
    done.summary.diagnostics.first().map(|told| told.text.clone()).unwrap_or_default()
}

/// Fanuc controls with parameter 3401#0 = 0 read X5000 as 5 mm.
#[test]
fn a_long_number_without_a_point_may_count_increments() {
    let hint = "; if X5000 counts least increments, run with --set numbers=increments";
    let ends = |name: &str, more: &str, text: &str| message(name, more, text).ends_with(hint);
    assert!(ends("fanuc-mill", "", "G0 X5000\nM30\n"));
    assert!(ends("fanuc-lathe", "", "G0 Z1 X5000\nM30\n"));
    for (name, more, text) in [
        ("fanuc-mill", "", "G0 X5000.\nM30\n"),
        ("fanuc-mill", "", "G0 X900 (X5000)\nG0 X9000.\nM30\n"),
        ("fanuc-mill", "[control]\nnumbers = \"increments\"\n", "G0 X5000000\nM30\n"),
        ("siemens-mill", "", "G0 X5000\nM30\n"),
    ] {
        let message = message(name, more, text);
        assert!(message.contains("is beyond its limits") && !message.contains("increments"), "{message}");
    }
}

/// A move in the plane, in geometry units: from a place by an angle about a centre, or straight.
#[derive(Debug, Clone, Copy)]
struct Move {
    from: [f64; 2],
    center: [f64; 2],
    sweep: f64,
    round: bool,
    /// Shift of the work frame against the machine frame, in programmed units.
    shift: [f64; 2],
}

impl Move {
    fn at(&self, sweep: f64) -> [f64; 2] {
        let [x, y] = [self.from[0] - self.center[0], self.from[1] - self.center[1]];
        let (sin, cos) = sweep.sin_cos();
        [self.center[0] + x * cos - y * sin, self.center[1] + x * sin + y * cos]
    }

    /// Extreme points along both axes, in geometry units: the ends, and each quarter point of the circle that the move
    /// passes.
    fn places(&self) -> Vec<[f64; 2]> {
        let mut places = vec![self.from, self.at(self.sweep)];
        if self.round {
            let start = (self.from[1] - self.center[1]).atan2(self.from[0] - self.center[0]);
            let quarters = (-8..=8).map(|quarter| f64::from(quarter) * FRAC_PI_2 - start);
            let passed = quarters.filter(|turn| turn * self.sweep > 0.0 && turn.abs() < self.sweep.abs());
            places.extend(passed.map(|turn| self.at(turn)));
        }
        places
    }
}

fn moves() -> impl Strategy<Value = Move> {
    let center = prop::array::uniform2(-30.0..40.0);
    let shift = prop::array::uniform2(-4_i32..4).prop_map(|shift| shift.map(|part| f64::from(part) / 2.0));
    let start = (1.0..25.0, 0.0..TAU);
    (start, center, 0.1..TAU - 0.1, any::<[bool; 2]>(), shift).prop_map(
        |(start, center, turn, [round, left], shift)| {
            let (radius, angle) = start;
            let from = [center[0] + radius * angle.cos(), center[1] + radius * angle.sin()];
            Move { from, center, sweep: if left { turn } else { -turn }, round, shift }
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: counterpoint_tests::cases(400), failure_persistence: None, ..ProptestConfig::default()
    })]

    #[test]
    fn a_move_is_an_alarm_exactly_where_it_leads_beyond_the_limits(line in moves(), lathe in any::<bool>()) {
        // The plane of a lathe is Z X: its first axis is Z, its second X, a diameter.
        let (names, scale) = if lathe { (["Z", "X"], [1.0, 2.0]) } else { (["X", "Y"], [1.0, 1.0]) };
        let word = |axis: usize, value: f64| format!("{}{:.4}", names[axis], value * scale[axis]);
        let (from, to) = (line.from, line.at(line.sweep));
        let code = match (line.round, line.sweep > 0.0) {
            (false, _) => "G1".to_owned(),
            (true, left) => {
                let centers = if lathe { ["K", "I"] } else { ["I", "J"] };
                let parts = [0, 1].map(|axis| format!("{}{:.4}", centers[axis], line.center[axis] - from[axis]));
                format!("{} {} {}", if left { "G3" } else { "G2" }, parts[0], parts[1])
            }
        };
        let text = format!(
            "G10 L2 P1 {}{} {}{}\nG98 G0 {} {}\n{code} {} {} F500\nM30\n",
            names[0], line.shift[0], names[1], line.shift[1],
            word(0, from[0]), word(1, from[1]), word(0, to[0]), word(1, to[1]),
        );
        let text = if lathe { text } else { text.replace("G98", "G94") };
        let values = line.places().into_iter().flat_map(|place| [0, 1].map(|axis| place[axis] * scale[axis] + line.shift[axis]));
        let beyond: Vec<f64> = values.map(|value| (LIMITS[0] - value).max(value - LIMITS[1])).collect();
        let most = beyond.into_iter().fold(f64::NEG_INFINITY, f64::max);
        prop_assume!(most.abs() > UNDECIDED);
        prop_assert_eq!(alarms(lathe, &text), most > 0.0, "{} by {}", text, most);
    }
}
