//! Spindles that turn together: the codes that begin and end it, and commands of the leading spindle.
//!
//! Facts: reference shop-machines.md 2, 3, 7, 12 (builders' codes, COUPON). Decisions: a code lasts until the follower
//! has reached the leader's speed, and then for the machine's phase time. After that both spindles change speed
//! together, in the time of the slower spindle. *Invariant:* a command for a follower changes nothing and is reported.

use counterpoint_event::event::{Kind, SpindleChange as SpindleEvent};
use counterpoint_fault::{self as diag, Acted, Halt};
use counterpoint_lang::format::wildcard_text;
use counterpoint_machine::ident::{CodeId, DataId, codes, data};
use counterpoint_machine::index::SpindleId;
use counterpoint_machine::rows::{CodeRow, TimeOverlap};
use counterpoint_program::block::PendingCode;
use counterpoint_sync::races::AccessMode;
use counterpoint_sync::shared::{SpindleCommand, SpindleCoupling};
use counterpoint_sync::spindle_coupling::CouplingRefusal;

use super::Kernel;
use super::actions::Action;
use super::report::report_spindle_conflict;
use counterpoint_channel::at::nanoseconds;
use counterpoint_channel::shared_target::SharedTarget;

/// The effect of a code on two spindles.
#[derive(Debug, Clone, Copy)]
enum CouplingStep {
    /// One follows the other.
    Speed,
    /// One follows the other in phase.
    Phase,
    /// The phase ends; the speeds stay the same.
    PhaseOff,
    /// The coupling ends.
    Off,
}

/// A spindle and the spindle that it follows.
#[derive(Debug, Clone, Copy)]
struct SpindlePair {
    leader: SpindleId,
    follower: SpindleId,
    ratio: f64,
}

/// The action of a code.
pub fn find(id: CodeId) -> Option<&'static dyn Action> {
    Some(match id {
        codes::COUPLE_SPINDLES => &CouplingStep::Speed,
        codes::COUPLE_SPINDLES_PHASE => &CouplingStep::Phase,
        codes::COUPLE_SPINDLES_PHASE_OFF => &CouplingStep::PhaseOff,
        codes::COUPLE_SPINDLES_OFF => &CouplingStep::Off,
        _ => return None,
    })
}

impl Action for CouplingStep {
    fn run(&self, kernel: &mut Kernel<'_>, _: &CodeRow, _: &PendingCode) -> Acted {
        kernel.flow.pass.effects = true;
        kernel.flush_lookahead()?;
        if kernel.channel.env.machine.channels.len() > 1 {
            kernel.channel.come_to_rest();
        }
        let pair = pair(kernel)?;
        match self {
            Self::Speed => couple(kernel, pair, None),
            Self::Phase => {
                let angle = kernel.take(data::COUPLE_SPINDLE_ANGLE).map_or(0.0, |angle| angle.value);
                couple(kernel, pair, Some(angle))
            }
            Self::PhaseOff => end_phase(kernel, pair),
            Self::Off => uncouple(kernel, pair),
        }
    }
}

/// The spindles that the block or the machine names.
fn pair(kernel: &mut Kernel<'_>) -> Result<SpindlePair, Halt> {
    let machine = kernel.channel.env.machine;
    let [leader, follower] = [data::COUPLE_SPINDLE_LEADER, data::COUPLE_SPINDLE_FOLLOWER].map(|id| number(kernel, id));
    let ratio = number(kernel, data::COUPLE_SPINDLE_RATIO).unwrap_or(1.0);
    let named = |number: f64| machine.spindles.find(|spindle| f64::from(spindle.number) == number);
    let follower = match follower {
        Some(number) => named(number).ok_or_else(|| no_spindle(kernel, number))?,
        None => machine.spindles.find(|spindle| spindle.follows.is_some()).ok_or_else(|| {
            illegal(kernel, "no spindle of the machine follows another one; give its row in [[spindles]] `follows`")
        })?,
    };
    let leader = leader.or_else(|| machine.spindles[follower].follows.map(f64::from));
    let Some(leader) = leader else {
        let number = machine.spindles[follower].number;
        return Err(illegal(kernel, &format!("the spindle that spindle {number} follows is not named")));
    };
    let leader = named(leader).ok_or_else(|| no_spindle(kernel, leader))?;
    if leader == follower {
        return Err(illegal(kernel, "a spindle cannot follow itself"));
    }
    if ratio == 0.0 || !ratio.is_finite() {
        return Err(illegal(kernel, "the ratio of the speeds is zero"));
    }
    Ok(SpindlePair { leader, follower, ratio })
}

