//! The ledger beside a twin in memory: random operations, random crashes.
//!
//! A crash lets all writes of the ledger's file fail from some step of an operation on. Then the ledger is closed,
//! examined and opened again. Answered operations must be there; a refused operation is there completely or not at all.

use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::path::Path;
use std::sync::atomic::{AtomicI64, Ordering};

use counterpoint_kernel::dialog::operator::Silence;

use super::checkup::Checkup;
use super::*;
use crate::ledger::record::tests::{record, work};
use crate::ledger::record::{CONTENT, JobState};
use crate::ledger::settled::Settled;
use crate::ledger::{NewJob, day};
use crate::local::disk::{Disk, DiskOperation, Faults};
use crate::machines::Pinned;

/// A host that loses its power after this many more writes of the ledger; negative = never.
#[derive(Debug)]
struct Power(AtomicI64);

impl Faults for Power {
    fn before(&self, step: DiskOperation, path: &Path) -> io::Result<usize> {
        if !path.ends_with("ledger.redb")
            || !matches!(step, DiskOperation::Write(_) | DiskOperation::Resize(_) | DiskOperation::Sync)
        {
            return Ok(usize::MAX);
        }
        match self.0.load(Ordering::SeqCst) {
            0 => Err(io::ErrorKind::StorageFull.into()),
            left => {
                self.0.store(if left > 0 { left - 1 } else { left }, Ordering::SeqCst);
                Ok(usize::MAX)
            }
        }
    }
}

/// The requests to the ledger.
#[derive(Debug, Clone)]
enum Operation {
    Submit(Box<JobRecord>, Box<JobWork>),
    Cancel(String),
    Pause(String, bool),
    Answer(String, Settled),
    End(Box<JobRecord>, Option<Bytes>),
    Remove(Box<JobRecord>),
    RemoveMany(Vec<EndedJob>),
    Put(MachineRecord),
    RemoveMachine(String, String, bool),
}

/// The expected content of the ledger.
#[derive(Debug, Clone, Default)]
struct Twin {
    jobs: BTreeMap<String, JobRecord>,
    works: BTreeMap<String, JobWork>,
    logs: BTreeMap<String, Bytes>,
    /// By tenant and name: the newest revision, and all.
    machines: BTreeMap<(String, String), (MachineRecord, BTreeMap<String, MachineRecord>)>,
    runs: BTreeMap<String, (u64, u64)>,
}

impl Twin {
    fn by_request(&self, tenant: &str, request: &str) -> Option<&JobRecord> {
        self.jobs.values().find(|job| job.tenant == tenant && job.request_id == request)
    }

    fn take_out(&mut self, id: &str) {
        self.jobs.remove(id);
        self.works.remove(id);
        self.logs.remove(id);
    }

    /// Executes an operation; `accepted`: the ledger's record of a submit. Returns whether the operation is refused.
    fn apply(&mut self, operation: &Operation, accepted: Option<&JobRecord>) -> bool {
        match operation {
            Operation::Submit(asked, work) => match self.by_request(&asked.tenant, &asked.request_id) {
                Some(known) => return known.asks_the_same(asked) != Some(true),
                None => {
                    let accepted = accepted.expect("a new request gives a new job").clone();
                    assert!(self.jobs.last_key_value().is_none_or(|(last, _)| *last < accepted.id), "ids ascend");
                    let id = accepted.id.clone();
                    let given = JobRecord { id: String::new(), submitted_ms: asked.submitted_ms, ..accepted.clone() };
                    assert_eq!(given, **asked);
                    self.works.insert(id.clone(), (**work).clone());
                    self.jobs.insert(id, accepted);
                }
            },
            Operation::Cancel(id) => {
                self.jobs.get_mut(id).into_iter().for_each(|job| job.cancel = true);
            }
            Operation::Pause(id, paused) => {
                let open = self.jobs.get_mut(id).filter(|job| !job.state.ended());
                open.into_iter().for_each(|job| job.paused = *paused);
            }
            Operation::Answer(id, settled) => {
                if self.jobs.get(id).is_some_and(|job| !job.state.ended()) {
                    self.works
                        .get_mut(id)
                        .into_iter()
                        .for_each(|work| work.answers.push((1, settled.answer.clone().ok())));
                }
            }
            Operation::End(record, log) => {
                let day = day(record.ended_ms);
                let run = self.runs.entry(record.tenant.clone()).or_default();
                let before = if run.0 == day { run.1 } else { 0 };
                *run = (day, before + record.runs.cpu_us);
                let before = self.jobs.get(&record.id).expect("it was accepted");
                let kept = JobRecord {
                    cancel: record.cancel || before.cancel,
                    paused: before.paused && !record.state.ended(),
                    ..(**record).clone()
                };
                self.jobs.insert(record.id.clone(), kept);
                log.iter().for_each(|log| drop(self.logs.insert(record.id.clone(), log.clone())));
            }
            Operation::Remove(record) => self.take_out(&record.id),
            Operation::RemoveMany(jobs) => jobs.iter().for_each(|job| self.take_out(&job.id)),
            Operation::Put(definition) => {
                let key = (definition.tenant.clone(), definition.name.clone());
                if self.machines.get(&key).is_some_and(|(newest, _)| newest.trusted && !definition.trusted) {
                    return true;
                }
                let entry = self.machines.entry(key).or_insert_with(|| (definition.clone(), BTreeMap::new()));
                entry.0 = definition.clone();
                entry.1.insert(definition.revision(), definition.clone());
            }
            Operation::RemoveMachine(tenant, name, trusted) => {
                let key = (tenant.clone(), name.clone());
                if self.machines.get(&key).is_some_and(|(newest, _)| newest.trusted && !trusted) {
                    return true;
                }
                self.machines.remove(&key);
            }
        }
        false
    }
}

