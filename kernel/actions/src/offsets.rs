//! Offsets that the program itself sets.
//!
//! Facts: general CNC practice (Fanuc G10); the annex of the emulated system has no identifier for it. *Invariant:* an
//! offset that cannot be kept is reported and nothing changes; the machine does not move.

use std::borrow::Cow;

use crate::context::{ActionContext, StraightSteps};
use crate::entry::{ActionEntry, CompensationEffect};
use counterpoint_channel::modal::group;
use counterpoint_channel::offset_tables::{EXTENDED, OffsetTable, Radii};
use counterpoint_event::event::Kind;
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::{codes, data};
use counterpoint_machine::index::BySlot;

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] =
    &[ActionEntry::of(&[codes::OFFSET_SET], |act, _, _| set(act)).contour(CompensationEffect::Waits)];

/// The set value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum OffsetTarget {
    /// Values of all axes.
    Axes(OffsetTable, u32),
    /// A length along Z.
    Length(OffsetTable, u32),
    Radius(Radii, u32),
    /// Values of the axes and the radius of a turning tool.
    Tool(OffsetTable, Radii, u32),
}

/// Geometry of turning tools: their numbers are above this one.
const GEOMETRY: u32 = 10_000;

/// Highest number of an extended work offset where the machine's tables say none.
const MOST_EXTENDED: u32 = 300;

/// Kinds whose data follow in blocks of their own up to G11: tool life; parameters, pitch errors and parameters of
/// axes.
const DATA_BLOCKS: [f64; 4] = [3.0, 50.0, 51.0, 52.0];

/// Meaning of L and P of G10: L2 work, L20 extended work, L10 length, L11 or L1 its wear, L12 and L13 radius and its
/// wear. For a turning tool L10 is its geometry and L11 or L1 its wear; without L a number above 10,000 is its
/// geometry.
///
/// # Errors
/// There is no such offset; the text says why.
fn meant(
    kind: Option<f64>,
    number: Option<u32>,
    turning: bool,
    most_extended: u32,
) -> Result<OffsetTarget, Cow<'static, str>> {
    let Some(number) = number else { return Err("P is missing or is not a number of an offset".into()) };
    match kind {
        Some(2.0) if number <= EXTENDED => Ok(OffsetTarget::Axes(OffsetTable::Work, number)),
        Some(2.0) => Err("P of L2 is 0 for the external offset or 1 to 6 for G54 to G59".into()),
        Some(20.0) if (1..=most_extended).contains(&number) => {
            Ok(OffsetTarget::Axes(OffsetTable::Work, EXTENDED + number))
        }
        Some(20.0) => Err(format!("P of L20 is 1 to {most_extended}").into()),
        // The shift of the work coordinate system of lathes.
        None if turning && number == 0 => Ok(OffsetTarget::Axes(OffsetTable::Work, 0)),
        _ if number == 0 => Err("P of a tool offset is at least 1".into()),
        Some(10.0) if turning => Ok(OffsetTarget::Tool(OffsetTable::Length, Radii::Cutter, number)),
        Some(1.0 | 11.0) if turning => Ok(OffsetTarget::Tool(OffsetTable::Wear, Radii::Wear, number)),
        Some(10.0) => Ok(OffsetTarget::Length(OffsetTable::Length, number)),
        Some(1.0 | 11.0) => Ok(OffsetTarget::Length(OffsetTable::Wear, number)),
        Some(12.0) => Ok(OffsetTarget::Radius(Radii::Cutter, number)),
        Some(13.0) => Ok(OffsetTarget::Radius(Radii::Wear, number)),
        None if turning && number > GEOMETRY => {
            Ok(OffsetTarget::Tool(OffsetTable::Length, Radii::Cutter, number - GEOMETRY))
        }
        None if turning => Ok(OffsetTarget::Tool(OffsetTable::Wear, Radii::Wear, number)),
        None => Err("L is missing".into()),
        Some(_) => Err("L is not 1, 2, 10, 11, 12, 13 or 20".into()),
    }
}

/// Highest number that the code of an extended work offset may have.
fn most_extended(act: &ActionContext<'_, '_>) -> u32 {
    let machine = &act.channel().env.machine;
    let rows = machine.tables.rows_of_data[data::COMP_EXTFIXT_REG].iter();
    rows.filter_map(|&row| machine.data[row].max)
        .fold(None, |most, max| Some(f64::max(max, most.unwrap_or(max))))
        .map_or(MOST_EXTENDED, |max| max as u32)
}

