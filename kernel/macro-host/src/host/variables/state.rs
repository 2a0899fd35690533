//! Variables of feeds, modes, tools, operations and times.

use counterpoint_channel::macro_queries::activate_code;
use counterpoint_channel::macros::books::operations::set_operation_value;
use counterpoint_channel::macros::books::travel::RangeEnd;
use counterpoint_channel::macros::runtime::Runtime;
use counterpoint_channel::macros::store::names;
use counterpoint_channel::modal::{feed_of, group};
use counterpoint_emulator::channel::Kernel;
use counterpoint_event::event::FeedUnit;
use counterpoint_lang::diag::DiagnosticNumber;
use counterpoint_lang::fault::{MacroFault, Outcome};
use counterpoint_lang::value::MacroValue;
use counterpoint_machine::ident::{CodeId, codes};

use super::{Read, Write, positions};
use crate::context::KernelHost;

fn number(value: impl Into<f64>) -> MacroValue {
    MacroValue::Real(value.into())
}

/// Number of the active code of a group in a list; `none` without one.
fn of_group(kernel: &Kernel<'_>, group: u16, list: &[(CodeId, f64)], none: f64) -> MacroValue {
    let active = kernel.channel.state.modal.code(group);
    let found = list.iter().find(|(code, _)| Some(*code) == active);
    MacroValue::Real(found.map_or(none, |(_, number)| *number))
}

const DIAMETER: [(CodeId, f64); 3] =
    [(codes::COMP_DIAM_LEFT, -1.0), (codes::COMP_DIAM_OFF, 0.0), (codes::COMP_DIAM_RIGHT, 1.0)];
/// `$HEAD`: the active code of heads, or the head that its word has named.
fn head(kernel: &Kernel<'_>, _: &[i64]) -> MacroValue {
    let word = match (kernel.channel.state.modal.code(group::HEAD), kernel.channel.state.others.head) {
        (Some(codes::HEAD_MAIN), _) => "MAIN",
        (Some(codes::HEAD_SIDE), _) | (_, 2) => "SIDE",
        (_, 3) => "RIGHT",
        _ => "MAIN",
    };
    counterpoint_lang::ident::minor_code(word).map_or(MacroValue::Null, MacroValue::Keyword)
}

const PLANES: [(CodeId, f64); 3] = [(codes::PLANE_XY, 1.0), (codes::PLANE_ZX, 2.0), (codes::PLANE_YZ, 3.0)];
const POSITIONING: [(CodeId, f64); 2] = [(codes::POSITION_ABSOLUTE, 0.0), (codes::POSITION_RELATIVE, 1.0)];

/// Makes the code of a number active.
fn set_group(kernel: &mut Kernel<'_>, list: &[(CodeId, f64)], value: &MacroValue) -> Outcome<()> {
    let wanted = value.as_real();
    match list.iter().find(|(_, number)| Some(*number) == wanted) {
        Some((code, _)) => {
            activate_code(&mut kernel.channel, *code);
            Ok(())
        }
        None => Err(MacroFault::new(DiagnosticNumber::BAD_VALUE, "unknown mode number")),
    }
}

/// `$DCOMP`: the code becomes active, and the path follows it.
fn switch_diameter(kernel: &mut Kernel<'_>, value: &MacroValue) -> Outcome<()> {
    set_group(kernel, &DIAMETER, value)?;
    kernel.switch_compensation();
    Ok(())
}

/// `$XDIAM`: X is programmed as a diameter.
fn reads_diameters(kernel: &Kernel<'_>) -> bool {
    match kernel.channel.state.modal.code(group::DIAMETER_X) {
        Some(codes::XAXIS_DIAMETER) => true,
        Some(codes::XAXIS_RADIUS) => false,
        _ => kernel.channel.state.place.scale_of(0) < 1.0,
    }
}

fn switch_diameter_x(kernel: &mut Kernel<'_>, _: &[i64], value: &MacroValue) -> Outcome<()> {
    let wanted = value.as_logical() == Some(true);
    if wanted != reads_diameters(kernel) {
        activate_code(&mut kernel.channel, if wanted { codes::XAXIS_DIAMETER } else { codes::XAXIS_RADIUS });
        if wanted != reads_diameters(kernel) {
            return Err(MacroFault::new(DiagnosticNumber::BAD_VALUE, "the machine has no code for this"));
        }
    }
    Ok(())
}

fn feed(kernel: &Kernel<'_>, _: &[i64]) -> MacroValue {
    let (id, _) = feed_of(kernel.channel.state.modal.code(group::FEED));
    number(kernel.channel.state.remembered.value(id).unwrap_or(0.0))
}

fn set_feed(kernel: &mut Kernel<'_>, _: &[i64], value: &MacroValue) -> Outcome<()> {
    let (id, _) = feed_of(kernel.channel.state.modal.code(group::FEED));
    kernel.channel.state.remembered.remember(id, value.as_real().unwrap_or(0.0));
    Ok(())
}

