//! Runs of several tenants on a few slots, with a clock that only the test advances.

use std::collections::BTreeSet;
use std::time::{Duration, Instant};

use super::*;
use crate::ledger::record::Priority;

/// Time between two looks of the server.
const TICK: Duration = Duration::from_millis(50);
const ENDLESS: Duration = Duration::from_secs(1_000_000);

const fn ms(ms: u64) -> Duration {
    Duration::from_millis(ms)
}

/// A simulated server. Its runs need worker time, and end between two ticks like real runs.
struct World {
    queue: LocalQueue,
    slots: usize,
    room: bool,
    begin: Instant,
    now: Instant,
    tick: Instant,
    /// Remaining time of the jobs that wait or run.
    needs: BTreeMap<String, Duration>,
    /// Runs in the order of their starts.
    started: Vec<String>,
    stand: BTreeSet<String>,
    /// Time with a slot, and time of the end, by job.
    used: BTreeMap<String, Duration>,
    ended: BTreeMap<String, Duration>,
    suspensions: usize,
    /// Suspects that were cleared, in order.
    cleared: Vec<String>,
}

impl World {
    fn new(slots: usize) -> Self {
        let now = Instant::now();
        Self {
            queue: LocalQueue::default(),
            slots,
            room: true,
            begin: now,
            now,
            tick: now + TICK,
            needs: BTreeMap::new(),
            started: Vec::new(),
            stand: BTreeSet::new(),
            used: BTreeMap::new(),
            ended: BTreeMap::new(),
            suspensions: 0,
            cleared: Vec::new(),
        }
    }

    /// Submits a job; its tenant is the first letter of its identity.
    fn submit(&mut self, id: &str, needs: Duration) {
        self.needs.insert(id.to_owned(), needs);
        let ticket = Ticket { id, tenant: &id[..1], priority: Priority::Normal };
        self.queue.push(ticket, EnqueueReason::Accepted(self.now));
        self.look();
    }

    /// A job that was running when the previous server died; it runs alone for five seconds.
    fn suspect(&mut self, id: &str, needs: Duration) {
        self.needs.insert(id.to_owned(), needs);
        let ticket = Ticket { id, tenant: &id[..1], priority: Priority::Normal };
        self.queue.push(ticket, EnqueueReason::Suspect(ms(5000)));
    }

    /// Pauses the run of a job that started as a suspect, and resumes the job.
    fn pause_and_resume(&mut self, id: &str, pause: Duration) {
        let ticket = Ticket { id, tenant: &id[..1], priority: Priority::Normal };
        self.queue.free(id, self.now);
        self.queue.push(ticket, EnqueueReason::Paused);
        self.look();
        self.pass(pause);
        assert!(self.queue.remove(id));
        let cleared = self.cleared.iter().any(|cleared| cleared == id);
        let entry = if cleared { EnqueueReason::Accepted(self.now) } else { EnqueueReason::Suspect(ms(5000)) };
        self.queue.push(ticket, entry);
        self.look();
    }

    fn look(&mut self) {
        let before = self.queue.suspended();
        let Self { queue, slots, room, now, started, stand, .. } = self;
        let look = SchedulingState {
            slots: *slots,
            starts: true,
            room: *room,
            now: *now,
            waits_for_client: &|id| stand.contains(id),
        };
        while let Some(id) = queue.next(&look) {
            started.push(id);
        }
        self.suspensions += self.queue.suspended().difference(&before).count();
        self.cleared.extend(self.queue.take_cleared());
    }

    /// Runs that use a slot.
    fn working(&self) -> Vec<String> {
        let runs = self.queue.running.iter().filter(|run| !run.suspended && !self.stand.contains(&run.id));
        runs.map(|run| run.id.clone()).collect()
    }

    /// Advances the clock, and ends runs that have used their time.
    fn pass(&mut self, time: Duration) {
        let until = self.now + time;
        while self.now < until {
            let working = self.working();
            let next = working.iter().map(|id| self.now + self.needs[id]).chain([self.tick, until]).min().unwrap();
            let passed = next - self.now;
            self.now = next;
            for id in &working {
                *self.used.entry(id[..1].to_owned()).or_default() += passed;
                let left = self.needs.get_mut(id).unwrap();
                *left -= passed;
                if left.is_zero() {
                    self.needs.remove(id);
                    self.ended.insert(id.clone(), self.now - self.begin);
                    self.queue.free(id, self.now);
                    self.look();
                }
            }
            if self.now >= self.tick {
                self.tick += TICK;
                self.look();
            }
            assert!(self.working().len() <= self.slots);
        }
    }

