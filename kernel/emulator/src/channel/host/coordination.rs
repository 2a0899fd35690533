//! Statements between channels: a wait or an act by the rows of the machine, and programs that other channels run.

use counterpoint_event::FileId;
use counterpoint_event::event::Kind;
use counterpoint_fault as diag;
use counterpoint_fault::{Acted, Halt};
use counterpoint_program::shape::ProgramRange;
use counterpoint_sync::Letter;
use counterpoint_sync::order::idle::StartableProgram;
use counterpoint_sync::wait::{MarkRange, WaitOp};

use crate::channel::Kernel;
use counterpoint_control_api::{Coordination, Operands, Signal};
use counterpoint_waits::{self as waits, Meaning, WaitStatement};

impl Coordination for Kernel<'_> {
    fn coordinates(&self, statement: &str) -> Option<Operands> {
        waits::operands(self.channel.env.machine, statement)
    }

    fn channel_named(&self, name: &str) -> Option<u16> {
        let mut channels = self.channel.env.machine.channels.iter();
        channels.find(|channel| channel.name.eq_ignore_ascii_case(name)).map(|channel| channel.number)
    }

    fn coordinate(&mut self, statement: &str, mark: i64, channels: &[i64]) -> Acted {
        self.flush_lookahead()?;
        let channel = self.channel.at.channel;
        let ignores_waits = self.channel.env.options.ignore_waits.contains(&channel);
        match waits::by_statement(self.channel.env.machine, statement, channel, mark, channels) {
            Ok(WaitStatement::Start(channels)) => self.start(channels),
            Ok(WaitStatement::Meaning(Meaning::Act(deed, shown))) => self.let_continue(deed, shown),
            Ok(WaitStatement::Meaning(Meaning::Wait(_))) if ignores_waits => {
                self.channel.emit(0, Kind::mode("sync passed without waiting"));
                Ok(())
            }
            Ok(WaitStatement::Meaning(Meaning::Wait(wait))) => self.wait(wait),
            Err(reason) => Err(illegal(self, &reason)),
        }
    }

    fn exchange(&mut self, statement: &str, axis: &str, channel: Option<i64>) -> Acted {
        Kernel::exchange(self, statement, axis, channel)
    }

    fn send(&mut self, statement: &str, signal: &Signal) -> Acted {
        self.flush_lookahead()?;
        let channel = self.channel.at.channel;
        let (send, shown) = match waits::signal(self.channel.env.machine, statement, channel, signal) {
            Ok(sent) => sent,
            Err(reason) => return Err(wrong_signal(self, &reason)),
        };
        let letter = (!signal.values.is_empty()).then(|| signal.values.as_slice().into());
        self.signal(WaitOp::Signal(send), letter, shown)
    }

    fn remove_signal(&mut self, statement: &str, signal: &Signal) -> Acted {
        self.flush_lookahead()?;
        let channel = self.channel.at.channel;
        let (send, shown) = match waits::signal(self.channel.env.machine, statement, channel, signal) {
            Ok(sent) => sent,
            Err(reason) => return Err(wrong_signal(self, &reason)),
        };
        let last = signal
            .last
            .map_or(Ok(send.key.number), |last| waits::signal_number(self.channel.env.machine, statement, last));
        let last = match last {
            Ok(last) => last,
            Err(reason) => return Err(wrong_signal(self, &reason)),
        };
        let range = MarkRange { space: send.key.space, first: send.key.number, last };
        let to = (!send.broadcast).then_some(send.to);
        self.signal(WaitOp::Remove { range, to }, None, shown)
    }

    fn receive(&mut self, statement: &str, signal: &Signal, waits: bool) -> Result<Option<Vec<(u8, f64)>>, Halt> {
        self.flush_lookahead()?;
        let channel = self.channel.at.channel;
        let wait = match waits::signal_wait(self.channel.env.machine, statement, channel, signal) {
            Ok(wait) => wait,
            Err(reason) => return Err(wrong_signal(self, &reason)),
        };
        if waits && self.channel.env.options.ignore_waits.contains(&channel) {
            self.channel.emit(0, Kind::mode("sync passed without waiting"));
            let letters = self.read_signal(wait)?.unwrap_or_default();
            return Ok(Some(values(&letters)));
        }
        let letters = if waits { Some(self.await_signal(wait)?) } else { self.read_signal(wait)? };
        Ok(letters.map(|letters| values(&letters)))
    }

    fn select(&mut self, channel: i64, name: &str, program: Option<(FileId, ProgramRange)>) -> Acted {
        let channel = match waits::known_channel(self.channel.env.machine, channel) {
            Ok(channel) => channel,
            Err(reason) => return Err(illegal(self, &reason)),
        };
        let program =
            program.map(|(file, range)| StartableProgram { file, lines: (range.first, range.last), name: name.into() });
        Kernel::select(self, channel, program)
    }
}

/// All values of some signals.
fn values(letters: &[Letter]) -> Vec<(u8, f64)> {
    letters.iter().flat_map(|letter| letter.iter().copied()).collect()
}

/// A statement of signals is not possible.
fn wrong_signal(kernel: &mut Kernel<'_>, reason: &str) -> Halt {
    let text = format!("{reason}, in '{}'", kernel.channel.block_text());
    kernel.alarm(&diag::SIGNAL_STATEMENT, text)
}

/// The arguments of a statement are not possible.
fn illegal(kernel: &mut Kernel<'_>, reason: &str) -> Halt {
    let text = format!("{reason}, in '{}'", kernel.channel.block_text());
    kernel.alarm(&diag::STATEMENT_ARGUMENTS, text)
}
