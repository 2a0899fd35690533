//! Every schedule of two and three kernels: under any schedule operations happen in the order of their tags, the
//! outcome is the same, and no kernel sleeps indefinitely.
//!
//! Kernels are short scripts. Publishing a bound, reading the need for it, and each access of the coordinator to the
//! bounds of others are steps of their own, as on real threads; all work under the lock is one step.

use std::collections::{BTreeSet, HashSet};
use std::fmt::Write as _;

use super::arrive::ArrivalReply;
use super::spin::{self, LoopPass};
use super::*;
use crate::testing::{ScriptedWaitOp, info, listening, program, wait, waits};
use crate::wait::{Finish, Terminal};
use counterpoint_event::event::Primitive::{self, Barrier, Count, Flag, Join, Lease, Signal};
use counterpoint_event::event::Verdict;

/// A step of a script.
#[derive(Debug, Clone, Copy, PartialEq)]
enum ScriptStep {
    /// Blocks that take this time.
    Run(i64),
    /// An operation on shared state.
    Act,
    /// A wait of all kernels with this primitive and number.
    At(Primitive, u32),
    /// The same, passed without a stop if all are there by then.
    Pass(Primitive, u32),
    /// A kernel that has arrived in motion stops.
    Halt,
    /// A wait for a signal with this number from any channel to all channels.
    Listen(u32),
    /// Something done for others, with this number.
    Do(ScriptedWaitOp, u32),
    /// The end of a program; the script continues when another kernel starts the next one.
    Rest,
    /// Starts this kernel.
    Begin(u16),
    /// A change of shared data.
    Write,
    /// A loop with ticks of two until there are this many changes.
    Poll(u64),
    /// A wait for the merger.
    Away,
    /// An alarm that stops the job.
    Stop,
    /// The end of the program, which comes after the script.
    End,
}

use ScriptStep::{Act, At, Away, Begin, Do, End, Halt, Listen, Pass, Poll, Rest, Run, Stop, Write};
use ScriptedWaitOp::{Call, Clear, Free, Remove, Send, Set, Share};

/// Next step of a kernel.
#[derive(Debug, Clone, Copy, PartialEq)]
enum ScriptPhase {
    /// Its script.
    Script,
    /// It has published its bound and looks at the need.
    LookAtNeed,
    /// It waits for an answer to this.
    Answer(ScriptStep),
    /// It is away.
    Return,
    Ended,
}

#[derive(Debug, Clone)]
struct Player {
    script: Vec<ScriptStep>,
    next: ScriptPhase,
    /// Time and microstep.
    clock: (i64, u32),
    bound: i64,
    need: i64,
    /// Changes at the start of its pass, if it polls.
    begun: Option<u64>,
    /// Fate of the kernel.
    fate: &'static str,
}

/// Next step of the holder of the lock.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Locked {
    /// Reads the bound of the kernel with this index.
    Hear(usize),
    /// Asks the kernel with this index, which acts before the tag.
    Ask(usize, Tag),
}

#[derive(Debug, Clone)]
struct World {
    order: Order,
    players: Vec<Player>,
    /// Bounds as they were read so far.
    heard: Vec<i64>,
    locked: Option<Locked>,
    /// Operations as they were executed.
    log: Vec<(Tag, ScriptStep)>,
    /// The verdicts, and when they were given.
    verdicts: Vec<String>,
}

impl World {
    fn new(scripts: &[&[ScriptStep]]) -> Self {
        let count = scripts.len() as u16;
        let channels = Channels::new(1..=count);
        let player = |script: &&[ScriptStep]| Player {
            script: script.iter().rev().copied().collect(),
            next: ScriptPhase::Script,
            clock: (0, 0),
            bound: 0,
            need: i64::MAX,
            begun: None,
            fate: "",
        };
        let mut order = Order::new(channels, SharedState::default(), waits(count));
        (1..=count).for_each(|channel| order.preselect(channel, program()));
        Self {
            order,
            players: scripts.iter().map(player).collect(),
            heard: vec![0; scripts.len()],
            locked: None,
            log: Vec::new(),
            verdicts: Vec::new(),
        }
    }

