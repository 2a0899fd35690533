//! Parameters of the control: positions, offsets, modes.
//!
//! Facts: LinuxCNC documentation, "Numbered parameters", "Predefined named parameters", "System parameters". Offsets
//! and stored positions are in the unit of the machine, positions in that of the program. *Invariant:* a parameter that
//! the kernel holds is not stored here as well.

use counterpoint_fault as diag;
use counterpoint_machine::ident::{CodeId, codes};

use super::block::AXES;
use super::text::Rs274Mistake;
use super::{Outcome, Rs274};
use counterpoint_control_api::host::{AxisPlace, InterpreterHost};
use counterpoint_control_api::numeric::truth;

/// First parameter of the nine work offsets, and the distance between their numbers.
const OFFSETS: u32 = 5221;
const APART: u32 = 20;

/// Number of work offsets: G54 to G59.3.
pub(super) const SYSTEMS: u32 = 9;

/// First parameter of the result of a probing move.
pub(super) const PROBED: u32 = 5061;

/// The axis of a channel by its place among [`AXES`].
pub(super) fn axis(places: &[AxisPlace], at: usize) -> Option<&AxisPlace> {
    let letter = AXES.get(at)?;
    places.iter().find(|place| place.letter.as_bytes().first().is_some_and(|own| own.eq_ignore_ascii_case(letter)))
}

/// Converts values by axis of the channel into the order of [`AXES`], times a factor for linear axes.
pub(super) fn by_letter(places: &[AxisPlace], values: &[f64], factor: f64) -> [f64; 9] {
    let mut out = [0.0; 9];
    for (place, value) in places.iter().zip(values) {
        let letter = place.letter.as_bytes().first().map(u8::to_ascii_lowercase);
        if let Some(slot) = AXES.iter().position(|known| Some(*known) == letter).and_then(|at| out.get_mut(at)) {
            *slot = if place.turns { *value } else { value * factor };
        }
    }
    out
}

/// The reverse of [`by_letter`].
pub(super) fn by_axis(places: &[AxisPlace], values: &[f64; 9], factor: f64) -> Vec<f64> {
    let value = |place: &AxisPlace| {
        let letter = place.letter.as_bytes().first().map(u8::to_ascii_lowercase);
        let at = AXES.iter().position(|known| Some(*known) == letter);
        let value = at.and_then(|at| values.get(at)).copied().unwrap_or(0.0);
        if place.turns { value } else { value / factor }
    };
    places.iter().map(value).collect()
}

/// Named parameters that are 1 while a code is active.
const MODES: &[(&str, CodeId)] = &[
    ("_absolute", codes::POSITION_ABSOLUTE),
    ("_incremental", codes::POSITION_RELATIVE),
    ("_inverse_time", codes::FEED_1T),
    ("_units_per_minute", codes::FEED_UPM),
    ("_units_per_rev", codes::FEED_UPR),
    ("_tool_offset", codes::COMP_LENGTH_ON),
    ("_retract_old_z", codes::CYCLE_RETRACT_INITIAL),
    ("_retract_r_plane", codes::CYCLE_RETRACT_R),
    ("_spindle_rpm_mode", codes::SPINDLE_RPM),
    ("_spindle_css_mode", codes::SPINDLE_CSS),
    ("_lathe_diameter_mode", codes::XAXIS_DIAMETER),
    ("_lathe_radius_mode", codes::XAXIS_RADIUS),
    ("_spindle_cw", codes::SPINDLE_CLW),
    ("_mist", codes::COOLANT_MIST),
    ("_flood", codes::COOLANT_FLOOD),
];

impl Rs274 {
    /// A parameter by number.
    pub(super) fn read_number(&mut self, host: &dyn InterpreterHost, number: u32) -> f64 {
        self.system_number(host, number).unwrap_or_else(|| self.parameters.number(number))
    }

