//! Variables of the program, the subprograms, diagnostics and the definition.

use counterpoint_channel::block_places::neighbour_block;
use counterpoint_channel::macros::store::SystemVariableStore;
use counterpoint_channel::macros::values::code_value;
use counterpoint_channel::text;
use counterpoint_emulator::channel::Kernel;
use counterpoint_emulator::channel::unit_switch::switch_unit;
use counterpoint_event::info::MachineUnit;
use counterpoint_lang::diag::DiagnosticNumber;
use counterpoint_lang::fault::{MacroFault, Outcome};
use counterpoint_lang::value::MacroValue;
use counterpoint_machine::Machine;
use counterpoint_machine::ident::codes;
use counterpoint_machine::model::MachineKind;

use super::{Read, Write};
use crate::context::MacroHooks;

fn number(value: impl Into<f64>) -> MacroValue {
    MacroValue::Real(value.into())
}

fn kept<R>(kernel: &Kernel<'_>, read: impl FnOnce(&SystemVariableStore) -> R) -> R {
    read(&kernel.macros.variables.store)
}

fn keep(kernel: &mut Kernel<'_>, write: impl FnOnce(&mut SystemVariableStore)) -> Outcome<()> {
    write(&mut kernel.macros.variables.store);
    Ok(())
}

/// Counter of a class of severity.
fn count<const CLASS: usize>(kernel: &Kernel<'_>, _: &[i64]) -> MacroValue {
    MacroValue::Real(kept(kernel, |store| store.counts.get(CLASS).copied()).unwrap_or(0.0))
}

fn set_count<const CLASS: usize>(kernel: &mut Kernel<'_>, _: &[i64], value: &MacroValue) -> Outcome<()> {
    let value = value.as_real().unwrap_or(0.0);
    keep(kernel, |store| {
        if let Some(count) = store.counts.get_mut(CLASS) {
            *count = value;
        }
    })
}

/// The block before or after the current one.
fn neighbour(kernel: &Kernel<'_>, behind: bool) -> MacroValue {
    MacroValue::text(neighbour_block(&kernel.channel, &kernel.flow, behind).unwrap_or_default())
}

/// The kind of the machine: its type, positioning modes and units.
fn machine_text(kernel: &Kernel<'_>, _: &[i64]) -> MacroValue {
    let machine = kernel.channel.env.machine;
    let kind = match machine.kind {
        MachineKind::Mill => "MILL",
        MachineKind::Lathe => "LATHE",
        MachineKind::MergingLathe => "MERGING LATHE",
        MachineKind::Composite => "COMPOSITE",
    };
    let has = |id| machine.codes.iter().any(|row| row.enable && row.id == id);
    let letters = machine.registers.iter().any(|register| register.second.is_some());
    let incremental = has(codes::POSITION_RELATIVE) || letters;
    let (first, second) = if machine.unit == MachineUnit::Inch { ("INCH", "MM") } else { ("MM", "INCH") };
    let mut text = format!("{kind} ABSOLUTE{}", if incremental { " INCREMENTAL" } else { "" });
    for unit in [Some(first), has(codes::UNITS_SECONDARY).then_some(second)].into_iter().flatten() {
        text.push(' ');
        text.push_str(unit);
    }
    MacroValue::text(text)
}

fn unit(kernel: &Kernel<'_>, secondary: bool) -> MacroValue {
    let inch = (kernel.channel.env.machine.unit == MachineUnit::Inch) != secondary;
    MacroValue::Real(if inch { 1.0 } else { 25.4 })
}

/// Version of the control whose language and variables are emulated, and its level.
const VERSION: (f64, f64) = (26.0, 0.0);

/// Name, number and revision, as a run names the definition.
fn stored_name(machine: &Machine) -> String {
    let number = if machine.number == 0 { String::new() } else { format!(",{}", machine.number) };
    format!("{}{number};{}", machine.name, machine.revision)
}

/// Secondary units in a primary one.
fn per_primary(kernel: &Kernel<'_>) -> f64 {
    if kernel.channel.env.machine.unit == MachineUnit::Inch { 25.4 } else { 1.0 / 25.4 }
}

