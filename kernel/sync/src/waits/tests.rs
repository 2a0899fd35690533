use super::*;
use crate::wait::{Absent, Lasts, MarkRange, MarkSpace, MismatchCheck, RuleId, Send, Terminal, WaitMark, WaitRule};

/// Channels by number.
fn set(channels: &[u16]) -> ChannelSet {
    channels.iter().copied().collect()
}

/// A wait of these channels.
fn wait(primitive: Primitive, number: u32, parts: &[u16]) -> Wait {
    let parts = set(parts);
    Wait {
        primitive,
        key: WaitMark { space: MarkSpace::Statements, number },
        named: Some(parts),
        parts,
        need: 0,
        rule: RuleId::Start,
    }
}

fn at(channel: u16, t: i64, wait: Wait) -> WaitingChannel {
    WaitingChannel { wait, tag: Tag { t, micro: 0, channel }, file: 0, line: 1 }
}

fn tag(channel: u16, t: i64) -> Tag {
    Tag { t, micro: 0, channel }
}

fn key(number: u32) -> WaitMark {
    WaitMark { space: MarkSpace::Statements, number }
}

fn ended() -> Finish {
    Finish { how: Terminal::Ended, file: 0, line: 9 }
}

fn rule(absent: Absent) -> WaitRules {
    WaitRules::new([(RuleId::Start, WaitRule { absent, list: " P".into(), ..WaitRule::plain("M") })])
}

fn waits(channels: u16) -> JobWaits {
    JobWaits::new(Channels::new(1..=channels), rule(Absent::Missed), 0)
}

fn counting_absent(channels: u16) -> JobWaits {
    JobWaits::new(Channels::new(1..=channels), rule(Absent::Counts), 0)
}

/// Channels that continue by an arrival, as groups, and when.
fn continue_by(waits: &mut JobWaits, waiting: WaitingChannel) -> Vec<(Vec<u16>, i64)> {
    let ArrivalConsequences { arrival, others, .. } = waits.arrive(waiting);
    let own = match arrival {
        ArrivalOutcome::Released(released) => Some(released),
        ArrivalOutcome::Blocked => None,
        other => panic!("{other:?}"),
    };
    let all: Vec<Released> = own.into_iter().chain(others).collect();
    assert!(all.iter().all(|one| one.by == waiting.tag.channel), "{all:?}");
    groups(&all)
}

fn groups(released: &[Released]) -> Vec<(Vec<u16>, i64)> {
    released.iter().map(|one| (one.channels.iter().collect(), one.t)).collect()
}

fn act(waits: &mut JobWaits, tag: Tag, act: WaitOp) -> Vec<(Vec<u16>, i64)> {
    let released = waits.act(tag, act).unwrap();
    assert!(released.iter().all(|one| one.by == tag.channel));
    groups(&released)
}

fn finish(waits: &mut JobWaits, tag: Tag) -> Vec<(Vec<u16>, i64)> {
    waits.finish(tag.channel, ended());
    groups(&waits.settle(tag))
}

const NOBODY: [(Vec<u16>, i64); 0] = [];

#[test]
fn a_barrier_releases_all_at_the_latest_arrival() {
    let mut waits = waits(3);
    let barrier = wait(Primitive::Barrier, 101, &[1, 2, 3]);
    assert_eq!(continue_by(&mut waits, at(1, 1, barrier)), NOBODY);
    assert_eq!(continue_by(&mut waits, at(2, 5, barrier)), NOBODY);
    assert_eq!(waits.missing(1), MissingChannels::all(set(&[3])));
    let released = Released { channels: ChannelSet::up_to(3), t: 7, micro: 1, by: 3, short: None };
    assert_eq!(waits.arrive(at(3, 7, barrier)), ArrivalOutcome::Released(released).into());
}

