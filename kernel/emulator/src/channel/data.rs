//! Data retrieval: an action asks for an identifier and gets the word's value.
//!
//! Facts: reference control-emulator.md 1.3. *Invariant:* a value is removed from the block at most once.

use counterpoint_channel::channel_context::Handed;
use counterpoint_channel::word_values::{counted, handed_value, recall, word_number};
use counterpoint_fault as diag;
use counterpoint_machine::ident::DataId;
use counterpoint_machine::ident::dimension::Dimension;
use counterpoint_machine::index::DataRowId;
use counterpoint_program::block::RetrievedValue;
use counterpoint_program::data_plan::RECALLED;

use super::Kernel;
use counterpoint_channel::trace::trace_data;

/// Reasons why nothing may take a value of the block.
const NOT_PROCESSED: &str = "its row is not processed";
const SWITCHED_OFF: &str = "its rows are switched off";

impl Kernel<'_> {
    /// Takes the value of `id` off the block, if it is there.
    #[inline(always)]
    pub fn take(&mut self, id: DataId) -> Option<RetrievedValue> {
        if let Some(hooks) = self.plan.hooks {
            return (hooks.codes.take)(self, id);
        }
        if self.channel.acting.as_data.is_some_and(|handed| handed.id == id) {
            return self.take_handed();
        }
        if (self.channel.block.present | RECALLED) & self.channel.tables.data.registers_of[id] == 0 {
            return None;
        }
        self.take_word(id)
    }

    /// Takes the value that the code in action hands over.
    #[cold]
    fn take_handed(&mut self) -> Option<RetrievedValue> {
        let handed = self.channel.acting.as_data.take()?;
        if self.refuse_handed(handed) {
            return None;
        }
        let (value, factor, modal) = self.accept(handed);
        let value = value * factor;
        if modal {
            self.channel.state.remembered.remember(handed.id, value);
        }
        trace_data(&mut self.channel, handed.id, value);
        Some(RetrievedValue { value, incremental: false, absolute: false, raw: handed.raw })
    }

    /// A value handed over by its row: value, factor of its unit, whether it is remembered. Reports a value outside the
    /// row's range.
    #[cold]
    pub fn accept(&mut self, handed: Handed) -> (f64, f64, bool) {
        let Some(at) = handed.row else {
            return (handed.raw, self.channel.unit_factor(handed.id.dimension().plain()), false);
        };
        let row = &self.channel.env.machine.data[at];
        if row.min.is_some_and(|min| handed.raw < min) || row.max.is_some_and(|max| handed.raw > max) {
            self.out_of_range(at, handed.raw);
        }
        (
            handed_value(self.channel.env.machine, handed),
            self.channel.unit_factor(row.dimension.plain()),
            row.modal && row.process,
        )
    }

    /// One of the registers of `id` is in the block.
    fn take_word(&mut self, id: DataId) -> Option<RetrievedValue> {
        let tables = self.channel.tables;
        for source in tables.sources_of(id) {
            let Some(word) = self.channel.block.take(source.register) else { continue };
            let raw = word_number(&self.channel, source, &word);
            let incremental = word.incremental;
            if raw < source.min || raw > source.max {
                self.out_of_range(source.row, raw);
            }
            let mut value = match source.dimension {
                Dimension::Increments => counted(&self.channel, source, &word, raw),
                other => (raw * source.mul + source.add) * self.channel.unit_factor(other),
            };
            if source.diameter_x {
                value *= self.channel.position_factor(id, incremental);
            }
            if source.modal && !incremental {
                self.channel.state.remembered.remember(id, value);
            }
            trace_data(&mut self.channel, id, value);
            return Some(RetrievedValue { value, incremental, absolute: false, raw });
        }
        if self.refuse(id) { None } else { recall(&self.channel, id) }
    }

    /// A word is there, but its row says that nothing may take it, or all rows of the data are off.
    #[cold]
    pub fn refuse(&mut self, id: DataId) -> bool {
        let refused = self.channel.tables.data.refused[id];
        if (self.channel.block.present | RECALLED) & refused != 0 {
            self.report_refused(id, if refused & RECALLED == 0 { NOT_PROCESSED } else { SWITCHED_OFF });
            return true;
        }
        false
    }

    #[cold]
    fn report_refused(&mut self, id: DataId, why: &str) {
        let text = format!(
            "{} is asked for in '{}', but {why}",
            self.channel.env.machine.data_name(id),
            self.channel.block_text()
        );
        self.diagnose(&diag::DATA_REFUSED, text);
    }

    /// Refuses a word for a macro. Unlike an action, a macro may ask for data whose rows are all switched off.
    #[cold]
    pub fn refuse_word(&mut self, id: DataId) {
        if self.channel.block.present & self.channel.tables.data.refused[id] & !RECALLED != 0 {
            self.refuse(id);
        }
    }

    /// Refuses the value of a code as data if the row of the data is not processed.
    #[cold]
    pub fn refuse_handed(&mut self, handed: Handed) -> bool {
        let refused = handed.row.is_some_and(|at| !self.channel.env.machine.data[at].process);
        if refused {
            self.report_refused(handed.id, NOT_PROCESSED);
        }
        refused
    }

    /// Reports the data that an action could have used and whose rows are all switched off.
    #[cold]
    pub fn report_switched_off(&mut self, ids: &[DataId]) {
        for &id in ids {
            let rows = || self.channel.env.machine.data.iter().filter(|row| row.id == id);
            if rows().next().is_some() && rows().all(|row| !row.enable) {
                self.report_refused(id, SWITCHED_OFF);
            }
        }
    }

    /// Reports a value outside the range of its row.
    pub fn out_of_range(&mut self, row: DataRowId, value: f64) {
        let row = &self.channel.env.machine.data[row];
        let name = match row.register {
            Some(register) => self.channel.env.machine.registers[register].name.clone(),
            None => "value ".to_owned(),
        };
        let bound = |b: Option<f64>| b.map_or_else(|| "-".to_owned(), counterpoint_lang::format::wildcard_text);
        let text = format!(
            "{name}{} is outside {} to {} of {} in '{}'",
            counterpoint_lang::format::wildcard_text(value),
            bound(row.min),
            bound(row.max),
            self.channel.env.machine.data_name(row.id),
            self.channel.block_text()
        );
        self.diagnose(&diag::DATA_OUT_OF_RANGE, text);
    }
}
