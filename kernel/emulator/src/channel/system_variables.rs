//! System variables of the machine's rows: their values, and the effect of setting them.
//!
//! Lengths and positions are in the units of the program. An offset that a program sets acts at once, and the machine
//! does not move. Facts: reference fanuc-variables-and-alarms.md 1.3 to 1.6. *Invariant:* reading changes no value;
//! nothing here depends on the clock of the computer.

use counterpoint_channel::addresses::{address_value, length_factor, main_number, tool_axis};
use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::flow::ProgramFlow;
use counterpoint_channel::offset_tables::{BASE, EXTENDED, OffsetTable, Radii};
use counterpoint_control_api::{NotThere, is_vacant};
use counterpoint_event::event::{MAX_AXES, Position};
use counterpoint_machine::ident::codes;
use counterpoint_machine::ident::dimension::Dimension;
use counterpoint_machine::index::BySlot;
use counterpoint_machine::model::RotaryPositioning;
use counterpoint_machine::rows::CodeForm;
use counterpoint_machine::system_variables::{MODAL_CALLS, Means, OffsetColumn, PositionReference};

use super::{Kernel, unit_switch};
use crate::channel::dialect_state::DialectState;

/// Seconds of a day.
const DAY: i64 = 86_400;

/// The millisecond clock starts again from 0 after this value.
const CLOCK_WRAP: f64 = 2_147_483_648.0;

/// Largest value of an offset.
const LARGEST_OFFSET: f64 = 9_999.999_9;

/// Bit of the inch system among the settings.
const INCH: u32 = 4;

