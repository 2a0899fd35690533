//! Statements between channels: a wait or an act by the rows of the machine.

use counterpoint_fault as diag;
use counterpoint_fault::Acted;

use crate::channel::Kernel;
use crate::waits::{self, Meaning};
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
        match waits::by_statement(self.channel.env.machine, statement, channel, mark, channels) {
            Ok(Meaning::Act(deed, shown)) => self.let_continue(deed, shown),
            Ok(Meaning::Wait(_)) if self.channel.env.options.ignore_waits.contains(&channel) => {
                self.emit(0, counterpoint_event::event::Kind::mode("sync passed without waiting"));
                Ok(())
            }
            Ok(Meaning::Wait(wait)) => self.wait(wait),
            Err(reason) => {
                let text = format!("{reason}, in '{}'", self.block_text());
                Err(self.alarm(&diag::STATEMENT_ARGUMENTS, text))
            }
        }
    }
}
