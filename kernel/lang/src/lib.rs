//! The macro language of the control emulator. Knows nothing of machines, programs, channels or I/O.
//!
//! Ground floor first: [`value`], [`ident`], [`source`], [`diag`], [`fault`], [`lex`], [`ast`], [`parse`],
//! [`mod@format`], [`pattern`], [`layout`], [`state`], [`host`], [`func`], [`bytecode`], [`program`], [`compile`],
//! [`vm`], [`explain`]. A source is lexed and parsed without ever failing, compiled once to [`bytecode`] with every
//! error it has, and run by [`vm::run`] against a [`host::MacroHost`].

pub mod ast;
pub mod bytecode;
pub mod compile;
pub mod diag;
pub mod explain;
pub mod fault;
pub mod format;
pub mod func;
pub mod host;
pub mod ident;
pub mod layout;
pub mod lex;
pub mod parse;
pub mod pattern;
pub mod program;
pub mod source;
pub mod state;
pub mod value;
pub mod vm;