#[test]
fn a_release_takes_its_time() {
    let mut waits = JobWaits::new(Channels::new(1..=2), rule(Absent::Missed), 500);
    let barrier = wait(Primitive::Barrier, 1, &[1, 2]);
    waits.arrive(at(1, 1, barrier));
    let released = Released { channels: ChannelSet::up_to(2), t: 503, micro: 0, by: 2, short: None };
    assert_eq!(waits.arrive(at(2, 3, barrier)).arrival, ArrivalOutcome::Released(released));
}

#[test]
fn a_barrier_with_other_participants_is_another_one() {
    let mut waits = waits(4);
    waits.arrive(at(1, 1, wait(Primitive::Barrier, 1, &[1, 2])));
    assert_eq!(continue_by(&mut waits, at(2, 2, wait(Primitive::Barrier, 1, &[2, 3]))), NOBODY);
    assert_eq!(continue_by(&mut waits, at(3, 3, wait(Primitive::Barrier, 1, &[2, 3]))), [(vec![2, 3], 3)]);
    assert_eq!(waits.missing(1).channels, set(&[2]));
}

#[test]
fn a_rule_refuses_pairs_of_waits() {
    let refuses = |one: &Wait, other: &Wait| (one.key != other.key).then_some("other numbers");
    let rule = |reaction| {
        let mismatch = MismatchCheck { refuses, title: "17 no pair", reaction };
        WaitRule { mismatch: Some(mismatch), ..WaitRule::plain("M") }
    };
    let arrive = |reaction| {
        let mut waits = JobWaits::new(Channels::new(1..=2), WaitRules::new([(RuleId::Start, rule(reaction))]), 0);
        waits.arrive(at(1, 1, wait(Primitive::Barrier, 1, &[1, 2])));
        let second = at(2, 2, wait(Primitive::Barrier, 2, &[1, 2]));
        assert_eq!(waits.arrive_plainly(second), None);
        (waits.arrive(second), waits)
    };
    let (arrived, waits) = arrive(Reaction::Alarm);
    let refused = |refused: &RefusedPairs| {
        assert_eq!(
            (refused.title, refused.channels(), refused.standing.len()),
            ("17 no pair", ChannelSet::up_to(2), 1)
        );
        let (other, case) = refused.standing[0];
        assert_eq!((refused.arriving.tag.channel, other.tag.channel, case), (2, 1, "other numbers"));
    };
    let ArrivalOutcome::Mismatch(alarm) = &arrived.arrival else { panic!("{arrived:?}") };
    refused(alarm);
    assert_eq!(waits.places.waiting().count(), 0);
    let (arrived, waits) = arrive(Reaction::Warning);
    assert_eq!(arrived.arrival, ArrivalOutcome::Blocked);
    refused(&arrived.warning.unwrap());
    assert_eq!(waits.dead(), ChannelSet::up_to(2));
}

#[test]
fn a_circle_of_three_is_dead_only_when_closed() {
    let mut waits = waits(3);
    waits.arrive(at(1, 1, wait(Primitive::Barrier, 101, &[1, 2])));
    waits.arrive(at(2, 2, wait(Primitive::Barrier, 102, &[2, 3])));
    assert_eq!(waits.dead(), ChannelSet::default());
    waits.arrive(at(3, 3, wait(Primitive::Barrier, 103, &[1, 3])));
    assert_eq!(waits.dead(), ChannelSet::up_to(3));
}

/// Scenario M05: a flag that is set without waiting stays, until it is cleared.
#[test]
fn a_flag_that_was_set_stays() {
    let mut waits = waits(2);
    assert_eq!(act(&mut waits, tag(1, 1), WaitOp::Set(key(5))), NOBODY);
    for t in [1, 2] {
        assert_eq!(continue_by(&mut waits, at(2, t, wait(Primitive::Flag, 5, &[1, 2]))), [(vec![2], t)]);
    }
    assert_eq!(act(&mut waits, tag(1, 3), WaitOp::Clear(key(5))), NOBODY);
    assert_eq!(continue_by(&mut waits, at(2, 4, wait(Primitive::Flag, 5, &[1, 2]))), NOBODY);
    assert_eq!(act(&mut waits, tag(1, 5), WaitOp::Set(key(5))), [(vec![2], 5)]);
}

