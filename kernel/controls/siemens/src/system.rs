//! System variables that the emulation knows by itself.
//!
//! Facts: reference control-emulator.md 5.4: a small set; variables that only keep written values are in `stored`.
//! Decisions: positions are those of the programmed point; `$AC_TIME`, the time since the start of the block, is 0,
//! since a block is read when it starts; the run time of the program is the simulated time of the channel. Invariant:
//! an unknown variable is none, so that it is reported.

use super::compiled::{IndexedName, as_name};
use super::conversions::number;
use super::value::Data;
use super::{Outcome, Siemens, syntax};
use counterpoint_control_api::host::InterpreterHost;
use counterpoint_machine::ident::codes;

/// Largest number of a timer.
const MOST_TIMERS: i64 = 99;

/// Group of the working plane.
const PLANE_GROUP: i64 = 6;

/// The working plane: 1 G17, 2 G18, 3 G19.
pub(super) fn plane(host: &dyn InterpreterHost) -> Option<i64> {
    let planes = [codes::PLANE_XY, codes::PLANE_ZX, codes::PLANE_YZ];
    planes.iter().zip(1..).find(|(plane, _)| host.is_active(**plane)).map(|(_, at)| at)
}

fn seconds(ns: i64) -> f64 {
    ns as f64 / 1e9
}

impl Siemens {
    /// Value of a system variable; none if it is not known.
    pub(super) fn system(&mut self, host: &mut dyn InterpreterHost, name: &IndexedName) -> Outcome<Option<Data>> {
        if let Some(frame) = self.control_frame(host, name)? {
            return Ok(Some(frame));
        }
        Ok(Some(match name.name.as_str() {
            "$P_EP" | "$AA_IW" | "$AA_IB" => Data::Real(self.position(host, name, false)?),
            "$AA_IM" => Data::Real(self.position(host, name, true)?),
            "$AA_FXS" => {
                let axis = self.axis_of(host, name)?.text();
                let letter = host.axis_letter(&axis).map(str::to_owned);
                Data::Int(i64::from(letter.is_some_and(|letter| host.is_at_fixed_stop(&letter))))
            }
            "$P_TOOLNO" => Data::Int(i64::from(host.tool())),
            "$P_UIFRNUM" => Data::Int(i64::from(host.work_offset())),
            "$P_CHANNO" => Data::Int(i64::from(host.channel())),
            "$P_STACK" => Data::Int(i64::try_from(host.level()).unwrap_or(0)),
            "$P_DRYRUN" | "$P_ISTEST" | "$P_SEARCH" | "$P_SEARCH1" | "$P_SEARCH2" => Data::Bool(false),
            "$P_AXN1" | "$P_AXN2" | "$P_AXN3" => {
                let at = name.name.bytes().next_back().map_or(0, |digit| usize::from(digit.saturating_sub(b'1')));
                let geometry = super::texts::geometry_name;
                // Abscissa, ordinate and applicate of the plane; without a Y axis the applicate stays Z.
                let first = match plane(host).filter(|_| geometry(host, 1).is_some()) {
                    Some(2) => 2,
                    Some(3) => 1,
                    _ => 0,
                };
                Data::Axis(geometry(host, (first + at) % 3).unwrap_or_default())
            }
            "$P_SUBPAR" => {
                let number = self.only_index(host, name)?;
                let given = &self.variables.calls.program().given;
                let given = usize::try_from(number - 1).ok().and_then(|at| given.get(at));
                Data::Bool(given.is_some_and(|given| given.is_there()))
            }
            "$P_GG" => match self.only_index(host, name)? {
                PLANE_GROUP => match plane(host) {
                    Some(plane) => Data::Int(plane),
                    None => return Ok(None),
                },
                group => match super::groups::active(host, group) {
                    Some(function) => Data::Int(function),
                    None => return Ok(None),
                },
            },
            "$PI" => Data::Real(std::f64::consts::PI),
            "$AC_TIME" => Data::Real(0.0),
            "$AC_CYCLE_TIME" | "$AC_OPERATING_TIME" | "$AC_PROG_NET_TIME" => Data::Real(seconds(host.clock())),
            "$AC_TIMER" => {
                let number = self.only_index(host, name)?;
                let (value, since) = self.stored.timers.get(&number).copied().unwrap_or((0.0, None));
                Data::Real(value + since.map_or(0.0, |since| seconds(host.clock().saturating_sub(since))))
            }
            _ => match self.tool_value(host, name)? {
                Some(value) => value,
                None => return self.stored_value(host, name),
            },
        }))
    }

    /// Assigns a system variable: the blocks that do so. None if it is not known.
    pub(super) fn set_system(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &IndexedName,
        value: &Data,
    ) -> Outcome<Option<Vec<String>>> {
        if name.name == "$AC_TIMER" {
            let timer = self.only_index(host, name)?;
            if !(0..=MOST_TIMERS).contains(&timer) {
                return syntax(format!("timer {timer} does not exist"));
            }
            let value = number(value)?;
            let state = if value < 0.0 {
                // A negative value stops it where it is.
                let (value, since) = self.stored.timers.get(&timer).copied().unwrap_or((0.0, None));
                (value + since.map_or(0.0, |since| seconds(host.clock().saturating_sub(since))), None)
            } else {
                (value, Some(host.clock()))
            };
            self.stored.timers.insert(timer, state);
            host.effect();
            return Ok(Some(Vec::new()));
        }
        if self.set_tool_value(host, name, value)? {
            return Ok(Some(Vec::new()));
        }
        if self.store_value(host, name, value)? {
            return Ok(Some(Vec::new()));
        }
        self.set_control_frame(host, name, value)
    }

    pub(super) fn only_index(&mut self, host: &mut dyn InterpreterHost, name: &IndexedName) -> Outcome<i64> {
        match name.index.as_slice() {
            [index] => self.whole_number(host, index),
            _ => syntax(format!("{} needs one index", name.name)),
        }
    }

    /// Position of the axis in the index.
    fn position(&mut self, host: &mut dyn InterpreterHost, name: &IndexedName, machine: bool) -> Outcome<f64> {
        let [index] = name.index.as_slice() else { return syntax(format!("{} needs an axis", name.name)) };
        let wanted = match as_name(index) {
            Some(axis) if axis.index.is_empty() && !axis.name.starts_with('$') && !self.variables.knows(&axis.name) => {
                axis.name.clone()
            }
            _ => match self.evaluate(host, index)? {
                Data::Axis(axis) | Data::Text(axis) => axis,
                other => return super::wrong_type(format!("{} is not an axis", other.described())),
            },
        };
        let is = |text: &str| text.eq_ignore_ascii_case(&wanted);
        match host.axes().into_iter().find(|axis| is(&axis.name) || is(&axis.letter)) {
            Some(axis) => Ok(if machine { axis.machine } else { axis.work }),
            None => super::wrong_type(format!("the channel has no axis {wanted}")),
        }
    }
}