impl Kernel<'_> {
    /// Value of a system variable.
    ///
    /// # Errors
    /// The machine does not have it, or the job was stopped.
    pub(super) fn system_variable(&mut self, number: u32) -> Result<f64, NotThere> {
        let variables = &self.channel.env.machine.variables.system;
        let Some((row, at)) = variables.find(number) else { return Err(NotThere::Missing) };
        match &row.means {
            Means::Alias(of) if *of + at < 1000 => self.numbered(of + at),
            // A loop that reads a clock ends without other channels.
            means @ (Means::Milliseconds | Means::Hours | Means::Date | Means::TimeOfDay) => {
                self.flow.pass.effects = true;
                self.channel.come_to_rest();
                shown(&self.channel, &self.flow, &self.dialect, means, number, at).ok_or(NotThere::Missing)
            }
            means => shown(&self.channel, &self.flow, &self.dialect, means, number, at).ok_or(NotThere::Missing),
        }
    }

    /// Sets a system variable.
    ///
    /// # Errors
    /// The machine does not have it, it can only be read, the value is not possible, or the job was stopped.
    pub(super) fn set_system_variable(&mut self, number: u32, value: f64) -> Result<(), NotThere> {
        let variables = &self.channel.env.machine.variables.system;
        let Some((row, at)) = variables.find(number) else { return Err(NotThere::Missing) };
        if let Means::Alias(of) = row.means
            && of + at < 1000
        {
            return self.set_numbered(of + at, value);
        }
        if !row.writable {
            let exists = shown(&self.channel, &self.flow, &self.dialect, &row.means, number, at).is_some();
            return Err(if exists { NotThere::ReadOnly } else { NotThere::Missing });
        }
        self.flow.pass.effects = true;
        if matches!(row.means, Means::Milliseconds | Means::Hours) {
            self.channel.come_to_rest();
        }
        let value = if is_vacant(value) { 0.0 } else { value };
        match &row.means {
            Means::WorkOffset { from, stride } => self.set_work_offset(from + at / stride, at % stride, value),
            Means::WorkOffsetAxis { from, axis } => self.set_work_offset(from + at, u32::from(*axis), value),
            Means::ToolOffset(column, wear) => self.set_tool_offset(*column, *wear, at + 1, value),
            means => {
                self.keep(means, number, value);
                Ok(())
            }
        }
    }

    fn keep(&mut self, means: &Means, number: u32, value: f64) {
        let clock = self.channel.now();
        let kept = &mut self.dialect.variables.system;
        match means {
            Means::Milliseconds => kept.clocks[0] = value - milliseconds(clock),
            Means::Hours => kept.clocks[1] = value - hours(clock),
            // As on the control: 32 bits, of which negative numbers have the highest.
            Means::Bits(of) => {
                let bits = value.clamp(-2_147_483_648.0, 4_294_967_295.0).round() as i64;
                for bit in 0..32 {
                    kept.kept.insert(of + bit, f64::from(u8::from(bits >> bit & 1 != 0)));
                }
            }
            Means::Settings => {
                let bits = value.clamp(0.0, 65_535.0).round() as u32;
                kept.kept.insert(number, f64::from(bits & !INCH));
                let inch = bits & INCH != 0;
                let machine_inch = self.channel.env.machine.unit == counterpoint_event::info::MachineUnit::Inch;
                unit_switch::switch_unit(self, inch != machine_inch);
            }
            Means::Bit(_) => {
                kept.kept.insert(number, f64::from(u8::from(value >= 0.5)));
            }
            _ => {
                kept.kept.insert(number, value);
            }
        }
    }

    fn set_work_offset(&mut self, number: u32, axis: u32, value: f64) -> Result<(), NotThere> {
        let Some(slot) = self.channel.state.place.layout.axes.id(axis as usize) else {
            return Err(NotThere::Missing);
        };
        let mut values = self.channel.offset_values(OffsetTable::Work, number);
        *values.at_mut(slot) = value * length_factor(&self.channel, slot);
        if self.set_offset(OffsetTable::Work, number, values) { Ok(()) } else { Err(NotThere::TooBig) }
    }

    fn set_tool_offset(&mut self, column: OffsetColumn, wear: bool, number: u32, value: f64) -> Result<(), NotThere> {
        if value.abs() > LARGEST_OFFSET {
            return Err(NotThere::TooBig);
        }
        let (table, radii) = tables(wear);
        let length = self.channel.unit_factor(Dimension::Length);
        let done = match column {
            OffsetColumn::Axis(role) => {
                let Some(slot) = tool_axis(&self.channel.state.place, role) else { return Err(NotThere::Missing) };
                let mut values = self.channel.offset_values(table, number);
                *values.at_mut(slot) = value * length;
                self.set_offset(table, number, values)
            }
            OffsetColumn::Radius => self.channel.set_offset_radius(radii, number, value * length),
            OffsetColumn::Diameter => self.channel.set_offset_radius(radii, number, value * length / 2.0),
            OffsetColumn::Tip => self.channel.state.place.offsets.get_or_insert_default().set_tip(number, value),
        };
        if done { Ok(()) } else { Err(NotThere::TooBig) }
    }
}

/// Value that a row shows; none if the channel does not have it.
fn shown(
    channel: &ChannelContext<'_>,
    flow: &ProgramFlow,
    dialect: &DialectState,
    means: &Means,
    number: u32,
    at: u32,
) -> Option<f64> {
    let variables = &channel.env.machine.variables.system;
    let kept = &dialect.variables.system;
    let clock = channel.now();
    Some(match means {
        Means::Kept(first) | Means::Bit(first) => kept.kept(number, *first),
        Means::Bits(of) => {
            let bits = (0..32_u32).filter(|bit| kept.kept(of + bit, 0.0) >= 0.5);
            let sum: u32 = bits.map(|bit| 1 << bit).sum();
            f64::from(sum as i32)
        }
        Means::Alias(_) => return None,
        Means::Milliseconds => (milliseconds(clock) + kept.clocks[0]).rem_euclid(CLOCK_WRAP),
        Means::Hours => hours(clock) + kept.clocks[1],
        Means::Date => f64::from(date(variables.start, clock)),
        Means::TimeOfDay => f64::from(time_of_day(variables.start.1, clock)),
        Means::Settings => {
            let machine_inch = channel.env.machine.unit == counterpoint_event::info::MachineUnit::Inch;
            let inch = machine_inch != channel.state.secondary;
            kept.kept(number, 0.0) + if inch { f64::from(INCH) } else { 0.0 }
        }
        Means::Mirrors => {
            let mirror = channel.state.place.frame_values().mirror;
            let linear: f64 =
                mirror.iter().zip([1.0, 2.0, 4.0]).filter(|(on, _)| **on != 0.0).map(|(_, bit)| bit).sum();
            linear + f64::from(channel.state.place.beside_mirrors())
        }
        Means::MainProgram => f64::from(main_number(channel, flow)),
        Means::Modal(groups) => modal_word(channel, flow, *groups.get(at as usize)?),
        Means::Address(letters) => address_value(channel, flow, *letters.get(at as usize)?),
        Means::Position(frame, axes) => return shown_position(channel, *frame, axes.as_deref(), at as usize),
        Means::WorkOffset { from, stride } => return work_offset_of(channel, from + at / stride, at % stride),
        Means::WorkOffsetAxis { from, axis } => return work_offset_of(channel, from + at, u32::from(*axis)),
        Means::ToolOffset(column, wear) => return tool_offset(channel, *column, *wear, at + 1),
    })
}

