use std::time::Duration;

use super::*;
use crate::ledger::record::Priority;

fn id(number: usize) -> String {
    format!("{number:06}")
}

fn ticket<'a>(id: &'a str, tenant: &'a str) -> Ticket<'a> {
    Ticket { id, tenant, priority: Priority::Normal }
}

/// Divides the slots, with memory for all runs, none of which stands.
fn next(queue: &mut LocalQueue, slots: usize, now: Instant) -> Option<String> {
    queue.next(&SchedulingState { slots, starts: true, room: true, now, waits_for_client: &|_| false })
}

/// Lets a job of the default tenant wait.
fn push(queue: &mut LocalQueue, id: &str, entry: EnqueueReason) {
    queue.push(ticket(id, "default"), entry);
}

#[test]
fn places_are_those_of_a_plain_list() {
    let now = Instant::now();
    let mut queue = LocalQueue::default();
    let mut twin: Vec<String> = Vec::new();
    let mut random = 7_u64;
    for number in 0..6000 {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let at = (random >> 33) as usize % twin.len().max(1);
        match random >> 61 {
            0 if !twin.is_empty() => assert!(queue.remove(&twin.remove(at))),
            1 | 2 if !twin.is_empty() => {
                assert_eq!(next(&mut queue, usize::MAX, now).unwrap(), twin.remove(0));
            }
            _ => {
                push(&mut queue, &id(number), EnqueueReason::Accepted(now));
                twin.push(id(number));
            }
        }
        if let Some(id) = twin.get(at) {
            assert_eq!(queue.before(id), at);
        }
        assert_eq!((queue.len(), queue.waiting_of("default")), (twin.len(), twin.len()));
    }
    for (at, id) in twin.iter().enumerate() {
        assert_eq!(queue.before(id), at);
    }
}

/// With a walk along the queue for each question this takes ten thousand million steps.
#[test]
fn a_hundred_thousand_questions_about_a_hundred_thousand_jobs_are_answered() {
    let now = Instant::now();
    let mut queue = LocalQueue::default();
    (0..100_000).for_each(|number| push(&mut queue, &id(number), EnqueueReason::Accepted(now)));
    for number in 0..100_000 {
        assert_eq!(queue.before(&id(number)), number);
    }
}

#[test]
fn suspects_run_first_and_without_company() {
    let now = Instant::now();
    let mut queue = LocalQueue::default();
    push(&mut queue, "other", EnqueueReason::Accepted(now));
    push(&mut queue, "first", EnqueueReason::Suspect(Duration::from_secs(5)));
    push(&mut queue, "second", EnqueueReason::Suspect(Duration::from_secs(5)));
    assert_eq!((queue.before("second"), queue.before("other")), (1, 2));
    assert_eq!(next(&mut queue, 4, now).unwrap(), "first");
    assert!(next(&mut queue, 4, now).is_none(), "nothing runs beside a suspect");
    queue.free("first", now);
    assert_eq!(next(&mut queue, 4, now).unwrap(), "second");
    assert!(next(&mut queue, 4, now).is_none());
    queue.free("second", now);
    assert_eq!(next(&mut queue, 4, now).unwrap(), "other");
}

#[test]
fn a_job_that_the_host_failed_waits_for_its_time_and_lets_others_run() {
    let now = Instant::now();
    let later = now + Duration::from_secs(1);
    let mut queue = LocalQueue::default();
    push(&mut queue, "other", EnqueueReason::Accepted(now));
    push(&mut queue, "last", EnqueueReason::Accepted(now));
    push(&mut queue, "failed", EnqueueReason::Again(later));
    assert_eq!(next(&mut queue, 4, now).unwrap(), "other");
    assert_eq!(next(&mut queue, 4, later).unwrap(), "failed");
    assert_eq!(next(&mut queue, 4, later).unwrap(), "last");
    assert!(!queue.remove("last"));
}

