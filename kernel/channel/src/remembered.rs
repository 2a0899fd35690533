//! Words that a channel remembers: the only table of them.
//!
//! A control keeps the last number of a word whether or not a code of the block used it: an offset number that is alone
//! in its block is the one that a later code takes. Codes, system variables, the tools of the summary and stepping all
//! read this table, so they cannot disagree. *Invariant:* a value is that of the last word of the program, in the units
//! of the machine, until another word replaces it or the channel is reset. The active offsets are not here but in
//! `Place::in_force`.

use counterpoint_machine::Machine;
use counterpoint_machine::ident::{DataId, data};
use counterpoint_machine::index::IdTable;

/// Highest number that an offset can have.
const HIGHEST: f64 = 999_999.0;

/// The words.
#[derive(Debug, Clone)]
pub struct RememberedWords {
    /// Values by data identifier.
    data: IdTable<DataId, Option<f64>>,
    /// M word.
    function: Option<f64>,
    /// S word, as written.
    speed: Option<f64>,
    /// Sequence number.
    sequence: Option<u32>,
}

impl RememberedWords {
    /// Nothing yet, on a machine with these data.
    pub fn new(machine: &Machine) -> Self {
        Self { data: machine.data_names.map(|_, _| None), function: None, speed: None, sequence: None }
    }

    /// The same words on another component, which has its own identifiers.
    pub fn fitted(&self, before: &Machine, machine: &Machine) -> Self {
        let mut fitted =
            Self { function: self.function, speed: self.speed, sequence: self.sequence, ..Self::new(machine) };
        for (id, name) in before.data_names.entries() {
            if let Some(value) = self.value(id)
                && let Some(new) = machine.data_names.find(|own| own == name)
            {
                fitted.remember(new, value);
            }
        }
        fitted
    }

    /// The last value of data.
    #[inline]
    pub fn value(&self, id: DataId) -> Option<f64> {
        self.data[id]
    }

    /// Remembers a value of data.
    #[inline]
    pub fn remember(&mut self, id: DataId, value: f64) {
        self.data[id] = Some(value);
    }

    /// The last number of an offset; 0 without one.
    fn number(&self, id: DataId) -> u32 {
        self.value(id).filter(|number| (0.0..=HIGHEST).contains(number)).map_or(0, |number| number as u32)
    }

    /// The last number of a diameter offset; 0 without one.
    pub fn diameter(&self) -> u32 {
        self.number(data::COMP_DIAM)
    }

    /// The last number of a length offset; 0 without one.
    pub fn length(&self) -> u32 {
        self.number(data::COMP_LENGTH)
    }

    /// The last M word.
    pub fn function(&self) -> Option<f64> {
        self.function
    }

    /// Remembers an M word.
    #[inline]
    pub fn remember_function(&mut self, value: f64) {
        self.function = Some(value);
    }

    /// The last speed word.
    pub fn speed(&self) -> Option<f64> {
        self.speed
    }

    /// Remembers a speed word of any meaning.
    pub fn remember_speed(&mut self, value: f64) {
        self.speed = Some(value);
    }

    /// The last sequence number.
    pub fn sequence(&self) -> Option<u32> {
        self.sequence
    }

    /// Remembers the sequence number of a block, if it has one.
    #[inline]
    pub fn remember_sequence(&mut self, number: Option<u32>) {
        self.sequence = number.or(self.sequence);
    }
}