    fn tag(&self, index: usize) -> Tag {
        let (t, micro) = self.players[index].clock;
        Tag { t, micro, channel: index as u16 + 1 }
    }

    fn waiting(&self, index: usize, op: ScriptStep) -> Option<WaitingChannel> {
        let channels = self.players.len() as u16;
        let wait = match op {
            At(primitive, number) | Pass(primitive, number) => wait(primitive, number, channels),
            Listen(number) => listening(number, channels),
            _ => return None,
        };
        Some(WaitingChannel { wait, tag: self.tag(index), file: 0, line: 0 })
    }

    /// Steps that can be taken now.
    fn choices(&self) -> Vec<usize> {
        // The holder of the lock can always continue; the others only with steps that need no lock.
        let mut choices: Vec<usize> = self.locked.map(|_| self.players.len()).into_iter().collect();
        choices.extend((0..self.players.len()).filter(|&index| {
            let player = &self.players[index];
            let woken = self.order.seats[index].wake.is_some();
            match player.next {
                ScriptPhase::Ended => false,
                ScriptPhase::Answer(_) => self.locked.is_none() && woken,
                ScriptPhase::Script => self.locked.is_none() || matches!(player.script.last(), Some(Run(_))),

                ScriptPhase::LookAtNeed => self.locked.is_none() || player.bound <= player.need,
                ScriptPhase::Return => self.locked.is_none(),
            }
        }));
        choices
    }

    fn step(&mut self, choice: usize) {
        match self.locked {
            Some(locked) if choice == self.players.len() => self.locked_step(locked),
            _ => self.player_step(choice),
        }
    }

    fn settle(&mut self) {
        self.apply();
        self.locked = Some(Locked::Hear(0));
    }

    fn locked_step(&mut self, locked: Locked) {
        self.locked = None;
        match locked {
            Locked::Hear(index) if index < self.players.len() => {
                self.heard[index] = self.players[index].bound;
                self.locked = Some(Locked::Hear(index + 1));
            }
            Locked::Hear(_) => {
                self.order.hear(self.heard.clone().into_iter());
                let waiting = self.order.settle();
                self.apply();
                self.locked = waiting.map(|tag| Locked::Ask(0, tag));
            }
            Locked::Ask(index, tag) if index < self.players.len() => {
                if self.order.earlier(tag).any(|earlier| earlier == index) {
                    let need = &mut self.players[index].need;
                    *need = (*need).min(tag.t);
                }
                self.locked = Some(Locked::Ask(index + 1, tag));
            }
            Locked::Ask(..) => {}
        }
    }

    fn apply(&mut self) {
        for effect in self.order.effects() {
            if let OrderEffect::Bound(channel, t) = effect {
                let player = &mut self.players[usize::from(channel) - 1];
                if player.bound == BLOCKED {
                    player.need = i64::MAX;
                }
                player.bound = t;
            }
        }
    }

    fn player_step(&mut self, index: usize) {
        let (tag, channel) = (self.tag(index), index as u16 + 1);
        let player = &mut self.players[index];
        match player.next {
            ScriptPhase::Script => match player.script.pop().unwrap_or(End) {
                Run(time) => {
                    player.clock = (player.clock.0 + time, 0);
                    player.bound = player.clock.0;
                    player.next = ScriptPhase::LookAtNeed;
                }
                Away => {
                    player.next = ScriptPhase::Return;
                    self.order.away(tag);
                    self.settle();
                }
                op => {
                    player.next = ScriptPhase::Answer(op);
                    let arriving = self.waiting(index, op).filter(|_| !matches!(op, Pass(..)));
                    let tag = if op == Halt { Tag { micro: u32::MAX, ..tag } } else { tag };
                    self.order.request(tag, arriving);
                    self.settle();
                }
            },
            ScriptPhase::LookAtNeed => {
                player.next = ScriptPhase::Script;
                if player.bound > player.need {
                    player.need = i64::MAX;
                    self.settle();
                }
            }
            ScriptPhase::Return => {
                player.next = ScriptPhase::Script;
                self.order.back(channel);
                self.settle();
            }
            ScriptPhase::Answer(op) => {
                player.next = ScriptPhase::Script;
                match self.order.take_wake(channel).unwrap() {
                    Wake::Turn => self.act(index, op),
                    Wake::Released { tag, .. } | Wake::Started { tag, .. } => {
                        self.players[index].clock = (tag.t, tag.micro);
                    }
                    Wake::Roused { tag, .. } => {
                        self.players[index].clock = (tag.t, tag.micro);
                        self.players[index].script.push(op);
                    }
                    Wake::Over => self.end(index, "over", None),
                    Wake::Alarm { .. } => self.end(index, "alarm", None),
                    Wake::Stopped => self.end(index, "stopped", None),
                }
            }
            ScriptPhase::Ended => {}
        }
    }

