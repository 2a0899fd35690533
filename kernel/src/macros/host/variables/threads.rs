//! Variables of threads: `$PITCH`, `$E` and the like.
//!
//! Invariant: they are those of the last thread; what a macro sets counts for threads without the word. Facts: reference
//! system-variables.md 9.

use counterpoint_lang::fault::Outcome;
use counterpoint_lang::value::Value;

use super::{Read, Write};
use crate::channel::Kernel;
use crate::machine::ident::{DataId, data};

fn real(value: &Value) -> f64 {
    value.as_real().filter(|value| value.is_finite()).unwrap_or(0.0)
}

fn known(kernel: &Kernel<'_>, id: DataId) -> f64 {
    kernel.modal.value(id).unwrap_or(0.0)
}

fn remember(kernel: &mut Kernel<'_>, id: DataId, value: f64) -> Outcome<()> {
    kernel.modal.remember(id, value);
    Ok(())
}

const PITCH: DataId = data::INTERP_THREAD_PITCH;
const CHANGE: DataId = data::INTERP_THREAD_PITCH_VAR;

/// How a variable is read and written.
pub(super) fn find(name: &str) -> Option<(Read, Option<Write>)> {
    let row: (Read, Option<Write>) = match name {
        "$PITCH" => (|k, _| Value::Real(known(k, PITCH)), Some(|k, _, value| remember(k, PITCH, real(value)))),
        "$PITCHV" => (|k, _| Value::Real(known(k, CHANGE)), Some(|k, _, value| remember(k, CHANGE, real(value)))),
        "$MULTRD" => (
            |k, _| Value::Real(k.threads.starts),
            Some(|k, _, value| {
                let starts = real(value).max(1.0);
                k.threads.starts = starts;
                remember(k, data::INTERP_THREAD_STARTS, starts)
            }),
        ),
        "$E" => (
            |k, _| Value::Real(known(k, PITCH) * k.threads.starts),
            Some(|k, _, value| remember(k, PITCH, real(value) / k.threads.starts)),
        ),
        "$EV" => (
            |k, _| Value::Real(known(k, CHANGE) * k.threads.starts),
            Some(|k, _, value| remember(k, CHANGE, real(value) / k.threads.starts)),
        ),
        _ => return None,
    };
    Some(row)
}
