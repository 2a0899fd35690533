//! Filters of jobs.
//!
//! Invariant: a filter takes a job exactly if the index of the ledger finds it with the same conditions.

use std::collections::{BTreeMap, BTreeSet};

use counterpoint_proto::v1;
use uuid::Uuid;

use super::feed::Removed;
use crate::ledger::prefix::IdPrefix;
use crate::ledger::record::{Record, State};
use crate::ledger::{Query, time_of};
use crate::reason::Refusal;

/// Conditions on jobs.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Filter {
    /// Empty = all.
    pub(crate) states: BTreeSet<State>,
    machine: Option<String>,
    labels: BTreeMap<String, String>,
    from_ms: i64,
    until_ms: i64,
    prefix: IdPrefix,
}

/// A state from the wire.
fn state(field: String, number: i32) -> Result<State, Refusal> {
    match v1::JobState::try_from(number) {
        Ok(v1::JobState::Queued) => Ok(State::Queued),
        Ok(v1::JobState::Running) => Ok(State::Running),
        Ok(v1::JobState::Succeeded) => Ok(State::Succeeded),
        Ok(v1::JobState::Failed) => Ok(State::Failed),
        Ok(v1::JobState::Cancelled) => Ok(State::Cancelled),
        Ok(v1::JobState::Unspecified) | Err(_) => Err(Refusal::field(field, "is not a state of a job")),
    }
}

/// States from the wire.
pub(crate) fn states(field: &str, numbers: &[i32]) -> Result<BTreeSet<State>, Refusal> {
    numbers.iter().enumerate().map(|(at, number)| state(format!("{field}[{at}]"), *number)).collect()
}

impl Filter {
    /// A filter from the wire.
    pub(crate) fn read(filter: v1::JobFilter) -> Result<Self, Refusal> {
        for (field, ms) in [("filter.from_ms", filter.from_ms), ("filter.until_ms", filter.until_ms)] {
            if ms < 0 {
                return Err(Refusal::field(field, "must not be negative"));
            }
        }
        Ok(Self {
            states: states("filter.states", &filter.states)?,
            machine: Some(filter.machine).filter(|machine| !machine.is_empty()),
            labels: filter.labels,
            from_ms: filter.from_ms,
            until_ms: filter.until_ms,
            prefix: IdPrefix::read(&filter.id_prefix)
                .ok_or_else(|| Refusal::field("filter.id_prefix", "is not the beginning of a job_id"))?,
        })
    }

    /// The question to the ledger for the first page.
    pub(crate) fn query(&self, tenant: &str, running: BTreeSet<String>, count: usize) -> Query {
        Query {
            tenant: tenant.to_owned(),
            states: self.states.clone(),
            running,
            machine: self.machine.clone(),
            labels: self.labels.clone(),
            from_ms: self.from_ms,
            until_ms: self.until_ms,
            prefix: self.prefix.clone(),
            count,
            ..Query::default()
        }
    }

    fn found_by(&self, machine: &str, labels: &BTreeMap<String, String>) -> bool {
        let name = machine.split_once('@').map_or(machine, |(name, _)| name);
        self.machine.as_ref().is_none_or(|wanted| wanted == machine || wanted == name)
            && self.labels.iter().all(|(key, value)| labels.get(key) == Some(value))
    }

    /// Whether a job is wanted.
    pub(crate) fn takes(&self, record: &Record) -> bool {
        let accepted_ms = Uuid::try_parse(&record.id).map_or(record.submitted_ms, time_of);
        (self.states.is_empty() || self.states.contains(&record.state))
            && self.found_by(&record.machine.full_name(), &record.asked.labels)
            && self.prefix.begins(&record.id)
            && accepted_ms >= self.from_ms
            && (self.until_ms == 0 || accepted_ms < self.until_ms)
    }

    /// Whether a job that was removed may have been wanted.
    pub(crate) fn took(&self, removed: &Removed) -> bool {
        self.found_by(&removed.machine, &removed.labels)
    }
}
