//! Breakpoints: waits, writes of shared variables, lines, times.
//!
//! Invariant: they inspect the progress of a kernel and change nothing.

use counterpoint_event::SourcePlace;
use counterpoint_event::info::Info;
use counterpoint_machine::Machine;
use counterpoint_ports::step::{BreakLocation, Breakpoint, KernelSnapshot, StepEvent};

/// Breakpoints of a job at most.
const MOST: usize = 1000;

/// The breakpoints of a job.
#[derive(Debug, Default)]
pub(super) struct Breakpoints {
    list: Vec<ArmedBreakpoint>,
    last_id: u32,
}

/// A breakpoint, and how often it was hit.
#[derive(Debug)]
struct ArmedBreakpoint {
    of: Breakpoint,
    hits: u32,
}

impl Breakpoints {
    /// All of them.
    pub(super) fn all(&self) -> Vec<Breakpoint> {
        self.list.iter().map(|set| set.of.clone()).collect()
    }

    /// Sets one; returns it with its number.
    pub(super) fn add(
        &mut self,
        breakpoint: Breakpoint,
        may_hit: impl Fn(&BreakLocation) -> Result<(), String>,
    ) -> Result<Breakpoint, String> {
        if self.list.len() >= MOST {
            return Err(format!("there are {MOST} breakpoints already: delete some"));
        }
        match &breakpoint.spot {
            BreakLocation::Write(name) if name.trim().is_empty() => {
                return Err("a breakpoint on a write needs the name of a variable, such as #500".to_owned());
            }
            BreakLocation::Line { line: 0, .. } => return Err("lines count from 1".to_owned()),
            BreakLocation::Time(ns) if *ns < 0 => return Err("simulated time begins at 0".to_owned()),
            spot => may_hit(spot)?,
        }
        self.last_id += 1;
        let of = Breakpoint { id: self.last_id, ..breakpoint };
        self.list.push(ArmedBreakpoint { of: of.clone(), hits: 0 });
        Ok(of)
    }

    /// Deletes one by its number, 0 = all.
    pub(super) fn remove(&mut self, id: u32) -> Result<(), String> {
        if id > 0 && !self.list.iter().any(|set| set.of.id == id) {
            return Err(format!("there is no breakpoint {id}"));
        }
        self.list.retain(|set| id > 0 && set.of.id != id);
        Ok(())
    }

    /// Counts a hit of each breakpoint there; the number of the first one that stops the run.
    fn hit(&mut self, is_there: impl Fn(&BreakLocation) -> bool) -> Option<u32> {
        let mut stops = None;
        for set in self.list.iter_mut().filter(|set| is_there(&set.of.spot)) {
            set.hits = set.hits.saturating_add(1);
            if set.hits.is_multiple_of(set.of.count.max(1)) {
                stops.get_or_insert(set.of.id);
            }
        }
        let spent = |set: &ArmedBreakpoint| {
            let stopped = set.hits > 0 && set.hits.is_multiple_of(set.of.count.max(1)) && is_there(&set.of.spot);
            stopped && (set.of.once || matches!(set.of.spot, BreakLocation::Time(_)))
        };
        self.list.retain(|set| !spent(set));
        stops
    }

    /// Why the run stops within a block, as an action of its channel.
    pub(super) fn hit_by(&mut self, event: StepEvent<'_>) -> Option<String> {
        if self.list.is_empty() {
            return None;
        }
        let id = self.hit(|spot| match (spot, event) {
            (BreakLocation::Wait(key), StepEvent::Wait(wait, number)) => is_wait(key, (&wait.key, &wait.mark), number),
            (BreakLocation::Write(wanted), StepEvent::Write(name, _)) => is_same(wanted, name),
            _ => false,
        })?;
        Some(match event {
            StepEvent::Wait(wait, _) => format!("reaches {} (breakpoint {id})", wait.key),
            StepEvent::Write(name, Some(value)) => format!("has written {name}={value} (breakpoint {id})"),
            StepEvent::Write(name, None) => format!("has written {name} (breakpoint {id})"),
        })
    }

    /// Whether there are none.
    pub(super) fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Whether a breakpoint is at this line.
    pub(super) fn is_at(&self, place: SourcePlace, info: &Info) -> bool {
        self.list.iter().any(|set| match &set.of.spot {
            BreakLocation::Line { file, line } => *line == place.line && is_file(file, info.file_name(place.file)),
            _ => false,
        })
    }

