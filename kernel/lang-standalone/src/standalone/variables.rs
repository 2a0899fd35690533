//! System and global variables.

use counterpoint_lang::fault::Outcome;
use counterpoint_lang::func::stamp;
use counterpoint_lang::host::{MacroHost, VariableHost};
use counterpoint_lang::state::MemoryTally;
use counterpoint_lang::value::MacroValue;

use super::Standalone;

impl VariableHost for Standalone {
    fn read_system(&mut self, index: u32, indices: &[i64]) -> Outcome<MacroValue> {
        let value = self.system.read(index, indices)?;
        if self.system.is_date(index) {
            let (now, offset, _) = self.now();
            return Ok(MacroValue::text(stamp(now, offset)));
        }
        Ok(value)
    }

    fn write_system(&mut self, index: u32, indices: &[i64], value: MacroValue) -> Outcome<()> {
        self.system.write(index, indices, value)
    }

    fn global(&mut self, index: u32, _: Option<usize>, access: &mut dyn FnMut(&mut MacroValue)) {
        if let Some(value) = self.own_global(index) {
            access(value);
        }
    }

    fn own_global(&mut self, index: u32) -> Option<&mut MacroValue> {
        self.global_place(index as usize)
    }

    fn held(&self, scale: &mut MemoryTally) {
        for (index, value) in self.globals.iter().enumerate() {
            let from = scale.bytes;
            scale.add(value);
            scale.held_by(from, || format!("the GLOBAL variable {}", index + 1));
        }
        let from = scale.bytes;
        self.system.all().for_each(|value| scale.add(value));
        scale.held_by(from, || "system variables".to_owned());
    }
}