/// Scenario N02b: lists that are not mutual, two phases.
#[test]
fn flags_are_deleted_after_all_who_saw_them_continue() {
    let mut waits = waits(4);
    let (two, four) = (wait(Primitive::Flag, 40, &[1, 2]), wait(Primitive::Flag, 40, &[2, 4]));
    assert_eq!(continue_by(&mut waits, at(2, 1, two)), NOBODY);
    assert_eq!(continue_by(&mut waits, at(4, 2, four)), [(vec![4], 2)]);
    assert_eq!(continue_by(&mut waits, at(4, 3, four)), [(vec![4], 3)]);
    assert_eq!(continue_by(&mut waits, at(1, 10, two)), [(vec![1, 2], 10)]);
    assert_eq!(continue_by(&mut waits, at(4, 11, four)), NOBODY, "the flag of channel 2 is deleted");
}

/// An arrival at a flag lets another channel continue that waits for it alone, and waits itself.
#[test]
fn a_flag_lets_others_continue() {
    let mut waits = waits(3);
    assert_eq!(continue_by(&mut waits, at(1, 1, wait(Primitive::Flag, 1, &[1, 2]))), NOBODY);
    assert_eq!(continue_by(&mut waits, at(2, 2, wait(Primitive::Flag, 1, &[2, 3]))), [(vec![1], 2)]);
    assert_eq!(waits.missing(2), MissingChannels::all(set(&[3])));
}

/// Scenario M07.
#[test]
fn a_number_is_passed_when_all_have_come_so_far() {
    let mut waits = waits(2);
    let order = |number| wait(Primitive::Order, number, &[1, 2]);
    assert_eq!(continue_by(&mut waits, at(2, 0, order(20))), NOBODY);
    assert_eq!(continue_by(&mut waits, at(1, 2, order(10))), [(vec![1], 2)]);
    assert_eq!(continue_by(&mut waits, at(1, 3, order(30))), [(vec![2], 3)]);
    assert_eq!(continue_by(&mut waits, at(2, 4, order(30))), [(vec![1, 2], 4)]);
    let ArrivalOutcome::Illegal { text } = waits.arrive(at(1, 5, order(20))).arrival else { panic!("it descends") };
    assert_eq!(text, "order number 20 comes after 30, but the numbers must ascend");
}

#[test]
fn an_absent_turret_holds_nobody_back_if_the_rule_says_so() {
    let mut waits = counting_absent(2);
    assert_eq!(continue_by(&mut waits, at(1, 2, wait(Primitive::Order, 10, &[1, 2]))), NOBODY);
    assert_eq!(finish(&mut waits, tag(2, 3)), [(vec![1], 3)]);
    assert_eq!(continue_by(&mut waits, at(1, 4, wait(Primitive::Order, 20, &[1, 2]))), [(vec![1], 4)]);
    assert_eq!(continue_by(&mut waits, at(1, 5, wait(Primitive::Barrier, 20, &[1, 2]))), [(vec![1], 5)]);
    assert_eq!(continue_by(&mut waits, at(1, 6, wait(Primitive::Count, 20, &[1, 2]))), [(vec![1], 6)]);
}

#[test]
fn an_alarm_is_no_absence() {
    let mut waits = counting_absent(2);
    waits.arrive(at(1, 2, wait(Primitive::Order, 10, &[1, 2])));
    waits.finish(2, Finish { how: Terminal::Alarmed, ..ended() });
    assert_eq!(waits.settle(tag(2, 3)), []);
    assert_eq!(waits.dead(), set(&[1]));
}

