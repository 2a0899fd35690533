//! Variables of the kernel and of the machine for the interpreter.

use counterpoint_channel::shared_target::SharedTarget;
use counterpoint_control_api::{IdentificationAnswer, NotThere, ValueHost};
use counterpoint_fault::{Acted, Halt};
use counterpoint_lang::value::MacroValue;
use counterpoint_machine::macros::model::Hook;
use counterpoint_sync::races::AccessMode;

use crate::channel::Kernel;
use crate::channel::variables::is_common;

impl ValueHost for Kernel<'_> {
    fn shared(&mut self, name: &str) -> Result<Option<MacroValue>, Halt> {
        self.access(SharedTarget::Named(name), AccessMode::Read, |shared| shared.named.get(name).cloned())
    }

    fn shared_number(&mut self, name: &str) -> Result<Option<f64>, Halt> {
        self.access(SharedTarget::Named(name), AccessMode::Read, |shared| {
            shared.named.get(name).and_then(MacroValue::as_real)
        })
    }

    fn set_shared(&mut self, name: &str, value: Option<MacroValue>) -> Acted {
        let limit = self.channel.env.shares().common;
        let growth = name.len() + 200 + value.as_ref().and_then(MacroValue::as_text).map_or(0, str::len);
        let over = self.access(SharedTarget::Named(name), AccessMode::Write, |shared| match value {
            Some(value) => {
                match shared.named.get_mut(name) {
                    Some(place) => *place = value,
                    None => {
                        shared.named.insert(name.into(), value);
                    }
                }
                shared.grown(growth, limit)
            }
            None => {
                shared.named.remove(name);
                false
            }
        })?;
        if over { Err(self.out_of_memory("variables that all channels share use most of it")) } else { Ok(()) }
    }

    fn has_own_common(&self) -> bool {
        self.channel.env.machine.variables.own_common
    }

    fn local_number(&self, index: u32) -> f64 {
        self.dialect.variables.local(index)
    }

    fn number(&mut self, index: u32) -> Result<f64, NotThere> {
        self.numbered(index)
    }

    fn set_number(&mut self, index: u32, value: f64) -> Result<(), NotThere> {
        self.set_numbered(index, value)
    }

    fn program_alarm(&self) -> u32 {
        self.channel.env.machine.variables.system.alarm
    }

    fn is_common(&self, index: u32) -> bool {
        is_common(&self.channel, index)
    }

    fn set_vacant(&mut self, on: bool) {
        self.dialect.variables.reads_zero = !on;
    }

    fn set_asking(&mut self, on: bool) {
        self.dialect.variables.keeps_system = !on;
    }

    fn identifies(&self) -> bool {
        self.macros.ready(Hook::Identification).is_some()
    }

    fn identify(&mut self, text: &str, assigned: Option<&MacroValue>) -> Result<IdentificationAnswer, Halt> {
        let Some(hooks) = self.plan.hooks else { return Ok(IdentificationAnswer::Unknown) };
        (hooks.identify)(self, text, assigned.cloned().unwrap_or(MacroValue::Null))
    }
}
