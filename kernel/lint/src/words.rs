//! Plain words of a block: those at which channels wait, and those of calls and ends.
//!
//! *Invariant:* they act by the actions of a run; all other words do nothing.

use std::sync::Arc;

use counterpoint_channel::callee::{Callee, Pending};
use counterpoint_channel::queued_codes::{enter_code, sort_codes};
use counterpoint_fault::{Acted, Halt};
use counterpoint_machine::ident::{CodeId, codes};
use counterpoint_machine::rows::CodeForm;
use counterpoint_program::block::PendingCode;

use super::Linter;
use super::region::{Certain, Meant};

/// Codes at which channels wait or let each other continue.
const MEETINGS: [CodeId; 15] = [
    codes::SYNC_REG,
    codes::SYNC_REG_MAIN,
    codes::SYNC_REG_SIDE,
    codes::SYNC_REG_START,
    codes::SYNC_REG_STOP,
    codes::SYNC_START_MAIN,
    codes::SYNC_START_SIDE,
    codes::BALANCE_ON,
    codes::BALANCE_OFF,
    codes::COUPLE_SYNCHRONOUS,
    codes::COUPLE_SYNCHRONOUS_OFF,
    codes::COUPLE_COMPOSITE,
    codes::COUPLE_COMPOSITE_OFF,
    codes::COUPLE_SUPERIMPOSED,
    codes::COUPLE_SUPERIMPOSED_OFF,
];
/// Codes that call.
const CALLS: [CodeId; 4] = [codes::CALSUB_ID, codes::CALSUB_RANGE, codes::FIGURE_TURN, codes::FIGURE_SHIFT];
/// Codes that end a program.
const ENDS: [CodeId; 3] = [codes::CALSUB_RETURN, codes::END, codes::REWIND];

impl Linter<'_, '_> {
    /// Words of a text act; `computed`: names of words of the block whose values are computed.
    pub(super) fn words(&mut self, text: &[u8], computed: &[String]) -> Acted {
        let read = self.scan(text);
        let acted = self.words_of_block(computed);
        self.kernel.channel.text.edited = read;
        acted
    }

    /// Splits a text into words; returns the previous text of the block.
    pub(super) fn scan(&mut self, text: &[u8]) -> Option<Arc<[u8]>> {
        let read = self.kernel.channel.text.edited.replace(text.into());
        let tables = self.kernel.channel.tables;
        let scanner = tables.unmarked.as_deref().unwrap_or(&tables.scanner);
        scanner.scan_as(text, self.kernel.channel.state.secondary, &mut self.kernel.channel.block, false);
        read
    }

    /// Words that are in the block act.
    pub(super) fn words_of_block(&mut self, computed: &[String]) -> Acted {
        if let Some(name) = computed.iter().find(|name| self.decides(name)) {
            return Err(self.lost(&format!("the value of {name} is computed")));
        }
        let called = self.kernel.categorise() || self.kernel.flow.calls_each_block(&self.kernel.channel.block);
        self.report_unknown(Certain { calls: called, computed: !computed.is_empty() });
        sort_codes(&mut self.kernel.channel);
        let acting = self.acting();
        let needed = |name: &&String| if called { is_of_call(name) } else { !self.moves(name) };
        if (called || !acting.is_empty())
            && let Some(name) = computed.iter().find(needed)
        {
            return Err(self.lost(&format!("the value of {name} is computed")));
        }
        if called {
            return self.macro_call();
        }
        for pending in acting {
            self.act(pending)?;
        }
        Ok(())
    }

    /// A call of a custom macro. One that blocks make without saying so matters only if it does something for others.
    fn macro_call(&mut self) -> Acted {
        self.kernel.macro_call()?;
        let Some(modal) = self.kernel.flow.modal.pop() else { return Ok(()) };
        match self.meets_in(&modal.what)? {
            None => Ok(()),
            Some(_) => Err(self.lost(&format!("blocks that move call {}, which waits", modal.what))),
        }
    }

