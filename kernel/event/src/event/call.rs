//! Subprograms.

use std::sync::Arc;

use super::declare::record;

record! {
    /// A subprogram was entered.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct SubprogramEntry {
        /// Program number or name as written.
        pub program: Arc<str> = 1,
        /// Nesting level inside the subprogram, from 1.
        pub level: u16 = 2,
    }

    fn action(&self, _: fn(f64) -> String) -> Option<String> {
        Some(format!("call id={}", self.program))
    }
}

record! {
    /// A subprogram was left.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub struct Return {
        /// Nesting level that was left, from 1.
        pub level: u16 = 1,
    }

    fn action(&self, _: fn(f64) -> String) -> Option<String> {
        Some("return".to_owned())
    }
}
