//! Variables and functions of offsets.
//!
//! Facts: reference system-variables.md 7, functions.md 12. Radii are those in the offset table of the control; axes
//! are those of `$AXES`, or the sixteen of the axis list.

use counterpoint_lang::diag::DiagnosticNumber;
use counterpoint_lang::fault::{MacroFault, Outcome};
use counterpoint_lang::ident::minor_code;
use counterpoint_lang::value::MacroValue;

use super::{Read, Write};
use crate::context::KernelHost;
use crate::host::variables::positions;
use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::compensation::number_of;
use counterpoint_channel::frames::shift::DIAMETERS;
use counterpoint_channel::modal::group;
use counterpoint_channel::offset_tables::{BASE, OffsetTable, Radii};
use counterpoint_emulator::channel::Kernel;
use counterpoint_machine::ident::{CodeId, codes, data};
use counterpoint_machine::index::{AxisSlot, BySlot};

const FIXTURES: [CodeId; 3] = [codes::COMP_WORKP_ON, codes::COMP_EXTFIXT, codes::COMP_EXTFIXT_RANGE];
const LENGTHS: [CodeId; 5] = [
    codes::COMP_LENGTH_ON,
    codes::COMP_LENGTH_ON_NEG,
    codes::COMP_LENGTH2_ON,
    codes::COMP_LENGTH3_ON,
    codes::COMP_LENGTH4_ON,
];

/// Axes of the long sequences that can be there: linear ones, then tables.
const LETTERS: [char; 9] = ['X', 'Y', 'Z', 'U', 'V', 'W', 'A', 'B', 'C'];

/// Length of a sequence of all axes.
const ALL_AXES: usize = 16;

fn real(value: impl Into<f64>) -> MacroValue {
    MacroValue::Real(value.into())
}

fn has(kernel: &Kernel<'_>, codes: &[CodeId]) -> bool {
    kernel.channel.env.machine.codes.iter().any(|row| codes.contains(&row.id))
}

/// A number of an offset.
fn whole(value: &MacroValue) -> u32 {
    value.as_real().map_or(0, |n| n.clamp(0.0, 999_999.0) as u32)
}

fn only_with(kernel: &Kernel<'_>, codes: &[CodeId]) -> Outcome<()> {
    if has(kernel, codes) {
        return Ok(());
    }
    Err(MacroFault::new(DiagnosticNumber::BAD_VALUE, "this machine does not have that compensation"))
}

/// How a variable is read and written.
pub(crate) fn find(name: &str) -> Option<(Read, Option<Write>)> {
    let row: (Read, Option<Write>) = match name {
        "$TCD" => (
            |k, _| {
                real(if k.channel.is_turning() {
                    k.channel.state.place.in_force.tool_offset
                } else {
                    k.channel.state.remembered.diameter()
                })
            },
            Some(|k, _, value| {
                only_with(k, &DIAMETERS)?;
                let number = whole(value);
                let before = k.channel.state.remembered.diameter();
                k.channel.state.remembered.remember(data::COMP_DIAM, f64::from(number));
                if number != before {
                    k.resize_compensation();
                }
                Ok(())
            }),
        ),
        "$TCDM" => (|k, _| k.channel.diameter_in_force().map_or(real(-1), real), None),
        "$DCOMPM" => (
            |k, _| {
                real(match k.channel.state.modal.code(group::DIAMETER) {
                    Some(codes::COMP_DIAM_LEFT | codes::COMP_DIAM_RIGHT) => 1,
                    Some(codes::COMP_3D_LEFT | codes::COMP_3D_RIGHT) => 3,
                    Some(codes::COMP_3D_VECTOR) => 4,
                    _ => 0,
                })
            },
            None,
        ),
        "$DCORNER" => (
            |k, _| real(k.channel.state.place.compensation.corner),
            Some(|k, _, value| {
                k.channel.state.place.compensation.corner = whole(value).min(2) as u8;
                Ok(())
            }),
        ),
        "$DYNFIX" => (
            |k, _| MacroValue::Logical(k.channel.state.place.compensation.dynamic),
            Some(|k, _, value| {
                k.channel.state.place.compensation.dynamic = value.as_logical().unwrap_or(false);
                Ok(())
            }),
        ),
        "$TCF" => (
            |k, _| real(k.channel.state.place.in_force.work_offset),
            Some(|k, _, value| {
                only_with(k, &FIXTURES)?;
                k.channel.state.place.in_force.work_offset = whole(value);
                k.reframe();
                Ok(())
            }),
        ),
        "$TCFM" => (
            |k, _| {
                if k.channel.state.place.in_force.work_offset == 0 {
                    real(-1)
                } else {
                    real(k.channel.state.place.in_force.work_offset)
                }
            },
            None,
        ),
        "$TCL" => (
            |k, _| {
                real(if k.channel.is_turning() {
                    k.channel.state.place.in_force.tool_offset
                } else {
                    k.channel.state.place.in_force.length_number
                })
            },
            Some(|k, _, value| {
                if k.channel.is_turning() {
                    k.channel.state.place.in_force.tool_offset = whole(value);
                } else {
                    only_with(k, &LENGTHS)?;
                    let in_force = &mut k.channel.state.place.in_force;
                    in_force.set_length(in_force.length_sign, whole(value));
                }
                k.reframe();
                Ok(())
            }),
        ),
        "$TCLM" => (
            |k, _| {
                let on = if k.channel.is_turning() {
                    k.channel.state.place.in_force.tool_offset > 0
                } else {
                    k.channel.state.place.in_force.length_sign != 0.0
                };
                match (on, k.channel.is_turning()) {
                    (false, _) => real(-1),
                    (true, true) => real(k.channel.state.place.in_force.tool_offset),
                    (true, false) => real(k.channel.state.place.in_force.length_number),
                }
            },
            None,
        ),
        "$TCLDIR" => (
            |k, _| real(k.channel.state.place.compensation.direction),
            Some(|k, _, value| {
                k.channel.state.place.compensation.direction = whole(value).min(6) as u8;
                k.reframe();
                Ok(())
            }),
        ),
        "$TCLSET" => (
            |k, _| real(k.channel.state.place.compensation.set),
            Some(|k, _, value| {
                k.channel.state.place.compensation.set = whole(value).clamp(1, 4) as u8;
                Ok(())
            }),
        ),
        _ => return None,
    };
    Some(row)
}