    /// Whether a breakpoint is before this block, which may or may not stop the run.
    pub(super) fn may_stop_before(&self, seen: &KernelSnapshot, info: &Info) -> bool {
        self.list.iter().any(|set| match &set.of.spot {
            BreakLocation::Line { file, line } => *line == seen.line && is_file(file, info.file_name(seen.file)),
            BreakLocation::Time(ns) => seen.t_ns >= *ns,
            BreakLocation::Wait(_) | BreakLocation::Write(_) => false,
        })
    }

    /// Why the run stops before a block, as an action of its channel.
    pub(super) fn hit_before(&mut self, seen: &KernelSnapshot, info: &Info) -> Option<String> {
        if self.list.is_empty() {
            return None;
        }
        let file = info.file_name(seen.file);
        let id = self.hit(|spot| match spot {
            BreakLocation::Line { file: wanted, line } => *line == seen.line && is_file(wanted, file),
            BreakLocation::Time(ns) => seen.t_ns >= *ns,
            BreakLocation::Wait(_) | BreakLocation::Write(_) => false,
        })?;
        Some(format!("reaches {file}:{} (breakpoint {id})", seen.line))
    }
}

/// Whether a channel can reach a breakpoint.
pub(super) fn may_hit(spot: &BreakLocation, info: &Info, machine: &Machine) -> Result<(), String> {
    match spot {
        BreakLocation::Line { file, line } => may_come(file, *line, info, machine),
        BreakLocation::Write(name) => may_write(name.trim(), info, machine),
        BreakLocation::Wait(_) | BreakLocation::Time(_) => Ok(()),
    }
}

/// Refuses a variable whose write cannot stop the run. Accepted are a shared numbered variable and a name in a text of
/// the job.
fn may_write(name: &str, info: &Info, machine: &Machine) -> Result<(), String> {
    let number = name.strip_prefix('#').and_then(|number| number.trim().parse::<u32>().ok());
    let Some(number) = number else { return may_name(name, info, machine) };
    let mut shared: Vec<(u32, u32)> = Vec::new();
    for (_, machine) in machine.definitions() {
        shared.extend(
            machine.variables.shared.iter().filter(|range| !shared.contains(range)).copied().collect::<Vec<_>>(),
        );
    }
    if shared.iter().any(|(first, last)| (*first..=*last).contains(&number)) {
        return Ok(());
    }
    let ranges: Vec<String> = shared.iter().map(|(first, last)| format!("#{first} to #{last}")).collect();
    let has = if ranges.is_empty() { "none".to_owned() } else { ranges.join(", ") };
    Err(format!(
        "#{number} belongs to each channel: a run stops only at shared variables, and this machine shares {has}"
    ))
}

/// Whether a text of the job has the letters of a name; its index may be computed. A file that no channel has read yet
/// may have any name.
fn may_name(name: &str, info: &Info, machine: &Machine) -> Result<(), String> {
    let letters: String = name
        .chars()
        .take_while(|c| c.is_ascii_alphabetic() || matches!(c, '_' | '$'))
        .collect::<String>()
        .to_uppercase();
    let has = |text: &[u8]| {
        let wanted = letters.as_bytes();
        wanted.is_empty() || text.windows(wanted.len()).any(|part| part.eq_ignore_ascii_case(wanted))
    };
    for file in &info.files {
        match file.text.get().and_then(Option::as_ref) {
            Some(text) if !has(text.bytes()) => {}
            _ => return Ok(()),
        }
    }
    let machines = std::iter::once(machine).chain(machine.definitions().map(|(_, machine)| machine));
    let macros = machines.filter_map(|machine| machine.macros.as_deref());
    let sources = macros.flat_map(|macros| &macros.program.macros).map(|code| code.source.text.as_bytes());
    if sources.into_iter().any(has) {
        return Ok(());
    }
    Err(format!("no program or macro of this job has a variable '{name}'"))
}

