//! The data of cycles along contours: levels, feeds, allowances, direction.
//!
//! Facts: programming manuals of the control (Q1 to Q9 of cycle 20, Q8 is a radius of the path of the tool; Q10 to Q19,
//! Q208 of the cycles; the lines of the old cycles, which count from where the tool is; cycles 271 to 274 and 277).
//! Decisions: the tool of 277 comes to a point.

use counterpoint_control_api::host::InterpreterHost;

use super::moves::RAPID;
use super::path_state::actual;
use super::q_parameter::{ParameterKind, QParameter};
use super::{Heidenhain, old};

/// Column T-ANGLE of the tool table.
const TIP_ANGLE: u32 = 32;

/// Data of a cycle, with lengths and heights as in the program.
pub(super) struct ContourParameters {
    pub(super) surface: f64,
    pub(super) bottom: f64,
    /// Its allowance on the ground.
    pub(super) floor: f64,
    pub(super) infeed: f64,
    pub(super) allowance: f64,
    /// How much of the radius of the tool rows lie apart.
    pub(super) overlap: f64,
    pub(super) climbs: bool,
    /// Heights between rows, and before and after the cycle.
    pub(super) clear: f64,
    pub(super) safe: f64,
    pub(super) plunge: f64,
    pub(super) feed: f64,
    pub(super) out: f64,
    /// Direction of the cuts, degrees.
    pub(super) along: f64,
    /// Other tools that it names.
    pub(super) others: ContourTools,
    pub(super) rounding: Rounding,
}

/// The path of the tool inside of corners: an arc of a radius, geometry units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Rounding {
    /// Where it is round by itself it has at least this radius.
    Everywhere(f64),
    /// Corners alone, smaller where there is less room.
    Corners(f64),
}

/// Other tools that a cycle names, and the kind of its contours.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ContourTools {
    /// The tool for which holes are made; none for the active tool.
    pub(super) holes: Option<u32>,
    /// The tool that has roughed before.
    pub(super) earlier: Option<u32>,
    /// The first contour bounds the material, the tool may leave it.
    pub(super) open: bool,
}

/// The effect of an OCM cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum OcmOperation {
    Rough,
    Floor,
    Side,
    Chamfer,
}

impl Heidenhain {
    pub(super) fn sl(&self, index: u32) -> f64 {
        self.number(QParameter { kind: ParameterKind::Q, index })
    }

    /// Task of a cycle from 21 to 24, with its allowances at the floor and at the side.
    pub(super) fn task(&self, host: &dyn InterpreterHost, floor: f64, allowance: f64) -> ContourParameters {
        let surface = self.sl(5);
        let feed = self.sl(12);
        ContourParameters {
            surface,
            bottom: surface + self.sl(1) + floor,
            floor,
            infeed: self.sl(10),
            allowance,
            overlap: if self.sl(2) > 0.0 { self.sl(2) } else { 1.0 },
            climbs: self.sl(9) >= 0.0,
            clear: surface + self.sl(6),
            safe: self.sl(7),
            plunge: self.sl(11),
            feed,
            out: if self.sl(208) > 0.0 { self.sl(208) } else { feed },
            along: 0.0,
            others: ContourTools { holes: Some(self.sl(13) as u32), ..ContourTools::default() },
            rounding: Rounding::Corners(self.sl(8).max(0.0) * host.length_factor()),
        }
    }

    /// Task of cycles 271 and 272 to 274: the last infeed that the floor leaves, the side, the infeed, the feed and the
    /// plunge feed.
    pub(super) fn adaptive_task(
        &self,
        host: &dyn InterpreterHost,
        work: OcmOperation,
    ) -> Result<ContourParameters, String> {
        let surface = self.sl(203);
        let (floor, allowance, infeed, feed, plunge) = match work {
            OcmOperation::Rough => {
                (self.sl(369), self.sl(368), self.sl(202), self.sl(207), self.sl(207) * self.sl(568))
            }
            OcmOperation::Floor => (0.0, self.sl(368), 0.0, self.sl(385), self.sl(385) * self.sl(568)),
            OcmOperation::Side => (0.0, self.sl(14), self.sl(338), self.sl(385), self.sl(253)),
            OcmOperation::Chamfer => (0.0, self.beside_chamfer(host)?, 0.0, self.sl(207), self.sl(253)),
        };
        let depth = self.sl(if work == OcmOperation::Chamfer { 353 } else { 201 });
        Ok(ContourParameters {
            surface,
            bottom: surface + depth + floor,
            floor,
            infeed,
            allowance,
            overlap: if self.sl(370) > 0.0 { self.sl(370) } else { 1.0 },
            climbs: self.sl(351) >= 0.0,
            clear: surface + self.sl(200),
            safe: self.sl(260),
            plunge,
            feed,
            out: RAPID,
            along: 0.0,
            others: ContourTools {
                holes: None,
                earlier: self.tool_before(438).filter(|_| work == OcmOperation::Rough),
                open: self.sl(569) != 0.0,
            },
            rounding: Rounding::Everywhere(self.cutter(host)? * self.sl(578).max(0.0)),
        })
    }

    /// The tool of a parameter that has roughed before.
    pub(super) fn tool_before(&self, index: u32) -> Option<u32> {
        (self.sl(index) > 0.0).then(|| self.sl(index) as u32)
    }

    /// Additional distance of the tool of cycle 277 from the contour, beyond its radius. At the surface its cone
    /// reaches beyond the contour by the width of the chamfer.
    fn beside_chamfer(&self, host: &dyn InterpreterHost) -> Result<f64, String> {
        let tool = self.variables.control.tool.unwrap_or_else(|| f64::from(host.tool()));
        let half = self.tools.column(host, tool as u32, TIP_ANGLE).unwrap_or(0.0) / 2.0;
        if half <= 0.0 {
            return Err("cycle 277 needs T-ANGLE of the tool (ID50 NR32)".to_owned());
        }
        if self.sl(354) > 0.0 && (self.sl(354) - half).abs() > 1e-4 {
            return Err(format!("the angle Q354 of cycle 277 is not half of T-ANGLE, {half} degrees"));
        }
        let apart = self.sl(353).abs() * libm::tan(half.to_radians()) - self.sl(359);
        if apart < 0.0 {
            return Err("the chamfer Q359 is wider than the tool at the surface: program Q353 deeper".to_owned());
        }
        Ok(apart - self.cutter(host)? / host.length_factor())
    }

    /// Task of cycle 6, 15 or 16; 16 gives the sense.
    pub(super) fn old_task(&self, host: &dyn InterpreterHost) -> ContourParameters {
        let of = |number: usize| self.cycles.old.get(number - 1).copied().unwrap_or(0.0);
        let along = self.variables.control.tool_axis.unwrap_or(2);
        let stands = actual(host).get(along).copied().unwrap_or(0.0);
        let surface = stands - of(old::CLEARANCE).abs();
        ContourParameters {
            surface,
            bottom: surface - of(old::DEPTH).abs(),
            floor: 0.0,
            infeed: of(old::INFEED),
            allowance: of(old::ALLOWANCE),
            overlap: 1.2,
            climbs: of(old::DIRECTION) >= 0.0,
            clear: stands,
            safe: stands,
            plunge: of(old::PLUNGE_FEED),
            feed: of(old::FEED),
            out: RAPID,
            along: of(old::ANGLE),
            others: ContourTools::default(),
            rounding: Rounding::Corners(0.0),
        }
    }
}
