use super::*;
use crate::ledger::record::tests::record;

fn live(id: usize) -> Arc<Live> {
    Arc::new(Live::new(record(&format!("{id:06}"))))
}

#[test]
fn places_are_those_of_a_plain_list() {
    let mut queue = Queue::default();
    let mut twin: Vec<Arc<Live>> = Vec::new();
    let mut random = 7_u64;
    for id in 0..6000 {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let at = (random >> 33) as usize % twin.len().max(1);
        match random >> 61 {
            0 if !twin.is_empty() => assert!(queue.remove(&twin.remove(at))),
            1 | 2 if !twin.is_empty() => {
                let next = queue.next(usize::MAX, Instant::now()).unwrap();
                assert_eq!(next.id, twin.remove(0).id);
            }
            _ => {
                let live = live(id);
                queue.push(live.clone());
                twin.push(live);
            }
        }
        if let Some(live) = twin.get(at) {
            assert_eq!(queue.before(live), at);
        }
        assert_eq!(queue.len(), twin.len());
    }
    for (at, live) in twin.iter().enumerate() {
        assert_eq!(queue.before(live), at);
    }
}

/// With a walk along the queue for each question this takes ten thousand million steps.
#[test]
fn a_hundred_thousand_questions_about_a_hundred_thousand_jobs_are_answered() {
    let mut queue = Queue::default();
    let jobs: Vec<_> = (0..100_000).map(live).collect();
    jobs.iter().for_each(|live| queue.push(live.clone()));
    for (at, live) in jobs.iter().enumerate() {
        assert_eq!(queue.before(live), at);
    }
}

#[test]
fn suspects_run_first_and_without_company() {
    let now = Instant::now();
    let mut queue = Queue::default();
    let (first, second, other) = (live(1), live(2), live(3));
    queue.push(other.clone());
    queue.push_suspect(first.clone());
    queue.push_suspect(second.clone());
    assert_eq!((queue.before(&second), queue.before(&other)), (1, 2));
    assert_eq!(queue.next(4, now).unwrap().id, first.id);
    assert!(queue.next(4, now).is_none(), "nothing runs beside a suspect");
    queue.free(&first);
    assert_eq!(queue.next(4, now).unwrap().id, second.id);
    assert!(queue.next(4, now).is_none());
    queue.free(&second);
    assert_eq!(queue.next(4, now).unwrap().id, other.id);
}

#[test]
fn a_job_that_the_host_failed_waits_for_its_time_and_lets_others_run() {
    let now = Instant::now();
    let later = now + std::time::Duration::from_secs(1);
    let mut queue = Queue::default();
    let (failed, other, last) = (live(1), live(2), live(3));
    queue.push(other.clone());
    queue.push(last.clone());
    queue.push_again(later, failed.clone());
    assert_eq!(queue.next(4, now).unwrap().id, other.id);
    assert_eq!(queue.next(4, later).unwrap().id, failed.id);
    assert_eq!(queue.next(4, later).unwrap().id, last.id);
    assert!(!queue.remove(&last));
}
