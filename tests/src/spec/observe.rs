//! Observing changes nothing: an example that is traced, stepped through or stopped at breakpoints has the same log,
//! the same files and the same results.
//!
//! *Invariant:* which ways of observing an example takes in the usual run depends on its name only, so that a failure
//! comes again. One example in `SHARE` takes every way, the others one way or three; together they take all ways many
//! times. `OBSERVE=all` makes every example take every way.

use std::fmt::Write as _;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

use counterpoint_kernel::control::JobControl;
use counterpoint_kernel::event::letters;
use counterpoint_kernel::log::event::{Event, Kind};
use counterpoint_kernel::operator::{
    BreakLocation, Breakpoint, Console, Heard, StepCalls, StepCommand, StepReply, Whom,
};
use counterpoint_mdspec::{Check, Example};

use super::Case;
use crate::{Done, Work};

/// Stops after which the operator leaves, so that programs of many blocks do not take long.
const MOST_STOPS: u32 = 300;

/// One example in this number takes every way.
const SHARE: u64 = 16;

/// Paths of observing that an example takes unless it takes all of them: without macros, and with some.
const USUAL: [usize; 2] = [1, 3];

/// A way of observing a job.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Way {
    /// A letter of the trace; blank: all of them.
    Trace(char),
    /// An operator steps, with each kind of step in turn.
    Steps,
    /// An operator sets breakpoints of every kind, and continues at each.
    Breakpoints,
    /// A thread that looks at the progress again and again.
    Watcher,
    /// This many threads.
    Threads(u16),
}

/// All paths, in an order that never changes.
fn ways() -> Vec<Way> {
    let mut ways: Vec<Way> = letters::ALL.chars().chain([' ']).map(Way::Trace).collect();
    ways.extend([Way::Steps, Way::Breakpoints, Way::Watcher, Way::Threads(2), Way::Threads(3)]);
    ways
}

