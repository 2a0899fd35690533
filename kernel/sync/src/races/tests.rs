use super::*;
use crate::wait::{Lasts, MarkSpace, RuleId, Wait};

const V: RaceVariable = RaceVariable::Common(100);

fn races() -> RaceDetector {
    RaceDetector::new(Channels::new([1, 2, 3]))
}

fn at(channel: u16, line: u32) -> AccessSite {
    AccessSite { channel, file: channel, line }
}

/// Lines of the earlier accesses that race with this one.
fn lines(races: &mut RaceDetector, access: AccessSite, mode: AccessMode) -> Vec<(u16, u32)> {
    races.access(&V, access, mode).iter().map(|race| (race.earlier.channel, race.earlier.line)).collect()
}

fn wait(primitive: Primitive, number: u32, channels: &[u16]) -> Wait {
    let parts: ChannelSet = channels.iter().copied().collect();
    Wait {
        primitive,
        key: WaitMark { space: MarkSpace::Row(1), number },
        named: None,
        parts,
        need: 0,
        rule: RuleId::Start,
    }
}

#[test]
fn a_write_races_with_every_access_that_nothing_orders() {
    let mut races = races();
    assert_eq!(lines(&mut races, at(1, 1), AccessMode::Read), []);
    assert_eq!(lines(&mut races, at(2, 2), AccessMode::Read), [], "two reads");
    assert_eq!(lines(&mut races, at(3, 3), AccessMode::Write), [(1, 1), (2, 2)]);
    assert_eq!(lines(&mut races, at(1, 4), AccessMode::Read), [(3, 3)]);
    assert_eq!(lines(&mut races, at(1, 4), AccessMode::Read), [], "once a pair of lines");
    assert_eq!(races.access(&RaceVariable::Common(101), at(1, 5), AccessMode::Write), [], "another variable");
}

#[test]
fn a_barrier_orders_what_is_before_it_and_nothing_after_it() {
    let mut races = races();
    lines(&mut races, at(1, 1), AccessMode::Write);
    let barrier = wait(Primitive::Barrier, 101, &[1, 2]);
    races.arrive(1, &barrier);
    races.arrive(2, &barrier);
    races.release(ChannelSet::up_to(2), 2);
    assert_eq!(lines(&mut races, at(2, 2), AccessMode::Read), []);
    assert_eq!(lines(&mut races, at(3, 3), AccessMode::Read), [(1, 1)], "channel 3 did not take part");
    assert_eq!(lines(&mut races, at(1, 4), AccessMode::Write), [(2, 2), (3, 3)]);
}

#[test]
fn a_flag_orders_one_way() {
    let mut races = races();
    lines(&mut races, at(1, 1), AccessMode::Write);
    races.act(1, WaitOp::Set(WaitMark { space: MarkSpace::Row(1), number: 5 }));
    lines(&mut races, at(1, 2), AccessMode::Write);
    let flag = wait(Primitive::Flag, 5, &[1, 2]);
    races.arrive(2, &flag);
    races.release(ChannelSet::default().with(2), 2);
    assert_eq!(lines(&mut races, at(2, 3), AccessMode::Read), [(1, 2)], "the second write comes after the flag");
    let mut races = super::tests::races();
    lines(&mut races, at(2, 1), AccessMode::Write);
    races.act(1, WaitOp::Set(WaitMark { space: MarkSpace::Row(1), number: 5 }));
    races.arrive(2, &flag);
    races.release(ChannelSet::default().with(2), 2);
    assert_eq!(lines(&mut races, at(1, 2), AccessMode::Read), [(2, 1)], "who set the flag did not wait");
}

#[test]
fn an_order_number_orders_up_to_the_first_that_is_large_enough() {
    let mut races = races();
    lines(&mut races, at(1, 1), AccessMode::Write);
    races.arrive(1, &wait(Primitive::Order, 20, &[1, 2]));
    races.release(ChannelSet::default().with(1), 1);
    lines(&mut races, at(1, 2), AccessMode::Write);
    races.arrive(1, &wait(Primitive::Order, 30, &[1, 2]));
    races.arrive(2, &wait(Primitive::Order, 10, &[1, 2]));
    races.release(ChannelSet::default().with(2), 2);
    assert_eq!(lines(&mut races, at(2, 3), AccessMode::Read), [(1, 2)]);
}

#[test]
fn signals_leases_starts_and_ends_order() {
    let acts: [(WaitOp, Wait); 2] = [
        (
            WaitOp::Signal(Send {
                key: WaitMark { space: MarkSpace::Row(1), number: 1 },
                to: ChannelSet::up_to(3),
                broadcast: false,
                lasts: Lasts::Each,
            }),
            wait(Primitive::Signal, 1, &[1, 2]),
        ),
        (WaitOp::Release(WaitMark { space: MarkSpace::Row(1), number: 1 }), wait(Primitive::Lease, 1, &[1, 2, 3])),
    ];
    for (act, wait) in acts {
        for late in [false, true] {
            let mut races = races();
            lines(&mut races, at(1, 1), AccessMode::Write);
            if !late {
                races.arrive(2, &wait);
            }
            races.act(1, act);
            if late {
                races.pass(2, &wait);
            } else {
                races.release(ChannelSet::default().with(2), 1);
            }
            assert_eq!(lines(&mut races, at(2, 2), AccessMode::Write), [], "{act:?}, late: {late}");
        }
    }
    let mut races = races();
    lines(&mut races, at(1, 1), AccessMode::Write);
    races.start(ChannelSet::default().with(2), 1);
    assert_eq!(lines(&mut races, at(2, 2), AccessMode::Write), []);
    races.finish(2);
    races.pass(1, &wait(Primitive::Join, 0, &[1, 2]));
    assert_eq!(lines(&mut races, at(1, 3), AccessMode::Write), []);
}

#[test]
fn a_poll_orders_what_the_writer_did_before() {
    let (mut races, other) = (races(), RaceVariable::Named("DATA".into()));
    assert_eq!(lines(&mut races, at(2, 1), AccessMode::Poll), []);
    races.access(&other, at(1, 1), AccessMode::Write);
    assert_eq!(lines(&mut races, at(1, 2), AccessMode::Write), [], "what is polled is meant to be written");
    assert_eq!(lines(&mut races, at(2, 1), AccessMode::Poll), []);
    assert_eq!(races.access(&other, at(2, 2), AccessMode::Read), []);
    races.access(&other, at(1, 3), AccessMode::Write);
    assert_eq!(races.access(&other, at(3, 2), AccessMode::Read).len(), 1, "channel 3 has not polled");
}

#[test]
fn the_first_look_of_a_poll_is_part_of_it() {
    let mut races = races();
    lines(&mut races, at(2, 1), AccessMode::Read);
    lines(&mut races, at(2, 1), AccessMode::Poll);
    assert_eq!(lines(&mut races, at(1, 1), AccessMode::Write), []);
}