const TENANTS: [&str; 2] = ["default", "other"];

struct Random(u64);

impl Random {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % end.max(1)
    }

    fn one<'a, T>(&mut self, all: &'a [T]) -> Option<&'a T> {
        if all.is_empty() { None } else { all.get(self.below(all.len())) }
    }
}

/// Bytes of a row.
fn row_bytes(row: &impl serde::Serialize) -> u64 {
    (seal::HEAD + serde_json::to_vec(row).unwrap().len()) as u64
}

fn definition(random: &mut Random) -> MachineRecord {
    let file = ("m/machine.toml".to_owned(), format!("{:064}", random.below(4)));
    MachineRecord {
        name: ["m", "n", "m-2"][random.below(3)].to_owned(),
        files: [file].into(),
        tenant: TENANTS[random.below(2)].to_owned(),
        trusted: random.below(4) == 0,
    }
}

fn operation(random: &mut Random, twin: &Twin, step: usize) -> Operation {
    let open: Vec<_> = twin.jobs.values().filter(|job| !job.state.ended()).collect();
    let ended: Vec<_> = twin.jobs.values().filter(|job| job.state.ended()).collect();
    match random.below(12) {
        0 | 1 => {
            if let Some(job) = random.one(&open) {
                let state = [JobState::Succeeded, JobState::Failed, JobState::Cancelled][random.below(3)];
                let mut record = JobRecord { state, ended_ms: 86_400_000 + step as i64, ..(*job).clone() };
                // The record may have been copied before a cancel or a pause was stored.
                (record.cancel, record.paused) =
                    (job.cancel && random.below(2) == 0, job.paused && random.below(2) == 0);
                record.runs.stored_bytes = random.below(1000) as u64;
                record.runs.cpu_us = random.below(50) as u64;
                let log = (random.below(2) == 0).then(|| Bytes::from(vec![7; random.below(3000)]));
                return Operation::End(Box::new(record), log);
            }
        }
        2 => {
            if let Some(job) = random.one(&ended) {
                return Operation::Remove(Box::new((*job).clone()));
            }
        }
        3 => {
            let gone = ended.iter().filter(|_| random.below(6) == 0);
            let gone = gone.map(|job| EndedJob { id: job.id.clone(), ended_ms: job.ended_ms }).collect();
            return Operation::RemoveMany(gone);
        }
        4 => {
            let all: Vec<_> = twin.jobs.keys().cloned().collect();
            if let Some(id) = random.one(&all) {
                let question = twin.works.get(id).map_or(1, |work| work.answers.len() as u64 + 1);
                return match random.below(3) {
                    0 => Operation::Cancel(id.clone()),
                    1 => Operation::Pause(id.clone(), random.below(2) == 0),
                    _ => {
                        Operation::Answer(id.clone(), Settled { channel: 1, question, answer: Err(Silence::Declined) })
                    }
                };
            }
        }
        5 | 6 => return Operation::Put(definition(random)),
        7 => {
            let MachineRecord { tenant, name, trusted, .. } = definition(random);
            return Operation::RemoveMachine(tenant, name, trusted);
        }
        _ => {}
    }
    let mut asked = JobRecord { submitted_ms: 0, ..record("") };
    asked.tenant = TENANTS[random.below(2)].to_owned();
    asked.request_id = format!("r{}", random.below(2 * step + 2));
    asked.content = format!("{CONTENT}{}", random.below(2));
    let machine = MachineRecord { tenant: asked.tenant.clone(), ..definition(random) };
    asked.machine = Pinned::from(&machine);
    let files = vec![("f".to_owned(), format!("{:064}", random.below(5)))];
    asked.asked.labels.insert("part".to_owned(), random.below(3).to_string());
    Operation::Submit(Box::new(asked), Box::new(JobWork { machine, files, ..work() }))
}

