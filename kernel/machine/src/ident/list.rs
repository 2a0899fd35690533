//! How the list of code identifiers is made.

/// Rows: name without `CODE_`, group, order, built in, own, kind, and the meaning of an own identifier.
macro_rules! codes {
    ($($name:ident $group:literal $order:literal $built_in:literal $own:literal $kind:expr $(=> $meaning:literal)?;)*) => {
        #[allow(non_camel_case_types, clippy::upper_case_acronyms)]
        enum Position { $($name),* }
        /// Facts of every identifier, indexed by `CodeId`.
        pub const TABLE: &[CodeFacts] = &[$(CodeFacts {
            name: concat!("CODE_", stringify!($name)), group: $group, order: $order, built_in: $built_in, own: $own, kind: $kind,
            meaning: concat!($($meaning)?),
        }),*];
        $(#[doc = concat!("`CODE_", stringify!($name), "`" $(, $meaning)?, ".")]
        pub const $name: CodeId = CodeId::built_in(Position::$name as u16);)*
    };
}

pub(super) use codes;
