//! The macro language of the control emulator. Knows nothing of machines, programs, channels or I/O.
//!
//! Ground floor first: [`value`], [`ident`], [`source`], [`diag`], [`lex`], [`format`].

pub mod diag;
pub mod format;
pub mod ident;
pub mod lex;
pub mod source;
pub mod value;
