//! Small jobs whose times are worked out by hand.

use super::*;
use crate::sync_points::ChannelArrival;

const S: i64 = 1_000_000_000;

/// A sync point: mark, primitive, when all continued and by whose doing, arrivals.
fn point(key: &str, kind: Primitive, (release, by): (i64, u16), arrivals: &[(u16, i64)]) -> SyncPoint {
    let arrival = |&(channel, t): &(u16, i64)| ChannelArrival {
        channel,
        t_ns: t * S,
        file: "p.nc".into(),
        line: 1,
        block: key.into(),
    };
    let arrivals = arrivals.iter().map(arrival).collect();
    SyncPoint { key: key.into(), kind, release_ns: Some(release * S), by, acts: false, arrivals }
}

fn barrier(key: &str, release: (i64, u16), arrivals: &[(u16, i64)]) -> SyncPoint {
    point(key, Primitive::Barrier, release, arrivals)
}

/// Channel 1 works 2 s, meets channel 2 (5 s) at M101, works 6 s to M102, where channel 2 came after 1 s; both end 1 s
/// and 4 s later.
fn job() -> (Vec<(u16, i64)>, Vec<SyncPoint>) {
    let waits = vec![barrier("M101", (5, 2), &[(1, 2), (2, 5)]), barrier("M102", (11, 1), &[(1, 11), (2, 6)])];
    (vec![(1, 12 * S), (2, 15 * S)], waits)
}

#[test]
fn the_last_to_come_costs_the_others_their_wait() {
    let (ends, waits) = job();
    let costs = Analysis::of(&ends, &waits).wait_cost;
    assert_eq!(costs, [("M102".into(), 5 * S), ("M101".into(), 3 * S)]);
}

#[test]
fn the_critical_path_changes_the_channel_where_somebody_waited() {
    let (ends, waits) = job();
    assert_eq!(Analysis::of(&ends, &waits).critical, [(2, 0, 5 * S), (1, 5 * S, 11 * S), (2, 11 * S, 15 * S)]);
}

#[test]
fn slack_is_what_a_channel_may_lose_anywhere() {
    // Both channels are on the critical path; a third one meets no channel and ends 4 s before the job.
    let (mut ends, waits) = job();
    ends.push((3, 11 * S));
    assert_eq!(Analysis::of(&ends, &waits).slack, BTreeMap::from([(1, 0), (2, 0), (3, 4 * S)]));
    // Alone with M101, channel 1 may be 3 s late there, but only 3 s later at its end, too.
    let waits = [barrier("M101", (5, 2), &[(1, 2), (2, 5)])];
    assert_eq!(Analysis::of(&[(1, 12 * S), (2, 15 * S)], &waits).slack, BTreeMap::from([(1, 3 * S), (2, 0)]));
}

#[test]
fn a_flag_holds_up_who_waits_for_it_and_not_who_sets_it() {
    // Channel 2 sets the flag at 4 s and ends at 6 s; channel 1 has waited from 1 s and ends at 10 s.
    let waits = [point("1", Primitive::Flag, (4, 2), &[(1, 1)])];
    let found = Analysis::of(&[(1, 10 * S), (2, 6 * S)], &waits);
    assert_eq!(found.critical, [(2, 0, 4 * S), (1, 4 * S, 10 * S)]);
    assert_eq!(found.slack, BTreeMap::from([(1, 0), (2, 0)]));
    // Set before it was waited for: the setter has as much time as the waiting channel.
    let waits = [point("1", Primitive::Flag, (4, 2), &[(1, 4)])];
    let found = Analysis::of(&[(1, 10 * S), (2, 6 * S)], &waits);
    assert_eq!((found.critical, found.slack), (vec![(1, 0, 10 * S)], BTreeMap::from([(1, 0), (2, 0)])));
}

#[test]
fn a_sync_point_right_after_another_one_is_redundant() {
    let again = [
        barrier("M101", (5, 2), &[(1, 2), (2, 5)]),
        barrier("M102", (5, 2), &[(1, 5), (2, 5)]),
        barrier("M103", (8, 1), &[(1, 8), (2, 5)]),
    ];
    assert_eq!(Analysis::of(&[(1, 9 * S), (2, 9 * S)], &again).redundant, ["M102".into()]);
    // Not if one of its channels came from elsewhere.
    let third = [barrier("M101", (5, 2), &[(1, 2), (2, 5)]), barrier("M102", (5, 2), &[(1, 5), (2, 5), (3, 5)])];
    assert_eq!(Analysis::of(&[(1, 9 * S), (2, 9 * S), (3, 9 * S)], &third).redundant, [] as [Arc<str>; 0]);
}

#[test]
fn a_code_that_begins_or_ends_something_is_never_redundant() {
    let acts = |point: SyncPoint| SyncPoint { acts: true, ..point };
    let points = [
        barrier("M102", (5, 2), &[(1, 2), (2, 5)]),
        acts(barrier("G68", (5, 2), &[(1, 5), (2, 5)])),
        acts(barrier("G68 cut", (5, 2), &[(1, 5), (2, 5)])),
        acts(barrier("G69", (7, 2), &[(1, 6), (2, 7)])),
        barrier("M103", (7, 2), &[(1, 7), (2, 7)]),
    ];
    assert_eq!(Analysis::of(&[(1, 9 * S), (2, 9 * S)], &points).redundant, ["M103".into()]);
}

#[test]
fn a_faster_channel_saves_only_what_nobody_else_needs() {
    let (ends, waits) = job();
    let saves = |channel, faster: i64| WhatIf::of(&ends, &waits, channel, faster * S).map(|found| found.saves_ns / S);
    // Channel 2 works 5 + 1 + 4 s. With half of it: at M101 after 2.5 s, M102 at 8.5 s, its end at 10.5 s; channel 1
    // ends at 9.5 s.
    assert_eq!(WhatIf::of(&ends, &waits, 2, 5 * S).unwrap().saves_ns, 9 * S / 2);
    // Channel 1 works 2 + 6 + 1 s. With 2/3 of it M102 is passed 2 s earlier.
    assert_eq!(saves(1, 3), Some(2));
    assert_eq!((saves(1, 10), saves(9, 1), saves(1, 0)), (None, None, Some(0)));
}

#[test]
fn one_channel_is_its_own_critical_path() {
    let found = Analysis::of(&[(1, 7 * S)], &[]);
    assert_eq!((found.critical, found.slack), (vec![(1, 0, 7 * S)], BTreeMap::from([(1, 0)])));
    assert_eq!(Analysis::of(&[], &[]), Analysis::default());
}