/// G number that is active in a group of the kernel.
fn modal_word(channel: &ChannelContext<'_>, flow: &ProgramFlow, (group, idle): (u16, f64)) -> f64 {
    if group == MODAL_CALLS {
        return flow.modal.word().unwrap_or(idle);
    }
    let modal = &channel.state.modal;
    let place = &channel.state.place;
    let Some(code) = modal.code(group).filter(|_| group != 0) else { return idle };
    match code {
        codes::COMP_WORKP_ON | codes::COMP_EXTFIXT if place.in_force.work_offset > EXTENDED => return 54.1,
        codes::COMP_WORKP_ON => return f64::from(place.in_force.work_offset) + 53.0,
        _ => {}
    }
    let machine = channel.env.machine;
    let of_row = modal.row(group).map(|row| &machine.codes[row].form).and_then(|form| match form {
        CodeForm::Register { register, min, .. } | CodeForm::RegisterAsData { register, min, .. }
            if Some(*register) == channel.tables.registers.g =>
        {
            Some(*min)
        }
        _ => None,
    });
    of_row.or_else(|| machine.variables.system.word(code)).unwrap_or(idle)
}

/// A value by axis of the channel, in units of the program; `axes` are the X, Y and Z axes in another order.
fn shown_position(
    channel: &ChannelContext<'_>,
    frame: PositionReference,
    axes: Option<&[u8]>,
    at: usize,
) -> Option<f64> {
    let layout = &channel.state.place.layout;
    let slot = match axes {
        None => layout.axes.id(at)?,
        Some(axes) => layout.cartesian.get(usize::from(*axes.get(at)?)).copied().flatten()?,
    };
    let values = match frame {
        PositionReference::Local => local_shift(channel),
        PositionReference::BlockEnd => channel.state.place.programmed(),
        PositionReference::Machine => channel.state.place.machine_point(&channel.state.place.position),
        PositionReference::Work => sum(channel.state.place.programmed(), channel.tool_shift()),
        PositionReference::Skip => sum(channel.state.skip.end, channel.tool_shift()),
        PositionReference::Tool => channel.tool_shift(),
        PositionReference::Wear => in_force(channel, OffsetTable::Wear),
        PositionReference::Geometry => in_force(channel, OffsetTable::Length),
        PositionReference::Zero => [0.0; MAX_AXES],
    };
    let places = matches!(
        frame,
        PositionReference::BlockEnd | PositionReference::Machine | PositionReference::Work | PositionReference::Skip
    );
    let rolls = channel.env.machine.axes[layout.axes[slot].machine].turn != RotaryPositioning::Position;
    if places && rolls && channel.state.place.polar().is_none() {
        // The control counts the angle alone.
        return Some(values.at(slot).rem_euclid(360.0));
    }
    Some(values.at(slot) / length_factor(channel, slot))
}

