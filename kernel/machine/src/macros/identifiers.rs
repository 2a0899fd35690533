//! The code and data identifiers as macros name them.
//!
//! Invariant: the numbers are those of the tables of the machine, one higher: 0 means none.

use crate::ident;

/// Number of a code, 0 for `CODE_NONE`; other spellings are accepted.
#[must_use]
pub fn code(name: &str) -> Option<u32> {
    if name == "CODE_NONE" { Some(0) } else { ident::code(name).map(|id| id.index() as u32 + 1) }
}

/// Number of data, 0 for `REG_NONE`; other spellings are accepted.
#[must_use]
pub fn register(name: &str) -> Option<u32> {
    if name == "REG_NONE" { Some(0) } else { ident::data(name).map(|id| id.index() as u32 + 1) }
}

/// The name of the tables for a code or data that may be spelled otherwise.
#[must_use]
pub fn canonical(name: &str) -> Option<&'static str> {
    let code = ident::code(name).and_then(ident::code_facts).map(|facts| facts.name);
    code.or_else(|| ident::data(name).and_then(ident::data_facts).map(|facts| facts.name))
}

/// All names, codes first.
pub fn names() -> impl Iterator<Item = &'static str> {
    let codes = ident::codes::TABLE.iter().map(|facts| facts.name);
    codes.chain(ident::data::TABLE.iter().map(|facts| facts.name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_names() {
        assert_eq!((code("CODE_NONE"), register("REG_NONE"), code("CODE_FOO")), (Some(0), Some(0), None));
        assert_eq!(code("CODE_AIR_OFF"), Some(1));
        assert_eq!((canonical("CODE_TPRINT"), canonical("DATA_AXIS_X")), (Some("CODE_COMMENT"), Some("REG_AXIS_X")));
        assert!(names().all(|name| canonical(name) == Some(name)));
    }
}