fn number(kernel: &mut Kernel<'_>, id: DataId) -> Option<f64> {
    kernel.take(id).map(|datum| datum.value)
}

fn no_spindle(kernel: &mut Kernel<'_>, number: f64) -> Halt {
    illegal(kernel, &format!("the machine has no spindle {}", wildcard_text(number)))
}

fn illegal(kernel: &mut Kernel<'_>, reason: &str) -> Halt {
    let text = format!("{reason}, in '{}'", kernel.channel.block_text());
    kernel.alarm(&diag::SPINDLE_COUPLING, text)
}

/// Makes the follower follow the leader. Without a new phase, the follower keeps its current phase.
fn couple(kernel: &mut Kernel<'_>, pair: SpindlePair, phase: Option<f64>) -> Acted {
    let machine = kernel.channel.env.machine;
    let SpindlePair { leader, follower, ratio } = pair;
    let before = speeds(kernel, pair)?;
    let coupling = SpindleCoupling { leader: leader.index(), ratio, phase, mirrored: false };
    let (at, most) = ((kernel.channel.now(), kernel.channel.at.channel), largest_speeds(kernel));
    let done = kernel.access(SharedTarget::Spindle, AccessMode::Write, |shared| {
        let was = shared.couple(follower.index(), coupling, &most)?;
        let command = shared.spindle(follower.index()).map(|spindle| spindle.command);
        let Some(spindle) = shared.spindles.get_mut(follower.index()) else { return Ok(None) };
        if spindle.coupling == was {
            return Ok(None);
        }
        let moved = was.is_none() && command != Some(spindle.command);
        spindle.changes.note(at.0, at.1);
        Ok(Some((was, spindle.coupling, moved, spindle.written(at.1))))
    })?;
    let (was, now, changed, conflict) = match done {
        Ok(None) => return repeated(kernel, pair, phase),
        Ok(Some(done)) => done,
        Err(refusal) => return Err(refuse(kernel, pair, refusal)),
    };
    if conflict != 0 {
        report_spindle_conflict(kernel, conflict);
    }
    let after = speeds(kernel, pair)?;
    let (leads, follows) = (after.0 - before.0, after.1 - before.1);
    let ramps = machine.spindles[leader].ramp(leads).max(machine.spindles[follower].ramp(follows));
    let in_phase = now.and_then(|coupling| coupling.phase);
    let finds = in_phase.is_some() && was.and_then(|was| was.phase) != in_phase;
    let finding = if finds { machine.spindles[follower].phase } else { 0.0 };
    let rest = if was.is_some() { rest_of_run_up(kernel, [leader, follower])? } else { 0 };
    let ns = rest + nanoseconds(ramps + finding);
    let changed = changed || was.is_some_and(|was| was.ratio != ratio);
    note_run_up(kernel, follower, ns)?;
    if leads != 0.0 {
        log(kernel, leader, 0)?;
    }
    if changed || ns > 0 {
        log(kernel, follower, ns)?;
        kernel.channel.advance(ns);
    }
    let numbers = numbers(kernel, pair);
    let ratio = if ratio == 1.0 { String::new() } else { format!(" ratio {}", wildcard_text(ratio)) };
    let phase = in_phase.map_or_else(String::new, |phase| format!(" phase {}", wildcard_text(phase)));
    kernel.channel.emit(0, Kind::mode(format!("synchronous spindles {numbers}{ratio}{phase}")));
    kernel.channel.check_stop()
}

/// Executes a code that repeats the state of the spindles: the block lasts until they have reached their speed.
fn repeated(kernel: &mut Kernel<'_>, pair: SpindlePair, phase: Option<f64>) -> Acted {
    let ns = rest_of_run_up(kernel, [pair.leader, pair.follower])?;
    if ns == 0 {
        return Ok(());
    }
    let numbers = numbers(kernel, pair);
    let phase = phase.map_or_else(String::new, |phase| format!(" phase {}", wildcard_text(phase)));
    kernel.channel.emit(ns, Kind::mode(format!("synchronous spindles {numbers}{phase}")));
    kernel.channel.advance(ns);
    kernel.channel.check_stop()
}

/// Executes a command that another channel has already given: the block lasts until the spindle has reached its speed.
pub(super) fn wait_for_speed(kernel: &mut Kernel<'_>, id: SpindleId) -> Acted {
    let ns = rest_of_run_up(kernel, [id, id])?;
    if ns > 0 && kernel.channel.env.machine.spindles[id].overlap == TimeOverlap::None {
        let command = kernel.channel.state.spindle.command;
        emit(kernel, id, &command, ns);
        kernel.channel.advance(ns);
    }
    Ok(())
}