#[test]
fn a_count_takes_whoever_comes() {
    let mut waits = waits(4);
    let two = Wait { need: 2, ..wait(Primitive::Count, 100, &[1, 2, 3, 4]) };
    assert_eq!(continue_by(&mut waits, at(3, 1, two)), NOBODY);
    assert_eq!(waits.missing(3), MissingChannels::any(set(&[1, 2, 4])));
    for channel in [1, 2] {
        waits.finish(channel, ended());
    }
    assert!(waits.hopeful(3), "one channel is enough");
    assert_eq!(continue_by(&mut waits, at(4, 2, two)), [(vec![3, 4], 2)]);
    waits.finish(4, ended());
    waits.arrive(at(3, 3, two));
    assert_eq!(waits.dead(), set(&[3]));
}

#[test]
fn each_signal_ends_one_wait() {
    let mut waits = waits(3);
    let from_1 = wait(Primitive::Signal, 7, &[1, 2]);
    let send = |to: &[u16]| WaitOp::Signal(Send { key: key(7), to: set(to), broadcast: false, lasts: Lasts::Each });
    assert_eq!(act(&mut waits, tag(1, 1), send(&[2])), NOBODY);
    assert!(waits.pass(&at(2, 2, from_1)));
    assert!(!waits.pass(&at(2, 2, from_1)), "it is used up");
    assert_eq!(continue_by(&mut waits, at(2, 3, from_1)), NOBODY);
    assert_eq!(waits.missing(2), MissingChannels::all(set(&[1])));
    assert_eq!(act(&mut waits, tag(3, 4), send(&[2])), NOBODY, "another sender");
    assert_eq!(act(&mut waits, tag(1, 5), send(&[2, 3])), [(vec![2], 5)]);
    assert!(!waits.pass(&at(2, 6, from_1)), "the wait that it ended has used it up");
    assert!(waits.pass(&at(3, 6, wait(Primitive::Signal, 7, &[1, 3]))), "each receiver has one of its own");
}

#[test]
fn a_signal_to_everybody_needs_a_wait_for_anybody() {
    let mut waits = waits(3);
    let any = Wait { need: 1, named: None, ..wait(Primitive::Signal, 7, &[1, 2, 3]) };
    let all = WaitOp::Signal(Send { key: key(7), to: ChannelSet::up_to(3), broadcast: true, lasts: Lasts::Each });
    assert_eq!(continue_by(&mut waits, at(3, 1, any)), NOBODY);
    assert_eq!(waits.missing(3), MissingChannels::any(set(&[1, 2])));
    let directed = WaitOp::Signal(Send { key: key(7), to: set(&[3]), broadcast: false, lasts: Lasts::Each });
    assert_eq!(act(&mut waits, tag(1, 2), directed), NOBODY, "that one is for a wait that names channel 1");
    waits.finish(1, ended());
    assert!(waits.hopeful(3), "channel 2 can still send");
    assert_eq!(act(&mut waits, tag(2, 3), all), [(vec![3], 3)]);
    waits.arrive(at(3, 4, any));
    waits.finish(2, ended());
    assert_eq!(waits.dead(), set(&[3]));
}

#[test]
fn a_signal_that_all_share_ends_the_longest_wait() {
    let mut waits = waits(3);
    let any = Wait { need: 1, named: None, ..wait(Primitive::Signal, 7, &[1, 2, 3]) };
    let send = |lasts| WaitOp::Signal(Send { key: key(7), to: ChannelSet::up_to(3), broadcast: true, lasts });
    assert_eq!(continue_by(&mut waits, at(3, 1, any)), NOBODY);
    assert_eq!(continue_by(&mut waits, at(2, 2, any)), NOBODY);
    assert_eq!(act(&mut waits, tag(1, 3), send(Lasts::Times(1))), [(vec![3], 3)]);
    assert_eq!(act(&mut waits, tag(1, 4), send(Lasts::Times(2))), [(vec![2], 4)]);
    assert!(waits.pass(&at(3, 5, any)) && !waits.pass(&at(3, 5, any)), "one use was left");
    assert_eq!(act(&mut waits, tag(1, 6), send(Lasts::Always)), NOBODY);
    assert!(waits.pass(&at(3, 7, any)) && waits.pass(&at(3, 7, any)));
    let remove = WaitOp::Remove { range: MarkRange { space: MarkSpace::Statements, first: 7, last: 7 }, to: None };
    assert_eq!(act(&mut waits, tag(1, 8), remove), NOBODY);
    assert!(!waits.pass(&at(3, 9, any)));
}

