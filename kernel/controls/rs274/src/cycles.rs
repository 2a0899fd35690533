//! Canned cycles G73, G74, G81 to G86, G89.
//!
//! Facts: LinuxCNC documentation, "Canned cycles". The kernel gets heights as positions: R of incremental mode counts
//! from the initial level, Z from R. If R is above the initial level, the tool goes to R before it moves in the plane
//! (both as in rs274 and its tests). *Invariant:* the initial level is the level before the first cycle of a series.

use counterpoint_fault as diag;
use counterpoint_machine::ident::codes as ids;

use super::block::{AXES, BlockWords};
use super::codes::{Rs274Kind, spelled};
use super::motion::{push_axis, push_feed, work};
use super::polar::without_polar;
use super::run::{push_code, push_named, push_value, push_word};
use super::text::Rs274Mistake;
use super::{Outcome, Rs274};
use counterpoint_control_api::host::InterpreterHost;

/// Seconds that grblHAL waits after each peck.
const GRBLHAL_DWELL: f64 = 0.25;

/// Short retract of G73 on grblHAL, mm (setting $28).
const GRBLHAL_RETRACT: f64 = 0.1;

/// Words that a cycle remembers.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct StickyWords {
    /// The active cycle, 0 for none.
    code: u16,
    /// Level before the first cycle of the series.
    initial: Option<f64>,
    z: Option<f64>,
    r: Option<f64>,
    q: Option<f64>,
    p: Option<f64>,
    d: Option<f64>,
    /// P and Q of the last G5.
    pub(super) spline: Option<[f64; 2]>,
}

impl StickyWords {
    /// Ends the cycle, because another motion is active.
    pub(super) fn end(&mut self) {
        *self = Self { spline: self.spline, ..Self::default() };
    }
}

fn refused(error: u8, text: String) -> Rs274Mistake {
    Rs274Mistake::new(&diag::REFUSED, error, text)
}

/// A hole of G73 or G83 on grblHAL: the tool returns to the depth at feed, and dwells after each peck.
struct PeckedHole {
    /// The axes of the plane and of the hole.
    plane: [usize; 3],
    clear: f64,
    depth: f64,
    back: f64,
    step: f64,
    /// Whether retracts are short (G73).
    breaks: bool,
}

impl PeckedHole {
    fn leave_blocks(&self, host: &mut dyn InterpreterHost, words: &BlockWords, count: u32, level: f64) -> Outcome<()> {
        let [first, second, along] = self.plane;
        let (relative, span) = (host.relative(), words.whole);
        let short = GRBLHAL_RETRACT / host.length_factor();
        let in_plane = [first, second].map(|at| AXES.get(at).and_then(|letter| words.word(*letter)));
        let mut here = level;
        let mut wrote = false;
        for pass in 0..count {
            if (pass == 0 || relative) && in_plane.iter().any(Option::is_some) {
                end_before(host, &mut wrote);
                push_code(host, b'G', 0.0, span);
                in_plane.iter().flatten().try_for_each(|word| push_word(host, word))?;
            }
            let mut go = |host: &mut dyn InterpreterHost, code: f64, to: f64| {
                let from = std::mem::replace(&mut here, to);
                if to == from {
                    return Outcome::Ok(());
                }
                end_before(host, &mut wrote);
                push_code(host, b'G', code, span);
                push_axis(host, along, if relative { to - from } else { to }, span)?;
                if code == 0.0 {
                    return Ok(());
                }
                push_feed(host, words)?;
                host.end_block();
                push_code(host, b'G', 4.0, span);
                push_value(host, b'P', GRBLHAL_DWELL, span)
            };
            go(host, 0.0, self.clear)?;
            let mut reached = self.clear;
            while reached > self.depth {
                host.work(1)?;
                reached = (reached - self.step).max(self.depth);
                let ends = reached == self.depth || !self.breaks;
                go(host, 1.0, reached)?;
                go(host, 0.0, if ends { self.back } else { reached + short })?;
            }
        }
        Ok(())
    }
}

/// Ends the previous block, if one has been written.
fn end_before(host: &mut dyn InterpreterHost, wrote: &mut bool) {
    if std::mem::replace(wrote, true) {
        host.end_block();
    }
}

/// Refuses tapping and boring if the spindle does not turn, or turns in the wrong direction.
fn check_spindle(host: &dyn InterpreterHost, code: u16) -> Outcome<()> {
    let [clockwise, counter] = [ids::SPINDLE_CLW, ids::SPINDLE_CCLW].map(|id| host.is_active(id));
    let (turns, start) = match code {
        840 => (clockwise, "M3"),
        740 => (counter, "M4"),
        860 => (clockwise || counter, "M3 or M4"),
        _ => return Ok(()),
    };
    if turns {
        return Ok(());
    }
    Err(refused(20, format!("{} needs a turning spindle: write {start} before", spelled(code))).into())
}

