//! The working area of a program: limits of axes below those of travel.
//!
//! Facts: programming manual of the 840D, "Working area limitation (G25/G26, WALIMON, WALIMOF)": limits are positions
//! in the basic coordinate system, that is without frames, and hold for the tip of the tool; setting data enable them
//! for each axis and direction. *Invariant:* without an enabled limit there is no working area.

use counterpoint_event::event::{MAX_AXES, Position};
use counterpoint_machine::index::AxisSlot;

use super::channel_context::ChannelContext;

/// A side of an axis.
#[derive(Debug, Clone, Copy, Default)]
pub struct WorkAreaSide {
    /// The limit in the basic coordinate system; none before the program sets it.
    pub limit: Option<f64>,
    /// Whether it is enabled, if the program has set this.
    pub enabled: Option<bool>,
}

/// The working area.
#[derive(Debug, Clone, Default)]
pub struct WorkArea {
    /// Lower and upper side by axis.
    sides: [[WorkAreaSide; 2]; MAX_AXES],
    /// It is switched off.
    pub off: bool,
}

impl WorkArea {
    /// A side of an axis; `high`: the upper one.
    pub fn side(&mut self, axis: AxisSlot, high: bool) -> Option<&mut WorkAreaSide> {
        self.sides.get_mut(axis.index())?.get_mut(usize::from(high))
    }
}

impl ChannelContext<'_> {
    /// The working area, made if there is none.
    pub fn work_area(&mut self) -> &mut WorkArea {
        self.state.others.area.get_or_insert_default()
    }

    /// A side of the area: its limit, and whether it is enabled.
    pub fn area_side(&self, axis: AxisSlot, high: bool) -> (Option<f64>, bool) {
        let area = self.state.others.area.as_deref();
        let side = area.and_then(|area| area.sides.get(axis.index())?.get(usize::from(high))).copied();
        let WorkAreaSide { limit, enabled } = side.unwrap_or_default();
        (limit, enabled.unwrap_or(self.env.machine.habits.work_area))
    }

    /// The enabled limits of an axis.
    pub fn area_of(&self, axis: AxisSlot) -> Option<(f64, f64)> {
        self.state.others.area.as_deref().filter(|area| !area.off)?;
        let [low, high] = [false, true].map(|high| match self.area_side(axis, high) {
            (limit, true) => limit,
            (_, false) => None,
        });
        (low.is_some() || high.is_some()).then_some((low.unwrap_or(f64::NEG_INFINITY), high.unwrap_or(f64::INFINITY)))
    }

    /// A place of the work frame in the basic coordinate system, where the tip of the tool is; none in a tilted plane.
    pub fn basic_point(&self, work: &Position) -> Option<Position> {
        if self.state.place.tilted().is_some() {
            return None;
        }
        let (mut point, tool) = (*work, self.tool_shift());
        for ((slot, shift), tool) in point.iter_mut().zip(&self.state.place.shift).zip(tool) {
            *slot += shift - tool;
        }
        Some(point)
    }
}
