use super::*;

fn id(number: usize) -> String {
    format!("{number:06}")
}

#[test]
fn places_are_those_of_a_plain_list() {
    let mut queue = LocalQueue::default();
    let mut twin: Vec<String> = Vec::new();
    let mut random = 7_u64;
    for number in 0..6000 {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let at = (random >> 33) as usize % twin.len().max(1);
        match random >> 61 {
            0 if !twin.is_empty() => assert!(queue.remove(&twin.remove(at))),
            1 | 2 if !twin.is_empty() => {
                assert_eq!(queue.next(usize::MAX, Instant::now()).unwrap(), twin.remove(0));
            }
            _ => {
                queue.push(&id(number), Entry::Accepted);
                twin.push(id(number));
            }
        }
        if let Some(id) = twin.get(at) {
            assert_eq!(queue.before(id), at);
        }
        assert_eq!(queue.len(), twin.len());
    }
    for (at, id) in twin.iter().enumerate() {
        assert_eq!(queue.before(id), at);
    }
}

/// With a walk along the queue for each question this takes ten thousand million steps.
#[test]
fn a_hundred_thousand_questions_about_a_hundred_thousand_jobs_are_answered() {
    let mut queue = LocalQueue::default();
    (0..100_000).for_each(|number| queue.push(&id(number), Entry::Accepted));
    for number in 0..100_000 {
        assert_eq!(queue.before(&id(number)), number);
    }
}

#[test]
fn suspects_run_first_and_without_company() {
    let now = Instant::now();
    let mut queue = LocalQueue::default();
    queue.push("other", Entry::Accepted);
    queue.push("first", Entry::Suspect);
    queue.push("second", Entry::Suspect);
    assert_eq!((queue.before("second"), queue.before("other")), (1, 2));
    assert_eq!(queue.next(4, now).unwrap(), "first");
    assert!(queue.next(4, now).is_none(), "nothing runs beside a suspect");
    queue.free("first");
    assert_eq!(queue.next(4, now).unwrap(), "second");
    assert!(queue.next(4, now).is_none());
    queue.free("second");
    assert_eq!(queue.next(4, now).unwrap(), "other");
}

#[test]
fn a_job_that_the_host_failed_waits_for_its_time_and_lets_others_run() {
    let now = Instant::now();
    let later = now + std::time::Duration::from_secs(1);
    let mut queue = LocalQueue::default();
    queue.push("other", Entry::Accepted);
    queue.push("last", Entry::Accepted);
    queue.push("failed", Entry::Again(later));
    assert_eq!(queue.next(4, now).unwrap(), "other");
    assert_eq!(queue.next(4, later).unwrap(), "failed");
    assert_eq!(queue.next(4, later).unwrap(), "last");
    assert!(!queue.remove("last"));
}