/// Which values of an offset are meant.
enum Which {
    /// The six of `$AXES`.
    Six,
    /// All sixteen.
    All,
    /// One, if the channel has the axis.
    One(Option<AxisSlot>),
}

fn number_argument(arguments: &[MacroValue], at: usize) -> Outcome<u32> {
    match arguments.get(at).and_then(MacroValue::as_real) {
        Some(number) if (0.0..=999_999.0).contains(&number) => Ok(number as u32),
        _ => Err(MacroFault::new(DiagnosticNumber::OUT_OF_RANGE, "the number of an offset is 0 to 999999")),
    }
}

/// Number of an offset: fixtures by primary and secondary number, the others by the second one.
fn offset_number(arguments: &[MacroValue], fixture: bool) -> Outcome<u32> {
    let (first, second) = (number_argument(arguments, 0)?, number_argument(arguments, 1)?);
    Ok(match (fixture, first, second) {
        (true, first, 0) => first,
        (true, first, second) => number_of(first, second),
        (false, 0, 0) => BASE,
        (false, _, second) => second,
    })
}

/// `$FMSSLCV`, `$FMSSFCV`: 1, or 0 if it cannot be kept.
pub(in crate::host) fn write_offset(
    host: &mut KernelHost<'_, '_>,
    table: OffsetTable,
    arguments: &[MacroValue],
) -> Outcome<MacroValue> {
    let number = offset_number(arguments, table == OffsetTable::Work)?;
    let mut values = host.kernel.channel.offset_values(table, number);
    let given = |at: usize| arguments.get(at).and_then(MacroValue::as_real);
    let (axes, numbers): (Vec<Option<AxisSlot>>, Vec<f64>) = match arguments.get(2) {
        Some(MacroValue::Sequence(given)) => {
            let axes = axes_of(&host.kernel.channel, &which(&host.kernel.channel, arguments.get(3))?);
            if given.len() != axes.len() {
                let text = format!("the offset takes {} numbers, not {}", axes.len(), given.len());
                return Err(MacroFault::new(DiagnosticNumber::BAD_VECTOR, text));
            }
            let number = |value: &MacroValue| value.as_real().ok_or_else(|| MacroFault::kind("a number", value));
            (axes, given.iter().map(number).collect::<Outcome<_>>()?)
        }
        _ => match (given(2), given(3), given(4)) {
            (Some(x), Some(y), Some(z)) if table == OffsetTable::Length => {
                (host.kernel.channel.state.place.layout.cartesian.to_vec(), vec![x, y, z])
            }
            (Some(z), None, _) if table == OffsetTable::Length && arguments.len() == 3 => {
                (host.kernel.channel.state.place.layout.cartesian.to_vec(), vec![0.0, 0.0, z])
            }
            (Some(value), ..) if arguments.len() > 3 => {
                (axes_of(&host.kernel.channel, &which(&host.kernel.channel, arguments.get(3))?), vec![value])
            }
            _ => {
                return Err(MacroFault::new(
                    DiagnosticNumber::BAD_VECTOR,
                    "the offset takes a sequence, or a number and its axis",
                ));
            }
        },
    };
    if numbers.iter().any(|number| !number.is_finite()) {
        return Ok(real(0));
    }
    let mut known = false;
    for (axis, number) in axes.into_iter().zip(numbers) {
        if let Some(axis) = axis {
            (*values.at_mut(axis), known) = (number, true);
        }
    }
    Ok(real(u8::from(known && host.kernel.set_offset(table, number, values))))
}