    fn used(&self, tenant: &str) -> Duration {
        self.used.get(tenant).copied().unwrap_or_default()
    }
}

#[test]
fn a_late_tenant_has_its_share_beside_endless_runs_of_eight() {
    let mut world = World::new(1);
    for tenant in ["a", "b", "c", "d", "e", "f", "g", "h"] {
        world.submit(tenant, ENDLESS);
        world.pass(ms(730));
    }
    world.submit("z", ms(40));
    let late = world.now - world.begin;
    world.pass(ms(1000));
    // Bound: the current slice, and the time of the job itself.
    assert!(world.ended["z"] - late <= ms(75 + 40), "{:?}", world.ended["z"] - late);
    // A tenant whose job needs several slices gets a ninth of the time.
    world.submit("y", ENDLESS);
    world.pass(Duration::from_secs(9));
    assert!((ms(900)..=ms(1100)).contains(&world.used("y")), "{:?}", world.used("y"));
}

#[test]
fn endless_runs_share_one_slot_equally() {
    let mut world = World::new(1);
    for tenant in ["a", "b", "c"] {
        world.submit(tenant, ENDLESS);
        world.pass(ms(300));
    }
    let before = ["a", "b", "c"].map(|tenant| world.used(tenant));
    world.pass(Duration::from_secs(30));
    for (tenant, before) in ["a", "b", "c"].into_iter().zip(before) {
        let used = world.used(tenant) - before;
        assert!((ms(9800)..=ms(10_200)).contains(&used), "{tenant}: {used:?}");
    }
}

#[test]
fn a_tenant_alone_is_never_suspended() {
    let mut world = World::new(2);
    for number in 0..20 {
        world.submit(&format!("a{number}"), ms(330));
    }
    world.pass(Duration::from_secs(10));
    assert_eq!((world.ended.len(), world.suspensions), (20, 0));
    assert_eq!(world.ended.values().max(), Some(&ms(3300)), "both slots were used all the time");
}

#[test]
fn no_run_is_suspended_while_there_are_slots_for_all() {
    let mut world = World::new(3);
    for tenant in ["a", "b", "c"] {
        world.submit(tenant, ENDLESS);
    }
    world.pass(Duration::from_secs(10));
    assert_eq!((world.suspensions, world.started.len()), (0, 3));
}

#[test]
fn short_jobs_of_one_tenant_have_half_the_time_beside_an_endless_run() {
    let mut world = World::new(1);
    world.submit("a", ENDLESS);
    world.pass(ms(500));
    for number in 0..2000 {
        world.submit(&format!("b{number}"), ms(3));
    }
    let before = world.used("a");
    world.pass(Duration::from_secs(4));
    let used = [world.used("a") - before, world.used("b")];
    assert!(used.iter().all(|used| (ms(1850)..=ms(2150)).contains(used)), "{used:?}");
}

/// Each job arrives after the previous job has ended. An account that restarted with each job would always be first.
#[test]
fn a_tenant_whose_jobs_come_one_by_one_has_no_more_than_its_share() {
    let mut world = World::new(1);
    for tenant in ["a", "b", "c"] {
        world.submit(tenant, ENDLESS);
    }
    for number in 0..200 {
        let id = format!("z{number}");
        world.submit(&id, ms(40));
        while !world.ended.contains_key(&id) {
            world.pass(ms(5));
        }
    }
    let (all, own) = (world.now - world.begin, world.used("z"));
    assert!(own * 4 <= all + ms(1000) && own * 5 >= all, "{own:?} of {all:?}");
}

#[test]
fn of_a_tenant_the_run_that_started_first_continues_and_no_job_starts_beside_a_suspended_one() {
    let mut world = World::new(2);
    for id in ["a1", "a2", "a3"] {
        world.submit(id, ENDLESS);
    }
    world.pass(ms(100));
    world.submit("b1", ENDLESS);
    world.submit("b2", ENDLESS);
    world.pass(Duration::from_secs(5));
    assert_eq!(world.started, ["a1", "a2", "b1"], "half of the slots for each tenant");
    assert_eq!(world.queue.suspended(), BTreeSet::from(["a2".to_owned()]));
    world.queue.free("b1", world.now);
    world.needs.remove("b1");
    world.look();
    assert_eq!(world.started[3..], ["b2"]);
}

