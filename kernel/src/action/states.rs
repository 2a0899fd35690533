//! What actions remember of a channel beyond modal codes, data and positions.
//!
//! Invariant: one box a kernel; the block loop never looks into it for what a machine does not use.

use crate::machine::model::{Channel, Machine, MachineKind};

/// States of one channel.
#[derive(Debug)]
pub(crate) struct States {
    /// Coolant.
    pub(crate) coolant: super::coolant::State,
    /// Spindles.
    pub(crate) spindles: super::spindles::State,
    /// Tool tip control.
    pub(crate) tip: crate::channel::frames::tip::Settings,
    /// Number of the head in work.
    pub(crate) head: u32,
    /// Where the axes stood before they went to the change position.
    pub(crate) before_change: Option<crate::log::event::Position>,
    /// What was told about tools.
    pub(crate) tools: super::tool_data::Told,
}

impl States {
    /// At the start of the program.
    pub(crate) fn new(machine: &Machine, channel: &Channel) -> Self {
        let side = machine.kind == MachineKind::MergingLathe && channel.number == 2;
        Self {
            coolant: super::coolant::State::default(),
            spindles: super::spindles::State::new(machine, channel),
            tip: crate::channel::frames::tip::Settings::default(),
            head: if side { 2 } else { 1 },
            before_change: None,
            tools: super::tool_data::Told::default(),
        }
    }
}
