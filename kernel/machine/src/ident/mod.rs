//! Identifiers of codes and data: the names that tables, macros and listings use for the meaning of a word.
//!
//! Invariant: an identifier is a small number everywhere but at the borders; custom names of a machine follow the
//! built-in ones.

pub mod codes;
pub mod data;
pub mod dimension;
pub mod kind;
mod list;
pub mod meaning;
mod own;
pub mod owns;
pub mod takes;

use crate::index::IdTable;
pub use crate::index::{CodeId, DataId};

/// Name of an identifier: a built-in one, or one of a machine's own.
pub type Name = std::borrow::Cow<'static, str>;

/// The names of all built-in codes.
#[must_use]
pub fn code_names() -> IdTable<CodeId, Name> {
    codes::TABLE.iter().map(|facts| Name::from(facts.name)).collect()
}

/// The names of all built-in data.
#[must_use]
pub fn data_names() -> IdTable<DataId, Name> {
    data::TABLE.iter().map(|facts| Name::from(facts.name)).collect()
}

/// Facts of a code identifier.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CodeFacts {
    /// Full name, `CODE_…`.
    pub name: &'static str,
    /// Default modal group, 0 = none.
    pub group: u16,
    /// Default order, 1–999.
    pub order: u16,
    /// A built-in action is documented.
    pub built_in: bool,
    /// Added by this project.
    pub own: bool,
    /// Its subject.
    pub kind: kind::CodeKind,
    /// The meaning of an own identifier, after a colon; empty for the others.
    meaning: &'static str,
}

impl CodeId {
    /// The subject of the code; a custom code is a separate family.
    #[must_use]
    pub fn kind(self) -> kind::CodeKind {
        code_facts(self).map_or(kind::CodeKind::Plain, |facts| facts.kind)
    }

    /// The first built-in code of a kind.
    #[must_use]
    pub fn of_kind(kind: kind::CodeKind) -> Option<Self> {
        codes::TABLE.iter().position(|facts| facts.kind == kind).map(|at| Self::built_in(at as u16))
    }
}

impl DataId {
    /// The subject of the data; custom data of a machine are plain.
    #[must_use]
    pub fn kind(self) -> kind::data::DataKind {
        data_facts(self).map_or(kind::data::DataKind::Plain, |facts| facts.kind)
    }

    /// Dimension of values where the machine does not say; those of a machine's own are numbers.
    #[must_use]
    pub fn dimension(self) -> dimension::Dimension {
        data_facts(self).map_or(dimension::Dimension::None, |facts| facts.dimension)
    }
}

/// Facts of a data identifier.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DataFacts {
    /// Full name, `REG_…`.
    pub name: &'static str,
    /// A built-in action takes it.
    pub built_in: bool,
    /// Added by this project.
    pub own: bool,
    /// Its subject.
    pub kind: kind::data::DataKind,
    /// Dimension of its values where the machine does not say.
    pub dimension: dimension::Dimension,
    /// The meaning of an own identifier; empty for the others.
    meaning: &'static str,
}

/// Other spellings that the pages of the emulated system use for the same identifier (reference README, conflicts).
fn canonical_code(name: &str) -> String {
    let name = name.to_ascii_uppercase();
    match name.as_str() {
        "CODE_TPRINT" => return "CODE_COMMENT".into(),
        "CODE_LINEAR" => return "CODE_INTERP_LINEAR".into(),
        "CODE_POSITION_INCREMENTAL" => return "CODE_POSITION_RELATIVE".into(),
        _ => {}
    }
    match name.strip_prefix("CODE_SPINDL_") {
        Some(rest) => format!("CODE_SPINDLE_{rest}"),
        None => name,
    }
}

/// Built-in code identifier by name; letter case and the documented other spellings are accepted.
#[must_use]
pub fn code(name: &str) -> Option<CodeId> {
    let name = canonical_code(name);
    codes::TABLE.iter().position(|facts| facts.name == name).map(|at| CodeId::built_in(at as u16))
}

/// Built-in data identifier by name; letter case and the prefix `DATA_` are accepted.
#[must_use]
pub fn data(name: &str) -> Option<DataId> {
    let name = name.to_ascii_uppercase();
    let name = name.strip_prefix("DATA_").map_or(name.clone(), |rest| format!("REG_{rest}"));
    data::TABLE.iter().position(|facts| facts.name == name).map(|at| DataId::built_in(at as u16))
}

/// Facts of a built-in code identifier; `None` for a custom one.
#[must_use]
pub fn code_facts(id: CodeId) -> Option<&'static CodeFacts> {
    codes::TABLE.get(id.index())
}

/// Facts of a built-in data identifier; `None` for a custom one.
#[must_use]
pub fn data_facts(id: DataId) -> Option<&'static DataFacts> {
    data::TABLE.get(id.index())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The annex as it is printed: one line an identifier, tabs between, a heading.
    #[test]
    fn the_tables_are_the_documented_annex() {
        let yes = |flag: bool| if flag { "yes" } else { "no" };
        let mut annex = String::from("identifier\tgroup\torder\tbuilt_in\n");
        for f in codes::TABLE.iter().filter(|f| !f.own) {
            annex += &format!("{}\t{}\t{}\t{}\n", f.name, f.group, f.order, yes(f.built_in));
        }
        assert_eq!(annex.lines().count(), 438);
        assert_eq!(
            blake3::hash(annex.as_bytes()).to_hex().as_str(),
            "f1443202b17c98c3bc98b7f25fed9616307694a1775e0930e7f1dbeca667b501"
        );
        let mut annex = String::from("identifier\tbuilt_in\n");
        for f in data::TABLE.iter().filter(|f| !f.own) {
            annex += &format!("{}\t{}\n", f.name, yes(f.built_in));
        }
        assert_eq!(annex.lines().count(), 212);
        assert_eq!(
            blake3::hash(annex.as_bytes()).to_hex().as_str(),
            "625893ab05509500d24b6208bb50038a7ba51b64fdad5dcc02c8f99cc4e63908"
        );
    }

    #[test]
    fn orders_follow_the_documented_bands() {
        for f in codes::TABLE {
            assert!((1..=999).contains(&f.order) && f.group <= 999, "{}", f.name);
        }
        let of = |name: &str| code(name).and_then(code_facts).map(|f| (f.group, f.order)).unwrap();
        assert_eq!(of("CODE_GOHOME").1, 450);
        assert_eq!(of("CODE_INTERP_DEF_CLW").1, 600);
        assert_eq!((of("CODE_SPINDLE_CLW"), of("CODE_SPINDLE_OFF")), ((64, 300), (64, 700)));
        assert_eq!((of("CODE_STOP").1, of("CODE_REWIND").1, of("CODE_END").1), (900, 900, 900));
        assert_eq!((of("CODE_PLANE_XY").0, of("CODE_UNITS_PRIMARY").0, of("CODE_CYCLE_DRILL").0), (2, 6, 9));
    }

    #[test]
    fn constants_stand_where_their_names_stand() {
        assert_eq!(code("CODE_RAPID"), Some(codes::RAPID));
        assert_eq!(code("code_spindl_clw"), Some(codes::SPINDLE_CLW));
        assert_eq!(code("CODE_TPRINT"), Some(codes::COMMENT));
        assert_eq!(data("DATA_AXIS_X"), Some(data::AXIS_X));
        assert_eq!(code("CODE_NO_SUCH"), None);
        assert_eq!(code_facts(codes::TOOL_LOAD).map(|f| (f.group, f.order)), Some((0, 700)));
    }
}