#[test]
fn a_tenant_has_its_share_of_several_slots() {
    let mut world = World::new(4);
    for number in 0..8 {
        world.submit(&format!("a{number}"), ENDLESS);
    }
    world.pass(Duration::from_secs(2));
    for number in 0..8 {
        world.submit(&format!("b{number}"), ENDLESS);
    }
    let before = world.used("a");
    world.pass(Duration::from_secs(10));
    let used = [world.used("a") - before, world.used("b")];
    assert!(used.iter().all(|used| (ms(19_500)..=ms(20_500)).contains(used)), "{used:?}");
    assert_eq!(world.queue.workers(), 6, "two runs of the first are suspended");
}

#[test]
fn a_tenant_that_can_use_one_slot_only_does_not_hold_up_the_others() {
    let mut world = World::new(3);
    world.submit("a", ENDLESS);
    for number in 0..9 {
        world.submit(&format!("b{number}"), ENDLESS);
    }
    world.pass(Duration::from_secs(20));
    for number in 0..9 {
        world.submit(&format!("c{number}"), ENDLESS);
    }
    let before = ["a", "b", "c"].map(|tenant| world.used(tenant));
    world.pass(Duration::from_secs(1));
    assert!(world.used("b") - before[1] >= ms(400), "earlier use beyond the share delays a tenant only briefly");
    world.pass(Duration::from_secs(9));
    let used: Vec<_> = ["a", "b", "c"].into_iter().zip(before).map(|(of, before)| world.used(of) - before).collect();
    assert!(used.iter().all(|used| (ms(9000)..=ms(11_000)).contains(used)), "{used:?}");
}

#[test]
fn a_run_that_stands_uses_no_slot_and_no_time_and_holds_up_its_tenant_only() {
    let mut world = World::new(1);
    world.submit("a1", ENDLESS);
    world.stand.insert("a1".to_owned());
    world.pass(ms(500));
    world.submit("a2", ENDLESS);
    world.submit("b", ENDLESS);
    world.pass(Duration::from_secs(5));
    assert_eq!(world.started, ["a1", "b"]);
    assert_eq!((world.suspensions, world.working()), (0, vec!["b".to_owned()]));
    // The run is active again: both tenants share the slot.
    world.stand.clear();
    let before = world.used("b");
    world.pass(Duration::from_secs(10));
    let used = [world.used("a"), world.used("b") - before];
    assert!(used.iter().all(|used| (ms(4300)..=ms(5700)).contains(used)), "{used:?}");
    assert_eq!(world.started, ["a1", "b"]);
}

#[test]
fn without_memory_no_more_runs_than_twice_the_slots_are_there() {
    let mut world = World::new(1);
    world.room = false;
    for tenant in ["a", "b", "c"] {
        world.submit(tenant, ENDLESS);
        world.pass(Duration::from_secs(1));
    }
    assert_eq!(world.started, ["a", "b"]);
    world.room = true;
    world.pass(ms(100));
    assert_eq!(world.started, ["a", "b", "c"]);
}

#[test]
fn a_job_that_the_host_failed_gets_a_slot_beside_endless_runs() {
    let mut world = World::new(1);
    world.submit("a", ENDLESS);
    world.needs.insert("b".to_owned(), ms(10));
    let ticket = Ticket { id: "b", tenant: "b", priority: Priority::Normal };
    world.queue.push(ticket, EnqueueReason::Again(world.now + ms(220)));
    world.pass(ms(200));
    assert!(!world.started.contains(&"b".to_owned()));
    world.pass(ms(200));
    assert!(world.ended.contains_key("b"));
}

#[test]
fn suspended_runs_continue_after_a_suspect_and_while_no_job_may_start() {
    let mut world = World::new(1);
    world.submit("a", ms(1000));
    world.pass(ms(100));
    world.submit("b", ms(1000));
    world.pass(ms(100));
    world.suspect("c", ms(10));
    world.pass(Duration::from_secs(3));
    assert_eq!(world.ended.keys().collect::<Vec<_>>(), ["a", "b", "c"]);
    let mut world = World::new(1);
    world.submit("a", ms(1000));
    world.pass(ms(100));
    world.submit("b", ms(100));
    world.pass(ms(50));
    world.queue.free("b", world.now);
    let look = SchedulingState { slots: 1, starts: false, room: true, now: world.now, waits_for_client: &|_| false };
    assert_eq!((world.queue.next(&look), world.queue.suspended().len()), (None, 0));
}

