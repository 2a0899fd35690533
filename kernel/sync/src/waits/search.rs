//! Compares the fix-point with a search of all possible futures: a channel is dead exactly if no sequence of
//! operations, of the running channels and of those that they release, ends its wait.

use std::collections::HashSet;

use super::*;
use crate::wait::{Lasts, MarkRange, MarkSpace, RuleId, Send, WaitMark, WaitRule, WaitRules};

/// Numbers that are the same in every run of the test.
struct Numbers(u64);

impl Numbers {
    fn below(&mut self, limit: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as usize) % limit
    }
}

/// Possible next action of a channel.
#[derive(Debug, Clone, Copy)]
enum FutureStep {
    Arrive(Wait),
    Act(WaitOp),
}

const CHANNELS: u16 = 3;

fn set(channels: &[u16]) -> ChannelSet {
    channels.iter().copied().collect()
}

fn wait(primitive: Primitive, number: u32, parts: &[u16], need: u32) -> Wait {
    let need = need as u16;
    Wait {
        primitive,
        key: WaitMark { space: MarkSpace::Statements, number },
        named: Some(set(parts)),
        parts: set(parts),
        need,
        rule: RuleId::Start,
    }
}

/// Everything that channels do in a test of one primitive.
fn steps(primitive: Primitive) -> Vec<FutureStep> {
    let lists: [&[u16]; 4] = [&[1, 2], &[2, 3], &[1, 3], &[1, 2, 3]];
    let mut steps: Vec<FutureStep> = Vec::new();
    for number in [1, 2] {
        let key = WaitMark { space: MarkSpace::Statements, number };
        match primitive {
            Primitive::Signal => {
                let send = |broadcast, lasts| {
                    FutureStep::Act(WaitOp::Signal(Send { key, to: ChannelSet::up_to(CHANNELS), broadcast, lasts }))
                };
                steps.push(send(false, Lasts::Each));
                steps.push(send(true, Lasts::Each));
                steps.push(send(true, Lasts::Times(1)));
                let range = MarkRange { space: MarkSpace::Statements, first: number, last: number };
                steps.push(FutureStep::Act(WaitOp::Remove { range, to: None }));
                steps.push(FutureStep::Arrive(Wait { named: None, ..wait(primitive, number, &[1, 2, 3], 1) }));
            }
            Primitive::Flag => steps.push(FutureStep::Act(WaitOp::Set(key))),
            Primitive::Lease => steps.push(FutureStep::Act(WaitOp::Release(key))),
            // The words of a count need equally many.
            Primitive::Count => steps.push(FutureStep::Arrive(wait(primitive, number, &[1, 2, 3], number + 1))),
            Primitive::Barrier | Primitive::Order | Primitive::Join => {}
        }
        if primitive == Primitive::Lease {
            steps.push(FutureStep::Arrive(wait(primitive, number, &[1, 2, 3], 0)));
        } else if primitive != Primitive::Count {
            steps.extend(lists.iter().map(|list| FutureStep::Arrive(wait(primitive, number, list, 0))));
        }
    }
    steps
}

/// Executes a step of a running channel; false if it is not possible.
fn carry_out(waits: &mut JobWaits, channel: u16, t: i64, step: FutureStep) -> bool {
    let tag = Tag { t, micro: 0, channel };
    match step {
        FutureStep::Arrive(wait) => {
            let own = wait.parts.with(channel);
            let wait = Wait { parts: own, named: wait.named.map(|_| own), ..wait };
            let arriving = WaitingChannel { wait, tag, file: 0, line: 1 };
            let passes = matches!(wait.primitive, Primitive::Signal | Primitive::Lease | Primitive::Join);
            if passes && waits.pass(&arriving) {
                return true;
            }
            !matches!(waits.arrive(arriving).arrival, ArrivalOutcome::Illegal { .. } | ArrivalOutcome::Mismatch { .. })
        }
        FutureStep::Act(act) => waits.act(tag, act).is_ok(),
    }
}

/// Channels that some sequence of steps gets past the waits where they are now.
fn released_by_search(from: &JobWaits, steps: &[FutureStep]) -> ChannelSet {
    const DEEPEST: usize = 5;
    let standing: ChannelSet = from.places.waiting().map(|waiting| waiting.tag.channel).collect();
    let mut released = ChannelSet::default();
    let mut seen = HashSet::new();
    let mut level = vec![(from.clone(), standing)];
    for depth in 0..DEEPEST {
        let mut next = Vec::new();
        for (waits, left) in &level {
            for channel in (1..=CHANNELS).filter(|&channel| waits.places.runs(channel)) {
                for &step in steps {
                    let mut after = waits.clone();
                    if !carry_out(&mut after, channel, 1000 + depth as i64, step) {
                        continue;
                    }
                    let still: ChannelSet = left.iter().filter(|&one| after.places.at(one).is_some()).collect();
                    released = ChannelSet(released.0 | (standing.0 & !still.0));
                    if released == standing {
                        return released;
                    }
                    let places: Vec<_> = after.places.waiting().map(|own| (own.tag.channel, own.wait)).collect();
                    if seen.insert(format!("{places:?} {:?} {still:?}", after.memory)) {
                        next.push((after, still));
                    }
                }
            }
        }
        level = next;
    }
    released
}

#[test]
fn exactly_those_are_dead_whom_no_continuation_releases() {
    let mut numbers = Numbers(1);
    let (mut dead, mut alive) = (0, 0);
    use Primitive::{Barrier, Count, Flag, Lease, Order, Signal};
    for primitive in [Barrier, Flag, Order, Count, Signal, Lease] {
        let steps = steps(primitive);
        for _ in 0..40 {
            let mut waits = JobWaits::new(
                crate::channels::Channels::new(1..=CHANNELS),
                WaitRules::new([(RuleId::Start, WaitRule::plain("M"))]),
                0,
            );
            for t in 0..8 {
                let running: Vec<u16> = (1..=CHANNELS).filter(|&channel| waits.places.runs(channel)).collect();
                let Some(&channel) = running.get(numbers.below(running.len().max(1))) else { break };
                if numbers.below(5) == 0 {
                    waits.finish(channel, Finish { how: Terminal::Ended, file: 0, line: 1 });
                    waits.settle(Tag { t, micro: 0, channel });
                } else {
                    let step = steps[numbers.below(steps.len())];
                    let before = waits.clone();
                    if !carry_out(&mut waits, channel, t, step) {
                        waits = before;
                    }
                }
                let standing: ChannelSet = waits.places.waiting().map(|waiting| waiting.tag.channel).collect();
                let found = released_by_search(&waits, &steps);
                let expected = ChannelSet(standing.0 & !found.0);
                assert_eq!(waits.dead(), expected, "{primitive:?} {:#?}", waits.places);
                dead += expected.count();
                alive += found.count();
            }
        }
    }
    assert!(dead > 50 && alive > 50, "{dead} dead, {alive} alive");
}
