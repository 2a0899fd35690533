//! Transfer of parts between the chucks of two spindles, and the moves of the sub-spindle that the chucks allow.
//!
//! Facts: reference shop-machines.md 12 (part transfer, word by word). Decisions: there is no model of the part, so a
//! sub-chuck that closes away from home closes on the part. A feed move that ends at the turning axis cuts off a part
//! that both chucks hold. The sub-spindle may relieve such a part by up to 1 mm in total. A spindle that still
//! runs up or down has not reached the speed of its command. *Invariant:* a refused code or move changes neither a
//! position nor a chuck.

use counterpoint_event::event::{Kind, Motion, MotionKind};
use counterpoint_fault::{self as diag, Acted, DiagnosticFacts, Halt};
use counterpoint_lang::format::wildcard_text;
use counterpoint_machine::ident::{CodeId, codes};
use counterpoint_machine::index::{AxisSlot, BySlot, SpindleId};
use counterpoint_machine::rows::CodeRow;
use counterpoint_program::block::PendingCode;
use counterpoint_sync::chucks::{ChuckEffect, ChuckPair};
use counterpoint_sync::races::AccessMode;

use super::Kernel;
use super::actions::Action;
use super::paired_spindles::{phase_of, settled, speed_of};
use counterpoint_channel::shared_target::SharedTarget;

/// Largest distance that a sub-spindle may move while both chucks hold the part, geometry units.
const RELIEF: f64 = 1.0;

/// Speeds that differ by less than this are equal, rev/min.
const SAME_SPEED: f64 = 1.0;

/// Radius at or below which a cut has reached the turning axis.
const AXIS: f64 = 1e-6;

/// The effect of a code on chucks.
#[derive(Debug, Clone, Copy)]
enum ChuckCode {
    /// Opens the chuck of the sub-spindle or of the main spindle.
    Open { sub: bool },
    /// Closes that chuck.
    Close { sub: bool },
    /// The part is cut off.
    CutOff,
}

/// The action of a code.
pub fn find(id: CodeId) -> Option<&'static dyn Action> {
    Some(match id {
        codes::CHUCK_MAIN_OPEN => &ChuckCode::Open { sub: false },
        codes::CHUCK_MAIN_CLOSE => &ChuckCode::Close { sub: false },
        codes::CHUCK_SUB_OPEN => &ChuckCode::Open { sub: true },
        codes::CHUCK_SUB_CLOSE => &ChuckCode::Close { sub: true },
        codes::PART_CUT_OFF => &ChuckCode::CutOff,
        _ => return None,
    })
}

impl Action for ChuckCode {
    fn run(&self, kernel: &mut Kernel<'_>, _: &CodeRow, _: &PendingCode) -> Acted {
        kernel.flow.pass.effects = true;
        kernel.flush_lookahead()?;
        let Some(chucks) = known(kernel)? else { return Ok(()) };
        match *self {
            Self::Open { sub } => open(kernel, chucks, sub),
            Self::Close { sub } => close(kernel, chucks, sub),
            Self::CutOff => cut_off(kernel),
        }
    }
}

/// The chucks now, if the machine knows them.
fn known(kernel: &mut Kernel<'_>) -> Result<Option<ChuckPair>, Halt> {
    kernel.access(SharedTarget::Spindle, AccessMode::Read, |shared| shared.chucks)
}

/// Changes the state of both chucks.
fn change<R: Default>(kernel: &mut Kernel<'_>, by: impl FnOnce(&mut ChuckPair) -> R) -> Result<R, Halt> {
    kernel.access(SharedTarget::Spindle, AccessMode::Write, |shared| shared.chucks.as_mut().map(by).unwrap_or_default())
}

fn name(sub: bool) -> &'static str {
    if sub { "sub" } else { "main" }
}

fn open(kernel: &mut Kernel<'_>, chucks: ChuckPair, sub: bool) -> Acted {
    if chucks.would_drop(sub) {
        let other = name(!sub);
        let reason =
            format!("the chuck of the {other} spindle is open, so no chuck would hold the part: close it first");
        return Err(refuse(kernel, &diag::PART_NOT_HELD, &reason));
    }
    if chucks.chuck(sub).open {
        return Ok(());
    }
    let effect = change(kernel, |chucks| Some(chucks.open(sub)))?;
    emit(kernel, format!("chuck {} open", name(sub)));
    if effect == Some(ChuckEffect::Released) {
        emit(kernel, format!("part out of chuck {}", name(sub)));
    }
    Ok(())
}

fn close(kernel: &mut Kernel<'_>, chucks: ChuckPair, sub: bool) -> Acted {
    if let Some((leader, follower)) = kernel.channel.env.machine.chucks().filter(|_| chucks.would_hold_twice(sub)) {
        if let Some((main, other)) = other_speeds(kernel, (leader, follower))? {
            let reason = format!(
                "the main spindle turns at {main} rev/min and the sub-spindle at {other}: couple the spindles before \
                 the chuck closes"
            );
            return Err(refuse(kernel, &diag::CHUCK_SPEED, &reason));
        }
        if let Some(at) = settled(kernel, [leader, follower])? {
            let reason = format!(
                "the spindles reach their common speed only at {:.3} s: make the channel wait until then before it closes the chuck",
                at as f64 / 1e9
            );
            return Err(refuse(kernel, &diag::CHUCK_SPEED, &reason));
        }
        let main = speed_of(kernel, leader)?;
        let needs_phase = kernel.channel.env.machine.spindles[follower].takes_in_phase && main > 0.0;
        if needs_phase && phase_of(kernel, follower)?.is_none() {
            let reason = "the spindles are not in phase, and the part has edges: couple them in phase first";
            return Err(refuse(kernel, &diag::CHUCK_PHASE, reason));
        }
    }
    if !chucks.chuck(sub).open {
        return Ok(());
    }
    let effect = change(kernel, |chucks| Some(chucks.close(sub)))?;
    emit(kernel, format!("chuck {} closed", name(sub)));
    if effect == Some(ChuckEffect::Joined) {
        emit(kernel, "part in both chucks".to_owned());
    }
    Ok(())
}

