//! Variables of the components of a composite machine.
//!
//! *Invariant:* blank and none on a machine that is not a composite, and in a master kernel where no component works.
//! Facts: reference system-variables.md.

use counterpoint_lang::ident::minor_code;
use counterpoint_lang::value::{MacroValue, ValueType};

use super::{Read, Write};
use counterpoint_emulator::channel::Kernel;
use counterpoint_emulator::channel::components::PreparedComponent;

fn nth<'k>(kernel: &Kernel<'k>, at: &[i64]) -> Option<&'k PreparedComponent<'k>> {
    let place = at.first().copied().and_then(|at| usize::try_from(at).ok()).and_then(|at| at.checked_sub(1))?;
    kernel.components.all.get(place)
}

fn designator(component: Option<&PreparedComponent<'_>>) -> MacroValue {
    MacroValue::text(component.map_or("", |component| component.designator))
}

fn name(component: Option<&PreparedComponent<'_>>) -> MacroValue {
    MacroValue::text(component.map_or("", |component| component.name))
}

/// How a variable is read.
pub(crate) fn find(name_of: &str) -> Option<(Read, Option<Write>)> {
    let read: Read = match name_of {
        "$CPPCNT" => |kernel, _| MacroValue::Real(kernel.components.all.len() as f64),
        "$CPPADS" => |kernel, at| designator(nth(kernel, at)),
        "$CPPANM" => |kernel, at| name(nth(kernel, at)),
        "$CPPDES" => |kernel, _| {
            let current = kernel.components.current();
            let code = current.and_then(|component| minor_code(component.designator));
            code.map_or(ValueType::Keyword.initial(), MacroValue::Keyword)
        },
        "$CPPNAM" => |kernel, _| name(kernel.components.current()),
        "$CPPPDS" => |kernel, _| designator(kernel.components.previous()),
        "$CPPPNM" => |kernel, _| name(kernel.components.previous()),
        _ => return None,
    };
    Some((read, None))
}
