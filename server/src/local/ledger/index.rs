//! Finding jobs without reading them: by state, machine and label, in order of acceptance.
//!
//! Each job is listed under some terms, each term of one tenant: its state, its machine with and without revision, and
//! each of its labels. A query asks each term in turn for the next identity from where the others are, until all agree.
//! Invariants: a job is listed under exactly the terms of its row; a query takes a bounded number of steps and then
//! gives the place to continue from.

use std::collections::BTreeSet;
use std::ops::Bound::{Excluded, Included, Unbounded};

use redb::{ReadOnlyTable, ReadTransaction, ReadableTable, WriteTransaction};
use uuid::Uuid;

use super::tables::{INDEX, TransactionTables};
use super::{JOB, readable, storage};
use crate::ledger::prefix::shortest;
use crate::ledger::record::{JobRecord, JobState};
use crate::ledger::{PAGE_BYTES, Page, Query};
use crate::reason::Refusal;

/// Most look-ups of a page.
const STEPS: usize = 2000;
/// States, with those that the ledger does not tell apart as one.
const STATES: [JobState; 4] = [JobState::Queued, JobState::Succeeded, JobState::Failed, JobState::Cancelled];

fn state_term(tenant: &str, state: JobState) -> String {
    let state = match state {
        JobState::Queued | JobState::Running => "open",
        JobState::Succeeded => "succeeded",
        JobState::Failed => "failed",
        JobState::Cancelled => "cancelled",
    };
    format!("{tenant}/s/{state}")
}

fn machine_term(tenant: &str, machine: &str) -> String {
    format!("{tenant}/m/{machine}")
}

fn label_term(tenant: &str, key: &str, value: &str) -> String {
    format!("{tenant}/l/{key}={value}")
}

/// Terms of a job that never change.
fn fixed(record: &JobRecord) -> Vec<String> {
    let (tenant, machine) = (record.tenant.as_str(), &record.machine);
    let mut terms = vec![machine_term(tenant, &machine.name)];
    if !machine.revision.is_empty() {
        terms.push(machine_term(tenant, &machine.full_name()));
    }
    terms.extend(record.asked.labels.iter().map(|(key, value)| label_term(tenant, key, value)));
    terms
}

/// All terms of a job.
fn terms(record: &JobRecord) -> Vec<String> {
    let mut terms = fixed(record);
    terms.push(state_term(&record.tenant, record.state));
    terms
}

/// Lists a job that is accepted.
pub(super) fn add(tables: &TransactionTables<'_>, record: &JobRecord) -> Result<(), Refusal> {
    let mut table = tables.index()?;
    for term in terms(record) {
        table.insert((term.as_str(), record.id.as_str()), ()).map_err(storage)?;
    }
    Ok(())
}

/// Lists a job that ends now under its end.
pub(super) fn end(tables: &TransactionTables<'_>, record: &JobRecord) -> Result<(), Refusal> {
    let mut table = tables.index()?;
    let (open, ended) = (state_term(&record.tenant, JobState::Queued), state_term(&record.tenant, record.state));
    table.remove((open.as_str(), record.id.as_str())).map_err(storage)?;
    table.insert((ended.as_str(), record.id.as_str()), ()).map_err(storage)?;
    Ok(())
}

/// Takes a job out.
pub(super) fn remove(tables: &TransactionTables<'_>, record: &JobRecord) -> Result<(), Refusal> {
    let mut table = tables.index()?;
    for term in terms(record) {
        table.remove((term.as_str(), record.id.as_str())).map_err(storage)?;
    }
    Ok(())
}

/// Lists all jobs anew.
pub(super) fn list_all(txn: &WriteTransaction) -> Result<(), Refusal> {
    txn.open_table(INDEX).map_err(storage)?.retain(|_, ()| false).map_err(storage)?;
    let (tables, jobs) = (TransactionTables::of(txn), txn.open_table(JOB).map_err(storage)?);
    for row in jobs.iter().map_err(storage)? {
        let (id, row) = row.map_err(storage)?;
        if let Some(record) = readable::<JobRecord>(JOB, id.value(), row.value()) {
            add(&tables, &record)?;
        }
    }
    Ok(())
}

/// Entries of the list: term and identity.
pub(super) fn listed(txn: &ReadTransaction) -> Result<BTreeSet<(String, String)>, Refusal> {
    let mut listed = BTreeSet::new();
    for row in txn.open_table(INDEX).map_err(storage)?.iter().map_err(storage)? {
        let (key, _) = row.map_err(storage)?;
        let (term, id) = key.value();
        listed.insert((term.to_owned(), id.to_owned()));
    }
    Ok(listed)
}

/// Entries that the list must have for these jobs.
pub(super) fn expected<'a>(jobs: impl Iterator<Item = &'a JobRecord>) -> BTreeSet<(String, String)> {
    jobs.flat_map(|record| terms(record).into_iter().map(|term| (term, record.id.clone()))).collect()
}

/// Jobs in the order of acceptance, or in the reverse order, from a bound on.
struct JobScan<'a> {
    index: ReadOnlyTable<(&'static str, &'static str), ()>,
    query: &'a Query,
    /// Look-ups left.
    left: usize,
}