/// The speeds of both spindles as texts, if they differ.
fn other_speeds(kernel: &mut Kernel<'_>, pair: (SpindleId, SpindleId)) -> Result<Option<(String, String)>, Halt> {
    let (main, other) = (speed_of(kernel, pair.0)?, speed_of(kernel, pair.1)?);
    let differ = (main - other).abs() > SAME_SPEED;
    Ok(differ.then(|| (wildcard_text(main), wildcard_text(other))))
}

/// Refuses a command after which the spindles turn at different speeds while both chucks hold the same piece.
pub(super) fn after_command(kernel: &mut Kernel<'_>) -> Acted {
    let Some(pair) = kernel.channel.env.machine.chucks() else { return Ok(()) };
    if !known(kernel)?.is_some_and(|chucks| chucks.hold_twice()) {
        return Ok(());
    }
    let Some((main, other)) = other_speeds(kernel, pair)? else { return Ok(()) };
    let text = format!(
        "both chucks hold the part, but the main spindle turns at {main} rev/min and the sub-spindle at {other} after \
         '{}': couple the spindles, or open a chuck first",
        kernel.channel.block_text()
    );
    Err(kernel.alarm(&diag::CHUCK_SPEED, text))
}

fn cut_off(kernel: &mut Kernel<'_>) -> Acted {
    if change(kernel, ChuckPair::cut_off)? {
        emit(kernel, "part cut off".to_owned());
    }
    Ok(())
}

fn emit(kernel: &mut Kernel<'_>, text: String) {
    kernel.channel.emit(0, Kind::mode(text));
}

fn refuse(kernel: &mut Kernel<'_>, facts: &DiagnosticFacts, reason: &str) -> Halt {
    let text = format!("{reason}, in '{}'; no part of the block acts", kernel.channel.block_text());
    kernel.alarm(facts, text)
}

/// The axis that moves the sub-spindle in this channel, its position before and after a move, and its home position.
fn slide(kernel: &Kernel<'_>, motion: &Motion) -> Option<(AxisSlot, [f64; 2], f64)> {
    let machine = kernel.channel.env.machine;
    let (_, follower) = machine.chucks()?;
    let slide = machine.spindles[follower].slide?;
    let place = &kernel.channel.state.place;
    let slot = place.layout.axes.find(|axis| axis.machine == slide)?;
    let places = [&motion.from, &motion.to].map(|position| place.machine_point(position).at(slot));
    (motion.from.at(slot) != motion.to.at(slot)).then_some((slot, places, machine.axes[slide].home))
}

/// Executes a motion if the chucks of the machine allow it.
pub(super) fn travel(kernel: &mut Kernel<'_>, seconds: f64, motion: &Motion) -> Acted {
    if !kernel.channel.state.others.spindles.chucks {
        return kernel.begin_travel(seconds, motion);
    }
    let relief = before_move(kernel, motion)?;
    kernel.begin_travel(seconds, motion)?;
    if let Some(relief) = relief {
        change(kernel, |chucks| chucks.relief = relief)?;
    }
    after_move(kernel, motion)
}

/// Refuses a move of a sub-spindle that the chucks do not allow. Returns the travel of the slide after the move, if
/// both chucks hold a part.
fn before_move(kernel: &mut Kernel<'_>, motion: &Motion) -> Result<Option<f64>, Halt> {
    let Some((slot, [from, to], home)) = slide(kernel, motion) else { return Ok(None) };
    let Some(chucks) = known(kernel)? else { return Ok(None) };
    let axis = kernel.channel.axis_name(slot);
    let approaches = motion.kind != MotionKind::Rapid && (to - home).abs() > (from - home).abs();
    if approaches && !chucks.sub.open && chucks.sub.piece.is_none() && chucks.main.piece.is_some() {
        let reason = format!("{axis} feeds the sub-spindle against the part, but its chuck is closed: open it first");
        return Err(refuse(kernel, &diag::CHUCK_NOT_OPEN, &reason));
    }
    if !chucks.joined || chucks.sub.open {
        return Ok(None);
    }
    let relief = if chucks.main.open { to - from } else { chucks.relief + (to - from) };
    if relief.abs() <= RELIEF {
        return Ok(Some(relief));
    }
    if !chucks.main.open {
        let reason = format!(
            "{axis} moves the sub-spindle while both chucks hold the part: cut it off, or open one of the chucks first"
        );
        return Err(refuse(kernel, &diag::SLIDE_HELD, &reason));
    }
    if change(kernel, ChuckPair::take_out)? {
        emit(kernel, "part in chuck sub".to_owned());
    }
    Ok(None)
}

/// Records whether the sub-spindle is away from home. A cut that ends at the turning axis cuts off a part that both
/// chucks hold.
fn after_move(kernel: &mut Kernel<'_>, motion: &Motion) -> Acted {
    if let Some((_, [_, to], home)) = slide(kernel, motion) {
        let away = (to - home).abs() > RELIEF;
        change(kernel, |chucks| chucks.away = away)?;
    }
    let [from, to] = [&motion.from, &motion.to].map(|position| kernel.channel.state.place.radius(position));
    let cuts = motion.kind != MotionKind::Rapid && from > AXIS && to <= AXIS;
    if cuts { cut_off(kernel) } else { Ok(()) }
}