    fn act(&mut self, index: usize, op: ScriptStep) {
        let (tag, channel) = (self.tag(index), index as u16 + 1);
        if !matches!(op, Poll(_) | Halt) {
            self.log.push((tag, op));
        }
        match op {
            Write => {
                self.order.change();
                self.players[index].clock.1 += 1;
            }
            Poll(count) if self.order.changes >= count => {
                self.log.push((tag, op));
                (self.players[index].begun, self.players[index].clock.1) = (None, tag.micro + 1);
            }
            Poll(_) => {
                let lap = LoopPass { file: 0, lines: (1, 2), count: 1, reads: 1 };
                let begun = self.players[index].begun;
                match self.order.lap(tag, lap, begun, &"#100".into(), Some(2)) {
                    spin::PassOutcome::Pass(changes) => {
                        let player = &mut self.players[index];
                        player.begun = Some(changes);
                        player.script.extend([op, Run(2)]);
                    }
                    spin::PassOutcome::Rest => self.players[index].next = ScriptPhase::Answer(op),
                    spin::PassOutcome::Hopeless => {
                        self.verdicts.push(format!("{tag:?} hopeless"));
                        self.order.stop(tag);
                        return self.end(index, "hopeless", None);
                    }
                }
            }
            Act => self.players[index].clock.1 += 1,
            Stop => {
                self.order.stop(tag);
                return self.end(index, "stopped", None);
            }
            Do(deed, number) => {
                if self.order.act(tag, deed.act(number, self.players.len() as u16)).is_err() {
                    return self.end(index, "alarm", Some(Terminal::Alarmed));
                }
                self.players[index].clock.1 += 1;
            }
            Begin(other) => {
                if self.order.start(tag, crate::wait::ChannelSet::default().with(other)).is_err() {
                    return self.end(index, "alarm", Some(Terminal::Alarmed));
                }
                self.players[index].clock.1 += 1;
            }
            Rest => {
                self.order.finish(tag, Finish { how: Terminal::Ended, file: 0, line: 0 });
                self.order.rest_idle(channel);
                let verdict = self.order.judge(tag.t, &info());
                self.players[index].next = ScriptPhase::Answer(op);
                self.judged(verdict);
            }
            Pass(..) => {
                let own = Finish { how: Terminal::Alarmed, file: 0, line: 0 };
                let Some(waiting) = self.waiting(index, op) else { return };
                match self.order.arrive_in_motion(waiting, own, &info()).0 {
                    ArrivalReply::Go { t, .. } => self.moves_on(index, t),
                    ArrivalReply::Stand(_) => self.players[index].script.push(Halt),
                    ArrivalReply::Alarm { .. } | ArrivalReply::Illegal { .. } => {
                        return self.end(index, "alarm", Some(Terminal::Alarmed));
                    }
                }
            }
            Halt => match self.order.stops(tag, &info()) {
                Ok(Wake::Released { tag, .. }) => self.moves_on(index, tag.t),
                Ok(_) => return self.end(index, "alarm", None),
                Err(verdict) => {
                    self.players[index].next = ScriptPhase::Answer(op);
                    self.judged(verdict);
                }
            },
            At(..) | Listen(_) => {
                let own = Finish { how: Terminal::Alarmed, file: 0, line: 0 };
                let Some(waiting) = self.waiting(index, op) else { return };
                match self.order.arrive(waiting, own, &info()).0 {
                    ArrivalReply::Go { t, micro, .. } => self.players[index].clock = (t, micro),
                    ArrivalReply::Stand(verdict) => {
                        self.players[index].next = ScriptPhase::Answer(op);
                        self.judged(verdict);
                    }
                    ArrivalReply::Alarm { verdict, .. } => {
                        self.judged(Some(verdict));
                        return self.end(index, "alarm", None);
                    }
                    ArrivalReply::Illegal { .. } => return self.end(index, "alarm", Some(Terminal::Alarmed)),
                }
            }
            End => {
                self.order.finish(tag, Finish { how: Terminal::Ended, file: 0, line: 0 });
                let verdict = self.order.judge(tag.t, &info());
                self.judged(verdict);
                return self.end(index, "ended", None);
            }
            Run(_) | Away => {}
        }
        self.order.leave(channel);
        self.settle();
    }

