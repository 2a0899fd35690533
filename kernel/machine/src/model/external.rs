//! Variables that programs share with the PLC of the machine: rows of `[[external]]`.
//!
//! Facts: reference channel-synchronisation.md 1.7.

/// The existing variables.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Externals {
    /// Those that are described.
    pub rows: Vec<External>,
    /// Names that no row has are variables of all channels, too.
    pub any: bool,
}

impl Externals {
    /// The row of a name in capitals.
    #[must_use]
    pub fn find(&self, name: &str) -> Option<&External> {
        self.rows.iter().find(|row| row.name == name)
    }
}

/// A variable that programs share with the PLC.
#[derive(Debug, Clone, PartialEq)]
pub struct External {
    /// Name behind `V.E.`, in capitals.
    pub name: String,
    /// Each channel has its own; otherwise all share one.
    pub own: bool,
    /// It is read and written when the program is executed, not when it is decoded.
    pub synchronous: bool,
    /// Programs may read it.
    pub readable: bool,
    /// Programs may write it.
    pub writable: bool,
    /// Its values.
    pub kind: ExternalKind,
    /// Elements of an array; 0: it is none.
    pub elements: u32,
    /// Value at the start.
    pub value: f64,
}

/// The possible values of a variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ExternalKind {
    /// Numbers.
    Real,
    /// Whole numbers.
    Integer,
    /// 0 and 1.
    Boolean,
}