/// Whether a block may begin in this line of a file of the job. A file that no channel has read yet may have any lines.
fn may_come(wanted: &str, line: u32, info: &Info, machine: &Machine) -> Result<(), String> {
    let (mut most, mut mark) = (0, false);
    let rewind = machine.format.rws.as_bytes();
    for file in info.files.iter().filter(|file| is_file(wanted, &file.name)) {
        let Some(text) = file.text.get().and_then(Option::as_ref) else { return Ok(()) };
        if line <= text.lines() {
            let own = text.line(line).trim_ascii();
            mark |= !rewind.is_empty() && own == rewind;
            if !own.is_empty() && own != rewind {
                return Ok(());
            }
        }
        most = most.max(text.lines());
    }
    let files = || info.files.iter().take(10).map(|file| file.name.as_str()).collect::<Vec<_>>().join(", ");
    Err(match most {
        0 => format!("the job has no file '{wanted}'; it has {}", files()),
        most if line > most => format!("there is no line {line}: the file has {most} lines"),
        _ if mark => format!("line {line} is a rewind-stop: no block begins there"),
        _ => format!("line {line} is blank: no block begins there"),
    })
}

/// Whether both are the same except for blanks and letter case.
fn is_same(one: &str, other: &str) -> bool {
    let letters = |text: &str| text.chars().filter(|c| !c.is_whitespace()).map(|c| c.to_ascii_uppercase()).collect();
    let (one, other): (String, String) = (letters(one), letters(other));
    one == other
}

/// Whether a text names a wait by its whole text, its mark, its number, or its text without the list of channels.
fn is_wait(wanted: &str, (text, mark): (&str, &str), number: u32) -> bool {
    let word = text.split([' ', 'P', 'p']).next().unwrap_or("");
    wanted.trim().is_empty()
        || is_same(wanted, text)
        || is_same(wanted, mark)
        || is_same(wanted, word)
        || wanted.trim().parse() == Ok(number)
}

/// Whether a text names a file by its path or the end of it.
fn is_file(wanted: &str, name: &str) -> bool {
    let end = name.strip_suffix(wanted);
    wanted.is_empty() || end.is_some_and(|before| before.is_empty() || before.ends_with(['/', '\\']))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wait(key: &str) -> Breakpoint {
        Breakpoint { id: 0, spot: BreakLocation::Wait(key.into()), count: 0, once: false }
    }

    #[test]
    fn a_wait_is_known_by_text_word_mark_and_number() {
        for wanted in ["M101 P12", "m101p12", "M101", "101", " 101 ", ""] {
            assert!(is_wait(wanted, ("M101 P12", "101"), 101), "{wanted}");
        }
        for wanted in ["M102", "10", "M101 P13"] {
            assert!(!is_wait(wanted, ("M101 P12", "101"), 101), "{wanted}");
        }
        assert!(is_wait("WAITM(10, 1, 2)", ("WAITM(10,1,2)", "WAITM10"), 10));
        assert!(is_wait("10", ("WAITM(10,1,2)", "WAITM10"), 10));
    }

    #[test]
    fn a_file_is_known_by_the_end_of_its_path() {
        assert!(is_file("p1.nc", "jobs/p1.nc") && is_file("jobs/p1.nc", "jobs/p1.nc") && is_file("", "x"));
        assert!(!is_file("1.nc", "jobs/p1.nc") && !is_file("p2.nc", "jobs/p1.nc"));
    }

    #[test]
    fn a_breakpoint_counts_and_may_be_spent() {
        let mut set = Breakpoints::default();
        assert_eq!(set.add(Breakpoint { count: 2, once: true, ..wait("") }, |_| Ok(())).unwrap().id, 1);
        assert_eq!(set.add(wait("102"), |_| Ok(())).unwrap().id, 2);
        assert_eq!(set.hit(|spot| matches!(spot, BreakLocation::Wait(key) if key.is_empty())), None);
        assert_eq!(set.hit(|spot| matches!(spot, BreakLocation::Wait(key) if key.is_empty())), Some(1));
        assert_eq!(set.all().len(), 1, "the first one is spent");
        assert_eq!(set.hit(|_| true), Some(2));
        assert_eq!(set.remove(1), Err("there is no breakpoint 1".to_owned()));
        assert_eq!(set.remove(0), Ok(()));
        assert_eq!(set.hit(|_| true), None);
        assert!(set.add(Breakpoint { spot: BreakLocation::Write(" ".into()), ..wait("") }, |_| Ok(())).is_err());
        assert!(
            set.add(Breakpoint { spot: BreakLocation::Line { file: String::new(), line: 0 }, ..wait("") }, |_| Ok(()))
                .is_err()
        );
    }
}
