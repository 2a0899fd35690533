//! Filters of jobs.
//!
//! Invariant: a filter takes a job exactly if the index of the ledger finds it with the same conditions.

use std::collections::{BTreeMap, BTreeSet};

use counterpoint_proto::v1;
use uuid::Uuid;

use super::Core;
use super::feed::Removed;
use crate::ledger::prefix::IdPrefix;
use crate::ledger::record::{JobRecord, JobState};
use crate::ledger::{Query, time_of};
use crate::reason::Refusal;

/// Conditions on jobs.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct JobConditions {
    pub(crate) states: States,
    machine: Option<String>,
    labels: BTreeMap<String, String>,
    from_ms: i64,
    until_ms: i64,
    prefix: IdPrefix,
}

/// States of jobs that have not ended, and of jobs that have.
pub(crate) const OPEN: [JobState; 2] = [JobState::Queued, JobState::Running];
pub(crate) const ENDED: [JobState; 3] = [JobState::Succeeded, JobState::Failed, JobState::Cancelled];

/// Jobs in one of the states, and perhaps those that are held back; neither = all.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct States {
    of: BTreeSet<JobState>,
    paused: bool,
}

impl States {
    /// States from the wire.
    pub(crate) fn read(field: &str, numbers: &[i32]) -> Result<Self, Refusal> {
        let mut states = Self::default();
        for (at, number) in numbers.iter().enumerate() {
            let state = match v1::JobState::try_from(*number) {
                Ok(v1::JobState::Queued) => JobState::Queued,
                Ok(v1::JobState::Running) => JobState::Running,
                Ok(v1::JobState::Succeeded) => JobState::Succeeded,
                Ok(v1::JobState::Failed) => JobState::Failed,
                Ok(v1::JobState::Cancelled) => JobState::Cancelled,
                Ok(v1::JobState::Paused) => {
                    states.paused = true;
                    continue;
                }
                Ok(v1::JobState::Unspecified) | Err(_) => {
                    return Err(Refusal::field(format!("{field}[{at}]"), "is not a state of a job"));
                }
            };
            states.of.insert(state);
        }
        Ok(states)
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.of.is_empty() && !self.paused
    }

    /// The part of a choice that is among these states; none if no job can be there.
    pub(crate) fn among(&self, states: &[JobState]) -> Option<Self> {
        if self.is_empty() {
            return Some(Self { of: states.iter().copied().collect(), paused: false });
        }
        let of = self.of.iter().copied().filter(|state| states.contains(state)).collect();
        // Only a job that has not ended is held back.
        Some(Self { of, paused: self.paused && states.contains(&JobState::Queued) }).filter(|part| !part.is_empty())
    }

    /// Jobs that two choices have in common; none if no job can be in both.
    pub(crate) fn both(self, other: Self) -> Result<Option<Self>, Refusal> {
        if self.is_empty() || other.is_empty() {
            return Ok(Some(if self.is_empty() { other } else { self }));
        }
        if self.paused || other.paused {
            return Err(Refusal::field(
                "states",
                "must be empty if filter.states is used and one has JOB_STATE_PAUSED",
            ));
        }
        Ok(self.among(&other.of.into_iter().collect::<Vec<_>>()))
    }

    fn take(&self, record: &JobRecord) -> bool {
        self.is_empty() || self.of.contains(&record.state) || self.paused && record.paused
    }
}

impl JobConditions {
    /// A filter from the wire.
    pub(crate) fn read(filter: v1::JobFilter) -> Result<Self, Refusal> {
        for (field, ms) in [("filter.from_ms", filter.from_ms), ("filter.until_ms", filter.until_ms)] {
            if ms < 0 {
                return Err(Refusal::field(field, "must not be negative"));
            }
        }
        Ok(Self {
            states: States::read("filter.states", &filter.states)?,
            machine: Some(filter.machine).filter(|machine| !machine.is_empty()),
            labels: filter.labels,
            from_ms: filter.from_ms,
            until_ms: filter.until_ms,
            prefix: IdPrefix::read(&filter.id_prefix)
                .ok_or_else(|| Refusal::field("filter.id_prefix", "is not the beginning of a job_id"))?,
        })
    }

    /// Whether it has no condition.
    pub(crate) fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// The question to the ledger for the first page.
    pub(crate) fn query(&self, tenant: &str, core: &Core, count: usize) -> Query {
        Query {
            tenant: tenant.to_owned(),
            states: self.states.of.clone(),
            running: core.busy(),
            paused: self.states.paused.then(|| core.held_back(tenant)),
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
    pub(crate) fn takes(&self, record: &JobRecord) -> bool {
        let accepted_ms = Uuid::try_parse(&record.id).map_or(record.submitted_ms, time_of);
        self.states.take(record)
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
