//! Decides for which machine of a control the programs were written.
//!
//! Every trait of the machines (milling, turning, five axes) has a weight: that of its signs in the programs. It counts
//! for the machines that have the trait, and against those that do not. *Invariant:* a machine is chosen only if all
//! its traits show, or if no other machine has as many channels.

use std::collections::BTreeSet;
use std::ops::RangeInclusive;

use super::controls::{ControlEvidence, decide};
use super::evidence::{self, Evidence, ExaminedProgram, FoundSign};
use super::pattern::SignPattern;
use super::{Guess, MachineCandidate};

/// Weight from which signs are enough.
const ENOUGH: u32 = 2;

/// Guesses the machine for programs, left to right, among `candidates`.
///
/// `waits` are the M codes that are waiting codes, if they differ from those of the machines. Only the first
/// [`searched_bytes`](super::searched_bytes) of each program count. The search ends early if `stop` returns true.
///
/// # Errors
///
/// The reason why no machine can be chosen, as the rest of a sentence.
pub fn guess(
    candidates: &[MachineCandidate],
    programs: &[ExaminedProgram],
    waits: Option<&RangeInclusive<u32>>,
    stop: &dyn Fn() -> bool,
) -> Result<Guess, String> {
    let candidates = &with_waits(candidates, waits);
    let tables = candidates.iter().flat_map(|candidate| {
        let signs = &candidate.signs;
        let named = signs.elsewhere.iter().chain(&signs.traits).map(|(_, rows)| rows);
        [&signs.marks, &signs.waits, &signs.channels].into_iter().chain(named)
    });
    let patterns: Vec<&SignPattern> = tables.flatten().map(|(pattern, _)| pattern).collect();
    let evidence = Evidence::of(programs, &patterns, stop)?;
    let control = decide(candidates, &evidence)?;
    let of_control = candidates.iter().filter(|candidate| candidate.signs.control == control.title);
    let machines: Vec<_> = of_control.map(|candidate| MachineEvidence::of(candidate, &evidence)).collect();
    Judge { programs, evidence: &evidence, control: &control, machines }.judge()
}

/// The candidates with other waiting codes.
fn with_waits(candidates: &[MachineCandidate], waits: Option<&RangeInclusive<u32>>) -> Vec<MachineCandidate> {
    let mut candidates = candidates.to_vec();
    if let Some(waits) = waits {
        for (pattern, _) in candidates.iter_mut().flat_map(|candidate| &mut candidate.signs.waits) {
            if pattern.is_m_codes() {
                *pattern = SignPattern::m_codes(*waits.start(), *waits.end());
            }
        }
    }
    candidates
}

/// A candidate with its signs in the programs.
struct MachineEvidence<'c> {
    candidate: &'c MachineCandidate,
    /// Its traits with their signs.
    traits: Vec<(&'c str, Vec<FoundSign<'c>>)>,
    waits: Vec<FoundSign<'c>>,
}

impl<'c> MachineEvidence<'c> {
    fn of(candidate: &'c MachineCandidate, evidence: &'c Evidence) -> Self {
        let traits = candidate.signs.traits.iter().map(|(name, rows)| (name.as_str(), evidence.shown(rows))).collect();
        Self { candidate, traits, waits: evidence.shown(&candidate.signs.waits) }
    }

    /// Weight of its signs, each counted once.
    fn weight(&self) -> u32 {
        let mut counted: Vec<FoundSign<'c>> = Vec::new();
        for sign in self.signs() {
            match counted.iter_mut().find(|known| known.pattern == sign.pattern) {
                Some(known) => known.weight = known.weight.max(sign.weight),
                None => counted.push(*sign),
            }
        }
        weight(&counted)
    }

    fn has(&self, name: &str) -> bool {
        self.traits.iter().any(|(own, _)| *own == name)
    }

    /// Whether the signs of all its traits show.
    fn is_proven(&self) -> bool {
        self.traits.iter().all(|(_, shown)| !shown.is_empty())
    }

    /// Whether it differs from another machine by further properties only, one of which nothing shows.
    fn only_adds_to(&self, plainer: &Self) -> bool {
        let has = |of: &Self, name: &str| of.traits.iter().any(|(own, _)| *own == name);
        plainer.traits.iter().all(|(name, _)| has(self, name))
            && self.traits.iter().any(|(name, shown)| shown.is_empty() && !has(plainer, name))
    }

