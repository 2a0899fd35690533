//! Everything together: local frames, offsets, compensation of the cutter radius, polar interpolation, tool tip
//! control, cycles, threads and circles in one program. The log keeps its order, the path of the axes has no gap, and
//! neither scheduling nor the lack of a log changes anything.

mod machines;
mod programs;

use counterpoint_kernel::log::event::{Event, FrameShift, Kind, Motion, OperatorMessage, Position};
use counterpoint_kernel::machine::Machine;
use counterpoint_kernel::options::{JobLimits, JobOptions};
use counterpoint_tests::{Done, Work, cases, processors};
use machines::{Macros, machine};
use programs::program;
use proptest::prelude::*;
use std::sync::Arc;

/// Differences of axes that noise may make.
const NEAR: f64 = 1e-6;

fn options(threads: u16) -> JobOptions {
    let limits = JobLimits { blocks: 5_000, zero_time_blocks: 2_000, events: 50_000, ..JobLimits::default() };
    JobOptions { limits, threads, ..JobOptions::default() }
}

/// Data of a channel while its events go by.
#[derive(Default)]
struct Seen {
    end: i64,
    /// End of the last motion, in the work frame.
    at: Option<Position>,
    shift: Position,
    /// Tool tip control is active: positions are those of the tip.
    tip: bool,
    /// Axis data from macros since the last motion.
    joints: Option<Vec<f64>>,
}

