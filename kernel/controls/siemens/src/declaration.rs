//! Declarations as data: DEF, REDEF, PROC and EXTERN.

use super::compiled::{Expression, SiemensArgument};
use super::value::Type;

/// Whose variable it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum VariableScope {
    /// All channels.
    Nck,
    /// All programs of the channel.
    Channel,
    /// This program.
    Local,
}

/// DEF: variables of one type.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct VariableDeclaration {
    pub(super) scope: Option<VariableScope>,
    /// None in a REDEF of attributes.
    pub(super) kind: Option<Type>,
    /// Longest text of a STRING.
    pub(super) length: Option<Expression>,
    pub(super) variables: Vec<DeclaredVariable>,
}

/// A variable of a declaration.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct DeclaredVariable {
    pub(super) name: String,
    pub(super) sizes: Vec<Expression>,
    pub(super) initial: Option<Initial>,
}

/// The initial value of a variable.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Initial {
    One(Expression),
    List(Vec<SiemensArgument>),
    Fill(Vec<SiemensArgument>),
}

/// PROC or EXTERN.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ProcHeader {
    pub(super) name: String,
    pub(super) parameters: Vec<Parameter>,
    /// SAVE: modal codes come back at the end.
    pub(super) save: bool,
}

/// A parameter of a subprogram.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Parameter {
    pub(super) kind: Type,
    /// Assignments of the subprogram are visible to its caller.
    pub(super) by_reference: bool,
    /// Empty in EXTERN.
    pub(super) name: String,
    /// It is an array.
    pub(super) array: bool,
    pub(super) default: Option<Expression>,
}
