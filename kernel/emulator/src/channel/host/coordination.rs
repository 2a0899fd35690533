//! Statements between channels: a wait or an act by the rows of the machine, and programs that other channels run.

use counterpoint_event::FileId;
use counterpoint_event::event::Kind;
use counterpoint_fault as diag;
use counterpoint_fault::{Acted, Halt};
use counterpoint_program::shape::Range;
use counterpoint_sync::order::idle::Program;

use crate::channel::Kernel;
use crate::waits::{self, Meaning, Statement};
use counterpoint_dialect::{Coordination, Operands};

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
            Ok(Statement::Start(channels)) => self.start(channels),
            Ok(Statement::Meaning(Meaning::Act(deed, shown))) => self.let_continue(deed, shown),
            Ok(Statement::Meaning(Meaning::Wait(_))) if ignores_waits => {
                self.emit(0, Kind::mode("sync passed without waiting"));
                Ok(())
            }
            Ok(Statement::Meaning(Meaning::Wait(wait))) => self.wait(wait),
            Err(reason) => Err(illegal(self, &reason)),
        }
    }

    fn select(&mut self, channel: i64, name: &str, program: Option<(FileId, Range)>) -> Acted {
        let channel = match waits::known_channel(self.channel.env.machine, channel) {
            Ok(channel) => channel,
            Err(reason) => return Err(illegal(self, &reason)),
        };
        let program =
            program.map(|(file, range)| Program { file, lines: (range.first, range.last), name: name.into() });
        Kernel::select(self, channel, program)
    }
}

/// The arguments of a statement are not possible.
fn illegal(kernel: &mut Kernel<'_>, reason: &str) -> Halt {
    let text = format!("{reason}, in '{}'", kernel.block_text());
    kernel.alarm(&diag::STATEMENT_ARGUMENTS, text)
}