fn time<const RAPID: bool>(kernel: &Kernel<'_>, _: &[i64]) -> MacroValue {
    number(kernel.channel.state.times.motion(RAPID))
}

fn set_time<const RAPID: bool>(kernel: &mut Kernel<'_>, _: &[i64], value: &MacroValue) -> Outcome<()> {
    kernel.channel.state.times.set_motion(RAPID, value.as_real().unwrap_or(0.0));
    Ok(())
}

/// `$TLSUM` or `$OPSUM`.
fn sum<const OF_TOOLS: bool>(kernel: &Kernel<'_>, at: &[i64]) -> MacroValue {
    let (column, row) = (at.first().copied().unwrap_or(0), at.get(1).copied().unwrap_or(0));
    let row = if OF_TOOLS { kernel.macros.tools.kept_row(row) } else { row };
    MacroValue::Real(kernel.channel.state.times.sum_value(OF_TOOLS, kernel.channel.now(), (column, row)))
}

/// State of a rule of the tape editor, counted from 1.
fn rule(kernel: &Kernel<'_>, at: &[i64]) -> Option<usize> {
    let at = at.first().and_then(|at| usize::try_from(*at).ok())?.checked_sub(1)?;
    (at < kernel.channel.env.machine.tape_editor.len()).then_some(at)
}

fn whole(value: &MacroValue) -> u32 {
    value.as_real().map_or(0, |n| n.clamp(0.0, f64::from(u32::MAX)) as u32)
}

/// A number that is kept.
fn kept(kernel: &Kernel<'_>, index: u32) -> Option<f64> {
    kernel.macros.variables.store.get(index).as_real()
}

/// An end of the travel of tools or operations.
fn travel<const TOOLS: bool>(end: RangeEnd) -> (Read, Option<Write>) {
    match end {
        RangeEnd::Low => (
            |k, at| k.macros.books.travel_value(&k.macros.tools, TOOLS, RangeEnd::Low, at),
            Some(|k, at, value| {
                let Runtime { tools, books, .. } = &mut *k.macros;
                books.set_travel_value(tools, TOOLS, RangeEnd::Low, (at, value));
                Ok(())
            }),
        ),
        RangeEnd::High => (
            |k, at| k.macros.books.travel_value(&k.macros.tools, TOOLS, RangeEnd::High, at),
            Some(|k, at, value| {
                let Runtime { tools, books, .. } = &mut *k.macros;
                books.set_travel_value(tools, TOOLS, RangeEnd::High, (at, value));
                Ok(())
            }),
        ),
    }
}

