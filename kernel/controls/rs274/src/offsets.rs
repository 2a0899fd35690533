//! Work offsets, tool offsets, presets and stored positions: G10, G28.1, G30.1, G43.1, G43.2, G52, G92.
//!
//! Facts: LinuxCNC documentation of these codes. A machine point is the rotated sum of the programmed point and the
//! preset, plus the work offset and the tool offset. *Invariant:* values are in the unit of the machine, in the order
//! of [`AXES`].

use counterpoint_fault as diag;

use super::block::{AXES, BlockWords};
use super::codes::spelled;
use super::system::{SYSTEMS, axis, by_axis, by_letter};
use super::text::Rs274Mistake;
use super::{Outcome, Rs274};
use counterpoint_control_api::host::{AxisPlace, InterpreterHost};
use counterpoint_control_api::numeric::{cosine, sine};

/// Number of the tool offset that the program itself sets (G43.1, G43.2).
pub(super) const OWN_LENGTH: u32 = 999_998;

/// Number of the radius that the program itself sets (G41.1, G42.1).
pub(super) const OWN_RADIUS: u32 = 999_999;

/// One value for each axis letter.
pub(super) type Letters = [f64; 9];

/// Presets and stored positions.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Rs274Offsets {
    pub(super) g92: Letters,
    /// The preset is active.
    pub(super) applied: bool,
    /// Positions that G28.1 and G30.1 have stored.
    pub(super) stored: [Letters; 2],
}

/// Rotates X and Y by an angle.
fn turned(mut values: Letters, degrees: f64) -> Letters {
    if degrees != 0.0
        && let [x, y, ..] = &mut values
    {
        let (sin, cos) = (sine(degrees), cosine(degrees));
        (*x, *y) = (*x * cos - *y * sin, *x * sin + *y * cos);
    }
    values
}

fn sum(left: Letters, right: Letters) -> Letters {
    std::array::from_fn(|at| left.get(at).unwrap_or(&0.0) + right.get(at).unwrap_or(&0.0))
}

fn difference(left: Letters, right: Letters) -> Letters {
    std::array::from_fn(|at| left.get(at).unwrap_or(&0.0) - right.get(at).unwrap_or(&0.0))
}

fn refused(text: impl Into<String>) -> Rs274Mistake {
    Rs274Mistake::new(&diag::REFUSED, 20, text)
}

impl Rs274 {
    /// Angle by which a work offset rotates X and Y.
    pub(super) fn rotation(&self, host: &dyn InterpreterHost, system: u32) -> f64 {
        host.offset_turn(system).map_or(0.0, |turn| {
            let [cos, _, _, sin, ..] = turn;
            libm::atan2(sin, cos).to_degrees()
        })
    }

    /// The active tool offset.
    pub(super) fn tool_offset_in_force(&self, host: &dyn InterpreterHost, places: &[AxisPlace]) -> Letters {
        by_letter(places, &host.length_in_force(), host.length_factor())
    }

    fn g92_in_force(&self) -> Letters {
        if self.offsets.applied { self.offsets.g92 } else { Letters::default() }
    }

    /// The programmed point that corresponds to a machine point.
    pub(super) fn point_of_machine(&self, host: &dyn InterpreterHost, machine: Letters) -> Letters {
        let (places, factor, system) = (host.axes(), host.length_factor(), host.work_offset().max(1));
        let origin = by_letter(&places, &host.offset(system), factor);
        let tool = self.tool_offset_in_force(host, &places);
        let turned = turned(difference(difference(machine, tool), origin), -self.rotation(host, system));
        difference(turned, self.g92_in_force())
    }

    /// Activates the preset in the direction of the active work offset.
    pub(super) fn apply_preset(&mut self, host: &mut dyn InterpreterHost) {
        let angle = self.rotation(host, host.work_offset().max(1));
        let places = host.axes();
        let values = by_axis(&places, &turned(self.g92_in_force(), angle), host.length_factor());
        host.set_preset(&values);
    }

    /// Whether a change of the work offset changes the direction of the preset.
    pub(super) fn preset_turns(&self, host: &dyn InterpreterHost) -> bool {
        self.g92_in_force() != Letters::default() && (1..=SYSTEMS).any(|system| self.rotation(host, system) != 0.0)
    }

    /// Sets a value of a work offset.
    pub(super) fn set_offset_value(&mut self, host: &mut dyn InterpreterHost, system: u32, at: usize, value: f64) {
        if at == AXES.len() {
            self.turn_offset(host, system, value);
            return;
        }
        let places = host.axes();
        let factor = host.length_factor();
        let mut values = by_letter(&places, &host.offset(system), factor);
        if let Some(slot) = values.get_mut(at) {
            *slot = value;
        }
        host.set_offset(system, &by_axis(&places, &values, factor));
    }