fn in_force(channel: &ChannelContext<'_>, table: OffsetTable) -> Position {
    let number = channel.state.place.in_force.tool_offset;
    if number == BASE { [0.0; MAX_AXES] } else { channel.offset_values(table, number) }
}

fn work_offset_of(channel: &ChannelContext<'_>, number: u32, axis: u32) -> Option<f64> {
    let slot = channel.state.place.layout.axes.id(axis as usize)?;
    Some(channel.offset_values(OffsetTable::Work, number).at(slot) / length_factor(channel, slot))
}

fn tool_offset(channel: &ChannelContext<'_>, column: OffsetColumn, wear: bool, number: u32) -> Option<f64> {
    let (table, radii) = tables(wear);
    let length = channel.unit_factor(Dimension::Length);
    match column {
        OffsetColumn::Axis(role) => {
            Some(channel.offset_values(table, number).at(tool_axis(&channel.state.place, role)?) / length)
        }
        OffsetColumn::Radius => Some(channel.offset_radius(radii, number) / length),
        OffsetColumn::Diameter => Some(2.0 * channel.offset_radius(radii, number) / length),
        OffsetColumn::Tip => Some(f64::from(channel.offset_tip(number))),
    }
}

fn tables(wear: bool) -> (OffsetTable, Radii) {
    if wear { (OffsetTable::Wear, Radii::Wear) } else { (OffsetTable::Length, Radii::Cutter) }
}

fn sum(mut values: Position, more: Position) -> Position {
    for (slot, more) in values.iter_mut().zip(more) {
        *slot += more;
    }
    values
}

fn milliseconds(clock: i64) -> f64 {
    (clock / 1_000_000) as f64
}

fn hours(clock: i64) -> f64 {
    clock as f64 / 3.6e12
}

/// Seconds since midnight of the first day.
fn seconds(start: u32, clock: i64) -> i64 {
    let start = i64::from(start);
    start / 10_000 * 3600 + start / 100 % 100 * 60 + start % 100 + clock / 1_000_000_000
}

/// Time of day as hhmmss, by the time at the start of the job and simulated time.
fn time_of_day(start: u32, clock: i64) -> u32 {
    let second = seconds(start, clock).rem_euclid(DAY);
    (second / 3600 * 10_000 + second / 60 % 60 * 100 + second % 60) as u32
}

/// Date as yyyymmdd.
fn date((first, start): (u32, u32), clock: i64) -> u32 {
    let (mut year, mut month, mut day) = (first / 10_000, first / 100 % 100, first % 100);
    let days = seconds(start, clock).div_euclid(DAY).clamp(0, 400);
    for _ in 0..days {
        day += 1;
        if day > month_days(year, month) {
            (day, month) = (1, month + 1);
        }
        if month > 12 {
            (month, year) = (1, year + 1);
        }
    }
    year * 10_000 + month * 100 + day
}

fn month_days(year: u32, month: u32) -> u32 {
    let leap = year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400));
    match month {
        2 if leap => 29,
        2 => 28,
        4 | 6 | 9 | 11 => 30,
        _ => 31,
    }
}

fn local_shift(channel: &ChannelContext<'_>) -> Position {
    let mut values = channel.state.place.beside_shift();
    let shift = channel.state.place.frame_values().translation;
    for (slot, value) in channel.state.place.layout.cartesian.iter().zip(shift) {
        if let Some(slot) = slot {
            *values.at_mut(*slot) = value;
        }
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND: i64 = 1_000_000_000;

    #[test]
    fn date_and_time_follow_simulated_time_across_months_and_years() {
        assert_eq!((date((20_261_122, 80_000), 0), time_of_day(80_000, 0)), (20_261_122, 80_000));
        let night = 235_959;
        assert_eq!(date((20_231_231, night), SECOND), 20_240_101);
        assert_eq!(time_of_day(night, SECOND), 0);
        assert_eq!(date((20_240_228, night), SECOND), 20_240_229);
        assert_eq!(date((20_250_228, night), SECOND), 20_250_301);
        assert_eq!(time_of_day(80_000, 3_661 * SECOND), 90_101);
    }
}
