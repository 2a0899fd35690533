//! A register of a machine: its number format, and the data that it supplies.
//!
//! *Invariant:* everything comes from the checked machine, with the file and the line that define it.

use counterpoint_kernel::machine::Machine;
use counterpoint_kernel::machine::ident::{meaning, takes};
use counterpoint_kernel::machine::index::{CodeRowId, DataRowId, RegisterId};
use counterpoint_kernel::machine::rows::{DecimalPointRule, Excess, Register, ZeroRule};
use counterpoint_kernel::machine::show;
use serde_json::{Value, json};

use super::related;

/// A row of the data table with its meaning, the format of its number, and the codes that read it.
pub(super) fn data(machine: &Machine, id: DataRowId) -> Value {
    let row = &machine.data[id];
    let name = machine.data_name(row.id);
    let mut value = show::data_json(machine, row);
    let readers: Vec<String> = takes::codes_of(name)
        .into_iter()
        .filter(|code| machine.codes.iter().any(|row| row.enable && machine.code_name(row.id) == *code))
        .map(str::to_owned)
        .collect();
    let more = json!({
        "meaning": meaning::of(name).unwrap_or_else(|| "data of the machine's own".to_owned()),
        "number": row.register.map(|id| number(&machine.registers[id])),
        "read_by": readers,
        "macros": related::macros(machine, name),
    });
    if let (Value::Object(value), Value::Object(more)) = (&mut value, more) {
        value.extend(more);
    }
    value
}

/// A register with its number format, and the refusals that test its words beside the codes.
pub(super) fn register(machine: &Machine, id: RegisterId, codes: &[CodeRowId]) -> Value {
    let register = &machine.registers[id];
    let mut value = show::register_json(register);
    if let Value::Object(value) = &mut value {
        value.insert("number".to_owned(), json!(number(register)));
        let refusals = related::refusals(machine, |rule| related::looks_at(machine, rule, id, codes));
        value.insert("refusals".to_owned(), json!(refusals));
    }
    value
}

/// How a number of the register is written: `4.3 digits, 1 without a point is 0.001, signed`.
fn number(register: &Register) -> String {
    let format = &register.format;
    let mut parts = vec![format!("{}.{} digits", format.whole, format.frac)];
    let least = || 10_f64.powi(-i32::from(format.frac));
    match (format.point, format.lead, format.trail) {
        _ if format.frac == 0 => parts.push("whole number or with a point".to_owned()),
        (DecimalPointRule::Omit, ZeroRule::Omit, _) => parts.push(format!("1 without a point is {}", least())),
        (DecimalPointRule::Omit, _, ZeroRule::Omit) => {
            parts.push("digits without a point count from the left".to_owned())
        }
        _ => parts.push("1 without a point is 1".to_owned()),
    }
    if !register.pointed {
        parts.pop();
        parts.push("no decimal point".to_owned());
    }
    parts.push(if register.signed { "signed" } else { "not negative" }.to_owned());
    match format.excess {
        Excess::Kept => {}
        Excess::Cut => parts.push("further digits are cut off".to_owned()),
        Excess::Rounded => parts.push("further digits are rounded".to_owned()),
    }
    parts.join(", ")
}
