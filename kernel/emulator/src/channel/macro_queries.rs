//! Queries of the pipeline and of actions about the memory of macros, and of macros about the current block.
//!
//! *Invariant:* nothing here runs a macro. Facts: reference control-emulator.md 4, 5.3.

use std::sync::Arc;

use counterpoint_channel::text;
use counterpoint_machine::ident::kind::data::DataKind;
use counterpoint_machine::ident::{CodeId, DataId};
use counterpoint_machine::index::CodeRowId;
use counterpoint_machine::index::RegisterId;
use counterpoint_machine::macros::condition::BlockIdentifier;
use counterpoint_machine::macros::model::Hook;
use counterpoint_program::scan::LineScanner;

use super::Kernel;
use counterpoint_channel::callee::Callee;
use counterpoint_channel::flow::CallRecord;

impl Kernel<'_> {
    /// Whether the block may hold embedded code of this kind: 0 before, 1 after the pre-processor.
    pub fn has_embedded(&self, kind: usize) -> bool {
        let runtime = &*self.macros;
        let open = runtime.variables.store.embedding.get(kind).map_or("", String::as_str);
        let Some(&first) = open.as_bytes().first() else { return false };
        let absent = self.channel.context.text.is_none() && text::is_line_without(&self.channel, first);
        !absent && contains(&self.channel.text_bytes(), open.as_bytes())
    }

    /// Whether the block has messages, or comments and messages fire codes.
    pub fn may_have_remarks(&self) -> bool {
        !self.channel.block.messages.is_empty()
            || self.macros.remarks_fire(self.channel.context.preprocessed).contains(&true)
    }

    /// Whether a macro has put the position of an axis or the shape of an arc in the block.
    pub fn adds_motion(&self) -> bool {
        self.channel.block.added.iter().any(|(id, _)| matches!(id.kind(), DataKind::Axis(_) | DataKind::Arc))
    }

    /// Data by which `$FCEDAC` fires the code of a group are in the block.
    pub fn has_calling_data(&self, group: u16) -> bool {
        let pairs = self.macros.modes.data_codes.as_slice();
        pairs.iter().any(|(id, of)| *of == group && self.has_data(*id))
    }

    /// The first code macro for a code that is on, not running, and whose condition holds.
    pub fn matching_code_macro(&self, id: CodeId) -> Option<u16> {
        let defined = self.channel.env.machine.macros.as_deref()?;
        let list = defined.of_code(id);
        let runtime = &*self.macros;
        if list.is_empty() || !runtime.hooks.matching {
            return None;
        }
        list.iter().find_map(|&at| {
            let named = &defined.codes[at];
            let may = runtime.hooks.has_code(at) && !runtime.calls.is_busy(named.code);
            let holds = || named.condition.is_empty() || named.condition.holds(|item| self.is_present(item, Some(id)));
            (may && holds()).then_some(named.code)
        })
    }

    /// Whether an identifier is in the block; the code that acts counts as present.
    pub fn is_present(&self, item: BlockIdentifier, fired: Option<CodeId>) -> bool {
        match item {
            BlockIdentifier::Code(id) => Some(id) == fired || self.has_code(id),
            BlockIdentifier::Data(id) => self.has_data(id),
        }
    }

    /// Whether a code that acts now or will act is in the block.
    pub fn has_code(&self, id: CodeId) -> bool {
        self.waiting_code(id).is_some()
    }

    /// Data are in the block.
    pub fn has_data(&self, id: DataId) -> bool {
        let registers = self.channel.tables.data.registers_of[id];
        self.channel.block.present & registers != 0
            || self.channel.block.added.iter().any(|(other, _)| *other == id)
            || self.channel.acting.as_data.is_some_and(|handed| handed.id == id)
    }

    /// Position of a code that has not acted yet.
    pub fn waiting_code(&self, id: CodeId) -> Option<usize> {
        let pending = self.channel.block.pending.iter().enumerate().skip(self.channel.block.next);
        let mut found = pending.filter(|(_, pending)| self.channel.env.machine.codes[pending.row].id == id);
        found.next().map(|(at, _)| at)
    }

    /// The scanner for the text of the block in process, if not the plan's: text made by the pre-processor undergoes no
    /// block delete.
    #[inline]
    pub fn block_scanner(&self) -> Option<Arc<LineScanner>> {
        self.plan.hooks?;
        let runtime = &*self.macros;
        match &self.channel.tables.unmarked {
            Some(scanner) if self.channel.context.made => Some(Arc::clone(scanner)),
            _ => runtime.reading.switched.clone(),
        }
    }

    /// The call of the current block.
    pub fn called(&self, what: Callee, passes: u32) -> CallRecord {
        let macros = self.channel.env.machine.macros.as_deref().filter(|_| self.plan.hooks.is_some());
        let hooks = [Hook::SubprogramStartup, Hook::SubprogramShutdown];
        let asks = macros.is_some_and(|macros| hooks.into_iter().any(|hook| macros.hook(hook).is_some()));
        let block = asks.then(|| String::from_utf8_lossy(&text::preprocessed_bytes(&self.channel)).trim().into());
        CallRecord { what, passes, block }
    }

    /// Register of the sequence numbers that the head of this channel has of its own.
    pub fn own_sequence(&self) -> Option<RegisterId> {
        let own = usize::from(self.channel.env.kernel_number(self.channel.at.channel))
            .checked_sub(1)
            .and_then(|head| self.channel.tables.registers.head_sequences.get(head));
        own.copied().flatten()
    }

    /// Makes a code the active one of its group, without acting; returns the previous one.
    pub fn activate_code(&mut self, id: CodeId) -> Option<CodeId> {
        let row = self.row_of_code(id)?;
        let group = Some(self.channel.env.machine.codes[row].group).filter(|group| *group != 0)?;
        let before = self.channel.state.modal.code(group);
        self.channel.state.modal.activate(group, id, Some(row));
        self.channel.follow_cycle();
        self.channel.follow_spindle();
        self.channel.follow_clamps();
        before
    }

    /// The first row of a code that is switched on.
    pub fn row_of_code(&self, id: CodeId) -> Option<CodeRowId> {
        self.channel.tables.rows_of_code[id]
    }
}

/// Whether a text contains a part.
fn contains(text: &[u8], part: &[u8]) -> bool {
    let Some(at) = part.first().and_then(|first| memchr::memchr(*first, text)) else { return false };
    text.get(at..).is_some_and(|rest| memchr::memmem::find(rest, part).is_some())
}
