//! The macro language of the control emulator. Knows nothing of machines, programs, channels or I/O.
//!
//! Ground floor first: [`value`], [`ident`], [`source`], [`diag`], [`lex`], [`ast`], [`parse`], [`format`].

pub mod ast;
pub mod diag;
pub mod fault;
pub mod format;
pub mod ident;
pub mod lex;
pub mod parse;
pub mod pattern;
pub mod source;
pub mod value;
