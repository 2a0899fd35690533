use redb::{Database, ReadableDatabase};

use super::*;
use crate::ledger::prefix::IdPrefix;
use crate::ledger::record::tests::record;
use crate::machines::{MachineRecord, Pinned};

/// Identity of the job accepted at a millisecond.
fn id(ms: i64) -> String {
    Uuid::from_u128((u128::from(ms.unsigned_abs()) << 80) | 0x7000_8000_0000_0000_0000).to_string()
}

struct Jobs(Database, Vec<JobRecord>);

impl Jobs {
    fn new(jobs: Vec<JobRecord>) -> Self {
        let backend = redb::backends::InMemoryBackend::new();
        let database = Database::builder().create_with_backend(backend).unwrap();
        let txn = database.begin_write().unwrap();
        {
            let mut table = txn.open_table(JOB).unwrap();
            for job in &jobs {
                table.insert(job.id.as_str(), serde_json::to_vec(job).unwrap().as_slice()).unwrap();
            }
        }
        list_all(&txn).unwrap();
        txn.commit().unwrap();
        Self(database, jobs)
    }

    fn page(&self, query: &Query) -> Page {
        page(&self.0.begin_read().unwrap(), query).unwrap()
    }

    /// All pages of a query.
    fn all(&self, mut query: Query) -> Vec<String> {
        let mut found = Vec::new();
        loop {
            let page = self.page(&query);
            assert!(page.jobs.len() <= query.count);
            found.extend(page.jobs.into_iter().map(|job| job.id));
            match page.next {
                Some(next) => query.after = next,
                None => return found,
            }
        }
    }

    /// Jobs found by looking at every job.
    fn scanned(&self, query: &Query) -> Vec<String> {
        let wanted = |job: &&JobRecord| {
            let state = if query.running.contains(&job.id) { JobState::Running } else { job.state };
            let machine = query.machine.as_ref();
            job.tenant == query.tenant
                && (query.states.is_empty() && query.paused.is_none()
                    || query.states.contains(&state)
                    || query.paused.as_ref().is_some_and(|paused| paused.contains(&job.id)))
                && machine.is_none_or(|name| *name == job.machine.name || *name == job.machine.full_name())
                && query.labels.iter().all(|(key, value)| job.asked.labels.get(key) == Some(value))
                && job.submitted_ms >= query.from_ms
                && (query.until_ms == 0 || job.submitted_ms < query.until_ms)
                && query.prefix.begins(&job.id)
        };
        let mut found: Vec<_> = self.1.iter().filter(wanted).map(|job| job.id.clone()).collect();
        if query.newest_first {
            found.reverse();
        }
        found
    }
}

fn random(state: &mut u64) -> usize {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 33) as usize
}

fn some_jobs(seed: &mut u64, count: i64) -> Vec<JobRecord> {
    let states = [JobState::Queued, JobState::Queued, JobState::Succeeded, JobState::Failed, JobState::Cancelled];
    let job = |ms: i64| {
        let mut job = JobRecord { state: states[random(seed) % 5], submitted_ms: 1000 + ms, ..record(&id(1000 + ms)) };
        job.tenant = ["default", "other"][random(seed) % 2].to_owned();
        let mut machine = MachineRecord::shipped(["mill", "lathe"][random(seed) % 2]);
        if random(seed).is_multiple_of(3) {
            let digest = ["aa", "bb"][random(seed) % 2];
            machine.files = [("lathe/machine.toml".to_owned(), digest.to_owned())].into();
        }
        job.machine = Pinned::from(&machine);
        for key in ["part", "shift"] {
            if !random(seed).is_multiple_of(4) {
                job.asked.labels.insert(key.to_owned(), (random(seed) % 3).to_string());
            }
        }
        job
    };
    (0..count).map(job).collect()
}

