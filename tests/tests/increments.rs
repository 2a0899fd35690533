//! The same path, written with decimal points and in least increments, in millimetres and in inches: the axes move the
//! same on every shipped machine whose control can count increments.

use std::fmt::Write as _;
use std::sync::Arc;

use counterpoint_kernel::log::event::{Kind, MotionKind};
use counterpoint_kernel::machine::Machine;
use counterpoint_kernel::options::JobOptions;
use counterpoint_tests::{Work, machine};
use proptest::prelude::*;

/// A number of a dimension word, in least increments.
#[derive(Debug, Clone, Copy)]
enum Step {
    Rapid([i32; 3]),
    Feed([i32; 3]),
    /// Half a circle about a centre that lies this far from its start along the first axis.
    Half(i32, bool),
    /// The same by its radius.
    ByRadius(i32, bool),
    /// A full circle, its centre off its start by this much.
    Full(i32, i32),
    Drill(i32, i32, u8),
    Scale(u16, i32),
    Rotate(i32, i32),
    Macro(i32, i32),
}

fn steps() -> impl Strategy<Value = Vec<Step>> {
    let at = -90_000_i32..90_000;
    let radius = (1_000_i32..40_000, any::<bool>()).prop_map(|(radius, right)| if right { radius } else { -radius });
    let one = prop_oneof![
        prop::array::uniform3(at.clone()).prop_map(Step::Rapid),
        prop::array::uniform3(at.clone()).prop_map(Step::Feed),
        (radius.clone(), any::<bool>()).prop_map(|(radius, clockwise)| Step::Half(radius, clockwise)),
        (1_000_i32..40_000, any::<bool>()).prop_map(|(radius, clockwise)| Step::ByRadius(radius, clockwise)),
        (radius.clone(), radius).prop_map(|(x, y)| Step::Full(x, y)),
        (at.clone(), 1_000_i32..9_000, 1_u8..4).prop_map(|(x, peck, times)| Step::Drill(x, peck, times)),
        (200_u16..3_000, at.clone()).prop_map(|(factor, x)| Step::Scale(factor, x)),
        (-180_000_i32..180_000, at.clone()).prop_map(|(angle, x)| Step::Rotate(angle, x)),
        (at.clone(), at).prop_map(|(x, i)| Step::Macro(x, i)),
    ];
    prop::collection::vec(one, 1..10)
}

/// How numbers are written.
#[derive(Debug, Clone, Copy)]
struct Way {
    inches: bool,
    increments: bool,
}

impl Way {
    /// A length in least increments.
    fn length(self, value: i32) -> String {
        let (power, places) = if self.inches { (1e4, 4) } else { (1e3, 3) };
        if self.increments { value.to_string() } else { format!("{:.places$}", f64::from(value) / power) }
    }

    /// An angle in thousandths of a degree.
    fn angle(self, value: i32) -> String {
        if self.increments { value.to_string() } else { format!("{:.3}", f64::from(value) / 1e3) }
    }

    fn program(self, steps: &[Step]) -> String {
        let l = |value: i32| self.length(value);
        let mut text = format!("O1\n{} G90 G17 G94 S1000 M3 F300.\n", if self.inches { "G20" } else { "G21" });
        for step in steps {
            _ = match *step {
                Step::Rapid([x, y, z]) => writeln!(text, "G0 X{} Y{} Z{}", l(x), l(y), l(z)),
                Step::Feed([x, y, z]) => writeln!(text, "G1 X{} Y{} Z{}", l(x), l(y), l(z)),
                Step::Half(radius, clockwise) => {
                    let code = if clockwise { 2 } else { 3 };
                    writeln!(text, "G91 G{code} X{} Y0 I{} J0\nG90", l(2 * radius), l(radius))
                }
                Step::ByRadius(radius, clockwise) => {
                    let code = if clockwise { 2 } else { 3 };
                    writeln!(text, "G91 G{code} X{} Y{} R{}\nG90", l(radius), l(radius), l(radius))
                }
                Step::Full(i, j) => writeln!(text, "G3 I{} J{}", l(i), l(j)),
                Step::Drill(x, peck, times) => writeln!(
                    text,
                    "G0 Z{}\nG91 G99 G83 X{} Z{} R{} Q{} K{times}\nG80 G90",
                    l(20_000),
                    l(x),
                    l(-12_000),
                    l(-2_000),
                    l(peck)
                ),
                Step::Scale(factor, x) => {
                    writeln!(text, "G51 X{} Y0 Z0 I{factor} J{factor} K1000\nG0 X{}\nG50", l(x), l(x / 2))
                }
                Step::Rotate(angle, x) => {
                    writeln!(text, "G68 X0 Y0 R{}\nG0 X{} Y0\nG69", self.angle(angle), l(x))
                }
                Step::Macro(x, i) => writeln!(text, "G65 P9000 X{} I{} W{}", l(x), l(i), l(x)),
            };
        }
        text + "M30\nO9000\nG0 X#24 Y#4 Z#23\nM99\n"
    }
}

/// A motion: kind, end, duration in ns.
type Moved = (MotionKind, [f64; 3], i64);

/// Each motion: its kind, its end, how long it takes.
fn ran(machine: &Arc<Machine>, text: &str) -> (Vec<Moved>, Vec<u32>) {
    let done = Work::texts(Arc::clone(machine), &[text], JobOptions::default()).run(None).expect("a job");
    let ends = done.events.iter().filter_map(|event| match &event.kind {
        Kind::Motion(motion) => Some((motion.kind, [motion.to[0], motion.to[1], motion.to[2]], event.dur_ns)),
        _ => None,
    });
    (ends.collect(), done.summary.diagnostics.iter().map(|told| told.number).collect())
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: counterpoint_tests::cases(40), failure_persistence: None, ..ProptestConfig::default()
    })]

    #[test]
    fn increments_and_points_mean_the_same(steps in steps(), inches in any::<bool>(), which in 0_usize..4) {
        // Scales of Haas controls are factors, and a Haas has no such cycles in increments.
        let name = ["fanuc-mill", "mitsubishi-mill", "mazak-eia-mill", "fanuc-mill-5axis"][which];
        let wide = "[[diagnostics]]\nnumber = 2900023\nenable = false\n\n";
        let [points, increments] = [false, true].map(|increments| {
            let numbers = if increments { "increments" } else { "as-written" };
            let machine = machine(name, &format!("[control]\nnumbers = \"{numbers}\"\n\n{wide}"));
            let text = Way { inches, increments }.program(&steps);
            (ran(&machine, &text), text)
        });
        let ((one, said), text) = points;
        let ((two, also_said), other) = increments;
        prop_assert_eq!(&said, &also_said, "\n{}\n{}", text, other);
        prop_assert_eq!(one.len(), two.len(), "\n{}\n{}", text, other);
        for (one, two) in one.iter().zip(&two) {
            let near = one.1.iter().zip(two.1).all(|(one, two)| (one - two).abs() < 1e-6);
            prop_assert!(one.0 == two.0 && near && (one.2 - two.2).abs() < 1_000, "{:?} {:?}\n{}\n{}", one, two, text, other);
        }
    }
}
