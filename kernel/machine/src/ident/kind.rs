//! Subjects of codes, beyond their names: the typed column of the table of codes.

pub mod arc;
pub mod coolant;
pub mod cycle;
pub mod data;
pub mod head;
pub mod local;
pub mod plane;
pub mod thread;
pub mod turning;

use counterpoint_motion::frame::local::LocalFramePart;

use super::DataId;
use counterpoint_event::event::SpindleDirection;

/// The distinguishing part of codes of a family, for the list of codes.
pub(super) mod families {
    pub(crate) use super::arc::{ArcDefinition, ArcForm};
    pub(crate) use super::coolant::{CoolantFluid, CoolantTarget};
    pub(crate) use super::cycle::HoleCycle;
    pub(crate) use super::head::HeadEvent;
    pub(crate) use super::local::FrameChange;
    pub(crate) use super::plane::{PlaneDefinition, Tilt};
    pub(crate) use super::thread::{LeadChange, ThreadCycle, ThreadCycleSetting};
    pub(crate) use super::turning::{LapCycle, TurningCycle};
}

/// The kind of a code: the family that it belongs to, and its distinction within the family.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CodeKind {
    /// A code that is a family of its own, or one that nothing handles.
    Plain,
    /// A modal state with its listing words; users read it from the group.
    Mode(&'static str),
    /// A circle.
    Arc(arc::ArcForm),
    /// A thread cut in one move.
    Thread(thread::LeadChange),
    /// A threading cycle.
    ThreadCycle(thread::ThreadCycle),
    /// A setting of threading cycles to come.
    ThreadSetting(thread::ThreadCycleSetting),
    /// A turning cycle.
    Turning(turning::TurningCycle),
    /// A drilling cycle.
    Cycle(cycle::HoleCycle),
    /// A part of the local frame.
    Local(LocalFramePart, local::FrameChange),
    /// Length compensation of a type, 1 to 4.
    Length {
        /// +1, −1, or 0 to cancel it.
        sign: i8,
        /// Its type.
        set: u8,
    },
    /// A tilted plane.
    Plane(plane::Tilt),
    /// Tool tip control on or off.
    TipControl,
    /// The form in which words orient the tool, as `$TCPFMT` counts them.
    TipFormat(u8),
    /// A spindle.
    Spindle {
        /// Number of the spindle, 0 = that of codes without a number.
        number: u16,
        /// Its effect.
        direction: SpindleDirection,
        /// Coolant that it switches along.
        coolant: Option<bool>,
    },
    /// Coolant, its devices and its pump.
    Coolant(coolant::CoolantTarget),
    /// Clamps an axis (`true`) or releases it.
    Clamp(DataId, bool),
    /// Takes whole turns off a rotary axis, or off all.
    Unwind(Option<DataId>),
    /// A tool.
    Tool,
    /// A head that only macros handle.
    Head(head::HeadEvent),
}

#[cfg(test)]
mod tests {
    use super::super::{code, codes, data};
    use super::*;

    fn kind(name: &str) -> CodeKind {
        code(name).unwrap().kind()
    }

    #[test]
    fn every_axis_has_its_clamp() {
        let axes = ["X", "Y", "Z", "U", "V", "W", "AT", "BT", "CT", "CT2", "AH", "BH", "CH", "N", "N2", "E"];
        for axis in axes {
            let data = data(&format!("REG_AXIS_{axis}")).unwrap();
            assert_eq!(kind(&format!("CODE_CLAMP_{axis}")), CodeKind::Clamp(data, true));
            assert_eq!(kind(&format!("CODE_UNCLAMP_{axis}")), CodeKind::Clamp(data, false));
        }
    }

    #[test]
    fn names_and_kinds_say_the_same() {
        for facts in codes::TABLE {
            let starts = |prefix: &str| facts.name.starts_with(prefix);
            match facts.kind {
                CodeKind::Clamp(..) => assert!(starts("CODE_CLAMP_") || starts("CODE_UNCLAMP_"), "{}", facts.name),
                CodeKind::Unwind(_) => assert!(starts("CODE_UNWIND_ROTARY"), "{}", facts.name),
                CodeKind::Coolant(_) => assert!(starts("CODE_COOLANT_"), "{}", facts.name),
                CodeKind::Head(_) => assert!(starts("CODE_HEAD_"), "{}", facts.name),
                CodeKind::Spindle { number: 0, .. } => assert!(starts("CODE_SPINDLE_"), "{}", facts.name),
                CodeKind::Spindle { number, .. } => {
                    assert!(starts(&format!("CODE_SPINDLE{number:02}_")), "{}", facts.name);
                }
                CodeKind::Local(..) => assert!(starts("CODE_LCS_"), "{}", facts.name),
                CodeKind::Plane(_) => assert!(starts("CODE_TILT_"), "{}", facts.name),
                CodeKind::TipFormat(_) => assert!(starts("CODE_RTCP_ORIENT_"), "{}", facts.name),
                CodeKind::TipControl => assert!(starts("CODE_RTCP"), "{}", facts.name),
                CodeKind::Cycle(_) => assert!(starts("CODE_CYCLE_"), "{}", facts.name),
                CodeKind::ThreadCycle(_) | CodeKind::ThreadSetting(_) => {
                    assert!(starts("CODE_THREAD_"), "{}", facts.name);
                }
                CodeKind::Turning(_) => assert!(starts("CODE_TURN_"), "{}", facts.name),
                CodeKind::Tool => assert!(starts("CODE_TOOL_"), "{}", facts.name),
                CodeKind::Plain
                | CodeKind::Mode(_)
                | CodeKind::Arc(_)
                | CodeKind::Thread(_)
                | CodeKind::Length { .. } => {
                    let families = ["CLAMP_", "UNCLAMP_", "COOLANT_", "SPINDLE0", "TOOL_LOAD", "TOOL_SELECT", "RTCP"];
                    assert!(!families.iter().any(|family| starts(&format!("CODE_{family}"))), "{}", facts.name);
                }
            }
        }
    }
}