    /// Whether it has the channels that a single program commands.
    fn has_partners(&self, partners: usize) -> bool {
        if partners > 1 { self.candidate.channels >= partners } else { self.takes(1, false) }
    }

    fn signs(&self) -> impl Iterator<Item = &FoundSign<'c>> {
        self.traits.iter().flat_map(|(_, shown)| shown)
    }

    fn takes(&self, channels: usize, several: bool) -> bool {
        let has = self.candidate.channels;
        match (several, self.candidate.whole_file) {
            (false, true) => true,
            (true, true) => has > 1 && channels <= has,
            _ => has == channels,
        }
    }
}

fn weight<'s>(signs: impl IntoIterator<Item = &'s FoundSign<'s>>) -> u32 {
    signs.into_iter().map(|sign| sign.weight).sum()
}

struct Judge<'c> {
    programs: &'c [ExaminedProgram],
    evidence: &'c Evidence,
    control: &'c ControlEvidence<'c>,
    machines: Vec<MachineEvidence<'c>>,
}

/// A machine with the weights for and against it.
struct MachineScore<'j, 'c> {
    machine: &'j MachineEvidence<'c>,
    by: u32,
    /// Traits that show and that it does not have.
    against: Vec<(&'c str, Vec<FoundSign<'c>>)>,
}

impl MachineScore<'_, '_> {
    fn against(&self) -> u32 {
        self.against.iter().map(|(_, shown)| weight(shown)).sum()
    }

    fn score(&self) -> i64 {
        i64::from(self.by) - i64::from(self.against())
    }
}

impl<'c> Judge<'c> {
    /// Channels that the programs are written for: one for each file; a single file with waiting codes has one for each
    /// program in it, and an archive one for each main program.
    fn channels(&self) -> usize {
        let [program] = self.programs else { return self.programs.len() };
        if program.part {
            return 1;
        }
        let waits = self.machines.iter().any(|machine| !machine.waits.is_empty());
        let definitions = if waits { self.evidence.definitions } else { 0 };
        definitions.max(self.evidence.mains).max(1)
    }

    /// Whether a wait that the programs show is a mark of the control, too.
    fn are_waits_marks(&self) -> bool {
        let is_mark = |wait: &FoundSign<'_>| self.control.shown.iter().any(|mark| mark.pattern == wait.pattern);
        self.machines.iter().flat_map(|machine| &machine.waits).any(is_mark)
    }

    /// Channels that the machine must have for the commands of the programs to other channels.
    fn partners(&self) -> usize {
        let shown = self.machines.iter().flat_map(|machine| self.evidence.shown(&machine.candidate.signs.channels));
        shown.map(|sign| sign.weight as usize).max().unwrap_or(1)
    }

    fn judge(&self) -> Result<Guess, String> {
        let several = self.programs.len() > 1;
        let (channels, partners) = (self.channels(), self.partners());
        let alone: Vec<_> = self.machines.iter().filter(|m| !several && m.has_partners(partners)).collect();
        let together: Vec<_> = self.machines.iter().filter(|m| channels > 1 && m.takes(channels, several)).collect();
        // Programs with waits that only this control has are for no machine with a single channel.
        let wait = self.evidence.mains == channels && !together.is_empty() && self.are_waits_marks();
        let alone = if wait { Vec::new() } else { alone };
        let mut fit: Vec<_> = [alone, together.clone()].concat();
        fit.sort_by_key(|machine| &machine.candidate.name);
        fit.dedup_by_key(|machine| &machine.candidate.name);
        if several {
            // A machine with a property that nothing shows gives way to one without this property.
            let plain = fit.clone();
            fit.retain(|machine| !plain.iter().any(|plainer| machine.only_adds_to(plainer)));
        }
        if fit.is_empty() {
            return Err(self.for_control(&no_machine(channels.max(partners))));
        }
        let sole = fit.len() == 1;
        let names: Vec<&str> = fit.iter().map(|machine| machine.candidate.name.as_str()).collect();
        let mut verdicts: Vec<_> = fit.into_iter().map(|machine| self.verdict(machine, channels)).collect();
        verdicts.sort_by_key(|verdict| std::cmp::Reverse(verdict.score()));
        let proven = |verdict: &&MachineScore<'_, '_>| sole || verdict.machine.is_proven();
        let mut proven = verdicts.iter().filter(proven);
        let Some(best) = proven.next() else {
            // A fault of several programs says more than that their machine is not known.
            let likely = verdicts.first().filter(|_| several);
            let fault = likely.and_then(|verdict| self.accept(verdict, channels, (true, together.is_empty())).err());
            return Err(fault.unwrap_or_else(|| self.unproven(&names)));
        };
        if let Some(other) = proven.next().filter(|other| other.score() == best.score()) {
            if best.by < best.against() * 2 && !several {
                return Err(self.disagree(best));
            }
            let (one, other) = (&best.machine.candidate.name, &other.machine.candidate.name);
            return Err(self.for_control(&format!("nothing shows whether it is for {one} or {other}")));
        }
        self.accept(best, channels, (sole, together.is_empty()))
    }

