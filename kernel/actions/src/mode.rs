//! Modes whose effect is that other actions read them, and switches that only show in the log.

use counterpoint_event::event::{Kind, OffsetKind, TimedFunction};
use counterpoint_fault::Acted;
use counterpoint_machine::ident::kind::CodeKind;
use counterpoint_machine::ident::{CodeId, codes, data};
use counterpoint_machine::rows::CodeRow;
use counterpoint_program::block::PendingCode;

use crate::context::ActionContext;
use crate::entry::{ActionEntry, CompensationEffect, entry_of_kind};

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] = &[
    entry_of_kind!(CodeKind::Mode(text) => |act, _row, _code| mode(act, text)).contour(CompensationEffect::Waits),
    ActionEntry::of(&[codes::UNITS_PRIMARY], |act, _, _| units(act, false)).contour(CompensationEffect::Waits),
    ActionEntry::of(&[codes::UNITS_SECONDARY, codes::UNITS_SECONDARY_LENGTHS], |act, _, _| units(act, true))
        .contour(CompensationEffect::Waits),
    ActionEntry::of(&[codes::EXACTSTOP], |act, _, _| exact_stop_block(act)).contour(CompensationEffect::Waits),
    ActionEntry::of(&[codes::COMP_DIAM_OFF], |act, row, _| diameter(act, "off", row.id))
        .contour(CompensationEffect::Waits),
    ActionEntry::of(&[codes::COMP_DIAM_LEFT], |act, row, _| diameter(act, "left", row.id))
        .contour(CompensationEffect::Waits),
    ActionEntry::of(&[codes::COMP_DIAM_RIGHT], |act, row, _| diameter(act, "right", row.id))
        .contour(CompensationEffect::Waits),
    ActionEntry::of(&[codes::FUNCTION], function).contour(CompensationEffect::Waits),
    ActionEntry::of(&[codes::AM_ON], |act, _, _| additive(act, true)).contour(CompensationEffect::Waits),
    ActionEntry::of(&[codes::AM_OFF], |act, _, _| additive(act, false)).contour(CompensationEffect::Waits),
];

/// A modal state.
pub(crate) fn mode(act: &mut ActionContext<'_, '_>, text: &'static str) -> Acted {
    if act.channel().acting.mode_changed {
        act.channel_mut().emit(0, Kind::mode(text));
    }
    Ok(())
}

/// Primary or secondary units.
pub(crate) fn units(act: &mut ActionContext<'_, '_>, secondary: bool) -> Acted {
    use counterpoint_event::info::MachineUnit;
    act.channel_mut().reports.unit_named = true;
    let inch = (act.channel().env.machine.unit == MachineUnit::Inch) != secondary;
    if act.channel().state.secondary != secondary {
        act.channel_mut().state.secondary = secondary;
        act.unit_selected(inch)?;
    }
    mode(act, if inch { "units inch" } else { "units mm" })
}

/// Exact stop at the end of this block.
pub(crate) fn exact_stop_block(act: &mut ActionContext<'_, '_>) -> Acted {
    act.channel_mut().block.flags.exact_stop = true;
    Ok(())
}

/// Cutter or nose radius compensation: number, listing, and the path if there is a radius.
pub(crate) fn diameter(act: &mut ActionContext<'_, '_>, side: &'static str, code: CodeId) -> Acted {
    // A code that ends compensation needs no number.
    let asks = side != "off" || act.block_has(data::COMP_DIAM);
    let number = if asks { super::tool_offsets::take_diameter(act) } else { None };
    if act.channel().acting.mode_changed || number.is_some() {
        let text = format!("comp diam {side}");
        let mode = match number.filter(|_| side != "off") {
            Some(number) => {
                let text = format!("{text} n={}", counterpoint_lang::format::wildcard_text(number));
                Kind::compensation(text, OffsetKind::Diameter, number)
            }
            None => Kind::mode(text),
        };
        super::cutter::switched(act, code)?;
        act.channel_mut().emit(0, mode);
        act.report_tool();
    }
    Ok(())
}

/// A function of the machine that only takes time; the time itself is added by the code loop.
pub(crate) fn function(act: &mut ActionContext<'_, '_>, row: &CodeRow, code: &PendingCode) -> Acted {
    act.take(data::FUNCTION);
    if row.seconds <= 0.0 {
        let (letter, value) = (act.channel().env.machine.letter_of(&row.form), code.value);
        if letter == 'M' {
            act.channel_mut().reports.swallowed.note(value);
        }
        act.channel_mut().emit(0, Kind::Function(TimedFunction { letter, value }));
    }
    Ok(())
}

/// Power of additive machining.
pub(crate) fn additive(act: &mut ActionContext<'_, '_>, on: bool) -> Acted {
    let power = act.take(data::AM).map(|d| counterpoint_lang::format::wildcard_text(d.value));
    let text = match (on, power) {
        (true, Some(power)) => format!("am on p={power}"),
        (true, None) => "am on".to_owned(),
        (false, _) => "am off".to_owned(),
    };
    act.channel_mut().emit(0, Kind::mode(text));
    Ok(())
}
