//! Numbered variables: local, of the channel, common to all channels, and system variables.
//!
//! Facts: reference channel-synchronisation.md 1.3 (variable ranges) and control-emulator.md 5.4. *Invariant:* common
//! variables are touched only in shared operations.

use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::channel_variables::within;
use counterpoint_channel::shared_target::SharedTarget;
use counterpoint_control_api::{NotThere, VACANT, is_vacant};
use counterpoint_fault::Halt;
use counterpoint_sync::races::AccessMode;

use super::Kernel;

/// Value of a numbered variable, if the machine has the variable and it is not vacant.
pub(super) fn value_of_variable(kernel: &mut Kernel<'_>, index: u32) -> Result<Option<f64>, Halt> {
    match kernel.value_of(index) {
        Ok(value) => Ok((!is_vacant(value)).then_some(value)),
        Err(NotThere::Halt(halt)) => Err(halt),
        Err(_) => Ok(None),
    }
}

impl Kernel<'_> {
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
                .access(SharedTarget::Common(index), AccessMode::Read, |shared| {
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

/// Whether this is a common variable, of all channels or of this one.
pub(crate) fn is_common(channel: &ChannelContext<'_>, index: u32) -> bool {
    within(&channel.env.machine.variables.shared, index) || within(&channel.env.machine.variables.channel, index)
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
                .access(SharedTarget::Common(index), AccessMode::Write, |shared| {
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
