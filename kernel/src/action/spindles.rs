//! Which spindle of a channel is in work: the front or the rear one when it turns the part, the milling one when it mills.
//!
//! Facts: reference control-emulator.md 3.2, 6.3, system-variables.md 9. Invariant: the spindle in work is that of
//! `Kernel::spindle`; what the channel has commanded of its other spindles is kept here, unless another channel can
//! command them too.

use crate::channel::Kernel;
use crate::channel::state::{SpindleState, group};
use crate::diag;
use crate::log::event::Kind;
use crate::machine::ident::{CodeId, code_facts, codes, data};
use crate::machine::model::{Channel, Machine};
use crate::multi::shared::Command;
use counterpoint_fault::Acted;

/// Spindles of one channel by index of the machine's list, and what they are in work for.
#[derive(Debug, Default)]
pub(crate) struct State {
    front: Option<usize>,
    rear: Option<usize>,
    mill: Option<usize>,
    /// Commands of spindles that are not in work.
    kept: Vec<Command>,
    /// Milling mode.
    pub(crate) milling: bool,
    /// Head that drives constant surface speed, when a code has said so.
    pub(crate) driver: Option<u16>,
    /// A speed that waits for the next spindle code.
    pub(crate) waiting: Option<f64>,
}

impl State {
    pub(crate) fn new(machine: &Machine, channel: &Channel) -> Self {
        let index = |number: Option<u16>| index_of(machine, number?);
        Self {
            front: index(channel.spindle),
            rear: index(channel.rear),
            mill: index(channel.milling),
            kept: vec![Command::default(); machine.spindles.len()],
            milling: false,
            driver: None,
            waiting: None,
        }
    }
}

fn index_of(machine: &Machine, number: u16) -> Option<usize> {
    machine.spindles.iter().position(|spindle| spindle.number == number)
}

/// Number in the name of a code of a numbered spindle, 1 to 5.
fn numbered(id: CodeId) -> Option<u16> {
    code_facts(id)?.name.strip_prefix("CODE_SPINDLE")?.split_once('_')?.0.parse().ok()
}

/// The machine commands this spindle by codes of its number.
fn has_codes(machine: &Machine, number: u16) -> bool {
    machine.codes.iter().any(|row| row.enable && numbered(row.id) == Some(number))
}

/// More than one channel can command the spindle.
pub(crate) fn is_shared(machine: &Machine, index: usize) -> bool {
    let Some(number) = machine.spindles.get(index).map(|spindle| spindle.number) else { return false };
    let uses = |channel: &&Channel| [channel.spindle, channel.rear, channel.milling].contains(&Some(number));
    let users = machine.channels.iter().filter(uses).count();
    users > 1 || machine.channels.len() > 1 && has_codes(machine, number)
}

/// `CODE_SPINDLE_FRONT`, `CODE_SPINDLE_REAR`: their group says which one it is.
pub(super) fn in_work(kernel: &mut Kernel<'_>, rear: bool) -> Acted {
    if kernel.channel.acting.mode_changed {
        let text = if rear { "spindle rear" } else { "spindle front" };
        kernel.emit(0, Kind::Mode { text: text.into() });
    }
    kernel.follow_spindle();
    Ok(())
}

/// `CODE_APPLY_TURN`, `CODE_APPLY_MILL`.
pub(super) fn apply(kernel: &mut Kernel<'_>, milling: bool) -> Acted {
    if kernel.channel.state.others.spindles.milling != milling {
        kernel.channel.state.others.spindles.milling = milling;
        let text = if milling { "apply mill" } else { "apply turn" };
        kernel.emit(0, Kind::Mode { text: text.into() });
        kernel.follow_spindle();
    }
    Ok(())
}