struct Bench {
    runtime: tokio::runtime::Runtime,
    power: Arc<Power>,
    store: DataFolder,
    ledger: Option<LocalLedger>,
}

impl Bench {
    fn ledger(&self) -> &LocalLedger {
        self.ledger.as_ref().expect("it is open")
    }

    /// Does an operation; returns the record that a submit was answered with.
    fn apply(&self, operation: Operation) -> Result<Option<JobRecord>, Refusal> {
        let ledger = self.ledger();
        let run = &self.runtime;
        match operation {
            Operation::Submit(record, work) => {
                let submitted = run.block_on(ledger.submit(
                    Box::new(NewJob { record: *record, work: *work }),
                    Box::new(|_| Ok(())),
                    Box::new(|_| ()),
                ))?;
                return Ok(Some(match submitted {
                    SubmitOutcome::New(record) | SubmitOutcome::Known(record) => *record,
                }));
            }
            Operation::Cancel(id) => run.block_on(ledger.flag_cancel(id))?,
            Operation::Pause(id, paused) => run.block_on(ledger.flag_paused(id, paused))?,
            Operation::Answer(id, settled) => run.block_on(ledger.answered(id, settled))?,
            Operation::End(record, log) => {
                let (answer, answered) = std::sync::mpsc::channel();
                ledger.end(*record, log, Box::new(move |kept| answer.send(kept).unwrap()));
                answered.recv().unwrap()?;
            }
            Operation::Remove(record) => {
                assert!(run.block_on(ledger.remove((*record).clone()))?, "it was there");
                assert!(!run.block_on(ledger.remove(*record))?, "a second removal finds nothing");
            }
            Operation::RemoveMany(jobs) => {
                let count = jobs.len();
                assert_eq!(ledger.remove_blocking(jobs.clone())?, vec![true; count]);
                assert_eq!(ledger.remove_blocking(jobs)?, vec![false; count]);
            }
            Operation::Put(definition) => run.block_on(ledger.put_machine(definition, Box::new(|_| Ok(()))))?,
            Operation::RemoveMachine(tenant, name, trusted) => {
                run.block_on(ledger.remove_machine(tenant, name, trusted)).map(drop)?;
            }
        }
        Ok(None)
    }

    /// Closes the ledger, examines it, and opens it again.
    fn reopen(&mut self) {
        let epoch = self.ledger().epoch();
        self.ledger = None;
        self.power.0.store(-1, Ordering::SeqCst);
        let rows = Checkup::open(&self.store, false).unwrap().rows().unwrap();
        assert!(!rows.wrong_counts && rows.unreadable.is_empty(), "counts and lists agree with the rows");
        assert!(rows.requests.is_empty() && rows.logs.is_empty(), "nothing is left of jobs that are gone");
        let ledger = LocalLedger::open(&self.store, Arc::new(Metrics::new())).unwrap();
        assert!(ledger.epoch() > epoch);
        self.ledger = Some(ledger);
    }

