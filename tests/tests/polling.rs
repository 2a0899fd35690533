//! Random programs that wait for variables of each other. A search without time finds the channels that can never leave
//! a loop. The verdict must name exactly those, with the lines of their loops, under any schedule of threads.

use std::collections::BTreeSet;

use counterpoint_kernel::log::event::VerdictKind;
use counterpoint_kernel::options::JobOptions;
use counterpoint_tests::{Work, cases, machine, processors};

/// Channels, and variables that they wait for.
const CHANNELS: u16 = 3;
const VARIABLES: u64 = 4;

struct Numbers(u64);

impl Numbers {
    fn below(&mut self, limit: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0 % limit
    }
}

/// The activity of a channel, with the line at which its loop begins.
#[derive(Debug, Clone, Copy)]
enum Step {
    Write(u64),
    Poll(u64, u32),
}

/// A program, and its steps.
fn program(own: u16, numbers: &mut Numbers) -> (String, Vec<Step>) {
    let mut lines: Vec<String> = vec![format!("O{own}")];
    if own == 1 {
        lines.extend((0..VARIABLES).map(|variable| format!("#{}=0", 500 + variable)));
    }
    lines.push("M110P123".to_owned());
    let mut steps = Vec::new();
    for label in 10..12 + numbers.below(4) {
        if numbers.below(3) == 0 {
            lines.push(format!("G4P{}", 1 + numbers.below(90)));
        }
        let variable = numbers.below(VARIABLES);
        let name = format!("#{}", 500 + variable);
        if numbers.below(2) == 0 {
            lines.push(format!("{name}=1"));
            steps.push(Step::Write(variable));
            continue;
        }
        let begins = lines.len() as u32 + 1;
        match numbers.below(6) {
            0 | 1 => lines.extend([format!("WHILE[{name}EQ0]DO1"), "END1".to_owned()]),
            2 => lines.extend([format!("N{label}G4P{}", 1 + numbers.below(50)), format!("IF[{name}EQ0]GOTO{label}")]),
            3 => {
                let inside = ["#1=0", "WHILE[#1LT3]DO2", "#1=#1+1", "END2"].map(str::to_owned);
                lines.push(format!("WHILE[{name}EQ0]DO1"));
                lines.extend(inside);
                lines.push("END1".to_owned());
            }
            4 => lines.extend([format!("N{label}M98P9"), format!("IF[{name}EQ0]GOTO{label}")]),
            _ => lines.extend([format!("N{label}#2={name}"), format!("IF[#2EQ0]GOTO{label}")]),
        }
        steps.push(Step::Poll(variable, begins));
    }
    lines.push("M30\nO9\n#3=0\nN80#3=#3+1\nIF[#3LT2]GOTO80\nM98P8L2\nM99\nO8\nG4P1\nM99\n".to_owned());
    (lines.join("\n"), steps)
}

/// The channels that never leave a loop, with the lines at which the loops begin: each channel continues if it can, in
/// any order.
fn stuck(programs: &[Vec<Step>]) -> BTreeSet<(u16, u32)> {
    let mut written = BTreeSet::new();
    let mut at = vec![0; programs.len()];
    loop {
        let mut moved = false;
        for (steps, at) in programs.iter().zip(&mut at) {
            while let Some(step) = steps.get(*at) {
                match step {
                    Step::Poll(variable, _) if !written.contains(variable) => break,
                    Step::Poll(..) => {}
                    Step::Write(variable) => {
                        written.insert(*variable);
                    }
                }
                *at += 1;
                moved = true;
            }
        }
        if !moved {
            break;
        }
    }
    let stands = |(index, at): (usize, &usize)| match programs[index].get(*at) {
        Some(Step::Poll(_, line)) => Some((index as u16 + 1, *line)),
        _ => None,
    };
    at.iter().enumerate().filter_map(stands).collect()
}

#[test]
fn exactly_those_spin_for_whom_nobody_writes() {
    let machine = machine("fanuc-3path-lathe-exact", "");
    let (mut alive, mut spinning) = (0, [0; CHANNELS as usize + 1]);
    for case in 1..=u64::from(cases(150)) {
        let mut numbers = Numbers(case.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
        let (texts, steps): (Vec<String>, Vec<Vec<Step>>) =
            (1..=CHANNELS).map(|own| program(own, &mut numbers)).unzip();
        let mut work = Work::texts(machine.clone(), &texts, JobOptions::default());
        work.options.threads = 1;
        let one = work.run(None).unwrap();
        let expected = stuck(&steps);
        let found: BTreeSet<(u16, u32)> = match &one.summary.verdict {
            None => BTreeSet::new(),
            Some(verdict) => {
                assert_eq!(verdict.kind, VerdictKind::PartnerSpinning, "case {case}: {texts:#?} {verdict:#?}");
                verdict.members.iter().map(|member| (member.channel, member.line)).collect()
            }
        };
        assert_eq!(found, expected, "case {case}: {texts:#?} {:#?}", one.summary.verdict);
        for threads in [0, 2] {
            work.options.threads = threads;
            assert!(work.run(None).unwrap().events == one.events, "case {case}, {threads} threads: {texts:#?}");
        }
        let (results, ..) = work.results(None).unwrap();
        assert_eq!(results.summary, one.summary, "case {case}: {texts:#?}");
        alive += usize::from(expected.is_empty());
        spinning[expected.len()] += 1;
    }
    // The programs are not all alike.
    let rare = std::env::var_os("MIXED_CASES").is_none();
    assert!(!rare || alive > 5 && spinning[1..].iter().all(|count| *count > 5), "{alive} alive, {spinning:?}");
}

/// One processor, two, free and beside busy threads, with few threads and many.
#[test]
fn everywhere() {
    processors::everywhere(&processors::FEW_SETTINGS, "everywhere", &[("MIXED_CASES", "10")]);
}