/// Lets an action command a spindle of the channel: `number` 0 = by codes without a number.
pub(super) fn commanded(kernel: &mut Kernel<'_>, number: u16, action: impl FnOnce(&mut Kernel<'_>) -> Acted) -> Acted {
    let index = if number == 0 {
        kernel.plain_spindle()
    } else {
        let index = index_of(kernel.channel.env.machine, number);
        if index.is_none() {
            let text = format!("the machine has no spindle {number} for '{}'", kernel.block_text());
            kernel.diagnose(&diag::NO_SPINDLE, text);
            super::spindle::drop_data(kernel);
            return Ok(());
        }
        index
    };
    let before = kernel.channel.state.spindle.index;
    kernel.select_spindle(index);
    let done = action(kernel);
    kernel.select_spindle(before);
    done
}

/// The head that `CODE_SPINDLE_CSS_ID` names.
pub(super) fn driver_by_id(kernel: &mut Kernel<'_>) -> Acted {
    let Some(id) = kernel.take(data::SPINDLE_CSS_ID).map(|d| d.value) else {
        let text = format!("no head is named in '{}'", kernel.block_text());
        kernel.diagnose(&diag::DATA_MISSING, text);
        return Ok(());
    };
    let known = kernel.channel.env.machine.channels.iter().find(|channel| f64::from(channel.number) == id);
    match known.map(|channel| channel.number) {
        Some(channel) => super::spindle::driver(kernel, channel),
        None => no_head(kernel, id),
    }
}

/// There is no such head to drive constant surface speed.
pub(super) fn no_head(kernel: &mut Kernel<'_>, id: f64) -> Acted {
    let id = counterpoint_lang::format::wildcard_text(id);
    let text = format!("there is no head {id} to drive constant surface speed in '{}'", kernel.block_text());
    kernel.diagnose(&diag::NO_HEAD, text);
    Ok(())
}

impl Kernel<'_> {
    /// The spindle that turns the part.
    fn turning_spindle(&self) -> Option<usize> {
        let spindles = &self.channel.state.others.spindles;
        let rear =
            spindles.rear.filter(|_| self.channel.state.modal.code(group::SPINDLES) == Some(codes::SPINDLE_REAR));
        rear.or(spindles.front)
    }

    /// The spindle in work.
    fn working_spindle(&self) -> Option<usize> {
        let spindles = &self.channel.state.others.spindles;
        spindles.mill.filter(|_| spindles.milling).or_else(|| self.turning_spindle())
    }

    /// The spindle of codes without a number: not a milling one that has codes of its own.
    fn plain_spindle(&self) -> Option<usize> {
        let spindles = &self.channel.state.others.spindles;
        let mill = spindles.mill.filter(|_| spindles.milling && self.milling_code() == 0);
        mill.or_else(|| self.turning_spindle())
    }

    fn number_in_codes(&self, index: Option<usize>) -> u16 {
        let number =
            index.and_then(|index| self.channel.env.machine.spindles.get(index)).map_or(0, |spindle| spindle.number);
        if has_codes(self.channel.env.machine, number) { number } else { 0 }
    }

    /// `$STID`
    pub(crate) fn turning_code(&self) -> u16 {
        self.number_in_codes(self.turning_spindle())
    }

    /// `$SMID`
    pub(crate) fn milling_code(&self) -> u16 {
        self.number_in_codes(self.channel.state.others.spindles.mill)
    }

    /// Puts into work what the codes say.
    pub(crate) fn follow_spindle(&mut self) {
        let wanted = self.working_spindle();
        self.select_spindle(wanted);
    }

    /// Puts a spindle into work.
    fn select_spindle(&mut self, index: Option<usize>) {
        if index == self.channel.state.spindle.index {
            return;
        }
        let old = self.channel.state.spindle;
        let kept = &mut self.channel.state.others.spindles.kept;
        if let Some(slot) = old.index.filter(|_| !old.shared).and_then(|at| kept.get_mut(at)) {
            *slot = old.command;
        }
        let command = index.and_then(|at| kept.get(at)).copied().unwrap_or_default();
        let shared = index.is_some_and(|at| is_shared(self.channel.env.machine, at));
        self.channel.state.spindle = SpindleState { index, shared, command, now: 0.0 };
    }
}
