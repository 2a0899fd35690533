//! Small functions that are executed in registers of their callers.
//!
//! *Invariant:* a body changes nothing but registers that only bodies use until its last form returns the result, so it
//! can be abandoned at any form, and the call itself is executed instead.

use super::fast::{Fast, Near};
use super::{Slot, Target};
use crate::value::ValueType;

/// Code that a call runs instead of the function.
#[derive(Clone, Debug)]
pub struct Body {
    /// The call: function and list of the arguments.
    pub callee: u16,
    /// List of the arguments.
    pub list: u16,
    /// Short forms of the function, each at its place in the function, with registers of the caller.
    pub forms: Vec<Fast>,
    /// Registers of arguments that must be of a type.
    pub typed: Vec<(Near, ValueType)>,
    /// Registers of parameters that the function changes, and those of their arguments.
    pub copied: Vec<(Near, Near)>,
    /// Registers of variables that are unset at the beginning.
    pub cleared: Vec<Near>,
    /// The result.
    pub result: Near,
    /// Its type.
    pub kind: Option<ValueType>,
    /// It may be read or given before it is set: it begins as `$NULL`.
    pub is_null_first: bool,
}

/// The effect of a form on registers, and where it continues.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FormEffect {
    /// Registers that it reads.
    pub reads: [Option<Near>; 4],
    /// The register that it writes.
    pub writes: Option<Near>,
    /// Instructions that it takes the place of.
    pub length: usize,
    /// Where it may jump to.
    pub target: Option<Target>,
    /// It may continue with the next instruction.
    pub falls: bool,
}