    /// The kernel has passed its wait and is in motion for a while.
    fn moves_on(&mut self, index: usize, t: i64) {
        let player = &mut self.players[index];
        (player.clock, player.bound) = ((t + 1, 0), t + 1);
    }

    fn end(&mut self, index: usize, fate: &'static str, how: Option<Terminal>) {
        let channel = index as u16 + 1;
        (self.players[index].next, self.players[index].fate) = (ScriptPhase::Ended, fate);
        if let Some(how) = how {
            self.order.waits.finish(channel, Finish { how, file: 0, line: 0 });
        }
        self.order.done(channel);
        self.settle();
    }

    fn judged(&mut self, verdict: Option<Verdict>) {
        if let Some(verdict) = verdict {
            let text = format!("{:?} at {} {:?}", verdict.kind, verdict.at_ns, verdict.members);
            assert!(!self.verdicts.contains(&text), "a verdict is given once");
            self.verdicts.push(text);
        }
    }

    /// The result that must not depend on the schedule. After a stop the progress of other kernels is arbitrary: only
    /// the content of the log counts.
    fn outcome(&self) -> String {
        let mut out = String::new();
        for (tag, op) in &self.log {
            let _ = writeln!(out, "{tag:?} {op:?}");
        }
        for player in &self.players {
            let _ = writeln!(out, "{:?} {}", player.clock, player.fate);
        }
        let _ = writeln!(out, "{:?}", self.verdicts);
        out
    }
}

/// Tries out all schedules; returns the outcomes and how many states there are.
fn explore(scripts: &[&[ScriptStep]]) -> (BTreeSet<String>, usize) {
    let (mut seen, mut outcomes) = (HashSet::new(), BTreeSet::new());
    let mut open = vec![World::new(scripts)];
    while let Some(world) = open.pop() {
        if !seen.insert(format!("{world:?}")) {
            continue;
        }
        let choices = world.choices();
        if choices.is_empty() {
            let sleeps = world.players.iter().any(|player| player.next != ScriptPhase::Ended);
            assert!(!sleeps, "somebody sleeps for ever: {scripts:?}\n{world:#?}");
            let sorted = world.log.is_sorted_by(|(one, _), (two, _)| one < two);
            assert!(sorted, "not in order: {scripts:?}\n{:?}", world.log);
            outcomes.insert(world.outcome());
        }
        for choice in choices {
            let mut next = world.clone();
            next.step(choice);
            open.push(next);
        }
    }
    (outcomes, seen.len())
}

fn one_outcome(scripts: &[&[ScriptStep]]) {
    let (outcomes, states) = explore(scripts);
    assert!(states > 1);
    let stops = |op: &ScriptStep| matches!(op, Stop | Poll(_));
    if !scripts.iter().any(|script| script.iter().any(stops)) {
        assert_eq!(outcomes.len(), 1, "{scripts:?}\n{outcomes:#?}");
        return;
    }
    // Up to the stop the operations are the same; afterwards nothing is executed.
    let logs: BTreeSet<Vec<&str>> =
        outcomes.iter().map(|o| o.lines().filter(|l| l.starts_with("Tag")).collect()).collect();
    assert_eq!(logs.len(), 1, "{scripts:?}\n{outcomes:#?}");
}

