//! One entry of the registry: the codes that an action takes, and its function.
//!
//! *Invariant:* no two entries take the same code.

use counterpoint_fault::Acted;
use counterpoint_machine::ident::CodeId;
use counterpoint_machine::ident::kind::CodeKind;
use counterpoint_machine::rows::CodeRow;
use counterpoint_program::block::PendingCode;

use crate::context::ActionContext;

/// Action of a code, with its row and its written form.
pub(crate) type ActFn = fn(&mut ActionContext<'_, '_>, &CodeRow, &PendingCode) -> Acted;

/// Which codes an entry takes.
#[derive(Debug, Clone, Copy)]
enum CodeSelector {
    /// These.
    Listed(&'static [CodeId]),
    /// Those of a kind.
    OfKind(fn(CodeKind) -> bool),
}

/// Effect of an action on a move that compensation of the tool radius keeps back.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum CompensationEffect {
    /// A move along the contour.
    Follows,
    /// Nothing: the move may wait longer.
    Waits,
    /// A command to the spindle: the move may wait longer, unless another channel can see the command.
    Commands,
    /// The action goes without compensation, which begins again after it.
    Leaves,
    /// The move is finished.
    Ends,
}

/// A built-in action.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ActionEntry {
    codes: CodeSelector,
    pub(crate) act: ActFn,
    /// A motion code of the program, which meets an active cycle.
    pub(crate) moves: bool,
    pub(crate) contour: CompensationEffect,
}

impl ActionEntry {
    /// The action of these codes.
    pub(crate) const fn of(codes: &'static [CodeId], act: ActFn) -> Self {
        Self { codes: CodeSelector::Listed(codes), act, moves: false, contour: CompensationEffect::Ends }
    }

    /// The action of the codes of a kind.
    pub(crate) const fn of_kind(takes: fn(CodeKind) -> bool, act: ActFn) -> Self {
        Self { codes: CodeSelector::OfKind(takes), act, moves: false, contour: CompensationEffect::Ends }
    }

    /// It moves the tool as the program says.
    pub(crate) const fn moves(self) -> Self {
        Self { moves: true, ..self }
    }

    /// Its effect on a move that is held back.
    pub(crate) const fn contour(self, contour: CompensationEffect) -> Self {
        Self { contour, ..self }
    }

    /// Whether it takes this code.
    pub(crate) fn takes(&self, id: CodeId) -> bool {
        match self.codes {
            CodeSelector::Listed(codes) => codes.contains(&id),
            CodeSelector::OfKind(takes) => takes(id.kind()),
        }
    }
}

/// An entry for the codes of a kind: its pattern, and its action on the values that the pattern binds.
macro_rules! entry_of_kind {
    ($pattern:pat => |$act:ident, $row:ident, $code:ident| $body:expr) => {
        $crate::entry::ActionEntry::of_kind(
            #[allow(unused_variables)]
            |kind| matches!(kind, $pattern),
            |$act, $row, $code| match $row.id.kind() {
                $pattern => $body,
                _ => Ok(()),
            },
        )
    };
}
pub(crate) use entry_of_kind;
