//! Comments and operator messages as codes, on a kernel with macros.
//!
//! Facts: reference control-emulator.md 5.4, 5.6: both act before everything else on their block (order 100). A
//! pre-processor that works in the block takes them off, unless `$FCEPP` says otherwise; a message is shown all the
//! same. Decision: they need no row of the code table, the delimiters of the machine's format are enough. Invariant:
//! `$TPRINT` or `$DISPLY` holds the text before a macro of the code runs.

use std::sync::Arc;

use counterpoint_lang::value::MacroValue;

use crate::channel::Kernel;
use counterpoint_channel::burden::shortened;
use counterpoint_channel::macros::calls::OutputTask;
use counterpoint_channel::macros::values::code_value;
use counterpoint_event::event::{Kind, OperatorMessage};
use counterpoint_fault::Acted;
use counterpoint_machine::ident::{CodeId, codes};
use counterpoint_program::block::PendingCode;

impl Kernel<'_> {
    /// Comments and messages of a block that is split into words.
    pub(crate) fn remarks_of_block(&mut self) -> Acted {
        // Remarks of a statement have acted before the statement.
        let are_done = self.channel.context.made && self.channel.context.text.is_none();
        if !self.may_have_remarks() || are_done && self.channel.block.messages.is_empty() {
            return Ok(());
        }
        let text = self.channel.text_bytes().into_owned();
        self.remarks(&text)
    }

    /// Those of a statement.
    pub(crate) fn remarks_of_statement(&mut self, text: &[u8]) -> Acted {
        if self.may_have_remarks() || self.plan.scanner.has_messages() { self.remarks(text) } else { Ok(()) }
    }

    /// Whether the block has messages, or comments and messages fire codes.
    pub(crate) fn may_have_remarks(&self) -> bool {
        !self.channel.block.messages.is_empty()
            || self.macros.remarks_fire(self.channel.context.preprocessed).contains(&true)
    }

    /// Comments and messages of a text, from left to right.
    fn remarks(&mut self, text: &[u8]) -> Acted {
        let fires = self.macros.remarks_fire(self.channel.context.preprocessed);
        self.channel.block.messages.clear();
        for (is_message, start, end) in self.plan.scanner.remarks(text) {
            let remark = String::from_utf8_lossy(text.get(start..end).unwrap_or_default()).trim().to_owned();
            match (is_message, fires) {
                (false, [true, _]) => self.fire_remark(codes::COMMENT, Arc::new(remark))?,
                (true, [_, true]) => self.fire_remark(codes::DISPLY, Arc::new(remark))?,
                (true, _) => self.display(&remark),
                (false, _) => {}
            }
        }
        Ok(())
    }

    /// A message to the operator.
    pub(crate) fn display(&mut self, text: &str) {
        let text = shortened(text);
        self.show_display(text);
        self.trace('C', |_| crate::trace::code("CODE_DISPLY"));
        self.channel.emit(0, Kind::Message(OperatorMessage { text: text.into(), printed: false }));
    }

    fn fire_remark(&mut self, id: CodeId, text: Arc<String>) -> Acted {
        self.keep_remark(id, &text);
        let outer = self.channel.context.set_code(Some(id));
        let done = match self.matching_code_macro(id) {
            Some(code) => {
                let mut arguments = [code_value(Some(id)), MacroValue::Text(Arc::clone(&text))];
                self.run_macro(code, OutputTask::Remark(id, text), &mut arguments).map(|_| ())
            }
            None if id == codes::DISPLY => {
                self.display(&text);
                Ok(())
            }
            None => {
                self.trace_ignored(id);
                Ok(())
            }
        };
        self.channel.context.set_code(outer);
        done?;
        self.pending_halt()
    }

    /// OUTPUT in the macro of a remark: the code that `$P1` holds now.
    pub(crate) fn output_remark(&mut self, id: CodeId, text: Arc<String>, wanted: Option<&MacroValue>) -> Acted {
        let target = wanted.map_or(Some(id), |value| self.code_id(value));
        match target {
            None => Ok(()),
            Some(target) if target == codes::COMMENT || target == codes::DISPLY => self.fire_remark(target, text),
            Some(target) => match self.row_of_code(target) {
                Some(row) => self.output_code(
                    PendingCode { order: 0, row, value: 0.0, modal: false, only_if_data_left: false },
                    target,
                    None,
                ),
                None => {
                    self.no_such_code(target);
                    Ok(())
                }
            },
        }
    }

    fn keep_remark(&mut self, id: CodeId, text: &Arc<String>) {
        if id == codes::DISPLY {
            return self.show_display(text);
        }
        self.store(counterpoint_channel::macros::store::names().comment, || MacroValue::Text(Arc::clone(text)));
    }
}