/// Where jobs come from.
enum IdSource<'a> {
    /// Those listed under a term, without some.
    Term(String, Option<&'a BTreeSet<String>>),
    Ids(&'a BTreeSet<String>),
}

/// A condition: the job is in one of the sources. The next identity of each is kept from one question to the next.
struct QueryCondition<'a>(Vec<(IdSource<'a>, SourceCursor)>);

/// State of a source: unknown, the next identity, or the end.
#[derive(Clone, PartialEq)]
enum SourceCursor {
    Nothing,
    Next(String),
    End,
}

impl<'a> QueryCondition<'a> {
    fn new(sources: impl IntoIterator<Item = IdSource<'a>>) -> Self {
        Self(sources.into_iter().map(|source| (source, SourceCursor::Nothing)).collect())
    }

    /// The first identity from `bound` on.
    fn seek(&mut self, walk: &mut JobScan<'_>, bound: &str) -> Result<Option<String>, Refusal> {
        let mut first: Option<String> = None;
        for (source, known) in &mut self.0 {
            let stale = match known {
                SourceCursor::Nothing => true,
                SourceCursor::Next(next) => walk.before(next, bound),
                SourceCursor::End => false,
            };
            if stale {
                *known = walk.next(source, bound)?.map_or(SourceCursor::End, SourceCursor::Next);
            }
            if let SourceCursor::Next(next) = known
                && first.as_ref().is_none_or(|first| walk.before(next, first))
            {
                first = Some(next.clone());
            }
        }
        Ok(first)
    }
}

impl JobScan<'_> {
    /// Whether one identity comes before another.
    fn before(&self, one: &str, other: &str) -> bool {
        if self.query.newest_first { one > other } else { one < other }
    }

    fn next(&mut self, source: &IdSource<'_>, bound: &str) -> Result<Option<String>, Refusal> {
        let newest_first = self.query.newest_first;
        match source {
            IdSource::Ids(ids) if newest_first => {
                Ok(ids.range::<str, _>((Unbounded, Included(bound))).next_back().cloned())
            }
            IdSource::Ids(ids) => Ok(ids.range::<str, _>((Included(bound), Unbounded)).next().cloned()),
            IdSource::Term(term, without) => {
                let skip = |id: &str| without.is_some_and(|without| without.contains(id));
                let term = term.as_str();
                let mut rows = match newest_first {
                    true => self.index.range((term, "")..=(term, bound)),
                    false => self.index.range((term, bound)..=(term, "\u{10ffff}")),
                }
                .map_err(storage)?;
                loop {
                    self.left = self.left.saturating_sub(1);
                    let row = if newest_first { rows.next_back() } else { rows.next() };
                    let Some(row) = row.transpose().map_err(storage)? else { return Ok(None) };
                    let id = row.0.value().1;
                    if !skip(id) {
                        return Ok(Some(id.to_owned()));
                    }
                }
            }
        }
    }

    /// The identity right after another one.
    fn after(&self, id: &str) -> Option<String> {
        let id = Uuid::parse_str(id).ok()?.as_u128();
        let next = if self.query.newest_first { id.checked_sub(1) } else { id.checked_add(1) };
        next.map(|next| Uuid::from_u128(next).to_string())
    }

    /// The identity right before another one: the token of a page that begins with that one.
    fn token(&self, id: &str) -> Option<String> {
        let id = Uuid::parse_str(id).ok()?.as_u128();
        let next = if self.query.newest_first { id.checked_add(1) } else { id.checked_sub(1) };
        next.map(|next| Uuid::from_u128(next).to_string())
    }
}

/// Smallest identity of a time.
fn at(ms: i64) -> String {
    Uuid::from_u128(u128::from(u64::try_from(ms).unwrap_or(0)).min((1 << 48) - 1) << 80).to_string()
}

/// Conditions of a query.
fn conditions(query: &Query) -> Vec<QueryCondition<'_>> {
    let tenant = &query.tenant;
    let all = query.states.is_empty() && query.paused.is_none();
    let wanted = |state: &JobState| query.states.contains(state);
    let states = STATES.iter().filter(|state| all || wanted(state)).map(|state| {
        let running = (*state == JobState::Queued && !all && !wanted(&JobState::Running)).then_some(&query.running);
        IdSource::Term(state_term(tenant, *state), running)
    });
    let running = (wanted(&JobState::Running) && !wanted(&JobState::Queued)).then_some(IdSource::Ids(&query.running));
    let mut conditions =
        vec![QueryCondition::new(states.chain(running).chain(query.paused.as_ref().map(IdSource::Ids)))];
    let term = |term: String| QueryCondition::new([IdSource::Term(term, None)]);
    conditions.extend(query.machine.iter().map(|machine| term(machine_term(tenant, machine))));
    conditions.extend(query.labels.iter().map(|(key, value)| term(label_term(tenant, key, value))));
    conditions
}