    fn system_number(&self, host: &dyn InterpreterHost, number: u32) -> Option<f64> {
        if number < 5021 {
            return None;
        }
        let at = |first: u32| (number - first) as usize;
        let place = |first: u32| {
            let places = host.axes();
            axis(&places, at(first)).cloned()
        };
        let factor = host.length_factor();
        Some(match number {
            5021..=5029 => place(5021).map_or(0.0, |place| place.machine),
            5081..=5089 => {
                let places = host.axes();
                let in_force = self.tool_offset_in_force(host, &places);
                in_force.get(at(5081)).copied().unwrap_or(0.0) / factor
            }
            5161..=5169 => self.offsets.stored[0].get(at(5161)).copied().unwrap_or(0.0),
            5181..=5189 => self.offsets.stored[1].get(at(5181)).copied().unwrap_or(0.0),
            5210 => truth(self.offsets.applied),
            5211..=5219 => self.offsets.g92.get(at(5211)).copied().unwrap_or(0.0),
            5220 => f64::from(host.work_offset().max(1)),
            5221..=5390 if (number - OFFSETS) % APART < 10 => {
                let (system, at) = ((number - OFFSETS) / APART + 1, (number - OFFSETS) % APART);
                if at == 9 {
                    self.rotation(host, system)
                } else {
                    let places = host.axes();
                    by_letter(&places, &host.offset(system), factor).get(at as usize).copied().unwrap_or(0.0)
                }
            }
            5400 => f64::from(host.tool()),
            5401..=5409 => {
                let places = host.axes();
                let values = by_letter(&places, &host.tool_offset(host.tool()), factor);
                values.get(at(5401)).copied().unwrap_or(0.0)
            }
            5410 => host.tool_size(host.tool())[1] * 2.0,
            5413 => f64::from(host.tip(host.tool())),
            5420..=5428 => place(5420).map_or(0.0, |place| place.work),
            _ => return None,
        })
    }

    /// Sets a parameter of the control. Returns false if the number belongs to no such parameter.
    pub(super) fn set_system(&mut self, host: &mut dyn InterpreterHost, number: u32, value: f64) -> Outcome<bool> {
        let at = |first: u32| (number - first) as usize;
        let slot = match number {
            5161..=5169 => self.offsets.stored[0].get_mut(at(5161)),
            5181..=5189 => self.offsets.stored[1].get_mut(at(5181)),
            5211..=5219 => self.offsets.g92.get_mut(at(5211)),
            5221..=5390 if (number - OFFSETS) % APART < 10 => {
                let (system, at) = ((number - OFFSETS) / APART + 1, (number - OFFSETS) % APART);
                self.set_offset_value(host, system, at as usize, value);
                return Ok(true);
            }
            5021..=5029 | 5081..=5089 | 5210 | 5220 | 5400..=5413 | 5420..=5428 => {
                let text = format!("#{number} can only be read");
                return Err(Rs274Mistake::new(&diag::MACRO_VARIABLE, 1, text).into());
            }
            _ => return Ok(false),
        };
        if let Some(slot) = slot {
            *slot = value;
        }
        Ok(true)
    }

    /// A named parameter of the control.
    pub(super) fn system_named(&self, host: &dyn InterpreterHost, name: &str) -> Option<f64> {
        let own = name.strip_prefix('_')?;
        if let Some((_, code)) = MODES.iter().find(|(known, _)| *known == name) {
            return Some(truth(host.is_active(*code)));
        }
        let letter = |text: &str| match text.as_bytes() {
            [letter] => AXES.iter().position(|known| known == letter),
            _ => None,
        };
        if let Some(at) = letter(own) {
            return Some(axis(&host.axes(), at).map_or(0.0, |place| place.work));
        }
        if let Some(at) = own.strip_prefix("abs_").and_then(letter) {
            return Some(axis(&host.axes(), at).map_or(0.0, |place| place.machine));
        }
        let active = |code| host.is_active(code);
        Some(match own {
            "vmajor" => 2.9,
            "vminor" | "task" | "remap_level" => 0.0,
            "line" => f64::from(host.place().line),
            "motion_mode" => f64::from(self.modes.motion),
            "plane" if active(codes::PLANE_ZX) => 180.0,
            "plane" if active(codes::PLANE_YZ) => 190.0,
            "plane" => 170.0,
            "ccomp" if active(codes::COMP_DIAM_LEFT) => 410.0,
            "ccomp" if active(codes::COMP_DIAM_RIGHT) => 420.0,
            "ccomp" => 400.0,
            "metric" => truth(!host.is_inch()),
            "imperial" => truth(host.is_inch()),
            "coord_system" => match host.work_offset().max(1) {
                system @ 1..=6 => f64::from(530 + system * 10),
                system => f64::from(584 + system),
            },
            "ijk_absolute_mode" => truth(self.modes.absolute_centers),
            "spindle_on" => truth(active(codes::SPINDLE_CLW) || active(codes::SPINDLE_CCLW)),
            "speed_override" | "feed_override" => 1.0,
            "adaptive_feed" | "feed_hold" => 0.0,
            "feed" => host.feed() / host.length_factor(),
            "current_tool" => f64::from(host.tool()),
            "selected_tool" => self.modes.selected.map_or(-1.0, f64::from),
            "value" | "value_returned" => 0.0,
            "call_level" => self.parameters.depth() as f64,
            _ => return None,
        })
    }
}