/// Sets an offset.
pub(crate) fn set(act: &mut ActionContext<'_, '_>) -> Acted {
    let whole = |value: f64| ((0.0..=99_999.0).contains(&value) && value.fract() == 0.0).then_some(value as u32);
    let kind = act.take(data::OFFSET_KIND).map(|datum| datum.value);
    let number = act.take(data::OFFSET_NUMBER).and_then(|datum| whole(datum.value));
    if kind.is_some_and(|kind| DATA_BLOCKS.contains(&kind)) {
        act.pass_data_blocks();
        return Ok(());
    }
    let what = match meant(kind, number, act.channel().is_turning(), most_extended(act)) {
        Ok(what) => what,
        Err(why) => {
            let text = format!("{why}: '{}' sets nothing", act.channel().block_text());
            act.diagnose(&diag::OFFSET_NOT_KEPT, text);
            act.take(data::OFFSET_VALUE);
            act.take(data::OFFSET_TIP);
            act.targets();
            return Ok(());
        }
    };
    let kept = match what {
        OffsetTarget::Axes(table, number) => axes(act, table, number),
        OffsetTarget::Length(table, number) => length(act, table, number),
        OffsetTarget::Radius(table, number) => radius(act, table, number),
        OffsetTarget::Tool(table, radii, number) => {
            axes(act, table, number) && radius(act, radii, number) && tip(act, number)
        }
    };
    let (table, number) = match what {
        OffsetTarget::Axes(_, number) => ("workp", number),
        OffsetTarget::Length(OffsetTable::Wear, number) => ("length wear", number),
        OffsetTarget::Length(_, number) => ("length", number),
        OffsetTarget::Radius(Radii::Wear, number) => ("radius wear", number),
        OffsetTarget::Radius(_, number) => ("radius", number),
        OffsetTarget::Tool(OffsetTable::Wear, _, number) => ("tool wear", number),
        OffsetTarget::Tool(_, _, number) => ("tool", number),
    };
    let text = if kept { format!("set {table} n={number}") } else { format!("set {table} n={number} refused") };
    act.channel_mut().emit(0, Kind::mode(text));
    Ok(())
}

fn is_relative(act: &ActionContext<'_, '_>) -> bool {
    act.channel().state.modal.code(group::POSITION) == Some(codes::POSITION_RELATIVE)
}

fn axes(act: &mut ActionContext<'_, '_>, table: OffsetTable, number: u32) -> bool {
    let mut values = act.channel().offset_values(table, number);
    let relative = is_relative(act);
    for axis in act.channel().state.place.layout.axes.ids() {
        let id = act.channel().state.place.layout.axes[axis].data;
        let Some(datum) = act.take(id).filter(|datum| datum.value.is_finite()) else { continue };
        *values.at_mut(axis) = if relative || datum.incremental { values.at(axis) + datum.value } else { datum.value };
    }
    act.set_offset(table, number, values)
}

fn length(act: &mut ActionContext<'_, '_>, table: OffsetTable, number: u32) -> bool {
    let mut values = act.channel().offset_values(table, number);
    let along = act.channel().state.place.layout.cartesian.get(2).copied().flatten();
    let relative = is_relative(act);
    let Some(value) = act.take(data::OFFSET_VALUE).map(|datum| datum.value) else { return false };
    let Some(axis) = along.filter(|_| value.is_finite()) else { return false };
    *values.at_mut(axis) = if relative { values.at(axis) + value } else { value };
    act.set_offset(table, number, values)
}

/// A missing value changes nothing.
fn radius(act: &mut ActionContext<'_, '_>, table: Radii, number: u32) -> bool {
    let before = act.channel().offset_radius(table, number);
    let relative = is_relative(act);
    match act.take(data::OFFSET_VALUE).map(|datum| datum.value) {
        Some(value) if value.is_finite() => {
            let value = if relative { before + value } else { value };
            act.channel_mut().set_offset_radius(table, number, value)
        }
        Some(_) => false,
        None => true,
    }
}

/// A missing value changes nothing.
fn tip(act: &mut ActionContext<'_, '_>, number: u32) -> bool {
    act.take(data::OFFSET_TIP)
        .is_none_or(|datum| act.channel_mut().state.place.offsets.get_or_insert_default().set_tip(number, datum.value))
}