/// How a variable is read and written.
pub(crate) fn find(name: &str) -> Option<(Read, Option<Write>)> {
    let row: (Read, Option<Write>) = match name {
        "$F" => (feed, Some(set_feed)),
        "$FMODE" => (
            |k, _| {
                let mode = k.channel.state.modal.code(group::FEED);
                number(match (mode, feed_of(mode).1) {
                    (None, _) => -1.0,
                    (_, FeedUnit::PerRevolution) => 1.0,
                    (_, FeedUnit::InverseTime) => 2.0,
                    _ => 0.0,
                })
            },
            None,
        ),
        "$XDIAM" => (|k, _| MacroValue::Logical(reads_diameters(k)), Some(switch_diameter_x)),
        "$DCOMP" => {
            (|k, _| of_group(k, group::DIAMETER, &DIAMETER, 0.0), Some(|k, _, value| switch_diameter(k, value)))
        }
        "$HEAD" => (head, None),
        "$AXES" => (|k, _| MacroValue::text(positions::axes_text(&k.channel.state.place)), None),
        "$RAPID" => (
            |k, _| MacroValue::Logical(k.channel.state.modal.code(group::MOTION) == Some(codes::RAPID)),
            Some(|k, _, value| {
                let rapid = value.as_logical() == Some(true);
                activate_code(&mut k.channel, if rapid { codes::RAPID } else { codes::INTERP_LINEAR });
                Ok(())
            }),
        ),
        "$SKIPERR" => (|k, _| number(k.channel.state.skip.result), None),
        "$SKIPCOD" => (
            |k, _| {
                let active = k.channel.state.modal.code(group::MOTION) == Some(codes::INTERP_SKIP)
                    || k.channel.state.skip.acts(k.channel.at.blocks);
                number(u8::from(active))
            },
            Some(|k, _, value| {
                let probing = k.channel.state.modal.code(group::MOTION) == Some(codes::INTERP_SKIP);
                match (value.as_real() == Some(1.0), probing) {
                    (true, false) => activate_code(&mut k.channel, codes::INTERP_SKIP),
                    (false, true) => activate_code(&mut k.channel, codes::INTERP_LINEAR),
                    _ => None,
                };
                Ok(())
            }),
        ),
        "$PLMODE" => (|k, _| of_group(k, group::PLANE, &PLANES, 0.0), Some(|k, _, value| set_group(k, &PLANES, value))),
        "$PNMODE" => (
            |k, _| of_group(k, group::POSITION, &POSITIONING, -1.0),
            Some(|k, _, value| set_group(k, &POSITIONING, value)),
        ),
        "$T" => (
            |k, _| number(k.channel.state.place.tools.current),
            Some(|k, _, value| {
                k.channel.state.place.tools.current = whole(value);
                Ok(())
            }),
        ),
        "$TP" => (|k, _| number(k.channel.state.place.tools.current), None),
        "$NT" | "$TS" => (
            |k, _| number(k.channel.state.place.tools.selected),
            Some(|k, _, value| {
                k.channel.state.place.tools.selected = whole(value);
                Ok(())
            }),
        ),
        "$FEDTIM" => (time::<false>, Some(set_time::<false>)),
        "$RAPTIM" => (time::<true>, Some(set_time::<true>)),
        "$MISTIM" => (
            |k, _| MacroValue::Real(k.channel.state.times.other(k.channel.now())),
            Some(|k, _, value| {
                let clock = k.channel.now();
                k.channel.state.times.set_other(clock, value.as_real().unwrap_or(0.0));
                Ok(())
            }),
        ),
        "$IDLTIM" => (
            |k, _| MacroValue::Real(k.channel.state.times.waiting()),
            Some(|k, _, value| {
                k.channel.state.times.set_waiting(value.as_real().unwrap_or(0.0));
                Ok(())
            }),
        ),
        "$EDTMAX" => (|k, _| number(k.channel.env.machine.tape_editor.len() as u32), None),
        "$EDTSTA" => (
            |k, at| MacroValue::Logical(rule(k, at).is_some_and(|at| k.channel.text.tape.0.has(at))),
            Some(|k, at, value| {
                let Some(at) = rule(k, at) else {
                    let most = k.channel.env.machine.tape_editor.len();
                    let text = format!("the index of $EDTSTA is not in 1 to {most}, the rules of the tape editor");
                    return Err(MacroFault::new(DiagnosticNumber::OUT_OF_RANGE, text));
                };
                k.channel.text.tape.0.set(at, value.as_logical().unwrap_or(true));
                Ok(())
            }),
        ),
        "$OPNAME" => (
            |k, _| MacroValue::text(k.macros.variables.store.text(names().operation_name)),
            Some(|k, _, value| {
                let name = value.as_text().unwrap_or("").to_owned();
                let Runtime { books, variables, .. } = &mut *k.macros;
                books.name_operation(&mut k.channel, &variables.store, &name);
                KernelHost::new(k).store(names().operation_name, || MacroValue::text(name));
                Ok(())
            }),
        ),
        "$OI" | "$OPSIZ" => (|k, _| number(k.macros.books.operation_row() as u32), None),
        "$FOI" => (
            |k, _| number(k.macros.books.first_operation() as u32),
            Some(|k, _, value| {
                k.macros.books.set_first_operation(value.as_real().unwrap_or(0.0));
                Ok(())
            }),
        ),
        "$OPTAB" => (
            |k, at| {
                let Runtime { tools, books, variables, .. } = &*k.macros;
                books.operation_value(tools, &variables.store, k.channel.now(), at)
            },
            Some(|k, at, value| set_operation_value(&mut k.macros.variables.store, at, value)),
        ),
        "$TLMIN" => travel::<true>(RangeEnd::Low),
        "$TLMAX" => travel::<true>(RangeEnd::High),
        "$OPMIN" => travel::<false>(RangeEnd::Low),
        "$OPMAX" => travel::<false>(RangeEnd::High),
        "$TLTAB" => (
            |k, at| k.macros.tools.value(&k.macros.variables.store, at),
            Some(|k, at, value| {
                let Runtime { tools, variables, .. } = &mut *k.macros;
                tools.set_value(&mut variables.store, at, value)
            }),
        ),
        "$TI" => (|k, _| number(kept(k, names().tool_row).map_or(1.0, |row| k.macros.tools.seen_row(row))), None),
        "$TLSORT" => (
            |k, _| number(kept(k, names().tool_sort).unwrap_or(0.0)),
            Some(|k, _, value| {
                KernelHost::new(k).store(names().tool_sort, || value.clone());
                let Runtime { tools, variables, .. } = &mut *k.macros;
                tools.sort(&variables.store);
                Ok(())
            }),
        ),
        "$TLSUM" => (sum::<true>, None),
        "$OPSUM" => (sum::<false>, None),
        "$VMTIME" => (|k, _| MacroValue::Real(k.channel.now() as f64 / 1e9), None),
        _ => return None,
    };
    Some(row)
}
