use super::super::Role;
use super::*;

fn identity(name: &str) -> Arc<Identity> {
    Arc::new(Identity { name: name.into(), tenant: format!("of {name}"), role: Role::Submit })
}

fn in_hand(fair: &Fair, identity: &Arc<Identity>, calls: usize) -> (Vec<CallTurn>, Vec<oneshot::Receiver<CallTurn>>) {
    let (mut turns, mut waiting) = (Vec::new(), Vec::new());
    for _ in 0..calls {
        match fair.ask(identity, Instant::now()) {
            Ok(turn) => turns.push(turn),
            Err(comes) => waiting.push(comes),
        }
    }
    (turns, waiting)
}

#[test]
fn alone_nobody_waits_and_beside_another_a_flood_has_a_few_calls_in_hand() {
    let (fair, noisy, quiet) = (Fair::default(), identity("noisy"), identity("quiet"));
    let (turns, waiting) = in_hand(&fair, &noisy, 64);
    assert_eq!((turns.len(), waiting.len()), (64, 0));
    let own = fair.ask(&quiet, Instant::now()).expect("it has no call in hand");
    let (more, mut waiting) = in_hand(&fair, &noisy, 10);
    assert_eq!((more.len(), waiting.len()), (0, 10));
    // Those in hand end; one by one the others follow, never more than a few at once.
    drop(turns);
    let mut first: Vec<CallTurn> = waiting.iter_mut().filter_map(|comes| comes.try_recv().ok()).collect();
    assert_eq!(first.len(), FEW);
    first.pop();
    waiting.drain(..FEW);
    assert!(waiting[0].try_recv().is_ok(), "in the order in which they came");
    drop(own);
}

#[test]
fn two_that_are_equally_busy_do_not_limit_each_other_and_a_third_limits_both() {
    let (fair, one, other) = (Fair::default(), identity("one"), identity("other"));
    let (_first, _) = in_hand(&fair, &one, 20);
    let (second, _) = in_hand(&fair, &other, 30);
    assert_eq!(second.len(), 20);
    let third = fair.ask(&identity("third"), Instant::now());
    let (more, waiting) = in_hand(&fair, &one, 1);
    assert_eq!((more.len(), waiting.len()), (0, 1));
    drop(third);
}

#[test]
fn calls_that_are_given_up_leave_their_place_to_the_next() {
    let (fair, noisy) = (Fair::default(), identity("noisy"));
    let _quiet = fair.ask(&identity("quiet"), Instant::now());
    let (mut turns, mut waiting) = in_hand(&fair, &noisy, FEW + 3);
    drop(waiting.drain(..2));
    turns.pop();
    assert!(waiting[0].try_recv().is_ok());
    // A turn that comes while its call is given up is not lost.
    let (_, late) = in_hand(&fair, &noisy, 2);
    drop((turns, late));
    let (again, _) = in_hand(&fair, &noisy, FEW + 1);
    assert_eq!(again.len(), FEW);
    drop(again);
    assert_eq!(fair.0.lock().get(&noisy).unwrap().active, 0);
}

#[test]
fn a_call_that_lasts_counts_while_its_data_flow() {
    let (fair, noisy, quiet) = (Fair::default(), identity("noisy"), identity("quiet"));
    let stay = fair.stay(&quiet);
    let may = |at| {
        let turns: Vec<_> = (0..FEW + 3).map_while(|_| fair.ask(&noisy, at).ok()).collect();
        turns.len()
    };
    let mut now = Instant::now();
    assert_eq!(may(now), FEW, "it has just come");
    now += LINGER;
    assert_eq!(may(now), FEW + 3, "it waits");
    stay.flows(HEARTBEAT, now);
    assert_eq!(may(now), FEW + 3, "a heartbeat");
    stay.flows(HEARTBEAT + 1, now);
    assert_eq!(may(now), FEW, "events");
    assert_eq!(may(now + LINGER), FEW + 3, "it waits again");
}

#[test]
fn jobs_of_others_count_and_those_who_have_left_do_not() {
    let (fair, noisy, quiet) = (Fair::default(), identity("noisy"), identity("quiet"));
    drop(fair.ask(&quiet, Instant::now()));
    let later = Instant::now() + LINGER;
    let alone: Vec<_> = (0..10).map(|_| fair.ask(&noisy, later)).collect();
    assert!(alone.iter().all(Result::is_ok));
    drop(alone);
    fair.mind(Box::new(|tenant| tenant != "of quiet"));
    let (turns, _) = in_hand(&fair, &noisy, 10);
    assert_eq!(turns.len(), FEW, "a job of the other tenant runs");
}
