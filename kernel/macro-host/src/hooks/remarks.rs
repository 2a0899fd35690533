//! Comments and operator messages as codes, on a kernel with macros.
//!
//! Facts: reference control-emulator.md 5.4, 5.6: both act before everything else on their block (order 100). A
//! pre-processor that works in the block takes them off, unless `$FCEPP` says otherwise; a message is shown all the
//! same. Decision: they need no row of the code table, the delimiters of the machine's format are enough. Invariant:
//! `$TPRINT` or `$DISPLY` holds the text before a macro of the code runs.

use std::sync::Arc;

use counterpoint_channel::macro_queries::{matching_code_macro, may_have_remarks, row_of_code};
use counterpoint_channel::macros::calls::OutputTask;
use counterpoint_channel::macros::values::code_value;
use counterpoint_channel::trace::trace_ignored;
use counterpoint_fault::Acted;
use counterpoint_lang::value::MacroValue;
use counterpoint_machine::ident::{CodeId, codes};
use counterpoint_program::block::PendingCode;

use crate::context::MacroHooks;

impl MacroHooks<'_, '_> {
    /// Comments and messages of a block that is split into words.
    pub(crate) fn remarks_of_block(&mut self) -> Acted {
        // Remarks of a statement have acted before the statement.
        let are_done = self.kernel.channel.context.made && self.kernel.channel.context.text.is_none();
        if !may_have_remarks(&self.kernel.channel, &self.kernel.macros)
            || are_done && self.kernel.channel.block.messages.is_empty()
        {
            return Ok(());
        }
        let text = self.kernel.channel.text_bytes().into_owned();
        self.remarks(&text)
    }

    /// Those of a statement.
    pub(crate) fn remarks_of_statement(&mut self, text: &[u8]) -> Acted {
        if may_have_remarks(&self.kernel.channel, &self.kernel.macros)
            || self.kernel.channel.tables.scanner.has_messages()
        {
            self.remarks(text)
        } else {
            Ok(())
        }
    }

    /// Comments and messages of a text, from left to right.
    fn remarks(&mut self, text: &[u8]) -> Acted {
        let fires = self.kernel.macros.remarks_fire(self.kernel.channel.context.preprocessed);
        self.kernel.channel.block.messages.clear();
        for (is_message, start, end) in self.kernel.channel.tables.scanner.remarks(text) {
            let remark = String::from_utf8_lossy(text.get(start..end).unwrap_or_default()).trim().to_owned();
            match (is_message, fires) {
                (false, [true, _]) => self.fire_remark(codes::COMMENT, Arc::new(remark))?,
                (true, [_, true]) => self.fire_remark(codes::DISPLY, Arc::new(remark))?,
                (true, _) => self.kernel.display(&remark),
                (false, _) => {}
            }
        }
        Ok(())
    }

    fn fire_remark(&mut self, id: CodeId, text: Arc<String>) -> Acted {
        self.keep_remark(id, &text);
        let outer = self.kernel.channel.context.set_code(Some(id));
        let done = match matching_code_macro(&self.kernel.channel, &self.kernel.macros, id) {
            Some(code) => {
                let mut arguments = [code_value(Some(id)), MacroValue::Text(Arc::clone(&text))];
                self.run_macro(code, OutputTask::Remark(id, text), &mut arguments).map(|_| ())
            }
            None if id == codes::DISPLY => {
                self.kernel.display(&text);
                Ok(())
            }
            None => {
                trace_ignored(&mut self.kernel.channel, id);
                Ok(())
            }
        };
        self.kernel.channel.context.set_code(outer);
        done?;
        self.pending_halt()
    }

    /// OUTPUT in the macro of a remark: the code that `$P1` holds now.
    pub(crate) fn output_remark(&mut self, id: CodeId, text: Arc<String>, wanted: Option<&MacroValue>) -> Acted {
        let target = wanted.map_or(Some(id), |value| self.host().code_id(value));
        match target {
            None => Ok(()),
            Some(target) if target == codes::COMMENT || target == codes::DISPLY => self.fire_remark(target, text),
            Some(target) => match row_of_code(&self.kernel.channel, target) {
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
            return self.host().show_display(text);
        }
        self.host().store(counterpoint_channel::macros::store::names().comment, || MacroValue::Text(Arc::clone(text)));
    }
}