#[test]
fn endless_suspects_hold_others_only_while_each_of_them_runs_alone() {
    let mut world = World::new(4);
    world.suspect("a", ENDLESS);
    world.suspect("b", ENDLESS);
    world.submit("z", ms(40));
    world.pass(ms(4000));
    assert_eq!(world.working(), ["a"]);
    world.pass(ms(2000));
    assert_eq!((world.working(), world.queue.idle()), (vec!["b".to_owned()], BTreeSet::from(["a".to_owned()])));
    world.pass(ms(4200));
    assert!(world.ended["z"] <= ms(10_000 + 75 + 40), "{:?}", world.ended["z"]);
    assert_eq!(world.working(), ["a", "b"]);
    assert!(world.queue.idle().is_empty());
}

/// The mark of such a job tells the next server that the run has not caused a crash.
#[test]
fn a_job_whose_end_is_being_stored_is_idle() {
    let mut world = World::new(1);
    world.submit("a1", ENDLESS);
    world.submit("a2", ENDLESS);
    world.pass(ms(10));
    assert!(world.queue.idle().is_empty());
    let (first, now) = (world.queue.running().remove(0), world.now);
    world.queue.store(&first, now);
    assert!(world.queue.idle().is_empty(), "most ends are stored at once");
    world.pass(2 * TICK);
    assert_eq!(world.queue.idle(), BTreeSet::from([first.clone()]));
    assert_eq!((world.queue.running().len(), world.queue.busy().len()), (1, 2), "its worker has the next job");
    world.queue.free(&first, now);
    assert!(world.queue.idle().is_empty());
}

#[test]
fn a_suspect_that_stands_holds_nobody() {
    let mut world = World::new(1);
    world.suspect("a", ENDLESS);
    world.suspect("b", ms(30));
    world.submit("z", ms(40));
    world.stand.insert("a".to_owned());
    world.pass(ms(300));
    assert!(world.ended["b"] <= ms(100) && world.ended["z"] <= ms(200), "{:?}", world.ended);
    // It runs beside others when its client acts.
    world.stand.clear();
    world.submit("y", ENDLESS);
    world.pass(ms(4000));
    assert!(world.used("a") >= ms(1800) && world.used("y") >= ms(1800), "{:?}", world.used);
}

#[test]
fn a_cleared_suspect_that_its_client_moves_waits_while_another_suspect_runs_alone() {
    let mut world = World::new(2);
    world.suspect("a", ENDLESS);
    world.suspect("b", ENDLESS);
    world.stand.insert("a".to_owned());
    world.look();
    world.pass(ms(200));
    world.stand.clear();
    world.pass(ms(100));
    assert_eq!(world.working(), ["b"]);
    world.pass(ms(5000));
    assert_eq!(world.working(), ["a", "b"]);
}

#[test]
fn a_suspect_that_is_paused_and_resumed_again_and_again_has_its_time_alone_once() {
    let mut world = World::new(2);
    world.suspect("a1", ENDLESS);
    world.suspect("a2", ENDLESS);
    world.submit("z", ENDLESS);
    for number in 0..12 {
        world.pass(ms(1000));
        world.pause_and_resume(["a1", "a2"][number % 2], ms(100));
    }
    let before = world.used("z");
    assert!(before >= ms(12_000 + 1200 - 10_000), "{before:?}");
    assert_eq!(world.cleared, ["a1", "a2"]);
    world.pass(ms(4000));
    assert!(world.used("z") - before >= ms(1900), "it has its share: {:?}", world.used("z") - before);
}

#[test]
fn a_suspect_whose_run_the_host_failed_runs_alone_after_its_pause() {
    let mut world = World::new(2);
    world.suspect("a", ENDLESS);
    world.pass(ms(1000));
    world.queue.free("a", world.now);
    let ticket = Ticket { id: "a", tenant: "a", priority: Priority::Normal };
    world.queue.push(ticket, EnqueueReason::Again(world.now + ms(500)));
    world.submit("z", ENDLESS);
    world.pass(ms(400));
    assert_eq!(world.working(), ["z"]);
    world.pass(ms(3000));
    assert_eq!(world.working(), ["a"]);
    world.pass(ms(2000));
    assert_eq!((world.working().len(), world.cleared), (2, vec!["a".to_owned()]));
}