/// Hash of a name: FNV-1a, the same in every run and on every machine.
fn hash(name: &str) -> u64 {
    name.bytes().fold(0xcbf2_9ce4_8422_2325, |hash: u64, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

/// Whether an example takes every way.
fn takes_all(example: &Example) -> bool {
    (hash(&example.name) >> 40).is_multiple_of(SHARE) || std::env::var_os("OBSERVE").is_some_and(|value| value == "all")
}

/// Paths that an example takes.
fn taken(example: &Example) -> Vec<Way> {
    let all = ways();
    if takes_all(example) {
        return all;
    }
    let hash = hash(&example.name);
    let first = (hash >> 16) as usize % all.len();
    // Paths that lie apart from each other, so that an example takes different kinds.
    let usual = if example.fence("macro").is_some() { USUAL[1] } else { USUAL[0] };
    let apart = all.len().div_ceil(usual);
    (0..usual).filter_map(|at| all.get((first + at * apart) % all.len()).copied()).collect()
}

/// Runs the example in its ways and compares each with the result without them.
pub(super) fn check(example: &Example, case: &Case, plain: &Done, check: &mut Check<'_>) {
    for way in taken(example) {
        let Some(work) = case.work(|options| match way {
            Way::Trace(' ') => letters::ALL.clone_into(&mut options.trace),
            Way::Trace(letter) => options.trace = letter.to_string(),
            Way::Threads(threads) => options.threads = threads,
            _ => {}
        }) else {
            return;
        };
        match observed(way, &work) {
            Ok(done) => {
                if let Some(difference) = difference(plain, &done) {
                    check.wrong(example.line, &format!("{way:?} changes the results: {difference}"));
                }
            }
            Err(error) => check.wrong(example.line, &format!("{way:?}: the job does not start: {error}")),
        }
    }
}

fn observed(way: Way, work: &Work) -> Result<Done, String> {
    let console = match way {
        Way::Steps => Some(Operator::new(Vec::new())),
        Way::Breakpoints => Some(Operator::new(breakpoints(work))),
        _ => None,
    };
    let run = |control: JobControl| match console.clone() {
        Some(console) => control.with_console(console),
        None => control,
    };
    work.run_with(run, way == Way::Watcher).map_err(|error| error.to_string())
}

/// Breakpoints at every wait, at lines of every file, at every variable that channels may share, and at a time.
fn breakpoints(work: &Work) -> Vec<StepCommand> {
    let mut spots = vec![BreakLocation::Wait(String::new()), BreakLocation::Time(1)];
    spots.extend((1..=40).map(|line| BreakLocation::Line { file: String::new(), line }));
    let numbered = (100..130).chain(500..530).map(|number| format!("#{number}"));
    let declared = work.machine.macros.iter().flat_map(|macros| macros.program.globals.iter().cloned());
    spots.extend(numbered.chain(declared.take(300)).map(BreakLocation::Write));
    spots.into_iter().map(|spot| StepCommand::Add(Breakpoint { id: 0, spot, count: 0, once: false })).collect()
}

/// Sets breakpoints at the first stop; then steps, or continues where there are breakpoints.
struct Operator {
    first: Vec<StepCommand>,
    turn: AtomicU32,
    stops: AtomicU32,
}

impl Operator {
    fn new(first: Vec<StepCommand>) -> Arc<Self> {
        Arc::new(Self { first, turn: AtomicU32::new(0), stops: AtomicU32::new(0) })
    }
}

impl Console for Operator {
    fn has_news(&self) -> bool {
        false
    }

    fn poll(&self) -> Heard {
        Heard::Nothing
    }

    fn wait(&self, _at_most: Duration) -> Heard {
        let turn = self.turn.fetch_add(1, Ordering::Relaxed) as usize;
        if self.stops.load(Ordering::Relaxed) > MOST_STOPS {
            return Heard::Gone;
        }
        Heard::Command(match (self.first.get(turn), self.first.is_empty(), turn % 6) {
            (Some(command), ..) => command.clone(),
            (None, false, _) => StepCommand::Continue,
            (None, true, 0) => StepCommand::Step { whom: Whom::Next, blocks: 1, calls: StepCalls::Into },
            (None, true, 1) => StepCommand::Step { whom: Whom::One(1), blocks: 1, calls: StepCalls::Into },
            (None, true, 2) => StepCommand::Show,
            (None, true, 3) => StepCommand::Step { whom: Whom::One(1), blocks: 1, calls: StepCalls::Over },
            (None, true, 4) => StepCommand::Step { whom: Whom::One(1), blocks: 1, calls: StepCalls::Out },
            (None, true, _) => StepCommand::Step { whom: Whom::All, blocks: 2, calls: StepCalls::Into },
        })
    }

    fn say(&self, said: StepReply) {
        if matches!(said, StepReply::Stopped(_)) {
            self.stops.fetch_add(1, Ordering::Relaxed);
        }
    }
}

/// The first thing that is not the same, apart from lines of the trace.
fn difference(plain: &Done, observed: &Done) -> Option<String> {
    let told = |done: &Done| -> Vec<Event> {
        let shown = |event: &&Event| !matches!(&event.kind, Kind::Trace(line) if line.listing.is_none());
        done.events.iter().filter(shown).cloned().collect()
    };
    let (one, other) = (told(plain), told(observed));
    if let Some((one, other)) = one.iter().zip(&other).find(|(one, other)| one != other) {
        return Some(format!("\n  plain    {one:?}\n  observed {other:?}"));
    }
    if one.len() != other.len() {
        let mut text = format!("{} events and {}", one.len(), other.len());
        let longer = if one.len() > other.len() { &one } else { &other };
        if let Some(event) = longer.get(one.len().min(other.len())) {
            let _ = write!(text, "\n  further {event:?}");
        }
        return Some(text);
    }
    if plain.files != observed.files {
        return Some("other files".to_owned());
    }
    let mut summary = observed.summary.clone();
    summary.log_digest.clone_from(&plain.summary.log_digest);
    (summary != plain.summary).then(|| "another summary".to_owned())
}

#[cfg(test)]
mod tests {
    use super::{taken, takes_all, ways};
    use crate::spec::{FENCES, folder};
    use counterpoint_mdspec::{Example, Fence, Page};

    fn examples() -> Vec<Example> {
        let files = std::fs::read_dir(folder("emulator")).unwrap().flatten();
        files.filter_map(|entry| Page::read(&entry.path(), FENCES).ok()).flat_map(|page| page.examples).collect()
    }

    #[test]
    fn every_way_is_taken_by_many_examples() {
        let mut counts = vec![0; ways().len()];
        for way in examples().iter().flat_map(taken) {
            counts[ways().iter().position(|known| *known == way).unwrap()] += 1;
        }
        assert!(counts.iter().all(|count| *count >= 150), "{counts:?}");
    }

    #[test]
    fn examples_of_all_kinds_take_every_way() {
        let all: Vec<Example> = examples().into_iter().filter(takes_all).collect();
        let with = |kind: &str, wanted: &str| {
            let is = |fence: &Fence| {
                fence.kind == kind && (wanted.is_empty() || fence.words.split(' ').any(|word| word == wanted))
            };
            all.iter().filter(|example| example.fences.iter().any(is)).count()
        };
        assert!(all.len() >= 80, "{}", all.len());
        assert!(with("macro", "") >= 10 && with("nc", "2") >= 5, "{} {}", with("macro", ""), with("nc", "2"));
    }
}
