//! Clamps of axes, and whole turns that are taken off rotary axes.
//!
//! Facts: reference control-emulator.md 3.2, 6.1, 6.3. Invariant: `Place::clamped` is zero unless an axis is clamped, so
//! a motion only looks at that. Decision: a move of a clamped axis is told and made all the same.

use crate::channel::Kernel;
use crate::diag;
use crate::log::event::{Kind, Motion, MotionKind};
use crate::machine::ident::DataId;
use counterpoint_fault::Acted;

/// How whole turns are taken off.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Modulo {
    /// Above −180 up to 180.
    Normal,
    /// From 0 to below 360.
    Plus,
    /// Between −360 and 360, with the sign that it has.
    Minus,
}

impl Modulo {
    /// The angle without whole turns.
    fn of(self, angle: f64) -> f64 {
        if !angle.is_finite() {
            return angle;
        }
        let positive = angle.rem_euclid(360.0);
        match self {
            Self::Normal if positive > 180.0 => positive - 360.0,
            // A tiny negative angle rounds up to the whole turn.
            Self::Normal | Self::Plus if positive < 360.0 => positive,
            Self::Normal | Self::Plus => 0.0,
            Self::Minus => angle % 360.0,
        }
    }
}

/// Clamps an axis or lets it go.
pub(super) fn clamp(kernel: &mut Kernel<'_>, id: DataId, on: bool) -> Acted {
    let Some(axis) = kernel.channel.axis_of_data(id) else { return no_axis(kernel, id) };
    kernel.channel.set_clamp(axis, on);
    let text = format!("{} {}", if on { "clamp" } else { "unclamp" }, kernel.channel.axis_name(axis));
    kernel.emit(0, Kind::mode(text));
    Ok(())
}

/// Takes whole turns off one rotary axis, or off all.
pub(super) fn unwind(kernel: &mut Kernel<'_>, id: Option<DataId>) -> Acted {
    let Some(id) = id else {
        for axis in 0..kernel.channel.state.place.axes.len() {
            if kernel.channel.state.place.axes.get(axis).is_some_and(|axis| axis.rotary) {
                kernel.unwind_axis(axis, Modulo::Normal);
            }
        }
        return Ok(());
    };
    match kernel
        .channel
        .axis_of_data(id)
        .filter(|axis| kernel.channel.state.place.axes.get(*axis).is_some_and(|axis| axis.rotary))
    {
        Some(axis) => kernel.unwind_axis(axis, Modulo::Normal),
        None => return no_axis(kernel, id),
    }
    Ok(())
}

fn no_axis(kernel: &mut Kernel<'_>, id: DataId) -> Acted {
    let text = format!(
        "channel {} has no axis of {} for '{}'",
        kernel.channel.at.channel,
        kernel.channel.env.machine.data_name(id),
        kernel.block_text()
    );
    kernel.diagnose(&diag::AXIS_NOT_IN_CHANNEL, text);
    Ok(())
}

impl Kernel<'_> {
    /// A motion while axes are clamped.
    #[cold]
    #[inline(never)]
    pub(crate) fn check_clamps(&mut self, motion: &Motion) {
        let round = matches!(motion.kind, MotionKind::ArcCw | MotionKind::ArcCcw);
        let clamped = self.channel.state.place.clamped;
        for axis in (0..self.channel.state.place.axes.len()).filter(|axis| clamped >> axis & 1 != 0) {
            let turns = round && motion.plane_axes.map(usize::from).contains(&axis);
            if !turns && motion.from.get(axis) == motion.to.get(axis) {
                continue;
            }
            let text = format!("axis {} is clamped and moves in '{}'", self.channel.axis_name(axis), self.block_text());
            self.diagnose(&diag::CLAMPED, text);
        }
    }

    /// Takes whole turns off the position of an axis; nothing moves.
    pub(crate) fn unwind_axis(&mut self, axis: usize, modulo: Modulo) {
        self.settle_for_macro();
        let mut machine = self.channel.machine_point(&self.channel.state.place.position);
        let Some(slot) = machine.get_mut(axis) else { return };
        let (before, after) = (*slot, modulo.of(*slot));
        if before == after {
            return;
        }
        *slot = after;
        self.channel.state.place.position = self.channel.way_of_machine(&machine);
        if let Some(slot) = self.channel.cutter().and_then(|cutter| cutter.contour.get_mut(axis)) {
            *slot += after - before;
        }
        self.channel.frames_changed();
        let text =
            format!("unwind {}={}", self.channel.axis_name(axis), counterpoint_lang::format::wildcard_text(after));
        self.emit(0, Kind::mode(text));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_turns_go_by_each_rule() {
        let all = |angle: f64| [Modulo::Normal, Modulo::Plus, Modulo::Minus].map(|modulo| modulo.of(angle));
        assert_eq!(all(540.0), [180.0, 180.0, 180.0]);
        assert_eq!(all(-540.0), [180.0, 180.0, -180.0]);
        assert_eq!(all(-450.0), [-90.0, 270.0, -90.0]);
        assert_eq!(all(-1e-20), [0.0, 0.0, -1e-20]);
        assert!(all(f64::NAN).iter().all(|angle| angle.is_nan()));
    }
}