#[test]
fn pages_hold_what_a_look_at_every_job_finds() {
    let mut seed = 5;
    let jobs = Jobs::new(some_jobs(&mut seed, 300));
    let open: Vec<_> = jobs.1.iter().filter(|job| job.state == JobState::Queued).map(|job| job.id.clone()).collect();
    let all = [JobState::Queued, JobState::Running, JobState::Succeeded, JobState::Failed, JobState::Cancelled];
    let pinned = jobs.1.iter().find(|job| !job.machine.revision.is_empty()).unwrap().machine.full_name();
    let mut seen = 0;
    for round in 0..1000 {
        let r = &mut seed;
        let query = Query {
            tenant: ["default", "other", "third"][random(r) % 3].to_owned(),
            states: all.into_iter().filter(|_| random(r).is_multiple_of(3)).collect(),
            running: open.iter().filter(|_| random(r).is_multiple_of(10)).cloned().collect(),
            paused: random(r)
                .is_multiple_of(4)
                .then(|| open.iter().filter(|_| random(r).is_multiple_of(5)).cloned().collect()),
            machine: [None, None, Some("mill"), Some("lathe"), Some("saw"), Some(pinned.as_str())][random(r) % 6]
                .map(str::to_owned),
            labels: [("part", "1"), ("shift", "2")]
                .iter()
                .filter(|_| random(r).is_multiple_of(3))
                .map(|(key, value)| ((*key).to_owned(), (*value).to_owned()))
                .collect(),
            from_ms: [0, 0, 1100, 1250][random(r) % 4],
            until_ms: [0, 0, 1200, 1299][random(r) % 4],
            newest_first: random(r).is_multiple_of(2),
            prefix: IdPrefix::read(["", "", "", "00000000-04", "0000000004b", "000000000400700", "01"][random(r) % 7])
                .unwrap(),
            after: String::new(),
            count: 1 + random(r) % 40,
            short_ids: false,
            most_bytes: 0,
        };
        let expected = jobs.scanned(&query);
        seen += expected.len();
        assert_eq!(jobs.all(query.clone()), expected, "{round}: {query:?}");
    }
    assert!(seen > 4000, "the queries find something: {seen}");
}

/// A short identity finds its job and no other job of the tenant, regardless of the state of the others.
#[test]
fn short_identities_find_their_jobs() {
    let mut seed = 9;
    let mut some = some_jobs(&mut seed, 300);
    // Of the same millisecond.
    let twin = JobRecord { id: format!("{}1", &some[5].id[..35]), state: JobState::Failed, ..some[5].clone() };
    some.insert(6, twin);
    let jobs = Jobs::new(some);
    for tenant in ["default", "other"] {
        let query = Query { tenant: tenant.to_owned(), count: 500, short_ids: true, ..Query::default() };
        let page = jobs.page(&query);
        assert!(page.jobs.len() > 100 && page.jobs.len() == page.short_ids.len());
        for (job, short) in page.jobs.iter().zip(&page.short_ids) {
            let query = Query { prefix: IdPrefix::read(short).unwrap(), newest_first: true, ..query.clone() };
            assert_eq!(jobs.all(query), std::slice::from_ref(&job.id), "{short}");
        }
        let longest = page.short_ids.iter().map(String::len).max().unwrap();
        assert!(page.short_ids.iter().filter(|short| short.len() > 13).count() <= 2 && longest <= 36, "{longest}");
    }
}

/// Without a bound on its steps the first page would look at all jobs.
#[test]
fn a_page_takes_a_bounded_number_of_steps_and_the_next_one_continues() {
    let job = |ms: i64| {
        let mut job = record(&id(ms));
        job.machine = Pinned::from(&MachineRecord::shipped(if ms % 2 == 0 { "mill" } else { "lathe" }));
        if ms % 2 == 1 || ms == 9000 {
            job.asked.labels.insert("k".to_owned(), "v".to_owned());
        }
        job
    };
    let jobs = Jobs::new((1..10_000).map(job).collect());
    for newest_first in [false, true] {
        let labels = [("k".to_owned(), "v".to_owned())].into();
        let (tenant, machine) = ("default".to_owned(), Some("mill".to_owned()));
        let mut query = Query { tenant, machine, labels, newest_first, count: 5, ..Query::default() };
        let (mut found, mut pages) = (Vec::new(), 0);
        loop {
            let page = jobs.page(&query);
            pages += 1;
            found.extend(page.jobs.into_iter().map(|job| job.id));
            match page.next {
                Some(next) => query.after = next,
                None => break,
            }
        }
        assert_eq!(found, [id(9000)]);
        assert!((5..100).contains(&pages), "{pages}");
    }
}

#[test]
fn a_page_ends_at_its_bytes_and_the_next_one_continues() {
    let job = |ms: i64| JobRecord { error: "e".repeat(300_000), submitted_ms: 1000 + ms, ..record(&id(1000 + ms)) };
    let mut large: Vec<_> = (0..10).map(job).collect();
    large[4].error = "e".repeat(2_000_000);
    let jobs = Jobs::new(large);
    for newest_first in [false, true] {
        let query = Query { tenant: "default".to_owned(), count: 500, newest_first, ..Query::default() };
        assert_eq!(jobs.page(&query).jobs.len(), 3, "of 1 MiB");
        assert_eq!(jobs.all(query.clone()), jobs.scanned(&query));
        let largest = Query { after: id(if newest_first { 1005 } else { 1003 }), ..query };
        assert_eq!(jobs.page(&largest).jobs.len(), 1, "a job that is larger than a page is one");
    }
}