impl Seen {
    fn event(&mut self, event: &Event) -> Result<(), String> {
        let Event { t_ns, dur_ns, line, .. } = *event;
        let fail = |what: String| Err(format!("{what} at line {line}"));
        // A limit may stop a channel in the middle of a motion.
        let stopped = matches!(event.kind, Kind::Lifecycle(_));
        if t_ns < self.end && !stopped || dur_ns < 0 {
            return fail(format!("time goes back from {} to {t_ns}", self.end));
        }
        self.end = self.end.max(t_ns);
        match &event.kind {
            Kind::Motion(motion) => {
                self.end = t_ns + dur_ns;
                self.joints = None;
                return self.motion(motion).or_else(fail);
            }
            Kind::Frame(FrameShift { shift }) => {
                if self.tip {
                    self.at = None;
                } else if let Some(at) = &mut self.at {
                    // The machine does not move.
                    for ((slot, old), new) in at.iter_mut().zip(self.shift).zip(**shift) {
                        *slot += old - new;
                    }
                }
                self.shift = **shift;
            }
            Kind::Mode(mode) if mode.text.starts_with("rtcp on") || mode.text.starts_with("rtcp off") => {
                self.tip = mode.text.starts_with("rtcp on");
                self.at = None;
            }
            Kind::Mode(mode) if mode.text.starts_with("unwind") => (self.at, self.joints) = (None, None),
            Kind::Message(OperatorMessage { text, .. }) => {
                if let Some(values) = text.strip_prefix("J ") {
                    let values: Vec<f64> = values.split(' ').map(|value| value.parse().unwrap_or(f64::NAN)).collect();
                    if let Some(before) = &self.joints
                        && before.iter().zip(&values).any(|(a, b)| (a - b).abs() > NEAR)
                    {
                        return fail(format!("the axes jump from {before:?} to {values:?}"));
                    }
                    self.joints = Some(values);
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn motion(&mut self, motion: &Motion) -> Result<(), String> {
        let numbers = motion.to.iter().chain(&motion.from).chain(&motion.center).chain([&motion.length, &motion.feed]);
        if numbers.into_iter().any(|value| !value.is_finite()) {
            return Err(format!("a number is not finite: {motion:?}"));
        }
        if let Some(at) = self.at
            && at.iter().zip(&motion.from).any(|(a, b)| (a - b).abs() > NEAR)
        {
            return Err(format!("a gap between {at:?} and {:?}", motion.from));
        }
        self.at = Some(motion.to);
        Ok(())
    }
}

fn check(done: &Done) -> Result<(), String> {
    let mut channels: std::collections::BTreeMap<u16, Seen> = std::collections::BTreeMap::new();
    let mut last = (0, 0);
    for event in &done.events {
        if (event.t_ns, event.micro) < last {
            return Err(format!("the log goes back at line {} of channel {}", event.line, event.channel));
        }
        last = (event.t_ns, event.micro);
        if event.channel != 0 && !matches!(event.kind, Kind::Verdict(_)) {
            let seen = channels.entry(event.channel).or_default();
            seen.event(event).map_err(|error| format!("channel {}: {error}", event.channel))?;
        }
    }
    Ok(())
}

fn run(machine: Arc<Machine>, texts: &[String]) -> Result<(), TestCaseError> {
    let shown = || texts.join("\n--\n");
    let one = Work::texts(machine.clone(), texts, options(1)).run(None).expect("the job can be prepared");
    if let Err(error) = check(&one) {
        return Err(TestCaseError::fail(format!("{error} of\n{}", shown())));
    }
    let many = Work::texts(machine.clone(), texts, options(0)).run(None).expect("the job can be prepared");
    prop_assert!(one.events == many.events, "scheduling counts in\n{}", shown());
    let (results, ..) = Work::texts(machine, texts, options(0)).results(None).expect("the job can be prepared");
    prop_assert_eq!(&one.summary, &results.summary, "results without a log differ in\n{}", shown());
    Ok(())
}

fn macros(cutter: bool) -> impl Strategy<Value = Macros> {
    // After a waiting move, macros report the positions of the axes before that move.
    prop::sample::select(if cutter {
        vec![Macros::None, Macros::Meddling, Macros::Rounds]
    } else {
        vec![Macros::Shown]
    })
}

/// A meeting is one microstep after its last arrival, and so is the move after it, however long that waits.
#[test]
fn a_move_that_waits_behind_a_meeting_keeps_its_place() {
    let upper = "G98 F500\nT101\nG42 G1 X20.\nM100\nG1 Z-5.\nG4 P100\nX30.\nG40 X40.\nM30\n";
    for lower in ["G98 F500\nT101\nG4 P100\nM100\nM30\n", "G98 F500\nT101\nG4 X60.\nM100\nM30\n"] {
        run(machine(false, Macros::None), &[upper.to_owned(), lower.to_owned()]).unwrap();
    }
}

/// A move that compensation holds back is executed before tool tip control ends: its points are those of the tip.
#[test]
fn a_move_that_waits_is_made_under_the_tip_control_of_its_block() {
    for moves in ["G53 G1 X2. C3.\nG0 X0. Y0.", "G53 G0 C3.\nG0 X0. Y0.", "G1 X2. C3.\nG0 X0. Y0.", "G1 X2. C3.\nX-9."]
    {
        for on in ["G43.4", "G43.5"] {
            let text = format!(
                "O1\nG90 G17 G94 F500\nG0 X20. Y1. Z5.\nG0 G42 D2 X3. Y1.\n{on} H2\n{moves}\nG49\nX-15. Y3.\nG40 Y50.\nM30\n"
            );
            run(machine(true, Macros::None), &[text]).unwrap();
        }
    }
}

/// The check of the spindle's speed is at the end of its instant, also for a waiting move that an alarm ends there.
#[test]
fn the_block_of_an_alarm_in_a_waiting_move_comes_after_its_diagnostics() {
    let rest = "\nM30\nO77\nM9\nM99\nO78\nG91 G1 Z1.\nG90\nM99\n";
    let upper = format!("O1\nG98 F500\nT101\nG0 X40. Z5.\nG99 F0.2\nG42\nG0 Z9. X-11.\nG1 Z6. C0.\nG0 Z0. X0.{rest}");
    let lower = format!("O1\nG98 F500\nT101\nG0 X40. Z5.\n{rest}");
    run(machine(false, Macros::Meddling), &[upper, lower]).unwrap();
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(100), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_program_of_a_mill((text, macros) in (program(true, true), macros(true))) {
        run(machine(true, macros), &[text])?;
    }

    #[test]
    fn any_program_of_a_mill_shows_its_axes((text, macros) in (program(true, false), macros(false))) {
        run(machine(true, macros), &[text])?;
    }

    #[test]
    fn any_programs_of_a_lathe(
        ((upper, lower), macros) in ((program(false, true), program(false, true)), macros(true))
    ) {
        run(machine(false, macros), &[upper, lower])?;
    }

    #[test]
    fn any_programs_of_a_lathe_show_their_axes(
        ((upper, lower), macros) in ((program(false, false), program(false, false)), macros(false))
    ) {
        run(machine(false, macros), &[upper, lower])?;
    }
}

/// One processor, two, free and beside busy threads, with few threads and many.
#[test]
fn everywhere() {
    processors::everywhere(&processors::FEW_SETTINGS, "everywhere", &[("MIXED_CASES", "5")]);
}