    fn turn_offset(&mut self, host: &mut dyn InterpreterHost, system: u32, degrees: f64) {
        let (sin, cos) = (sine(degrees), cosine(degrees));
        let turn = (degrees != 0.0).then_some([cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0]);
        host.turn_offset(system, turn);
        if system == host.work_offset().max(1) {
            self.apply_preset(host);
        }
    }

    /// Axis words of a block in the unit of the machine; `None` for an axis without a word.
    fn axis_words(
        &self,
        host: &dyn InterpreterHost,
        places: &[AxisPlace],
        block: &BlockWords,
    ) -> Outcome<[Option<f64>; 9]> {
        let factor = host.length_factor();
        let mut words = [None; 9];
        for ((at, letter), slot) in AXES.iter().enumerate().zip(&mut words) {
            let Some(value) = block.get(*letter) else { continue };
            let Some(place) = axis(places, at) else { return Err(no_axis(*letter).into()) };
            *slot = Some(if place.turns { value } else { value * factor });
        }
        Ok(words)
    }

    /// Executes the code of a block that takes axis words without moving; whether there was one.
    pub(super) fn statement(&mut self, host: &mut dyn InterpreterHost, block: &BlockWords) -> Outcome<()> {
        let places = host.axes();
        let factor = host.length_factor();
        let point = |value: fn(&AxisPlace) -> f64| {
            let values: Vec<f64> = places.iter().map(value).collect();
            by_letter(&places, &values, factor)
        };
        let (work, machine) = (point(|place| place.work), point(|place| place.machine));
        let given = self.axis_words(host, &places, block)?;
        let chosen = |before: Letters| -> Letters {
            std::array::from_fn(|at| given.get(at).copied().flatten().or(before.get(at).copied()).unwrap_or(0.0))
        };
        for (code, _) in &block.g {
            match code {
                100 => self.set_data(host, block, (work, machine, &given))?,
                281 => self.offsets.stored[0] = machine,
                301 => self.offsets.stored[1] = machine,
                520 | 920..=923 if host.keeps_moves_back() => {
                    let text =
                        format!("{} is not possible under cutter compensation: write G40 before", spelled(*code));
                    return Err(refused(text).into());
                }
                520 => {
                    self.offsets.g92 = chosen(self.g92_in_force());
                    self.offsets.applied = true;
                    self.apply_preset(host);
                }
                920 => {
                    // The axes do not move: the current point gets new coordinates.
                    let before = self.g92_in_force();
                    self.offsets.g92 = difference(sum(before, work), chosen(work));
                    self.offsets.applied = true;
                    self.apply_preset(host);
                }
                921 | 922 => {
                    if *code == 921 {
                        self.offsets.g92 = Letters::default();
                    }
                    self.offsets.applied = false;
                    self.apply_preset(host);
                }
                923 => {
                    self.offsets.applied = true;
                    self.apply_preset(host);
                }
                _ => {}
            }
        }
        host.effect();
        Ok(())
    }

    /// G10.
    fn set_data(
        &mut self,
        host: &mut dyn InterpreterHost,
        block: &BlockWords,
        (work, machine, given): (Letters, Letters, &[Option<f64>; 9]),
    ) -> Outcome<()> {
        let kind = block.get(b'l').unwrap_or(-1.0);
        if kind == 0.0 && self.kind.has_language() {
            return Ok(());
        }
        let Some(number) = block.get(b'p') else {
            return Err(Rs274Mistake { error: 28, ..refused("G10 needs P") }.into());
        };
        match kind {
            2.0 | 20.0 => self.set_work_offset(host, block, (kind == 20.0, number), (work, machine, given)),
            1.0 | 10.0 | 11.0 if self.kind.has_language() => {
                if block.has(b'i') || block.has(b'j') {
                    return Err(refused("I and J of a tool are its angles, which this machine does not have").into());
                }
                self.set_tool(host, block, (kind, number), (work, machine, given))
            }
            _ if !self.kind.has_language() => Err(refused("L of G10 is 2 or 20").into()),
            _ => Err(refused("L of G10 is 0, 1, 2, 10, 11 or 20").into()),
        }
    }