/// All pairs of scripts of two of these steps.
fn pairs<const N: usize>(steps: [ScriptStep; N]) {
    let scripts: Vec<[ScriptStep; 2]> = steps.iter().flat_map(|&one| steps.map(|two| [one, two])).collect();
    for one in &scripts {
        for two in &scripts {
            one_outcome(&[one, two]);
        }
    }
}

#[test]
fn all_schedules_of_short_scripts_of_two_kernels() {
    pairs([Run(1), Act, At(Barrier, 1), At(Barrier, 2), Away, Stop]);
}

#[test]
fn all_schedules_with_flags() {
    pairs([Run(1), At(Flag, 1), At(Flag, 2), Do(Set, 1), Do(Clear, 1)]);
}

#[test]
fn all_schedules_with_waits_that_are_passed_in_motion() {
    pairs([Run(1), At(Flag, 1), Pass(Flag, 1), Do(Set, 1), Stop]);
    pairs([Run(1), Pass(Barrier, 1), At(Barrier, 1), Act]);
    for [one, two, three] in [
        [&[Run(1), Pass(Flag, 1), Act][..], &[Run(1), Pass(Flag, 1), Act][..], &[Run(1), Pass(Flag, 1), Act][..]],
        [&[Run(2), Pass(Flag, 1)], &[At(Flag, 1), Act], &[Run(2), Act, At(Flag, 1)]],
        [&[Run(1), Pass(Flag, 1), Act], &[Run(2), Pass(Flag, 1)], &[Run(1)]],
        [&[Run(1), Pass(Barrier, 1), Act], &[Run(1), Act, Stop], &[Run(2), At(Barrier, 1)]],
    ] {
        one_outcome(&[one, two, three]);
    }
}

#[test]
fn all_schedules_with_order_numbers() {
    pairs([Run(1), At(Primitive::Order, 1), At(Primitive::Order, 2), Away]);
}

#[test]
fn all_schedules_with_counts() {
    pairs([Run(1), At(Count, 1), At(Count, 2), Act]);
}

#[test]
fn all_schedules_with_signals() {
    pairs([Run(1), At(Signal, 1), Do(Send, 1), Act]);
    pairs([Run(1), Listen(1), Do(Call, 1), Do(Share, 1), Do(Remove, 1)]);
}

#[test]
fn all_schedules_with_joins() {
    pairs([Run(1), At(Join, 0), Act, Away]);
}

#[test]
fn all_schedules_with_leases() {
    pairs([Run(1), At(Lease, 1), At(Lease, 2), Do(Free, 1)]);
}

#[test]
fn all_schedules_with_starts() {
    pairs([Run(1), Act, Rest, Begin(1), Begin(2)]);
    pairs([Run(1), Rest, Begin(2), At(Join, 0), At(Flag, 1)]);
}

#[test]
fn all_schedules_of_starts_of_three_kernels() {
    for [one, two, three] in [
        [&[Run(1), Begin(2), At(Barrier, 1)][..], &[Rest, Act, At(Barrier, 1)][..], &[Run(2), At(Barrier, 1)][..]],
        [&[Run(1), Begin(2), Begin(3)], &[Rest, Run(1), Begin(3)], &[Rest, Act, Rest, Act]],
        [&[At(Flag, 1)], &[Rest, Do(Set, 1)], &[Run(1), Begin(2), Do(Set, 1)]],
        [&[Rest, At(Join, 0)], &[Rest, Begin(1), Rest], &[Begin(2), Run(1), Begin(2)]],
    ] {
        one_outcome(&[one, two, three]);
    }
}

#[test]
fn all_schedules_of_primitives_beside_each_other() {
    pairs([At(Barrier, 1), At(Flag, 1), At(Signal, 1), Do(Send, 1), At(Lease, 1)]);
}