    /// Codes of the block that are followed, in their order.
    fn acting(&self) -> Vec<PendingCode> {
        let is_followed = |id: CodeId| MEETINGS.contains(&id) || CALLS.contains(&id) || ENDS.contains(&id);
        let pending = self.kernel.channel.block.pending.iter().copied();
        pending.filter(|pending| is_followed(self.kernel.channel.env.machine.codes[pending.row].id)).collect()
    }

    /// Lets a code act, without its time.
    fn act(&mut self, pending: PendingCode) -> Acted {
        let machine = self.kernel.channel.env.machine;
        let row = &machine.codes[pending.row];
        if !row.process {
            return Ok(());
        }
        if row.id == codes::BALANCE_ON {
            return Err(self.lost("balance cutting pairs the cuts of two channels, which only a run makes"));
        }
        enter_code(&mut self.kernel.channel, row, pending);
        let acted = match self.kernel.plan.action_of_row[pending.row] {
            Some(action) => action.run(self.kernel, row, &pending),
            None => Ok(()),
        };
        self.kernel.channel.acting.as_data = None;
        acted
    }

    /// Whether the value of a word with this name decides which code it is, and one of these codes is followed.
    pub(super) fn decides(&self, name: &str) -> bool {
        let machine = self.kernel.channel.env.machine;
        let Some(register) = machine.registers.find(|register| register.name == name) else { return false };
        machine.codes.iter().any(|row| {
            let of = match row.form {
                CodeForm::Register { register: of, .. } | CodeForm::RegisterAsData { register: of, .. } => {
                    of == register
                }
                CodeForm::Text(_) | CodeForm::NotApplicable => false,
            };
            of && row.enable && (MEETINGS.contains(&row.id) || CALLS.contains(&row.id) || ENDS.contains(&row.id))
        })
    }

    /// Whether a word with this name moves an axis.
    fn moves(&self, name: &str) -> bool {
        let registers = &self.kernel.channel.env.machine.registers;
        let register = registers.find(|register| register.name == name);
        register.is_some_and(|register| self.kernel.channel.tables.registers.motion & register.bit() != 0)
    }

    /// Effect of the words of a text, or of those in the block.
    pub(super) fn meant(&mut self, text: Option<&[u8]>, computed: &[String]) -> Result<Meant, Halt> {
        let read = text.map(|text| self.scan(text));
        let meant = self.meant_by_block(computed);
        if let Some(read) = read {
            self.kernel.channel.text.edited = read;
        }
        self.kernel.flow.pending = None;
        meant
    }

    fn meant_by_block(&mut self, computed: &[String]) -> Result<Meant, Halt> {
        if computed.iter().any(|name| self.decides(name)) {
            return Ok(Meant::Meet);
        }
        let called = self.kernel.categorise() || self.kernel.flow.calls_each_block(&self.kernel.channel.block);
        self.report_unknown(Certain { calls: called, computed: !computed.is_empty() });
        let acting = self.acting();
        if !called && acting.is_empty() {
            return Ok(self.asked());
        }
        if computed.iter().any(|name| is_of_call(name)) {
            return Ok(Meant::Meet);
        }
        if called {
            self.kernel.macro_call()?;
            return Ok(match self.kernel.flow.modal.pop() {
                Some(modal) => Meant::Call(modal.what),
                None => self.asked(),
            });
        }
        if acting.iter().any(|pending| MEETINGS.contains(&self.kernel.channel.env.machine.codes[pending.row].id)) {
            return Ok(Meant::Meet);
        }
        if let Some(call) =
            acting.iter().find(|pending| CALLS.contains(&self.kernel.channel.env.machine.codes[pending.row].id))
        {
            self.act(*call)?;
            return Ok(self.asked());
        }
        Ok(Meant::End)
    }

    /// The requests of the block.
    fn asked(&mut self) -> Meant {
        match self.kernel.flow.pending.take() {
            Some(Pending::Call { what, .. } | Pending::CallRange { what, .. }) => Meant::Call(what),
            Some(Pending::Figure { program, .. }) => Meant::Call(Callee::Program(program)),
            _ => Meant::Nothing,
        }
    }
}

/// Whether a word with this name gives the program or the count of a macro call.
fn is_of_call(name: &str) -> bool {
    matches!(name, "P" | "L")
}
