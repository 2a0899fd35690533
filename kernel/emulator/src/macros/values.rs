//! Identifiers of codes and data as values of macros.

use counterpoint_lang::value::Value;

use counterpoint_machine::ident::{CodeId, DataId};

/// Identifier of a code value, none for `CODE_NONE`.
pub(crate) fn code_id(value: &Value) -> Option<CodeId> {
    match value {
        Value::Code(at) => at.checked_sub(1).and_then(|at| u16::try_from(at).ok()).map(CodeId),
        _ => None,
    }
}

/// Identifier of a data value, none for `REG_NONE`.
pub(crate) fn data_id(value: &Value) -> Option<DataId> {
    match value {
        Value::Register(at) => at.checked_sub(1).and_then(|at| u16::try_from(at).ok()).map(DataId),
        _ => None,
    }
}

/// Value of a code.
pub(crate) fn code_value(id: Option<CodeId>) -> Value {
    Value::Code(id.map_or(0, |id| u32::from(id.0) + 1))
}

/// Value of data.
pub(crate) fn data_value(id: DataId) -> Value {
    Value::Register(u32::from(id.0) + 1)
}