/// Time until the last of these spindles has reached its speed, ns.
fn rest_of_run_up(kernel: &mut Kernel<'_>, spindles: [SpindleId; 2]) -> Result<i64, Halt> {
    let now = kernel.channel.now();
    Ok(settled(kernel, spindles)?.map_or(0, |at| at - now))
}

/// Ends the phase.
fn end_phase(kernel: &mut Kernel<'_>, pair: SpindlePair) -> Acted {
    let (follower, leader) = (pair.follower.index(), pair.leader.index());
    let ended = kernel.access(SharedTarget::Spindle, AccessMode::Write, |shared| {
        let coupling = shared.spindles.get_mut(follower)?.coupling.as_mut();
        coupling.filter(|coupling| coupling.leader == leader)?.phase.take()
    })?;
    if ended.is_some() {
        let numbers = numbers(kernel, pair);
        kernel.channel.emit(0, Kind::mode(format!("synchronous spindles {numbers} phase off")));
    }
    Ok(())
}

/// Ends a coupling; the follower keeps its speed. Has no effect on spindles that are not coupled.
fn uncouple(kernel: &mut Kernel<'_>, pair: SpindlePair) -> Acted {
    let (_, rpm) = speeds(kernel, pair)?;
    let (at, most) = ((kernel.channel.now(), kernel.channel.at.channel), largest_speeds(kernel));
    let (follower, leader) = (pair.follower.index(), pair.leader.index());
    let ended = kernel.access(SharedTarget::Spindle, AccessMode::Write, |shared| {
        shared.spindles.get(follower)?.coupling.filter(|coupling| coupling.leader == leader)?;
        let ended = shared.uncouple(follower, rpm, &most)?;
        let spindle = shared.spindles.get_mut(follower)?;
        spindle.changes.note(at.0, at.1);
        spindle.written(at.1);
        Some(ended)
    })?;
    if ended.is_some() {
        kernel.current()?;
        let numbers = numbers(kernel, pair);
        kernel.channel.emit(0, Kind::mode(format!("synchronous spindles off {numbers}")));
    }
    Ok(())
}

/// `1 2`: the leader and its follower.
fn numbers(kernel: &Kernel<'_>, pair: SpindlePair) -> String {
    let spindles = &kernel.channel.env.machine.spindles;
    format!("{} {}", spindles[pair.leader].number, spindles[pair.follower].number)
}

fn largest_speeds(kernel: &Kernel<'_>) -> Vec<f64> {
    kernel.channel.env.machine.spindles.entries().map(|(_, spindle)| spindle.max).collect()
}

fn refuse(kernel: &mut Kernel<'_>, pair: SpindlePair, refusal: CouplingRefusal) -> Halt {
    let spindles = &kernel.channel.env.machine.spindles;
    let of = |index: usize| spindles.id(index).map_or(0, |id| spindles[id].number);
    let (leader, follower) = (spindles[pair.leader].number, spindles[pair.follower].number);
    let reason = match refusal {
        CouplingRefusal::FollowsOther(other) => format!("spindle {follower} follows spindle {}", of(other)),
        CouplingRefusal::LeaderFollows(other) => format!("spindle {leader} itself follows spindle {}", of(other)),
        CouplingRefusal::FollowerLeads(other) => format!("spindle {} follows spindle {follower}", of(other)),
    };
    illegal(kernel, &format!("spindle {follower} cannot follow spindle {leader}: {reason}; end that coupling first"))
}

/// Current speeds of the leader and of the follower, rev/min.
fn speeds(kernel: &mut Kernel<'_>, pair: SpindlePair) -> Result<(f64, f64), Halt> {
    Ok((speed_of(kernel, pair.leader)?, speed_of(kernel, pair.follower)?))
}

/// Current speed of a spindle, rev/min.
pub(super) fn speed_of(kernel: &mut Kernel<'_>, id: SpindleId) -> Result<f64, Halt> {
    with(kernel, id, |kernel| kernel.turning_speed())
}

/// The phase in which a spindle follows another one.
pub(super) fn phase_of(kernel: &mut Kernel<'_>, id: SpindleId) -> Result<Option<f64>, Halt> {
    kernel.access(SharedTarget::Spindle, AccessMode::Read, |shared| shared.spindles.get(id.index())?.coupling?.phase)
}