impl Rs274 {
    /// Leaves the blocks of a cycle.
    pub(super) fn cycle(&mut self, host: &mut dyn InterpreterHost, words: &BlockWords, code: u16) -> Outcome<()> {
        let name = spelled(code);
        if host.keeps_moves_back() {
            return Err(
                refused(20, format!("{name} is not possible under cutter compensation: write G40 before")).into()
            );
        }
        let plane = if host.is_active(ids::PLANE_ZX) {
            [2, 0, 1]
        } else if host.is_active(ids::PLANE_YZ) {
            [1, 2, 0]
        } else {
            [0, 1, 2]
        };
        let [_, _, along] = plane;
        let (places, relative, span) = (host.axes(), host.relative(), words.whole);
        let here = work(&places, along);
        let sticky = &mut self.modes.cycle;
        if sticky.code != code {
            *sticky =
                StickyWords { code, initial: sticky.initial, r: sticky.r, spline: None, ..StickyWords::default() };
        }
        // On grblHAL each block has its own retract level.
        let before = *sticky.initial.get_or_insert(here);
        let initial = if self.kind == Rs274Kind::GrblHal { here } else { before };
        let letter = AXES.get(along).copied().unwrap_or(b'z');
        for (slot, letter) in [
            (&mut sticky.z, letter),
            (&mut sticky.r, b'r'),
            (&mut sticky.q, b'q'),
            (&mut sticky.p, b'p'),
            (&mut sticky.d, b'd'),
        ] {
            *slot = words.get(letter).or(*slot);
        }
        let sticky = *sticky;
        let missing = |letter: u8| {
            let letter = char::from(letter.to_ascii_uppercase());
            refused(28, format!("{name} needs {letter}: add the word"))
        };
        let (z, r) = (sticky.z.ok_or_else(|| missing(letter))?, sticky.r.ok_or_else(|| missing(b'r'))?);
        let clear = if relative { initial + r } else { r };
        let depth = if relative { clear + z } else { z };
        if clear < depth {
            return Err(refused(20, format!("R of {name} is below the bottom of the hole")).into());
        }
        let pecks = matches!(code, 730 | 830);
        if pecks && sticky.q.is_none_or(|step| step <= 0.0) {
            return Err(refused(28, format!("{name} needs Q, the depth of a peck, above 0")).into());
        }
        let dwells = matches!(code, 740 | 820 | 840 | 860 | 890);
        if dwells && sticky.p.unwrap_or(0.0) < 0.0 || matches!(code, 820 | 860 | 890) && sticky.p.is_none() {
            return Err(refused(28, format!("{name} needs P, the seconds of its dwell, 0 or more")).into());
        }
        if self.kind == Rs274Kind::LinuxCnc {
            check_spindle(host, code)?;
        }
        let count = words.get(b'l').unwrap_or(1.0);
        if count.fract() != 0.0 || !(1.0..=9999.0).contains(&count) {
            return Err(refused(20, format!("L of {name} must be a whole number of at least 1")).into());
        }
        if initial < clear && here != clear {
            push_code(host, b'G', 0.0, span);
            push_axis(host, along, if relative { clear - here } else { clear }, span)?;
            host.end_block();
        }
        let back = if host.is_active(ids::CYCLE_RETRACT_R) { clear } else { initial.max(clear) };
        if pecks && self.kind == Rs274Kind::GrblHal {
            let hole = PeckedHole { plane, clear, depth, back, step: sticky.q.unwrap_or(0.0), breaks: code == 730 };
            return hole.leave_blocks(host, words, count as u32, here.max(clear));
        }
        // These cycles feed out of the hole up to the return level.
        let feeds_out = matches!(code, 740 | 840 | 890) && back > clear;
        for pass in 0..count as u32 {
            let polar = without_polar(host, words, pass)?;
            let words = polar.as_ref().unwrap_or(words);
            push_code(host, b'G', f64::from(code / 10), span);
            if pass == 0 {
                push_feed(host, words)?;
            }
            for at in plane.iter().take(2) {
                let letter = AXES.get(*at).copied().unwrap_or(b'x');
                let stays = if relative { 0.0 } else { work(&places, *at) };
                push_axis(host, *at, words.get(letter).unwrap_or(stays), span)?;
            }
            push_named(host, "DEPTH", depth, span);
            push_value(host, b'R', clear, span)?;
            push_named(host, "LEVEL", if feeds_out { clear } else { back }, span);
            if let Some(step) = sticky.q.filter(|_| pecks) {
                push_value(host, b'Q', step, span)?;
            }
            if let Some(step_back) = sticky.d.filter(|_| pecks) {
                push_named(host, "CLEARANCE", step_back, span);
            }
            if dwells {
                push_value(host, b'P', sticky.p.unwrap_or(0.0), span)?;
            }
            if feeds_out {
                host.end_block();
                push_code(host, b'G', 1.0, span);
                push_axis(host, along, if relative { back - clear } else { back }, span)?;
            }
            if pass + 1 < count as u32 {
                host.end_block();
            }
        }
        host.work(count as usize)?;
        Ok(())
    }
}
