//! Dwells: seconds or spindle revolutions.

use counterpoint_lang::format::wildcard_text;

use super::spindle::Turning;
use crate::channel::{Acted, Kernel};
use crate::diag;
use crate::log::event::Kind;
use crate::machine::ident::data;
use crate::trace::{self, ACTION};

/// Dwell in seconds.
pub(super) fn seconds(kernel: &mut Kernel<'_>) -> Acted {
    let Some(datum) = kernel.take(data::DELAY) else {
        let text = format!("a dwell needs its time in '{}'", kernel.block_text());
        kernel.diagnose(&diag::DATA_MISSING, text);
        return Ok(());
    };
    dwell(kernel, datum.value)
}

/// Dwell in revolutions of the spindle.
pub(super) fn revolutions(kernel: &mut Kernel<'_>) -> Acted {
    let Some(datum) = kernel.take(data::DELAY_REV) else {
        let text = format!("a dwell needs its revolutions in '{}'", kernel.block_text());
        kernel.diagnose(&diag::DATA_MISSING, text);
        return Ok(());
    };
    turns(kernel, datum.value)
}

fn turns(kernel: &mut Kernel<'_>, revolutions: f64) -> Acted {
    let rpm = match kernel.spindle_speed()? {
        Some(Turning::Fixed(rpm)) => rpm,
        Some(Turning::Surface(surface)) => surface.rpm(kernel.radius(&kernel.place.position)),
        None => {
            let text = format!("dwell in revolutions while the spindle stands in '{}'", kernel.block_text());
            kernel.diagnose(&diag::SPINDLE_STANDS, text);
            return Ok(());
        }
    };
    let seconds = revolutions * 60.0 / rpm;
    if seconds > 0.0 {
        kernel.trace(ACTION, |_| trace::action(&format!("dwell rev={}", wildcard_text(revolutions))));
    }
    dwell(kernel, seconds)
}

/// A dwell of a cycle: positive seconds, negative revolutions, 0 none.
pub(super) fn of_cycle(kernel: &mut Kernel<'_>, amount: f64) -> Acted {
    if amount < 0.0 {
        return turns(kernel, -amount);
    }
    if amount > 0.0 { dwell(kernel, amount) } else { Ok(()) }
}

fn dwell(kernel: &mut Kernel<'_>, seconds: f64) -> Acted {
    if seconds <= 0.0 {
        let text = format!("a dwell of {seconds} s in '{}' takes no time", kernel.block_text());
        kernel.diagnose(&diag::DWELL_NOT_POSITIVE, text);
        return Ok(());
    }
    let ns = Kernel::ns(seconds);
    kernel.emit(ns, Kind::Dwell);
    kernel.advance(ns);
    Ok(())
}