#[test]
fn urgent_jobs_go_first_and_patience_is_rewarded() {
    let now = Instant::now();
    let mut queue = LocalQueue::default();
    for (id, priority) in [("low", Priority::Low), ("normal", Priority::Normal), ("high", Priority::High)] {
        queue.push(Ticket { id, tenant: "t", priority }, EnqueueReason::Accepted(now));
    }
    assert_eq!((queue.before("low"), queue.before("normal"), queue.before("high")), (2, 1, 0));
    assert_eq!(next(&mut queue, 9, now).unwrap(), "high");
    let later = now + Duration::from_secs(125);
    queue.push(Ticket { id: "new", tenant: "t", priority: Priority::High }, EnqueueReason::Accepted(later));
    // Both have risen above a new urgent job, and as far as each other: the difference between them stays.
    assert_eq!(next(&mut queue, 9, later).unwrap(), "normal");
    assert_eq!(next(&mut queue, 9, later).unwrap(), "low", "as urgent as the new one by now, and older");
    assert_eq!(next(&mut queue, 9, later).unwrap(), "new");
}

/// Runs jobs one after the other, each for its time; returns their order.
fn run_all(queue: &mut LocalQueue, mut now: Instant, time: impl Fn(&str) -> Duration) -> Vec<String> {
    let mut order = Vec::new();
    while let Some(id) = next(queue, 1, now) {
        now += time(&id);
        queue.free(&id, now);
        order.push(id);
    }
    order
}

#[test]
fn a_queue_of_thousands_delays_another_tenant_by_one_turn() {
    let now = Instant::now();
    let mut queue = LocalQueue::default();
    for number in 0..5000 {
        let id = format!("a{number}");
        queue.push(ticket(&id, "a"), EnqueueReason::Accepted(now));
    }
    queue.push(ticket("b", "b"), EnqueueReason::Accepted(now));
    assert_eq!(queue.before("b"), 1);
    // Jobs of 20 ms are longer than a quantum, so one of them goes before.
    let order = run_all(&mut queue, now, |_| Duration::from_millis(20));
    assert_eq!(order.len(), 5001);
    assert!(order.iter().position(|id| id == "b").unwrap() <= 2, "{:?}", &order[..5]);
}

#[test]
fn tenants_share_the_time_of_workers_and_not_the_number_of_jobs() {
    let now = Instant::now();
    let mut queue = LocalQueue::default();
    for number in 0..4000 {
        for tenant in ["long", "short"] {
            let id = format!("{tenant}-{number}");
            queue.push(ticket(&id, tenant), EnqueueReason::Accepted(now));
        }
    }
    let time = |id: &str| Duration::from_millis(if id.starts_with("long") { 100 } else { 10 });
    let order = run_all(&mut queue, now, time);
    let short = order.iter().take(1100).filter(|id| id.starts_with("short")).count();
    assert!((950..=1050).contains(&short), "ten short jobs for each long one: {short} of 1100");
}

#[test]
fn a_tenant_has_no_more_workers_than_its_quota() {
    let now = Instant::now();
    let mut queue = LocalQueue::default();
    queue.let_run(1, HashMap::new());
    for (id, tenant) in [("a1", "a"), ("a2", "a"), ("b1", "b"), ("b2", "b")] {
        queue.push(ticket(id, tenant), EnqueueReason::Accepted(now));
    }
    let mut first = [next(&mut queue, 4, now).unwrap(), next(&mut queue, 4, now).unwrap()];
    first.sort();
    assert_eq!((first, next(&mut queue, 4, now)), (["a1".to_owned(), "b1".to_owned()], None));
    queue.free("b1", now);
    assert_eq!(next(&mut queue, 4, now).as_deref(), Some("b2"));
    // A job that waits for another run needs a worker of its tenant, too.
    queue.push(ticket("a0", "a"), EnqueueReason::Again(now));
    assert_eq!(next(&mut queue, 4, now), None);
    queue.let_run(1, HashMap::from([("a".to_owned(), 2)]));
    assert_eq!((next(&mut queue, 4, now).as_deref(), next(&mut queue, 4, now)), (Some("a0"), None));
}

/// A tenant submits one job after the other beside ten thousand jobs of another tenant. Its share of the starts is
/// half, within a tenth, as beside a tenant like itself.
#[test]
fn a_tenant_beside_ten_thousand_jobs_of_another_has_its_share_of_the_starts() {
    const STARTS: usize = 400;
    let mut now = Instant::now();
    let mut queue = LocalQueue::default();
    for number in 0..10_000 {
        queue.push(ticket(&format!("noisy-{number}"), "noisy"), EnqueueReason::Accepted(now));
    }
    let (mut quiet, mut between) = (0, 0);
    queue.push(ticket("quiet-0", "quiet"), EnqueueReason::Accepted(now));
    for _ in 0..STARTS {
        let id = next(&mut queue, 1, now).unwrap();
        now += Duration::from_millis(10);
        let own = id.starts_with("quiet");
        between = if own { 0 } else { between + 1 };
        assert!(between <= 2, "two jobs of the other one at the most run before the next of this one");
        queue.free(&id, now);
        if own {
            quiet += 1;
            queue.push(ticket(&format!("quiet-{quiet}"), "quiet"), EnqueueReason::Accepted(now));
        }
    }
    assert!(quiet * 10 >= STARTS / 2 * 9, "{quiet} of {STARTS} starts");
}