#[test]
fn all_schedules_of_primitives_of_three_kernels() {
    for [one, two, three] in [
        [&[At(Flag, 1), Act][..], &[Run(1), At(Flag, 1)][..], &[Run(1), Do(Set, 1), Run(1), Do(Set, 1)][..]],
        [&[At(Flag, 1), At(Flag, 1)], &[Do(Set, 1), Run(1), Do(Clear, 1)], &[Run(1), At(Flag, 1)]],
        [&[At(Primitive::Order, 1), Act], &[Run(1), At(Primitive::Order, 2)], &[Run(1), At(Primitive::Order, 1)]],
        [&[At(Count, 1), Act], &[Run(1), At(Count, 1)], &[Run(1), At(Count, 1)]],
        [&[At(Signal, 1), Act], &[Run(1), Do(Send, 1)], &[Do(Send, 1), Run(1)]],
        [&[At(Join, 0), Act], &[Run(1)], &[Act, Run(2)]],
        [&[At(Lease, 1), Run(1), Do(Free, 1)], &[At(Lease, 1), Act], &[Run(1), At(Lease, 1)]],
        [&[At(Lease, 1), Run(1), At(Lease, 2)], &[At(Lease, 2), Run(1), At(Lease, 1)], &[At(Join, 0)]],
    ] {
        one_outcome(&[one, two, three]);
    }
}

#[test]
fn all_schedules_with_polls() {
    pairs([Run(1), Write, Poll(1), Poll(2)]);
    pairs([Run(3), Write, Poll(1), Stop]);
    for [one, two, three] in [
        [&[Poll(1), Act][..], &[Run(3), Write][..], &[Poll(1), Run(1), Act][..]],
        [&[Poll(2), Act], &[Run(3), Write, Run(2), Act], &[Run(4), Write]],
        [&[Poll(1)], &[Run(3), At(Barrier, 1)], &[Run(1)]],
        [&[Poll(2)], &[Run(3), Poll(1)], &[Run(6), Write]],
        [&[Poll(1), At(Barrier, 1)], &[At(Barrier, 1), Act], &[Run(5), Write, At(Barrier, 1)]],
    ] {
        one_outcome(&[one, two, three]);
    }
}

#[test]
fn all_schedules_of_longer_scripts_of_two_kernels() {
    for [one, two] in [
        [&[Run(1), Act, Run(2), At(Barrier, 1), Act][..], &[Run(2), Act, Run(1), Act, At(Barrier, 1)][..]],
        [&[Run(3), At(Barrier, 1), Run(1), At(Barrier, 2)], &[At(Barrier, 1), Run(1), Away, At(Barrier, 2), Act]],
        [&[Act, Run(1), Away, Act, Run(1), Act], &[Run(1), Act, Act, Run(1), Stop]],
        [&[At(Barrier, 1), At(Barrier, 1), Act], &[Run(1), At(Barrier, 1), Run(1), At(Barrier, 1)]],
        [&[Run(1), At(Barrier, 1), Act], &[Run(1), Act, Run(1)]],
    ] {
        one_outcome(&[one, two]);
    }
}

#[test]
fn all_schedules_of_three_kernels() {
    for [one, two, three] in [
        [&[Run(1), Act][..], &[Run(1), Act][..], &[Act, Run(2)][..]],
        [&[At(Barrier, 1), Act], &[Run(1), At(Barrier, 1)], &[Run(2), At(Barrier, 1)]],
        [&[At(Barrier, 1)], &[Run(1), At(Barrier, 1)], &[Run(1)]],
        [&[At(Barrier, 1)], &[Run(1), At(Barrier, 2)], &[Act, Run(1), At(Barrier, 1)]],
        [&[Run(1), Stop], &[At(Barrier, 1)], &[Run(2), Act]],
        [&[Away, Act], &[Run(1), Act], &[At(Barrier, 1)]],
    ] {
        one_outcome(&[one, two, three]);
    }
}