fn set_unit(kernel: &mut Kernel<'_>, _: &[i64], value: &MacroValue) -> Outcome<()> {
    let inch = match value.as_real() {
        Some(1.0) => true,
        Some(25.4) => false,
        _ => return Err(MacroFault::new(DiagnosticNumber::BAD_VALUE, "$UNIMCH is 1 for inch or 25.4 for millimetre")),
    };
    switch_unit(kernel, inch != (kernel.channel.env.machine.unit == MachineUnit::Inch));
    Ok(())
}

fn levels(kernel: &Kernel<'_>) -> u16 {
    kernel.macros.reading.switched.clone().map_or(kernel.channel.tables.scanner.levels(), |scanner| scanner.levels())
}

/// How a variable is read and written.
pub(crate) fn find(name: &str) -> Option<(Read, Option<Write>)> {
    let row: (Read, Option<Write>) = match name {
        "$CECODE" => (|k, _| code_value(k.channel.context.code), None),
        "$MCD" => (|k, _| MacroValue::text(String::from_utf8_lossy(&text::preprocessed_bytes(&k.channel))), None),
        "$LMCD" => (|k, _| neighbour(k, false), None),
        "$NMCD" => (|k, _| neighbour(k, true), None),
        "$MCDNO" => (
            |k, _| {
                let number_of_read = kept(k, |store| store.number);
                number(if number_of_read > 0 { number_of_read } else { k.channel.at.line })
            },
            None,
        ),
        "$SEQNO" => (
            |k, _| number(k.channel.block.sequence.unwrap_or(0)),
            Some(|k, _, value| {
                let number = value.as_real().filter(|n| (0.0..=f64::from(u32::MAX)).contains(n));
                k.channel.block.sequence = number.map(|n| n as u32);
                Ok(())
            }),
        ),
        "$TAPEN" => {
            (|k, _| MacroValue::text(k.flow.frames.first().map_or("", |f| k.channel.env.info.file_name(f.file))), None)
        }
        "$XMCD" => (
            |k, _| MacroValue::text(text::left_text(&k.channel)),
            Some(|k, _, value| {
                let text = value.as_text().unwrap_or("").to_owned();
                text::set_left(&mut k.channel, text);
                Ok(())
            }),
        ),
        "$OPSKIP" => (|k, _| number(levels(k).count_ones()), None),
        "$OPSKIPL" => (
            |k, at| {
                MacroValue::Logical(at.first().is_some_and(|&level| levels(k) & 1u16.wrapping_shl(level as u32) != 0))
            },
            Some(|k, at, value| {
                if let Some(level) = at.first().and_then(|&level| u8::try_from(level).ok()).filter(|level| *level < 10)
                {
                    MacroHooks::new(k).switch_level(level, value.as_logical().unwrap_or(false));
                }
                Ok(())
            }),
        ),
        "$EMBMAC" => (
            |k, at| {
                let at = at.first().map_or(0, |&at| at as usize - 1);
                MacroValue::text(kept(k, |store| store.embedding.get(at).cloned()).unwrap_or_default())
            },
            Some(|k, at, value| {
                let at = at.first().map_or(0, |&at| at as usize - 1);
                let text = value.as_text().unwrap_or("").trim().to_owned();
                keep(k, |store| {
                    if let Some(slot) = store.embedding.get_mut(at) {
                        *slot = text;
                    }
                })
            }),
        ),
        "$ERRMSG" => (
            |k, _| MacroValue::Logical(kept(k, |store| store.messages)),
            Some(|k, _, value| {
                let on = value.as_logical().unwrap_or(true);
                keep(k, |store| store.messages = on)
            }),
        ),
        "$DIAGLIST" => (
            |k, _| {
                let list = |store: &SystemVariableStore| store.listed.iter().map(|&n| number(n)).collect();
                MacroValue::sequence(kept(k, list))
            },
            Some(|k, _, value| {
                let list = value.as_sequence().unwrap_or(&[]).iter().filter_map(MacroValue::as_real);
                let list: Vec<u32> = list.map(|n| n.max(0.0) as u32).collect();
                keep(k, |store| store.listed = list)
            }),
        ),
        "$MSG00" => (count::<0>, Some(set_count::<0>)),
        "$WRN04" => (count::<1>, Some(set_count::<1>)),
        "$ERR08" => (count::<2>, Some(set_count::<2>)),
        "$FTL16" => (count::<3>, Some(set_count::<3>)),
        "$AUTHOR" => (|k, _| MacroValue::text(k.channel.env.machine.author.as_str()), None),
        "$MACHIN" => (|k, _| MacroValue::text(k.channel.env.machine.name.as_str()), None),
        "$MCHNUM" => (|k, _| number(k.channel.env.machine.number), None),
        "$MCHDSC" => (machine_text, None),
        "$CEDATE" => (|k, _| MacroValue::text(k.channel.env.machine.created.as_str()), None),
        "$DBFILE" => (|k, _| MacroValue::text(k.channel.env.machine.file.as_str()), None),
        // A job knows no clock.
        "$DATE" => (|_, _| MacroValue::text("01-JAN-1970 00:00:00.00"), None),
        "$PREPROC" => (|k, _| MacroValue::text(k.dialect.kind.title().to_ascii_uppercase()), None),
        "$BACK" => (
            |k, _| MacroValue::Logical(k.channel.env.options.answers.is_empty() && !k.channel.env.options.attended),
            None,
        ),
        "$TUDQ" => (
            |k, at| {
                answer(
                    &k.channel.env.machine.habits.texts,
                    at,
                    |text| MacroValue::text(text.as_str()),
                    MacroValue::text(""),
                )
            },
            None,
        ),
        "$IUDQ" => (
            |k, at| {
                answer(
                    &k.channel.env.machine.habits.integers,
                    at,
                    |number| MacroValue::Real(*number),
                    MacroValue::Real(0.0),
                )
            },
            None,
        ),
        "$WUDQ" => (
            |k, at| {
                answer(
                    &k.channel.env.machine.habits.numbers,
                    at,
                    |number| MacroValue::Real(*number),
                    MacroValue::Real(0.0),
                )
            },
            None,
        ),
        "$UNIPRI" => (|k, _| unit(k, false), None),
        "$UNISEC" => (|k, _| unit(k, true), None),
        "$CEFILE" => (|k, _| MacroValue::text(stored_name(k.channel.env.machine)), None),
        "$PVER" => (|_, _| number(VERSION.0), None),
        "$PLEV" => (|_, _| number(VERSION.1), None),
        "$UNITS" => (|k, _| unit(k, k.channel.state.secondary), None),
        "$UNIMCH" => (|k, _| unit(k, k.channel.state.secondary), Some(set_unit)),
        "$PCONFC" => (
            |k, _| number(if k.channel.state.secondary { per_primary(k) } else { 1.0 }),
            Some(|k, _, value| {
                let secondary = value.as_real() != Some(1.0);
                if secondary && value.as_real() != Some(per_primary(k)) {
                    let text = format!("$PCONFC is 1 or {} here", per_primary(k));
                    return Err(MacroFault::new(DiagnosticNumber::BAD_VALUE, text));
                }
                switch_unit(k, secondary);
                Ok(())
            }),
        ),
        "$SUBLVL" => (|k, _| number(k.flow.frames.len().saturating_sub(1) as u32), None),
        "$SUBNAM" => (
            |k, _| {
                let name = k.flow.frames.iter().skip(1).next_back().map_or("", |frame| &*frame.name);
                MacroValue::text(name)
            },
            None,
        ),
        "$SUBNO" | "$SUBSTK" => (
            |k, _| {
                let names = k.flow.frames.iter().skip(1).map(|frame| MacroValue::text(&*frame.name));
                MacroValue::sequence(names.collect())
            },
            None,
        ),
        "$MCECNT" => (|k, _| number(k.channel.env.machine.channels.len() as u32), None),
        "$MFICNT" => {
            (|k, _| number(k.channel.env.info.channels.iter().filter(|c| !c.program.is_empty()).count() as u32), None)
        }
        _ => return None,
    };
    Some(row)
}

/// The answer to a question of the machine's own; one that was not answered is empty.
fn answer<T>(answers: &[T], indices: &[i64], value: impl Fn(&T) -> MacroValue, missing: MacroValue) -> MacroValue {
    let index = indices.first().and_then(|index| usize::try_from(index - 1).ok());
    index.and_then(|index| answers.get(index)).map_or(missing, value)
}
