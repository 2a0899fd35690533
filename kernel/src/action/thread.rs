//! Thread cut in one move: feed locked to the spindle, lead along the longer axis.
//!
//! Facts: reference control-emulator.md 6.1; lead along the axis with the longer travel as on the real control.

use counterpoint_lang::value::Value;

use super::spindle::Turning;
use crate::channel::{Acted, Kernel};
use crate::diag;
use crate::log::event::{FeedUnit, Motion, MotionKind};
use crate::machine::ident::data;
use crate::macros::host::variables::names;

/// Cuts one pass.
pub(super) fn thread(kernel: &mut Kernel<'_>) -> Acted {
    let pitch = match kernel.take(data::INTERP_THREAD_PITCH) {
        Some(datum) => {
            kernel.modal.remember(data::INTERP_THREAD_PITCH, datum.value);
            Some(datum.value)
        }
        None => kernel.modal.value(data::INTERP_THREAD_PITCH),
    };
    kernel.take(data::INTERP_THREAD_ANGLE);
    let starts = kernel.take(data::INTERP_THREAD_STARTS).map(|d| d.value);
    let starts =
        starts.or_else(|| kernel.modal.value(data::INTERP_THREAD_STARTS)).map_or(1.0, |starts| starts.max(1.0));
    kernel.store(names().starts, || Value::Real(starts));
    let (coded, target) = kernel.targets();
    if coded == 0 {
        return Ok(());
    }
    let from = kernel.place.position;
    if target == from {
        return Ok(());
    }
    let lead = pitch.unwrap_or(0.0) * starts;
    let changes = kernel.changes(&from, &target);
    let seconds = if lead > 0.0 {
        match kernel.spindle_speed()? {
            Some(turning) => {
                let rpm = match turning {
                    Turning::Fixed(rpm) => rpm,
                    Turning::Surface(surface) => surface.rpm(kernel.radius(&from)),
                };
                let longest = changes.iter().fold(0.0_f64, |most, c| most.max(c.abs()));
                longest / (lead * rpm) * 60.0
            }
            None => {
                let text =
                    format!("thread while the spindle stands in '{}', the move is timed as rapid", kernel.block_text());
                kernel.diagnose(&diag::SPINDLE_STANDS, text);
                kernel.rapid_seconds(&from, &target)
            }
        }
    } else {
        let text = format!("thread without a lead in '{}', the move is timed as rapid", kernel.block_text());
        kernel.diagnose(&diag::DATA_MISSING, text);
        kernel.rapid_seconds(&from, &target)
    };
    let length = kernel.tool_path(&changes);
    let feed = (lead, FeedUnit::PerRevolution);
    let moving = kernel.moving(coded, &changes);
    kernel.travel(seconds, &Motion::straight(MotionKind::Thread, moving, [from, target], feed, length))?;
    super::cutter::after_thread(kernel);
    Ok(())
}