/// The first identity that a query may find, and the end of those that it may find.
fn ends(query: &Query) -> (String, String) {
    let (first, last) = query.prefix.range().into_inner();
    let beyond = |id: &str| Uuid::parse_str(id).ok().and_then(|id| id.as_u128().checked_add(1)).map(Uuid::from_u128);
    let end = beyond(&last).map_or_else(|| "g".to_owned(), |end| end.to_string());
    let until = if query.until_ms > 0 { at(query.until_ms) } else { "g".to_owned() };
    (at(query.from_ms).max(first), until.min(end))
}

/// The short identities of jobs of a tenant.
fn short_ids(
    index: &ReadOnlyTable<(&'static str, &'static str), ()>,
    jobs: &[JobRecord],
) -> Result<Vec<String>, Refusal> {
    let mut short = Vec::with_capacity(jobs.len());
    for JobRecord { id, tenant, .. } in jobs {
        let mut neighbours = Vec::with_capacity(2 * STATES.len());
        for state in STATES {
            let term = state_term(tenant, state);
            let (term, id) = (term.as_str(), id.as_str());
            let before = index.range((term, "")..(term, id)).map_err(storage)?.next_back();
            let after = index.range((Excluded((term, id)), Included((term, "\u{10ffff}")))).map_err(storage)?.next();
            for row in [before, after].into_iter().flatten() {
                neighbours.push(row.map_err(storage)?.0.value().1.to_owned());
            }
        }
        short.push(shortest(id, neighbours.iter().map(String::as_str)));
    }
    Ok(short)
}

/// A page of jobs.
pub(super) fn page(txn: &ReadTransaction, query: &Query) -> Result<Page, Refusal> {
    let mut page = jobs(txn, query)?;
    if query.short_ids {
        page.short_ids = short_ids(&txn.open_table(INDEX).map_err(storage)?, &page.jobs)?;
    }
    Ok(page)
}

fn jobs(txn: &ReadTransaction, query: &Query) -> Result<Page, Refusal> {
    let jobs = txn.open_table(JOB).map_err(storage)?;
    let most_bytes = if query.most_bytes == 0 { PAGE_BYTES } else { query.most_bytes };
    let mut walk = JobScan { index: txn.open_table(INDEX).map_err(storage)?, query, left: STEPS };
    let mut conditions = conditions(query);
    let (first, last) = ends(query);
    let mut bound = match (query.after.as_str(), query.newest_first) {
        ("", true) => last.clone(),
        ("", false) => first.clone(),
        (after, _) => match walk.after(after) {
            Some(next) => next,
            None => return Ok(Page::default()),
        },
    };
    // A token of another filter may lie outside.
    if !query.newest_first && bound < first {
        bound.clone_from(&first);
    } else if query.newest_first && bound > last {
        bound.clone_from(&last);
    }
    let mut page = Page::default();
    loop {
        let outside = if query.newest_first { bound < first } else { bound >= last };
        if outside {
            return Ok(page);
        }
        if walk.left == 0 {
            page.next = walk.token(&bound);
            return Ok(page);
        }
        let mut agree = true;
        for condition in &mut conditions {
            match condition.seek(&mut walk, &bound)? {
                None => return Ok(page),
                Some(next) if next == bound => {}
                Some(next) => {
                    agree = false;
                    bound = next;
                }
            }
        }
        // The upper end of a walk backwards is not part of it.
        if !agree || query.newest_first && bound >= last {
            if agree {
                match walk.after(&bound) {
                    Some(next) => bound = next,
                    None => return Ok(page),
                }
            }
            continue;
        }
        if page.jobs.len() >= query.count {
            page.next = page.jobs.last().map(|job| job.id.clone());
            return Ok(page);
        }
        if let Some(row) = jobs.get(bound.as_str()).map_err(storage)? {
            let bytes = row.value().len() as u64;
            if !page.jobs.is_empty() && page.bytes.saturating_add(bytes) > most_bytes {
                page.next = page.jobs.last().map(|job| job.id.clone());
                return Ok(page);
            }
            let record = readable::<JobRecord>(JOB, &bound, row.value()).filter(|record| record.tenant == query.tenant);
            page.bytes = page.bytes.saturating_add(if record.is_some() { bytes } else { 0 });
            page.jobs.extend(record);
        }
        match walk.after(&bound) {
            Some(next) => bound = next,
            None => return Ok(page),
        }
    }
}

/// Jobs of all tenants that have not ended, in order of acceptance.
pub(super) fn unfinished(txn: &ReadTransaction) -> Result<Vec<JobRecord>, Refusal> {
    let jobs = txn.open_table(JOB).map_err(storage)?;
    let mut ids = BTreeSet::new();
    for row in txn.open_table(INDEX).map_err(storage)?.iter().map_err(storage)? {
        let (key, _) = row.map_err(storage)?;
        let (term, id) = key.value();
        if term.split_once('/').is_some_and(|(_, term)| term == "s/open") {
            ids.insert(id.to_owned());
        }
    }
    let mut found = Vec::new();
    for id in ids {
        let row = jobs.get(id.as_str()).map_err(storage)?;
        found.extend(row.and_then(|row| readable::<JobRecord>(JOB, &id, row.value())));
    }
    Ok(found)
}

#[cfg(test)]
#[path = "index_tests.rs"]
mod tests;