#[test]
fn kept_signals_are_bounded() {
    let mut waits = waits(2);
    let send = |number| WaitOp::Signal(Send { key: key(number), to: set(&[2]), broadcast: false, lasts: Lasts::Each });
    for number in 0..10_000 {
        assert_eq!(waits.act(tag(1, 0), send(number)), Ok(Vec::new()));
    }
    assert!(waits.act(tag(1, 0), send(10_000)).is_err_and(|text| text.contains("10000 different signals")));
    assert_eq!(waits.act(tag(1, 0), send(9_999)), Ok(Vec::new()), "one more of a mark that is there");
}

/// Scenario M06.
#[test]
fn a_join_waits_for_the_end_of_programs() {
    let mut waits = waits(3);
    let join = wait(Primitive::Join, 0, &[1, 2, 3]);
    assert_eq!(continue_by(&mut waits, at(1, 1, join)), NOBODY);
    assert_eq!(finish(&mut waits, tag(3, 2)), NOBODY);
    assert_eq!(finish(&mut waits, tag(2, 3)), [(vec![1], 3)]);
    assert!(waits.pass(&at(1, 4, join)));
}

#[test]
fn an_alarm_ends_no_join() {
    let mut waits = waits(2);
    waits.arrive(at(1, 1, wait(Primitive::Join, 0, &[1, 2])));
    waits.finish(2, Finish { how: Terminal::Alarmed, ..ended() });
    assert_eq!(waits.settle(tag(2, 2)), []);
    assert_eq!(waits.dead(), set(&[1]));
}

/// Scenario M11.
#[test]
fn a_lease_goes_to_who_asks_first() {
    let mut waits = waits(3);
    let lease = |number| wait(Primitive::Lease, number, &[1, 2, 3]);
    assert!(waits.pass(&at(1, 0, lease(1))) && waits.pass(&at(1, 0, lease(1))), "it has it already");
    assert_eq!(continue_by(&mut waits, at(3, 1, lease(1))), NOBODY);
    assert_eq!(continue_by(&mut waits, at(2, 2, lease(1))), NOBODY);
    assert_eq!((waits.missing(3).channels, waits.missing(2).channels), (set(&[1]), set(&[1, 3])));
    assert_eq!(waits.act(tag(2, 2), WaitOp::Release(key(1))), Err("channel 1 holds it".to_owned()));
    assert_eq!(act(&mut waits, tag(1, 3), WaitOp::Release(key(1))), [(vec![3], 3)]);
    assert_eq!(act(&mut waits, tag(3, 4), WaitOp::Release(key(1))), [(vec![2], 4)]);
    assert_eq!(act(&mut waits, tag(2, 5), WaitOp::Release(key(1))), NOBODY);
    assert_eq!(waits.act(tag(2, 6), WaitOp::Release(key(1))), Err("nobody holds it".to_owned()));
}

#[test]
fn a_lease_can_be_taken_and_passed_on() {
    let mut waits = waits(3);
    let lease = wait(Primitive::Lease, 1, &[1, 2, 3]);
    waits.hold(1, key(1));
    assert_eq!(continue_by(&mut waits, at(3, 1, lease)), NOBODY);
    // Channel 2 takes it before channel 3, which asked earlier.
    assert_eq!(act(&mut waits, tag(2, 2), WaitOp::Take(key(1))), NOBODY);
    assert_eq!(waits.missing(3).channels, set(&[2]));
    assert_eq!(waits.act(tag(1, 3), WaitOp::Give { key: key(1), to: 3 }), Err("channel 2 holds it".to_owned()));
    assert_eq!(act(&mut waits, tag(2, 4), WaitOp::Give { key: key(1), to: 3 }), [(vec![3], 4)]);
    assert_eq!(waits.lease(key(1)).0, Some(3));
}