/// Time at which the last of these spindles reaches its speed, ns, if that is later than now.
pub(super) fn settled(kernel: &mut Kernel<'_>, spindles: [SpindleId; 2]) -> Result<Option<i64>, Halt> {
    let settled = kernel.access(SharedTarget::Spindle, AccessMode::Read, |shared| {
        let of = spindles.map(|id| shared.spindle(id.index()).map_or(0, |spindle| spindle.settled));
        of[0].max(of[1])
    })?;
    Ok(Some(settled).filter(|settled| *settled > kernel.channel.now()))
}

/// Records the time at which a spindle reaches its speed, for the rules of chucks and for other channels.
pub(super) fn note_run_up(kernel: &mut Kernel<'_>, id: SpindleId, ns: i64) -> Acted {
    let seen = kernel.channel.env.machine.channels.len() > 1 && kernel.channel.state.spindle.shared;
    if ns == 0 || !seen && !kernel.channel.state.others.spindles.chucks {
        return Ok(());
    }
    let settled = kernel.channel.now() + ns;
    kernel.access(SharedTarget::Spindle, AccessMode::Write, |shared| {
        if let Some(spindle) = shared.spindles.get_mut(id.index()) {
            spindle.settled = settled;
        }
    })
}

/// Runs `read` as if the given spindle were the active spindle.
fn with<R>(
    kernel: &mut Kernel<'_>,
    id: SpindleId,
    read: impl FnOnce(&mut Kernel<'_>) -> Result<R, Halt>,
) -> Result<R, Halt> {
    let active = kernel.channel.state.spindle;
    kernel.channel.select_spindle(Some(id));
    let read = read(kernel);
    kernel.channel.select_spindle(active.id);
    if active.id.is_some() && kernel.channel.state.spindle.id == active.id {
        kernel.channel.state.spindle = active;
    }
    read
}

fn log(kernel: &mut Kernel<'_>, id: SpindleId, ns: i64) -> Acted {
    let command = with(kernel, id, |kernel| kernel.current())?;
    emit(kernel, id, &command, ns);
    Ok(())
}

fn emit(kernel: &mut Kernel<'_>, id: SpindleId, command: &SpindleCommand, ns: i64) {
    let SpindleCommand { direction, css, limit, angle, .. } = *command;
    let (speed, spindle) =
        (if css { command.surface } else { command.rpm }, kernel.channel.env.machine.spindles[id].number);
    kernel.channel.emit(ns, Kind::Spindle(SpindleEvent { spindle, direction, css, speed, limit, angle }));
}

/// Spindles that follow a spindle.
pub(super) fn followers(kernel: &mut Kernel<'_>, leader: SpindleId) -> Result<Vec<(SpindleId, SpindleCoupling)>, Halt> {
    if !kernel.channel.state.spindle.shared {
        return Ok(Vec::new());
    }
    let found: Vec<(usize, SpindleCoupling)> =
        kernel.access(SharedTarget::Spindle, AccessMode::Read, |shared| shared.followers(leader.index()).collect())?;
    let spindles = &kernel.channel.env.machine.spindles;
    Ok(found.into_iter().filter_map(|(at, coupling)| Some((spindles.id(at)?, coupling))).collect())
}

/// Logs the state of the spindles that follow the active one.
pub(super) fn log_followers(kernel: &mut Kernel<'_>, followers: &[(SpindleId, SpindleCoupling)]) {
    let command = kernel.channel.state.spindle.command;
    for (id, coupling) in followers {
        emit(kernel, *id, &coupling.command(&command), 0);
    }
}

/// Reports a command for a following spindle, unless the spindle is already in the commanded state.
pub(super) fn not_commanded(
    kernel: &mut Kernel<'_>,
    id: SpindleId,
    leader: usize,
    change: impl Fn(&mut SpindleCommand),
) -> Acted {
    let now = kernel.current()?;
    let mut wanted = now;
    change(&mut wanted);
    if wanted == now {
        return Ok(());
    }
    let spindles = &kernel.channel.env.machine.spindles;
    let name = |id: SpindleId| format!("spindle {} ({})", spindles[id].number, spindles[id].name);
    let leader = spindles.id(leader).map_or_else(String::new, name);
    let text = format!(
        "{} follows {leader}: '{}' does not act on it; command {leader}, or end the coupling first",
        name(id),
        kernel.channel.block_text()
    );
    kernel.diagnose(&diag::SPINDLE_FOLLOWS, text);
    Ok(())
}