    /// Checks that the ledger has the same content as the twin.
    fn holds(&self, twin: &Twin) -> Result<(), String> {
        let ledger = self.ledger();
        let same = |what: &str, same: bool| if same { Ok(()) } else { Err(what.to_owned()) };
        let open: Vec<_> = twin.jobs.values().filter(|job| !job.state.ended()).cloned().collect();
        same("unfinished", ledger.unfinished().unwrap() == open)?;
        for (id, job) in &twin.jobs {
            same("job", ledger.job(id).unwrap().as_ref() == Some(job))?;
            same("request", ledger.by_request(&job.tenant, &job.request_id).unwrap().as_ref() == Some(job))?;
            same("work", ledger.work(id).unwrap().as_ref() == twin.works.get(id))?;
            same("log", ledger.log(id).unwrap().as_ref() == twin.logs.get(id))?;
        }
        for tenant in TENANTS {
            let own = || twin.jobs.values().filter(|job| job.tenant == tenant);
            let query = Query { tenant: tenant.to_owned(), count: usize::MAX, ..Query::default() };
            same("list", ledger.jobs(&query).unwrap().jobs.iter().eq(own()))?;
            let failed = Query { states: BTreeSet::from([JobState::Failed]), newest_first: true, ..query.clone() };
            let expected = own().rev().filter(|job| job.state == JobState::Failed);
            same("failed", ledger.jobs(&failed).unwrap().jobs.iter().eq(expected))?;
            let labels = BTreeMap::from([("part".to_owned(), "1".to_owned())]);
            let expected = own().filter(|job| job.asked.labels == labels && job.machine.name == "m");
            let labelled = Query { labels: labels.clone(), machine: Some("m".to_owned()), ..query };
            same("label", ledger.jobs(&labelled).unwrap().jobs.iter().eq(expected))?;
            let usage = ledger.usage(tenant).unwrap();
            let of_work = |id: &str| twin.works.get(id).map_or(0, row_bytes);
            let ended = own().filter(|job| job.state.ended());
            let bytes: u64 = ended.map(|job| job.runs.stored_bytes + of_work(&job.id)).sum();
            let (day, cpu_us) = twin.runs.get(tenant).copied().unwrap_or_default();
            let rows = twin.machines.iter().filter(|((of, _), _)| of == tenant);
            let rows = rows.flat_map(|(_, (newest, all))| std::iter::once(newest).chain(all.values()));
            let machines = rows.map(row_bytes).sum();
            same("usage", usage == Usage { bytes, day, cpu_us, machines })?;
            let mut machines: Vec<_> = twin
                .machines
                .iter()
                .filter(|((of, _), _)| of == tenant)
                .map(|(_, (newest, _))| newest.clone())
                .collect();
            machines.sort_by(|a, b| a.name.cmp(&b.name));
            let mut listed = ledger.machines(tenant).unwrap();
            listed.sort_by(|a, b| a.name.cmp(&b.name));
            same("machines", listed == machines)?;
            for name in ["m", "n", "m-2"] {
                let entry = twin.machines.get(&(tenant.to_owned(), name.to_owned()));
                same("machine", ledger.machine(tenant, name).unwrap().as_ref() == entry.map(|(newest, _)| newest))?;
                for (revision, definition) in entry.into_iter().flat_map(|(_, all)| all) {
                    let pinned = ledger.machine(tenant, &format!("{name}@{revision}")).unwrap();
                    same("revision", pinned.as_ref() == Some(definition))?;
                }
            }
        }
        Ok(())
    }
}

/// Random operations with crashes; returns how many operations were in doubt.
fn drive(seed: u64, steps: usize) -> usize {
    let folder = tempfile::tempdir().unwrap();
    let power = Arc::new(Power(AtomicI64::new(-1)));
    let store = DataFolder::open(folder.path().to_owned(), true, Disk::faulty(power.clone())).unwrap();
    let ledger = Some(LocalLedger::open(&store, Arc::new(Metrics::new())).unwrap());
    let runtime = tokio::runtime::Builder::new_current_thread().build().unwrap();
    let mut bench = Bench { runtime, power, store, ledger };
    let (mut random, mut twin, mut doubts) = (Random(seed), Twin::default(), 0);
    for step in 0..steps {
        let operation = operation(&mut random, &twin, step);
        let crash = random.below(8) == 0;
        if crash {
            bench.power.0.store(random.below(12) as i64, Ordering::SeqCst);
        }
        match bench.apply(operation.clone()) {
            Err(Refusal::Storage(_)) => {
                assert!(crash, "{step}: only a crash fails {operation:?}");
                doubts += 1;
                bench.reopen();
                let mut done = twin.clone();
                let accepted = match &operation {
                    Operation::Submit(asked, _) => bench.ledger().by_request(&asked.tenant, &asked.request_id).unwrap(),
                    _ => None,
                };
                let may_be_done = !matches!(operation, Operation::Submit(..)) || accepted.is_some();
                if may_be_done {
                    done.apply(&operation, accepted.as_ref());
                }
                let (undone, wholly) = (bench.holds(&twin), bench.holds(&done));
                assert!(undone.is_ok() || wholly.is_ok(), "{seed}/{step}: {operation:?}: {undone:?} {wholly:?}");
                if wholly.is_ok() {
                    twin = done;
                }
            }
            Ok(answer) => {
                let refused = twin.apply(&operation, answer.as_ref());
                assert!(!refused, "{seed}/{step}: must be refused: {operation:?}");
            }
            Err(_) => assert!(twin.apply(&operation, None), "{seed}/{step}: must not be refused: {operation:?}"),
        }
        if crash {
            bench.reopen();
        }
        assert_eq!(bench.holds(&twin), Ok(()), "{seed}/{step}: after {operation:?}");
    }
    doubts
}

#[test]
fn the_ledger_is_what_its_twin_is_after_any_operations_and_crashes() {
    let doubts: usize = [1, 22, 333].into_iter().map(|seed| drive(seed, 150)).sum();
    assert!(doubts > 15, "crashes hit operations: {doubts}");
}