    /// A sign counts for a machine with its weight there. If it weighs more for another machine, the difference counts
    /// against.
    fn verdict<'j>(&self, machine: &'j MachineEvidence<'c>, channels: usize) -> MachineScore<'j, 'c> {
        let mut against: Vec<(&'c str, Vec<FoundSign<'c>>)> = Vec::new();
        for (name, shown) in self.machines.iter().flat_map(|other| &other.traits) {
            for sign in shown {
                let own = machine.signs().filter(|own| own.pattern == sign.pattern).map(|own| own.weight).max();
                let more = sign.weight.saturating_sub(own.unwrap_or(0));
                let known = against.iter_mut().flat_map(|(_, signs)| signs).find(|known| known.pattern == sign.pattern);
                match known {
                    Some(known) => known.weight = known.weight.max(more),
                    None if more > 0 => {
                        let mut sign = *sign;
                        sign.weight = more;
                        match against.iter_mut().find(|(known, _)| known == name) {
                            Some((_, signs)) => signs.push(sign),
                            None => against.push((name, vec![sign])),
                        }
                    }
                    None => {}
                }
            }
        }
        let mut by = machine.weight();
        if channels > 1 && machine.candidate.channels > 1 {
            by += weight(&machine.waits);
        }
        MachineScore { machine, by, against }
    }

    /// The best machine, unless the weight against it is too large.
    fn accept(
        &self,
        best: &MachineScore<'_, 'c>,
        channels: usize,
        (sole, none_together): (bool, bool),
    ) -> Result<Guess, String> {
        let machine = best.machine;
        let several = self.programs.len() > 1;
        let against = best.against();
        if (several || self.evidence.mains == channels && channels > 1 && sole) && best.by < against * 2 {
            let (names, signs) = names(&best.against);
            let shown = self.evidence.named(&signs);
            return Err(self.for_control(&format!(
                "the {channels} programs show {names} ({shown}): no such machine with {channels} channels is shipped; run the \
                 programs one by one"
            )));
        }
        if several && machine.waits.is_empty() {
            let hint = evidence::common_m_code(self.programs).map_or_else(String::new, |code| {
                let first = code / 100 * 100;
                format!(", or add --set waits={first}-{} if M{code} is a waiting code", first + 99)
            });
            return Err(self.for_control(&format!(
                "the {channels} programs never wait for each other, so they may be {channels} jobs: run them one by one{hint}"
            )));
        }
        // Programs that wait for each other are not one job for one channel of a machine of the same kind.
        let multi = |name: &str| self.machines.iter().any(|other| other.candidate.channels > 1 && other.has(name));
        if channels > 1 && none_together && machine.traits.iter().any(|(name, _)| multi(name)) {
            return Err(self.for_control(&no_machine(channels)));
        }
        if machine.traits.is_empty() && self.control.shown.iter().all(FoundSign::is_name) {
            return Err(self.for_control("nothing but the name shows it"));
        }
        let needs = !self.control.is_marked() || !machine.traits.is_empty() && !sole;
        if best.by < ENOUGH && needs {
            return Err(self.unproven(&self.machines.iter().map(|one| one.candidate.name.as_str()).collect::<Vec<_>>()));
        }
        if best.by < against * 2 {
            return Err(self.disagree(best));
        }
        self.check_axes(machine)?;
        Ok(Guess { machine: machine.candidate.name.clone(), why: self.why(machine, channels) })
    }

    /// Refuses a machine without a rotary axis that the programs move. Checks only machines that are guessed by their
    /// rotary axes or have only X, Y and Z.
    fn check_axes(&self, machine: &MachineEvidence<'_>) -> Result<(), String> {
        let traits =
            |machine: &'_ MachineEvidence<'c>| machine.candidate.signs.traits.iter().flat_map(|(_, rows)| rows);
        let by_axes = machine.candidate.signs.traits.iter().flat_map(|(_, rows)| rows);
        let plain = machine.candidate.axes.iter().collect::<String>() == "XYZ";
        if !plain && !by_axes.into_iter().any(|(pattern, _)| pattern.rotary_axes().len() > 1) {
            return Ok(());
        }
        let of_axes = self.machines.iter().flat_map(traits).filter(|(pattern, _)| !pattern.rotary_axes().is_empty());
        let rows: Vec<_> = of_axes.collect();
        let shown = self.evidence.shown(rows.iter().copied());
        let is_shown = |pattern: &SignPattern| shown.iter().any(|sign| sign.pattern == pattern.text());
        let moved: BTreeSet<char> = rows
            .iter()
            .filter(|(pattern, _)| is_shown(pattern))
            .flat_map(|(pattern, _)| pattern.rotary_axes())
            .collect();
        if moved.iter().all(|letter| machine.candidate.axes.contains(letter)) {
            return Ok(());
        }
        let name = &machine.candidate.name;
        let list = |letters: Vec<char>| letters.iter().map(char::to_string).collect::<Vec<_>>().join(" and ");
        let own: Vec<_> = ['A', 'B', 'C'].into_iter().filter(|own| machine.candidate.axes.contains(own)).collect();
        let own = if own.is_empty() { "no rotary axis".to_owned() } else { list(own) };
        let (moved, places) = (list(moved.into_iter().collect()), self.evidence.named(&shown));
        Err(self.for_control(&format!(
            "the program moves {moved} ({places}): no shipped machine of its kind has {moved}; {name} has {own}. Make a \
             machine of your own from it (counterpoint machine new DIR --from {name}), and change its axes"
        )))
    }

    /// Signs speak for the best machine and against it.
    fn disagree(&self, best: &MachineScore<'_, 'c>) -> String {
        let (others, signs) = names(&best.against);
        let (own, shown) = names(&best.machine.traits);
        let (shown, signs) = (self.evidence.named(&shown), self.evidence.named(&signs));
        self.for_control(&format!("the program shows {own} ({shown}) as well as {others} ({signs})"))
    }

    fn why(&self, machine: &MachineEvidence<'_>, channels: usize) -> String {
        let mut parts = Vec::new();
        if channels > 1 {
            let of = if self.programs.len() > 1 { "programs" } else { "programs of one file" };
            let with = if machine.waits.is_empty() { "" } else { " with waiting codes" };
            parts.push(format!("{channels} {of}{with}"));
        }
        if self.control.is_marked() {
            parts.push(self.evidence.named(&self.control.shown));
        }
        let traits = machine.traits.iter();
        parts.extend(traits.map(|(_, shown)| self.evidence.named(shown)));
        let mut all: Vec<&str> = Vec::new();
        for one in parts.iter().flat_map(|part| part.split(", ")).filter(|one| !one.is_empty()) {
            if !all.contains(&one) {
                all.push(one);
            }
        }
        all.join(", ")
    }

    /// No machine of these has all its traits shown.
    fn unproven(&self, names: &[&str]) -> String {
        if !self.control.is_marked() {
            return self.nothing();
        }
        self.for_control(&format!("{} are shipped, and nothing shows which one it is for", names.join(" and ")))
    }

    fn nothing(&self) -> String {
        let names: Vec<&str> = self.programs.iter().map(|program| program.name.as_str()).collect();
        format!("nothing in {} shows which machine it is for", names.join(" "))
    }

    /// A reason with the marks that decided the control.
    fn for_control(&self, why: &str) -> String {
        if !self.control.is_marked() {
            return why.to_owned();
        }
        let marks = self.evidence.named(&self.control.shown);
        format!("the program is for {}, judging by {marks}: {why}", self.control.title)
    }
}

/// Names of traits that show, and their signs.
fn names<'s>(traits: &[(&'s str, Vec<FoundSign<'s>>)]) -> (String, Vec<FoundSign<'s>>) {
    let shown: Vec<_> = traits.iter().filter(|(_, shown)| !shown.is_empty()).collect();
    let names = shown.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(" and ");
    (names, shown.iter().flat_map(|(_, shown)| shown.iter().copied()).collect())
}

/// No machine of the control has as many channels.
fn no_machine(channels: usize) -> String {
    let plural = if channels == 1 { "channel" } else { "channels" };
    format!("no such machine with {channels} {plural} is shipped")
}
