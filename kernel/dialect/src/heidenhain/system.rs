//! FN 18: SYSREAD.
//!
//! Facts: programming manuals of the control (system data by ID, NR and IDX), reference control-emulator.md 4.3. The
//! machine is asked first. Invariant: what is not known here is diagnosed, the parameter becomes 0.

use super::Heidenhain;
use super::eval::{Asked, Evaluator};
use super::formula::{Formula, Name};
use super::path::AXES;
use super::variables::Value;
use super::words::shown;
use crate::host::Host;
use counterpoint_fault as diag;
use counterpoint_fault::Halt;

impl Heidenhain {
    pub(super) fn system_read(
        &mut self,
        host: &mut dyn Host,
        to: Name,
        (id, number, index): (&Formula, &Formula, Option<&Formula>),
    ) -> Result<(), Halt> {
        let mut evaluator = Evaluator::new(&mut self.variables, host);
        let (id, number) = (evaluator.number(id)?, evaluator.number(number)?);
        let index = match index {
            Some(index) => Some(evaluator.number(index)?),
            None => None,
        };
        let mut asked = format!("ID{} NR{}", shown(id), shown(number));
        if let Some(index) = index {
            asked.push_str(&format!(" IDX{}", shown(index)));
        }
        let value = match evaluator.ask(&asked)? {
            Asked::Value(value) => value,
            Asked::Nothing | Asked::Kept => Value::Number(0.0),
            Asked::Unknown => {
                let known = self.system_value(host, id, number, index);
                if known.is_none() {
                    let text = format!("no value is known for {asked} in '{}'; 0 is used", host.block_text());
                    host.diagnose(&diag::SYSTEM_DATA_UNKNOWN, text);
                }
                Value::Number(known.unwrap_or(0.0))
            }
        };
        Evaluator::new(&mut self.variables, host).assign(to, value)
    }

    /// System data that the kernel and this program know.
    fn system_value(&self, host: &dyn Host, id: f64, number: f64, index: Option<f64>) -> Option<f64> {
        let control = &self.variables.control;
        if !(0.0..10_000.0).contains(&id) || !(0.0..10_000.0).contains(&number) {
            return None;
        }
        match (id as u32, number as u32) {
            (20, 1) => control.tool,
            (20, 3) => Some(control.tool_axis.map_or(-1.0, |axis| axis as f64)),
            (20, 5) => Some(control.spindle.map_or(-1.0, f64::from)),
            (20, 8) => Some(f64::from(u8::from(control.coolant))),
            (210, 6) => Some(if host.plane_angles().is_some() { -1.0 } else { 0.0 }),
            (240 | 270, 1) => {
                let index = index.filter(|index| (1.0..=9.0).contains(index))? as usize;
                let letter = AXES.get(index - 1)?;
                let positions = host.positions();
                let is = |name: &str| name.trim_end_matches(|c: char| c.is_ascii_digit()) == *letter;
                let (_, work, machine) = positions.iter().find(|(name, ..)| is(name))?;
                let value = if id == 240.0 { *machine } else { *work };
                let turns = (4..=6).contains(&index);
                Some(if turns { value } else { value / host.length_factor() })
            }
            _ => None,
        }
    }
}
