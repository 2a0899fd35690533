//! Clamps of axes, and whole turns that are taken off rotary axes.
//!
//! Facts: reference control-emulator.md 3.2, 6.1, 6.3. Invariant: `Place::clamped` is zero unless an axis is clamped, so
//! a motion only looks at that. Decision: a move of a clamped axis is told and made all the same.

use crate::channel::Kernel;
use crate::diag;
use crate::log::event::{Kind, Motion, MotionKind};
use crate::machine::ident::{self, CodeId, DataId, code_facts};
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

/// The axis of a clamp code, and whether it clamps.
pub(super) fn of(id: CodeId) -> Option<(DataId, bool)> {
    let name = code_facts(id)?.name;
    let clamps = name.strip_prefix("CODE_CLAMP_");
    let axis = clamps.or_else(|| name.strip_prefix("CODE_UNCLAMP_"))?;
    Some((ident::data(&format!("REG_AXIS_{axis}"))?, clamps.is_some()))
}

/// The axis of a code that takes whole turns off, none for all rotary ones.
pub(super) fn unwinds(id: CodeId) -> Option<Option<DataId>> {
    match code_facts(id)?.name.strip_prefix("CODE_UNWIND_ROTARY")? {
        "" => Some(None),
        axis => Some(Some(ident::data(&format!("REG_AXIS{axis}"))?)),
    }
}

/// Clamps an axis or lets it go.
pub(super) fn clamp(kernel: &mut Kernel<'_>, id: DataId, on: bool) -> Acted {
    let Some(axis) = kernel.axis_of_data(id) else { return no_axis(kernel, id) };
    kernel.set_clamp(axis, on);
    let text = format!("{} {}", if on { "clamp" } else { "unclamp" }, kernel.axis_name(axis));
    kernel.emit(0, Kind::Mode { text: text.into() });
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
    /// Channel axis that these data move.
    pub(crate) fn axis_of_data(&self, id: DataId) -> Option<usize> {
        self.channel.state.place.axes.iter().position(|axis| axis.data == id)
    }

    /// Name of a channel axis for listings.
    pub(crate) fn axis_name(&self, axis: usize) -> String {
        let own =
            self.channel.state.place.axes.get(axis).and_then(|axis| self.channel.env.machine.axes.get(axis.machine));
        own.map_or_else(String::new, |own| own.letter.to_lowercase())
    }

    fn set_clamp(&mut self, axis: usize, on: bool) {
        let bit = 1_u8.checked_shl(axis as u32).unwrap_or(0);
        self.channel.state.place.clamped =
            if on { self.channel.state.place.clamped | bit } else { self.channel.state.place.clamped & !bit };
    }

    /// Follows the groups of clamps after a macro has changed active codes.
    pub(crate) fn follow_clamps(&mut self) {
        for axis in 0..self.channel.state.place.axes.len() {
            let Some(name) =
                self.channel.state.place.axes.get(axis).map(|axis| self.channel.env.machine.data_name(axis.data))
            else {
                break;
            };
            let code = ident::code(&name.replacen("REG_AXIS", "CODE_CLAMP", 1));
            let group = code.and_then(code_facts).map_or(0, |facts| facts.group);
            if let Some((_, on)) = self.channel.state.modal.code(group).filter(|_| group != 0).and_then(of) {
                self.set_clamp(axis, on);
            }
        }
    }

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
            let text = format!("axis {} is clamped and moves in '{}'", self.axis_name(axis), self.block_text());
            self.diagnose(&diag::CLAMPED, text);
        }
    }

    /// Takes whole turns off the position of an axis; nothing moves.
    pub(crate) fn unwind_axis(&mut self, axis: usize, modulo: Modulo) {
        self.settle_for_macro();
        let mut machine = self.machine_point(&self.channel.state.place.position);
        let Some(slot) = machine.get_mut(axis) else { return };
        let (before, after) = (*slot, modulo.of(*slot));
        if before == after {
            return;
        }
        *slot = after;
        self.channel.state.place.position = self.way_of_machine(&machine);
        if let Some(slot) = self.cutter().and_then(|cutter| cutter.contour.get_mut(axis)) {
            *slot += after - before;
        }
        self.frames_changed();
        let text = format!("unwind {}={}", self.axis_name(axis), counterpoint_lang::format::wildcard_text(after));
        self.emit(0, Kind::Mode { text: text.into() });
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

    #[test]
    fn every_axis_has_its_clamp() {
        let named = |name: &str| ident::code(name).and_then(of);
        let axes = ["X", "Y", "Z", "U", "V", "W", "AT", "BT", "CT", "CT2", "AH", "BH", "CH", "N", "N2", "E"];
        for axis in axes {
            let data = ident::data(&format!("REG_AXIS_{axis}")).unwrap();
            assert_eq!(named(&format!("CODE_CLAMP_{axis}")), Some((data, true)));
            assert_eq!(named(&format!("CODE_UNCLAMP_{axis}")), Some((data, false)));
        }
    }
}