#[test]
fn only_the_holder_moves_an_axis_and_the_next_one_finds_it_there() {
    let mut waits = waits(2);
    let moved = |by| LastAxisMove { to: 90.0, end_ns: 5, by };
    assert_eq!(waits.moves(1, key(1), moved(1)), Err(None));
    waits.hold(1, key(1));
    assert_eq!(waits.moves(2, key(1), moved(2)), Err(Some(1)));
    assert_eq!(waits.moves(1, key(1), moved(1)), Ok(()));
    assert_eq!(act(&mut waits, tag(1, 6), WaitOp::Release(key(1))), NOBODY);
    assert_eq!(waits.lease(key(1)), (None, Some(moved(1))));
    assert!(waits.pass(&at(2, 7, wait(Primitive::Lease, 1, &[1, 2]))));
    assert_eq!(waits.lease(key(1)), (Some(2), Some(moved(1))));
}

#[test]
fn leases_in_a_circle_are_dead() {
    let mut waits = waits(2);
    let lease = |number| wait(Primitive::Lease, number, &[1, 2]);
    assert!(waits.pass(&at(1, 0, lease(1))) && waits.pass(&at(2, 0, lease(2))));
    waits.arrive(at(1, 1, lease(2)));
    assert_eq!(waits.dead(), ChannelSet::default());
    waits.arrive(at(2, 2, lease(1)));
    assert_eq!(waits.dead(), ChannelSet::up_to(2));
}

#[test]
fn a_lease_of_an_ended_channel_is_free_if_the_rule_says_so() {
    for (mut waits, then) in [(waits(2), &NOBODY[..]), (counting_absent(2), &[(vec![2], 2)])] {
        let lease = wait(Primitive::Lease, 1, &[1, 2]);
        assert!(waits.pass(&at(1, 0, lease)));
        waits.arrive(at(2, 1, lease));
        assert_eq!(finish(&mut waits, tag(1, 2)), then);
        assert_eq!(waits.dead().has(2), then.is_empty());
    }
}

/// A plain arrival ends the wait or leaves hope, and comes to the same as any other.
#[test]
fn plain_arrivals_raise_nothing() {
    fn is_plain(waits: &JobWaits, arriving: WaitingChannel) -> bool {
        let plain = waits.clone().arrive_plainly(arriving);
        if let Some(plain) = &plain {
            assert_eq!(*plain, waits.clone().arrive(arriving));
        }
        plain.is_some()
    }

    let mut waits = waits(3);
    for (primitive, plain) in [
        (Primitive::Barrier, true),
        (Primitive::Flag, true),
        (Primitive::Order, true),
        (Primitive::Count, true),
        (Primitive::Signal, true),
        (Primitive::Join, true),
        (Primitive::Lease, true),
    ] {
        assert_eq!(is_plain(&waits, at(1, 1, wait(primitive, 3, &[1, 2]))), plain, "{primitive:?}");
        // The second one to come.
        let mut waits = waits.clone();
        waits.arrive(at(1, 1, wait(primitive, 3, &[1, 2])));
        assert!(is_plain(&waits, at(2, 2, wait(Primitive::Barrier, 4, &[2, 3]))), "{primitive:?}");
        is_plain(&waits, at(2, 2, wait(primitive, 3, &[1, 2])));
    }
    waits.finish(2, ended());
    for (primitive, plain) in [
        (Primitive::Barrier, false),
        (Primitive::Flag, false),
        (Primitive::Order, false),
        (Primitive::Count, false),
        (Primitive::Signal, false),
        (Primitive::Join, true),
        (Primitive::Lease, true),
    ] {
        assert_eq!(is_plain(&waits, at(1, 2, wait(primitive, 3, &[1, 2]))), plain, "{primitive:?}");
    }
}