impl Fast {
    /// The form with other registers and its effect on them; none for a form that touches more than registers, or whose
    /// registers are in a list.
    #[must_use]
    pub fn moved(self, of: &mut dyn FnMut(Near) -> Option<Near>) -> Option<(Fast, FormEffect)> {
        let mut effect = FormEffect { length: 1, falls: true, ..FormEffect::default() };
        macro_rules! reads {
            ($register:expr) => {{
                if let Some(place) = effect.reads.iter_mut().find(|place| place.is_none()) {
                    *place = Some($register);
                }
                of($register)?
            }};
        }
        macro_rules! writes {
            ($register:expr) => {{
                effect.writes = Some($register);
                of($register)?
            }};
        }
        macro_rules! jumps {
            ($target:expr) => {{
                effect.target = Some($target);
                $target
            }};
        }
        macro_rules! two {
            ($form:ident { $($given:ident),* }) => {
                Fast::$form { to: writes!(to_of(self)?), $($given: reads!($given)),* }
            };
        }
        let form = match self {
            Fast::Move { to, a } => Fast::Move { a: reads!(a), to: writes!(to) },
            Fast::MoveNumber { to, a } => Fast::MoveNumber { a: reads!(a), to: writes!(to) },
            Fast::MoveTyped { to, a, kind } => Fast::MoveTyped { a: reads!(a), to: writes!(to), kind },
            Fast::Negate { to, a } => Fast::Negate { a: reads!(a), to: writes!(to) },
            Fast::Not { to, a } => Fast::Not { a: reads!(a), to: writes!(to) },
            Fast::Truth { to, a } => Fast::Truth { a: reads!(a), to: writes!(to) },
            Fast::Add { a, b, .. } => two!(Add { a, b }),
            Fast::Subtract { a, b, .. } => two!(Subtract { a, b }),
            Fast::Multiply { a, b, .. } => two!(Multiply { a, b }),
            Fast::Divide { a, b, .. } => two!(Divide { a, b }),
            Fast::Power { a, b, .. } => two!(Power { a, b }),
            Fast::Join { a, b, .. } => two!(Join { a, b }),
            Fast::Compare { relation, to, a, b } => {
                Fast::Compare { relation, a: reads!(a), b: reads!(b), to: writes!(to) }
            }
            Fast::Math { to, a, function } => Fast::Math { a: reads!(a), to: writes!(to), function },
            Fast::Pair { to, a, b, function } => Fast::Pair { a: reads!(a), b: reads!(b), to: writes!(to), function },
            Fast::AddTo { to, a } => {
                effect.reads = [Some(to), None, None, None];
                Fast::AddTo { a: reads!(a), to: writes!(to) }
            }
            Fast::Two { first, then, to, a, b, c } => {
                effect.length = 2;
                Fast::Two { first, then, a: reads!(a), b: reads!(b), c: reads!(c), to: writes!(to) }
            }
            Fast::MultiplyAdd { a, b, c, .. } => {
                effect.length = 2;
                two!(MultiplyAdd { a, b, c })
            }
            Fast::DivideFrom { a, b, c, .. } => {
                effect.length = 2;
                two!(DivideFrom { a, b, c })
            }
            Fast::Element { array, index, .. } => two!(Element { array, index }),
            Fast::Cell { array, row, column, .. } => two!(Cell { array, row, column }),
            Fast::ElementThen { then, to, array, index, c } => {
                effect.length = 2;
                let (array, index, c) = (reads!(array), reads!(index), reads!(c));
                Fast::ElementThen { then, to: writes!(to), array, index, c }
            }
            Fast::UnlessElement { relation, array, index, b, target } => {
                effect.length = 2;
                let (array, index, b) = (reads!(array), reads!(index), reads!(b));
                Fast::UnlessElement { relation, array, index, b, target: jumps!(target) }
            }
            Fast::UnlessCell { relation, array, row, column, b, target } => {
                effect.length = 2;
                let (array, row, column, b) = (reads!(array), reads!(row), reads!(column), reads!(b));
                Fast::UnlessCell { relation, array, row, column, b, target: jumps!(target) }
            }
            Fast::Jump { target } => {
                effect.falls = false;
                Fast::Jump { target: jumps!(target) }
            }
            Fast::JumpIf { a, target } => Fast::JumpIf { a: reads!(a), target: jumps!(target) },
            Fast::JumpUnless { a, target } => Fast::JumpUnless { a: reads!(a), target: jumps!(target) },
            Fast::UnlessEqual { a, b, target } => {
                Fast::UnlessEqual { a: reads!(a), b: reads!(b), target: jumps!(target) }
            }
            Fast::UnlessNotEqual { a, b, target } => {
                Fast::UnlessNotEqual { a: reads!(a), b: reads!(b), target: jumps!(target) }
            }
            Fast::UnlessLess { a, b, target } => {
                Fast::UnlessLess { a: reads!(a), b: reads!(b), target: jumps!(target) }
            }
            Fast::UnlessLessEqual { a, b, target } => {
                Fast::UnlessLessEqual { a: reads!(a), b: reads!(b), target: jumps!(target) }
            }
            Fast::UnlessGreater { a, b, target } => {
                Fast::UnlessGreater { a: reads!(a), b: reads!(b), target: jumps!(target) }
            }
            Fast::UnlessGreaterEqual { a, b, target } => {
                Fast::UnlessGreaterEqual { a: reads!(a), b: reads!(b), target: jumps!(target) }
            }
            Fast::IfWhen { a, b, target } => Fast::IfWhen { a: reads!(a), b: reads!(b), target: jumps!(target) },
            Fast::IfThru { a, low, high, target } => {
                let (a, low, high) = (reads!(a), reads!(low), reads!(high));
                Fast::IfThru { a, low, high, target: jumps!(target) }
            }
            Fast::Return => {
                effect.falls = false;
                Fast::Leave
            }
            _ => return None,
        };
        Some((form, effect))
    }
}

/// The destination of a form that has one.
fn to_of(form: Fast) -> Option<Near> {
    match form {
        Fast::Add { to, .. }
        | Fast::Subtract { to, .. }
        | Fast::Multiply { to, .. }
        | Fast::Divide { to, .. }
        | Fast::Power { to, .. }
        | Fast::Join { to, .. }
        | Fast::MultiplyAdd { to, .. }
        | Fast::DivideFrom { to, .. }
        | Fast::Element { to, .. }
        | Fast::Cell { to, .. } => Some(to),
        _ => None,
    }
}

/// A register as short forms name it.
#[must_use]
pub fn near(slot: Slot) -> Option<Near> {
    Near::try_from(slot).ok()
}
