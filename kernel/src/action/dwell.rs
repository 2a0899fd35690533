//! Dwells: seconds or spindle revolutions.

use counterpoint_fault::Acted;
use counterpoint_lang::format::wildcard_text;

use super::spindle::Turning;
use crate::channel::Kernel;
use crate::diag;
use crate::log::event::{Dwell, Kind};
use crate::machine::ident::{DataId, data};

/// Dwell in seconds.
pub(super) fn seconds(kernel: &mut Kernel<'_>) -> Acted {
    let Some(seconds) = kernel.take_seconds(data::DELAY) else {
        if kernel.channel.env.machine.habits.dwell.bare {
            return super::mode::exact_stop_block(kernel);
        }
        let text = format!("a dwell needs its time in '{}'", kernel.block_text());
        kernel.diagnose(&diag::DATA_MISSING, text);
        return Ok(());
    };
    dwell(kernel, seconds)
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

impl Kernel<'_> {
    /// Takes a time, seconds. On some controls a decimal point makes seconds of a word in thousandths.
    pub(super) fn take_seconds(&mut self, id: DataId) -> Option<f64> {
        let pointed = self.channel.env.machine.habits.dwell.pointed && self.is_pointed(id);
        self.take(id).map(|datum| if pointed { datum.raw } else { datum.value })
    }

    /// The word that supplies a value is in a smaller unit and has a decimal point.
    fn is_pointed(&self, id: DataId) -> bool {
        let sources = self.plan.data.sources.get(usize::from(id.0)).into_iter().flatten();
        let found = sources.filter_map(|source| Some((source.mul, self.channel.block.look(source.register)?))).next();
        let Some((mul, word)) = found.filter(|(mul, _)| mul.abs() < 1.0) else { return false };
        let text = self.current_text().get(word.start as usize..word.end as usize).unwrap_or_default();
        mul != 0.0 && text.contains(&b'.')
    }
}

fn turns(kernel: &mut Kernel<'_>, revolutions: f64) -> Acted {
    let rpm = match kernel.spindle_speed()? {
        Some(Turning::Fixed(rpm)) => rpm,
        Some(Turning::Surface(surface)) => surface.rpm(kernel.channel.radius(&kernel.channel.state.place.position)),
        None => {
            let text = format!("dwell in revolutions while the spindle stands in '{}'", kernel.block_text());
            kernel.diagnose(&diag::SPINDLE_STANDS, text);
            return Ok(());
        }
    };
    let seconds = revolutions * 60.0 / rpm;
    if seconds > 0.0 {
        kernel.trace_instead(&format!("dwell rev={}", wildcard_text(revolutions)));
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
    let ns = crate::state::channel::nanoseconds(seconds);
    kernel.emit(ns, Kind::Dwell(Dwell));
    kernel.advance(ns);
    Ok(())
}