/// A job is always in one place, and lines and the ring agree with the jobs.
#[test]
fn the_books_of_the_queue_agree_after_anything() {
    let begin = Instant::now();
    let mut queue = LocalQueue::default();
    queue.let_run(3, HashMap::new());
    let (mut waiting, mut running) = (Vec::<(String, String)>::new(), Vec::<String>::new());
    let mut random = 99_u64;
    for step in 0..20_000_usize {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let now = begin + Duration::from_millis(step as u64);
        let pick = (random >> 20) as usize;
        match random >> 61 {
            0..=2 => {
                let (id, tenant) = (id(step), format!("t{}", pick % 5));
                let priority = [Priority::High, Priority::Normal, Priority::Low][pick / 5 % 3];
                let entry = match pick % 14 {
                    0 | 7 => EnqueueReason::Again(now),
                    3 => EnqueueReason::Paused,
                    _ => EnqueueReason::Accepted(now),
                };
                queue.push(Ticket { id: &id, tenant: &tenant, priority }, entry);
                waiting.push((id, tenant));
            }
            3 if !waiting.is_empty() => {
                let (id, _) = waiting.swap_remove(pick % waiting.len());
                assert!(queue.remove(&id) && !queue.remove(&id));
            }
            4 | 5 if !running.is_empty() => {
                let id = running.swap_remove(pick % running.len());
                queue.store(&id, now);
                queue.free(&id, now);
            }
            _ => {
                if let Some(id) = next(&mut queue, 4, now) {
                    assert!(!queue.is_paused(&id));
                    let at = waiting.iter().position(|(waiting, _)| *waiting == id).expect("it was waiting");
                    waiting.swap_remove(at);
                    running.push(id);
                }
            }
        }
        assert_eq!((queue.len(), queue.workers()), (waiting.len(), running.len()));
        let suspended = queue.suspended();
        assert!(suspended.iter().all(|id| running.contains(id)));
        assert!(queue.workers() - suspended.len() <= 4, "no more runs than slots use a core");
        for tenant in ["t0", "t1", "t2", "t3", "t4"] {
            let held = waiting.iter().filter(|(_, of)| of == tenant).count();
            assert_eq!(queue.waiting_of(tenant), held);
            assert!(queue.running.iter().filter(|run| &*run.tenant == tenant).count() <= 3, "its quota");
        }
    }
}

#[test]
fn a_run_that_stands_and_jobs_behind_it_are_no_work() {
    let now = Instant::now();
    let mut queue = LocalQueue::default();
    let work = |queue: &LocalQueue, tenant, stand: &[&str]| queue.others_work(tenant, &|id| stand.contains(&id));
    queue.push(ticket("steps", "other"), EnqueueReason::Accepted(now));
    assert!(!work(&queue, "one", &[]), "no worker is busy");
    assert_eq!(next(&mut queue, 1, now).as_deref(), Some("steps"));
    assert!(work(&queue, "one", &[]) && !work(&queue, "one", &["steps"]) && !work(&queue, "other", &[]));
    let next = |queue: &mut LocalQueue| {
        queue.next(&SchedulingState { slots: 1, starts: true, room: true, now, waits_for_client: &|id| id == "steps" })
    };
    queue.push(ticket("behind", "other"), EnqueueReason::Accepted(now));
    assert!(!work(&queue, "one", &["steps"]), "it waits for one that stands");
    queue.push(ticket("own", "one"), EnqueueReason::Accepted(now));
    assert_eq!(next(&mut queue).as_deref(), Some("own"));
    assert!(work(&queue, "one", &["steps"]), "it waits for a worker that a job keeps busy");
    queue.push(ticket("held", "third"), EnqueueReason::Paused);
    assert!(!work(&queue, "other", &["steps", "own"]));
}
