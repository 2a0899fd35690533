//! Codes of single axes: clamps, and whole turns that are taken off.

use super::super::{self as ident, CodeId, DataId, code_facts};

/// The axis of a clamp code, and whether it clamps.
pub fn clamp_of(id: CodeId) -> Option<(DataId, bool)> {
    let name = code_facts(id)?.name;
    let clamps = name.strip_prefix("CODE_CLAMP_");
    let axis = clamps.or_else(|| name.strip_prefix("CODE_UNCLAMP_"))?;
    Some((ident::data(&format!("REG_AXIS_{axis}"))?, clamps.is_some()))
}

/// The axis of a code that takes whole turns off, none for all rotary ones.
pub fn unwinds(id: CodeId) -> Option<Option<DataId>> {
    match code_facts(id)?.name.strip_prefix("CODE_UNWIND_ROTARY")? {
        "" => Some(None),
        axis => Some(Some(ident::data(&format!("REG_AXIS{axis}"))?)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_axis_has_its_clamp() {
        let named = |name: &str| ident::code(name).and_then(clamp_of);
        let axes = ["X", "Y", "Z", "U", "V", "W", "AT", "BT", "CT", "CT2", "AH", "BH", "CH", "N", "N2", "E"];
        for axis in axes {
            let data = ident::data(&format!("REG_AXIS_{axis}")).unwrap();
            assert_eq!(named(&format!("CODE_CLAMP_{axis}")), Some((data, true)));
            assert_eq!(named(&format!("CODE_UNCLAMP_{axis}")), Some((data, false)));
        }
    }
}
