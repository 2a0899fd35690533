//! Numbered variables of a channel, and the local ones of each level.

use crate::system_values::SystemValues;
use counterpoint_control_api::{CallStack, VACANT, is_vacant};
use counterpoint_machine::model::ProgramVariables;
use counterpoint_sync::separate::SeparateVariableUses;
use rustc_hash::FxHashMap;

/// Local variables #1–#33 of one level.
type Locals = [f64; 34];

/// Variables that only this channel sees.
#[derive(Debug)]
pub struct ChannelVariables {
    calls: CallStack<Locals>,
    /// Numbered variables of this channel, except local and kept ones.
    pub own: FxHashMap<u32, f64>,
    /// Print of those that have been written: equal while their values are.
    print: u64,
    /// Writes, calls and returns so far.
    pub writes: u64,
    /// Separate variables that the channel has read without a value, and written; kept if other channels also run.
    pub uses: SeparateVariableUses,
    /// Variables without a value, and variables that do not exist, are 0.
    pub reads_zero: bool,
    /// System variables that programs write keep their values; otherwise the identification macro is asked where to
    /// write them.
    pub keeps_system: bool,
    /// Those values.
    pub kept: FxHashMap<u32, f64>,
    /// The kept values of the system variables of the machine.
    pub system: SystemValues,
}

impl Default for ChannelVariables {
    fn default() -> Self {
        Self {
            calls: CallStack::new([VACANT; 34]),
            own: FxHashMap::default(),
            print: 0,
            writes: 0,
            uses: SeparateVariableUses::default(),
            reads_zero: false,
            keeps_system: false,
            kept: FxHashMap::default(),
            system: SystemValues::default(),
        }
    }
}

impl ChannelVariables {
    /// With the values that variables of the channel have at the start.
    pub fn new(variables: &ProgramVariables) -> Self {
        let own = variables.system.initial.iter().copied().filter(|&(number, _)| within(&variables.channel, number));
        Self { own: own.collect(), system: SystemValues::new(&variables.system), ..Self::default() }
    }

    /// A macro call: fresh locals with the arguments.
    pub fn enter(&mut self, arguments: &[(u8, f64)]) {
        let mut locals = [VACANT; 34];
        for &(number, value) in arguments {
            if let Some(slot) = locals.get_mut(usize::from(number)) {
                *slot = value;
            }
        }
        self.calls.enter(locals);
        self.writes += 1;
    }

    /// Return from a macro call.
    pub fn leave(&mut self) {
        self.calls.leave();
        self.writes += 1;
    }

    /// Local variables of the running macro that have a value.
    pub fn locals(&self) -> impl Iterator<Item = (u8, f64)> {
        (0..).zip(self.calls.here()).map(|(number, value)| (number, *value)).filter(|(_, value)| !is_vacant(*value))
    }

    /// A number that is another one whenever variables may have other values than before.
    pub fn writes(&self) -> u64 {
        self.writes
    }

    /// Takes the place of these.
    pub fn follow(&mut self, before: &Self) {
        self.writes = self.writes.max(before.writes) + 1;
    }

    /// Those that have a value: the ones of the running program first, each part ascending; at most so many.
    pub fn with_value(&self, most: usize) -> Vec<(u32, f64)> {
        let locals = (0..).zip(self.calls.here()).filter(|(_, value)| !is_vacant(**value));
        let mut own: Vec<_> = self.own.iter().chain(&self.kept).map(|(number, value)| (*number, *value)).collect();
        own.sort_unstable_by_key(|(number, _)| *number);
        own.retain(|(_, value)| !is_vacant(*value));
        locals.map(|(number, value)| (number, *value)).chain(own).take(most).collect()
    }

    /// A local variable; number 0 and the numbers of others have no value here.
    #[inline]
    pub fn local(&self, index: u32) -> f64 {
        self.calls.here().get(index as usize).copied().unwrap_or(VACANT)
    }

    /// Writes a variable that belongs to this channel.
    pub fn set_own(&mut self, index: u32, value: f64) {
        self.writes += 1;
        let before = self.own.insert(index, value).unwrap_or(VACANT);
        self.print ^= print(index, before) ^ print(index, value);
    }

    /// Print of the variables that the running program can see: equal while all values are.
    pub fn print(&self) -> u64 {
        let locals = self.calls.here().iter().zip(0..);
        locals.fold(self.print, |all, (value, index)| all ^ print(index, *value))
    }

    /// Whether it has another value than before.
    pub fn set_local(&mut self, index: u32, value: f64) -> bool {
        self.writes += 1;
        let slot = self.calls.here_mut().get_mut(index as usize);
        slot.is_some_and(|slot| std::mem::replace(slot, value).to_bits() != value.to_bits())
    }
}

/// Print of a variable with its value. Two prints of different values are equal once in 2^64.
fn print(index: u32, value: f64) -> u64 {
    let mix = |x: u64| (x ^ x >> 32).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    mix(mix(value.to_bits() ^ mix(u64::from(index) + 1)) + 1)
}

/// Whether one of these ranges contains the number.
pub fn within(ranges: &[(u32, u32)], index: u32) -> bool {
    ranges.iter().any(|&(low, high)| (low..=high).contains(&index))
}