fn which(channel: &ChannelContext<'_>, argument: Option<&MacroValue>) -> Outcome<Which> {
    let axis = |at: usize| {
        LETTERS.get(at).and_then(|letter| channel.state.place.layout.axis_of_letter(channel.env.machine, *letter))
    };
    match argument {
        None => Ok(Which::Six),
        Some(MacroValue::Keyword(code)) => {
            let is = |word: &str| minor_code(word) == Some(*code);
            if is("ALL") {
                return Ok(Which::All);
            }
            let named = LETTERS.iter().position(|letter| is(&format!("{letter}AXIS")));
            if named.is_none() && !["QUILL", "RAM", "ORIENT"].into_iter().any(is) {
                return Err(MacroFault::new(
                    DiagnosticNumber::OUT_OF_RANGE,
                    "an axis is 1 to 16, a keyword of an axis, or ALL",
                ));
            }
            Ok(Which::One(named.and_then(axis)))
        }
        Some(value) => match value.as_real() {
            Some(index) if (1.0..=ALL_AXES as f64).contains(&index) => Ok(Which::One(axis(index as usize - 1))),
            _ => {
                Err(MacroFault::new(DiagnosticNumber::OUT_OF_RANGE, "an axis is 1 to 16, a keyword of an axis, or ALL"))
            }
        },
    }
}

/// Channel axes of a sequence.
fn axes_of(channel: &ChannelContext<'_>, which: &Which) -> Vec<Option<AxisSlot>> {
    match which {
        Which::Six => positions::six_axes(&channel.state.place).to_vec(),
        Which::All => (0..ALL_AXES)
            .map(|at| {
                LETTERS
                    .get(at)
                    .and_then(|letter| channel.state.place.layout.axis_of_letter(channel.env.machine, *letter))
            })
            .collect(),
        Which::One(axis) => vec![*axis],
    }
}

/// `$FMSGLCV`, `$FMSGFCV`.
pub(in crate::host) fn read_offset(
    channel: &ChannelContext<'_>,
    table: OffsetTable,
    arguments: &[MacroValue],
) -> Outcome<MacroValue> {
    let values = channel.offset_values(table, offset_number(arguments, table == OffsetTable::Work)?);
    let which = which(channel, arguments.get(2))?;
    let axes = axes_of(channel, &which);
    let numbers: Vec<f64> = axes.iter().map(|axis| axis.map_or(0.0, |axis| values.at(axis))).collect();
    Ok(match (which, numbers.as_slice()) {
        (Which::One(_), [one, ..]) => MacroValue::Real(*one),
        _ => MacroValue::numbers(&numbers),
    })
}

/// `$FMSGDCV`, `$FMSGRCV`.
pub(in crate::host) fn read_radius(
    channel: &ChannelContext<'_>,
    table: Radii,
    arguments: &[MacroValue],
) -> Outcome<MacroValue> {
    Ok(MacroValue::Real(channel.offset_radius(table, offset_number(arguments, false)?)))
}

/// `$FMSSDCV`, `$FMSSRCV`: 1, or 0 if it cannot be kept.
pub(in crate::host) fn write_radius(
    channel: &mut ChannelContext<'_>,
    table: Radii,
    arguments: &[MacroValue],
) -> Outcome<MacroValue> {
    let number = offset_number(arguments, false)?;
    let value = arguments.get(2).and_then(MacroValue::as_real).filter(|value| value.is_finite());
    let set = value.is_some_and(|value| channel.set_offset_radius(table, number, value));
    let tip = arguments.get(3).and_then(MacroValue::as_real);
    Ok(real(u8::from(
        set && tip.is_none_or(|tip| channel.state.place.offsets.get_or_insert_default().set_tip(number, tip)),
    )))
}
