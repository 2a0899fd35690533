//! Decides for which control the programs were written.
//!
//! *Invariant:* a mark of one control counts against every control that does not have it, even if no machine has that
//! control.

use std::collections::BTreeMap;

use super::evidence::{Evidence, FoundSign};
use super::{MachineCandidate, Rows};

/// Controls named in an answer.
const NAMED: usize = 4;

/// A control with its marks in the programs.
#[derive(Debug)]
pub(crate) struct ControlEvidence<'c> {
    /// Name of the control in messages.
    pub(crate) title: &'c str,
    /// Whether a machine has this control.
    here: bool,
    /// Whether programs without marks are for this control.
    plain: bool,
    /// Its marks, those that the programs show.
    pub(crate) shown: Vec<FoundSign<'c>>,
    /// Weight of its own marks; programs without marks are for a plain control.
    own: u32,
    /// Marks of others that it does not have.
    foreign: BTreeMap<&'c str, u32>,
}

impl ControlEvidence<'_> {
    /// Whether the programs show that they are for this control and no other.
    pub(crate) fn is_marked(&self) -> bool {
        !self.plain && !self.shown.is_empty()
    }

    fn against(&self) -> u32 {
        self.foreign.values().sum()
    }

    fn score(&self) -> i64 {
        i64::from(self.own) - i64::from(self.against())
    }
}

/// All controls, including those without a machine, the most likely first.
fn controls<'c>(candidates: &'c [MachineCandidate], evidence: &'c Evidence) -> Vec<ControlEvidence<'c>> {
    let mut rows: BTreeMap<(bool, &str), (bool, Vec<&Rows>)> = BTreeMap::new();
    for MachineCandidate { signs, .. } in candidates {
        let known = rows.entry((false, &signs.control)).or_default();
        known.0 |= signs.plain;
        known.1.push(&signs.marks);
        for (title, marks) in &signs.elsewhere {
            rows.entry((true, title)).or_default().1.push(marks);
        }
    }
    let mut all: Vec<ControlEvidence<'c>> = rows
        .into_iter()
        .map(|((elsewhere, title), (plain, rows))| {
            let shown = evidence.shown(rows.into_iter().flatten());
            let own = u32::from(plain) + shown.iter().map(|mark| mark.weight).sum::<u32>();
            ControlEvidence { title, here: !elsewhere, plain, shown, own, foreign: BTreeMap::new() }
        })
        .collect();
    let marks: Vec<(&str, u32)> = all.iter().flat_map(|one| one.shown.iter().map(|m| (m.pattern, m.weight))).collect();
    for control in &mut all {
        for (pattern, weight) in &marks {
            if control.shown.iter().all(|own| own.pattern != *pattern) {
                let known = control.foreign.entry(pattern).or_default();
                *known = (*known).max(*weight);
            }
        }
    }
    all.sort_by_key(|control| std::cmp::Reverse(control.score()));
    all
}

/// The control of the programs, or the reason why it cannot be decided.
pub(crate) fn decide<'c>(
    candidates: &'c [MachineCandidate],
    evidence: &'c Evidence,
) -> Result<ControlEvidence<'c>, String> {
    let mut all = controls(candidates, evidence);
    if all.is_empty() {
        return Err("no machine has signs".to_owned());
    }
    let first = all.remove(0);
    let equal: Vec<&str> = all.iter().filter(|other| other.score() == first.score()).map(|one| one.title).collect();
    if !equal.is_empty() && !first.shown.is_empty() {
        let titles = std::iter::once(first.title).chain(equal).take(NAMED).collect::<Vec<_>>().join(", ");
        let marks = evidence.named(&first.shown);
        return Err(format!("the program may be for any of several controls, judging by {marks}: {titles}"));
    }
    if first.against() * 2 > first.own {
        return Err(disagree(&first, &all, evidence));
    }
    if first.plain && evidence.lines.are_no_program() {
        return Err("too many lines of the text are no blocks of words".to_owned());
    }
    if !first.here {
        let marks = evidence.named(&first.shown);
        return Err(format!(
            "the program is for {}, judging by {marks}: no shipped machine has such a control",
            first.title
        ));
    }
    Ok(first)
}

/// Marks of several controls.
fn disagree(first: &ControlEvidence<'_>, all: &[ControlEvidence<'_>], evidence: &Evidence) -> String {
    let foreign = |mark: &&FoundSign<'_>| first.foreign.contains_key(mark.pattern);
    let others = all.iter().filter(|other| other.shown.iter().any(|mark| foreign(&mark)));
    let mut marks: Vec<FoundSign<'_>> = Vec::new();
    let mut titles = Vec::new();
    for other in others.take(NAMED) {
        titles.push(other.title);
        marks.extend(
            other
                .shown
                .iter()
                .filter(foreign)
                .filter(|mark| marks.iter().all(|m| m.pattern != mark.pattern))
                .cloned()
                .collect::<Vec<_>>(),
        );
    }
    let (titles, marks) = (titles.join(" or "), evidence.named(&marks));
    if first.shown.is_empty() {
        return format!("the program shows marks of {titles}, judging by {marks}, but too few");
    }
    let own = evidence.named(&first.shown);
    format!("the program shows marks of {} ({own}) as well as of {titles} ({marks})", first.title)
}
