//! Identifiers of codes and data as values of macros.

use counterpoint_lang::value::MacroValue;

use counterpoint_machine::Machine;
use counterpoint_machine::ident::{CodeId, DataId};

/// Identifier of a code value, none for `CODE_NONE`.
pub fn code_id(machine: &Machine, value: &MacroValue) -> Option<CodeId> {
    match value {
        MacroValue::Code(number) => machine.code_names.id(number.checked_sub(1)? as usize),
        _ => None,
    }
}

/// Identifier of a data value, none for `REG_NONE`.
pub fn data_id(machine: &Machine, value: &MacroValue) -> Option<DataId> {
    match value {
        MacroValue::Register(number) => machine.data_names.id(number.checked_sub(1)? as usize),
        _ => None,
    }
}

/// Value of a code.
pub fn code_value(id: Option<CodeId>) -> MacroValue {
    MacroValue::Code(id.map_or(0, |id| id.index() as u32 + 1))
}

/// Value of data.
pub fn data_value(id: DataId) -> MacroValue {
    MacroValue::Register(id.index() as u32 + 1)
}
