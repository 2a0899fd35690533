//! Numbered variables: local, of the channel, common to all channels, and system variables.
//!
//! Facts: reference channel-synchronisation.md 1.3 (variable ranges) and control-emulator.md 5.4. *Invariant:* common
//! variables are touched only in shared operations.

use rustc_hash::FxHashMap;

use super::Kernel;
use super::access::Door;
use super::system_variables::SystemValues;
use counterpoint_control_api::{CallStack, NotThere, VACANT, is_vacant};
use counterpoint_fault::Halt;
use counterpoint_machine::model::ProgramVariables;
use counterpoint_sync::races::AccessMode;
use counterpoint_sync::separate::SeparateVariableUses;

/// Local variables #1–#33 of one level.
type Locals = [f64; 34];

/// Variables that only this channel sees.
#[derive(Debug)]
pub struct ChannelVariables {
    calls: CallStack<Locals>,
    own: FxHashMap<u32, f64>,
    /// Print of those that have been written: equal while their values are.
    print: u64,
    /// Writes, calls and returns so far.
    writes: u64,
    /// Separate variables that the channel has read without a value, and written; kept if other channels also run.
    pub(super) uses: SeparateVariableUses,
    /// Variables without a value, and variables that do not exist, are 0.
    pub(super) reads_zero: bool,
    /// System variables that programs write keep their values; otherwise the identification macro is asked where to
    /// write them.
    pub(super) keeps_system: bool,
    /// Those values.
    kept: FxHashMap<u32, f64>,
    /// The kept values of the system variables of the machine.
    pub(super) system: SystemValues,
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
    pub(crate) fn new(variables: &ProgramVariables) -> Self {
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
    pub(crate) fn locals(&self) -> impl Iterator<Item = (u8, f64)> {
        (0..).zip(self.calls.here()).map(|(number, value)| (number, *value)).filter(|(_, value)| !is_vacant(*value))
    }

    /// A number that is another one whenever variables may have other values than before.
    pub(super) fn writes(&self) -> u64 {
        self.writes
    }

    /// Takes the place of these.
    pub fn follow(&mut self, before: &Self) {
        self.writes = self.writes.max(before.writes) + 1;
    }

    /// Those that have a value: the ones of the running program first, each part ascending; at most so many.
    pub(super) fn with_value(&self, most: usize) -> Vec<(u32, f64)> {
        let locals = (0..).zip(self.calls.here()).filter(|(_, value)| !is_vacant(**value));
        let mut own: Vec<_> = self.own.iter().chain(&self.kept).map(|(number, value)| (*number, *value)).collect();
        own.sort_unstable_by_key(|(number, _)| *number);
        own.retain(|(_, value)| !is_vacant(*value));
        locals.map(|(number, value)| (number, *value)).chain(own).take(most).collect()
    }

    /// A local variable; number 0 and the numbers of others have no value here.
    #[inline]
    pub(super) fn local(&self, index: u32) -> f64 {
        self.calls.here().get(index as usize).copied().unwrap_or(VACANT)
    }

    fn set_own(&mut self, index: u32, value: f64) {
        self.writes += 1;
        let before = self.own.insert(index, value).unwrap_or(VACANT);
        self.print ^= print(index, before) ^ print(index, value);
    }

    /// Print of the variables that the running program can see: equal while all values are.
    pub(crate) fn print(&self) -> u64 {
        let locals = self.calls.here().iter().zip(0..);
        locals.fold(self.print, |all, (value, index)| all ^ print(index, *value))
    }

    /// Whether it has another value than before.
    fn set_local(&mut self, index: u32, value: f64) -> bool {
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

pub(super) fn within(ranges: &[(u32, u32)], index: u32) -> bool {
    ranges.iter().any(|&(low, high)| (low..=high).contains(&index))
}

/// Value of a numbered variable, if the machine has the variable and it is not vacant.
pub(super) fn value_of_variable(kernel: &mut Kernel<'_>, index: u32) -> Result<Option<f64>, Halt> {
    match kernel.value_of(index) {
        Ok(value) => Ok((!is_vacant(value)).then_some(value)),
        Err(NotThere::Halt(halt)) => Err(halt),
        Err(_) => Ok(None),
    }
}

impl Kernel<'_> {
    /// Whether this is a common variable, of all channels or of this one.
    pub(crate) fn is_common(&self, index: u32) -> bool {
        within(&self.channel.env.machine.variables.shared, index)
            || within(&self.channel.env.machine.variables.channel, index)
    }

    /// Value of a numbered variable.
    ///
    /// # Errors
    /// It does not exist, or the job was stopped.
    #[inline(never)]
    pub fn numbered(&mut self, index: u32) -> Result<f64, NotThere> {
        match self.value_of(index) {
            Ok(value) if !is_vacant(value) => Ok(value),
            Err(NotThere::Halt(halt)) => Err(NotThere::Halt(halt)),
            _ if self.dialect.variables.reads_zero => Ok(0.0),
            nothing => nothing,
        }
    }

    fn value_of(&mut self, index: u32) -> Result<f64, NotThere> {
        match index {
            0 | 3100 => Ok(VACANT),
            1..=33 => Ok(self.dialect.variables.local(index)),
            _ if within(&self.channel.env.machine.variables.shared, index) => self
                .access(Door::Common(index), AccessMode::Read, |shared| {
                    shared.variables.get(&index).copied().unwrap_or(VACANT)
                })
                .map_err(NotThere::Halt),
            _ if within(&self.channel.env.machine.variables.channel, index) => {
                let value = self.dialect.variables.own.get(&index).copied().unwrap_or(VACANT);
                if is_vacant(value) && !self.ports.coordinator.is_single() {
                    let place = self.channel.at.user_place();
                    let place = (place.file, place.line);
                    self.dialect.variables.uses.read_in_vain(index, place);
                }
                Ok(value)
            }
            _ => match self.dialect.variables.kept.get(&index) {
                Some(value) => Ok(*value),
                None => self.system_variable(index),
            },
        }
    }
}

impl Kernel<'_> {
    /// Writes a numbered variable.
    ///
    /// # Errors
    /// It does not exist or cannot be written, or the job was stopped.
    pub fn set_numbered(&mut self, index: u32, value: f64) -> Result<(), NotThere> {
        match index {
            1..=33 => {
                // Writing the same value changes nothing for the next pass.
                self.flow.pass.changes |= self.dialect.variables.set_local(index, value);
                Ok(())
            }
            _ if within(&self.channel.env.machine.variables.shared, index) => self
                .access(Door::Common(index), AccessMode::Write, |shared| {
                    if is_vacant(value) {
                        shared.variables.remove(&index);
                    } else {
                        shared.variables.insert(index, value);
                    }
                })
                .map_err(NotThere::Halt),
            _ if within(&self.channel.env.machine.variables.channel, index) => {
                self.flow.pass.changes = true;
                self.dialect.variables.set_own(index, value);
                if !self.ports.coordinator.is_single() {
                    let place = self.channel.at.user_place();
                    let place = (place.file, place.line);
                    self.dialect.variables.uses.write(index, place);
                }
                Ok(())
            }
            _ if self.dialect.variables.keeps_system && index >= 1000 => {
                self.flow.pass.effects = true;
                self.dialect.variables.writes += 1;
                self.dialect.variables.kept.insert(index, value);
                Ok(())
            }
            0 | 3100 => Err(NotThere::ReadOnly),
            _ => self.set_system_variable(index, value),
        }
    }
}