    fn set_work_offset(
        &mut self,
        host: &mut dyn InterpreterHost,
        block: &BlockWords,
        (here, number): (bool, f64),
        (_, machine, given): (Letters, Letters, &[Option<f64>; 9]),
    ) -> Outcome<()> {
        let most = if !self.kind.has_language() { 6.0 } else { 9.0 };
        if number.fract() != 0.0 || !(0.0..=most).contains(&number) {
            let error = if number > most { 29 } else { 20 };
            return Err(Rs274Mistake { error, ..refused(format!("P of G10 is 0 to {most}")) }.into());
        }
        if self.kind.is_firmware() && block.has(b'r') {
            return Err(Rs274Mistake { error: 20, ..refused("R of G10 is not possible on this control") }.into());
        }
        let system = if number == 0.0 { host.work_offset().max(1) } else { number as u32 };
        let (places, factor) = (host.axes(), host.length_factor());
        if let Some(angle) = block.get(b'r') {
            self.turn_offset(host, system, angle);
        }
        let mut origin = by_letter(&places, &host.offset(system), factor);
        if here {
            let angle = self.rotation(host, system);
            let tool = self.tool_offset_in_force(host, &places);
            let now = turned(difference(difference(machine, tool), origin), -angle);
            let now = difference(now, self.g92_in_force());
            let wanted: Letters = std::array::from_fn(|at| {
                let now = now.get(at).copied().unwrap_or(0.0);
                given.get(at).copied().flatten().map_or(0.0, |wanted| now - wanted)
            });
            origin = sum(origin, turned(wanted, angle));
        } else {
            for (slot, given) in origin.iter_mut().zip(given) {
                *slot = given.unwrap_or(*slot);
            }
        }
        host.set_offset(system, &by_axis(&places, &origin, factor));
        Ok(())
    }

    fn set_tool(
        &mut self,
        host: &mut dyn InterpreterHost,
        block: &BlockWords,
        (kind, number): (f64, f64),
        (work, machine, given): (Letters, Letters, &[Option<f64>; 9]),
    ) -> Outcome<()> {
        if number.fract() != 0.0 || !(1.0..100_000.0).contains(&number) {
            return Err(refused("P of G10 is the number of a tool, from 1 on").into());
        }
        if host.keeps_moves_back() {
            return Err(refused("G10 is not possible under cutter compensation: write G40 before").into());
        }
        let tool = number as u32;
        let (places, factor) = (host.axes(), host.length_factor());
        let mut values = by_letter(&places, &host.tool_offset(tool), factor);
        let frame = |system: u32, preset: Letters, point: Letters| {
            let origin = by_letter(&places, &host.offset(system), factor);
            sum(turned(sum(point, preset), self.rotation(host, system)), origin)
        };
        let point: Letters =
            std::array::from_fn(|at| given.get(at).copied().flatten().or(work.get(at).copied()).unwrap_or_default());
        let without = match kind {
            10.0 => frame(host.work_offset().max(1), self.g92_in_force(), point),
            11.0 => frame(SYSTEMS, Letters::default(), point),
            _ => Letters::default(),
        };
        for (at, slot) in values.iter_mut().enumerate() {
            let Some(given) = given.get(at).copied().flatten() else { continue };
            let here = machine.get(at).copied().unwrap_or(0.0) - without.get(at).copied().unwrap_or(0.0);
            *slot = if kind == 1.0 { given } else { here };
        }
        host.set_tool_offset(tool, &by_axis(&places, &values, factor));
        if let Some(radius) = block.get(b'r') {
            host.set_tool_size(tool, 1, radius * factor);
        }
        if let Some(tip) = block.get(b'q') {
            host.set_tip(tool, tip);
        }
        Ok(())
    }

    /// Sets the tool offset of G43.1 or G43.2 and returns its number.
    pub(super) fn own_length(
        &mut self,
        host: &mut dyn InterpreterHost,
        block: &BlockWords,
        adds: bool,
    ) -> Outcome<u32> {
        let (places, factor) = (host.axes(), host.length_factor());
        let given = self.axis_words(host, &places, block)?;
        let mut values = self.tool_offset_in_force(host, &places);
        match block.get(b'h') {
            Some(_) if block.has_axes() => return Err(refused("G43.2 has H and axis words: remove one of them").into()),
            Some(number) => {
                let more = by_letter(&places, &host.tool_offset(number.max(0.0) as u32), factor);
                values = sum(values, more);
            }
            None if adds && !block.has_axes() => return Err(refused("G43.2 needs H or axis words").into()),
            None => {
                for (slot, given) in values.iter_mut().zip(given) {
                    *slot = given.map_or(*slot, |given| if adds { *slot + given } else { given });
                }
            }
        }
        if !self.kind.has_language() && given.iter().enumerate().any(|(at, value)| value.is_some() && at != 2) {
            return Err(Rs274Mistake { error: 37, ..refused("G43.1 has Z only on this control") }.into());
        }
        host.set_tool_offset(OWN_LENGTH, &by_axis(&places, &values, factor));
        Ok(OWN_LENGTH)
    }
}

/// The mistake of a word for an axis that the machine does not have.
pub(super) fn no_axis(letter: u8) -> Rs274Mistake {
    let name = char::from(letter.to_ascii_uppercase());
    Rs274Mistake::new(&diag::UNKNOWN_TEXT, 20, format!("this machine has no axis {name}: remove the word"))
}
