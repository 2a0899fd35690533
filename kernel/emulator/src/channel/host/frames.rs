//! Axes, frames and modes for the interpreter.

use counterpoint_motion::frame::affine::Affine;

use crate::channel::Kernel;
use crate::state::frames::offsets::Table;
use crate::state::modal::group;
use counterpoint_dialect::{AxisPlace, Frames, Modes};
use counterpoint_machine::ident::codes;
use counterpoint_machine::ident::dimension::Dimension;

impl Kernel<'_> {
    /// Factor from positions as the program counts them to those of an axis.
    fn program_factor(&self, axis: usize) -> f64 {
        let turns = self.channel.state.place.layout.axes.get(axis).is_some_and(|axis| axis.rotary);
        let length = if turns { 1.0 } else { self.channel.unit_factor(Dimension::Length) };
        length * self.factor_across(axis)
    }
}

impl Frames for Kernel<'_> {
    fn axes(&self) -> Vec<AxisPlace> {
        let programmed = self.channel.programmed();
        let machine = self.channel.machine_point(&self.channel.state.place.position);
        let counted = self.channel.counted();
        let values = programmed.iter().zip(machine.iter()).zip(counted.iter());
        let places = self.channel.state.place.layout.axes.iter().enumerate().zip(values).filter_map(
            |((at, axis), ((work, machine), from))| {
                let named = self.channel.env.machine.axes.get(axis.machine)?;
                let factor = self.program_factor(at);
                Some(AxisPlace {
                    name: named.name.clone(),
                    letter: named.letter.clone(),
                    diameter: self.factor_across(at) * axis.scale < 1.0,
                    work: work / factor,
                    from: from / factor,
                    machine: machine / factor,
                })
            },
        );
        places.collect()
    }

    fn axis_letter(&self, name: &str) -> Option<&str> {
        let machine = &self.channel.env.machine.axes;
        let mut axes = self.channel.state.place.layout.axes.iter().filter_map(|axis| machine.get(axis.machine));
        let is = |text: &str| text.eq_ignore_ascii_case(name);
        axes.find(|axis| is(&axis.letter) || is(&axis.name)).map(|axis| &*axis.letter)
    }

    fn positions(&self) -> Vec<(String, f64, f64)> {
        let programmed = self.channel.programmed();
        let machine = self.channel.machine_point(&self.channel.state.place.position);
        let axes = self
            .channel
            .state
            .place
            .layout
            .axes
            .iter()
            .filter_map(|axis| self.channel.env.machine.axes.get(axis.machine));
        let values = programmed.iter().zip(machine.iter());
        axes.zip(values).map(|(axis, (work, machine))| (axis.name.clone(), *work, *machine)).collect()
    }

    fn relative(&self) -> bool {
        self.channel.state.modal.code(group::POSITION) == Some(codes::POSITION_RELATIVE)
    }

    fn moves_straight(&self) -> bool {
        matches!(self.channel.state.modal.code(group::MOTION), Some(codes::RAPID | codes::INTERP_LINEAR))
    }

    fn local_frame(&self) -> [f64; 12] {
        let map = self.channel.state.place.frames.as_deref().map_or(Affine::SAME, |frames| *frames.local.map());
        let mut rows = <[f64; 12]>::try_from(map.cells()).unwrap_or_default();
        for (row, axis) in self.channel.state.place.layout.cartesian.iter().enumerate() {
            let Some(at) = axis.map(usize::from) else { continue };
            let scale = self.channel.state.place.layout.axes.get(at).map_or(1.0, |axis| axis.scale);
            if let Some(shift) = rows.get_mut(row * 4 + 3) {
                *shift /= scale * self.program_factor(at);
            }
        }
        rows
    }

    fn work_offset(&self) -> u32 {
        self.channel.state.place.in_force.work_offset
    }

    fn offset(&self, number: u32) -> Vec<f64> {
        let values = self.channel.offset_values(Table::Work, number);
        let values = values.iter().take(self.channel.state.place.layout.axes.len()).enumerate();
        values.map(|(at, value)| value / self.program_factor(at)).collect()
    }

    fn set_offset(&mut self, number: u32, values: &[f64]) -> bool {
        let mut offset = self.channel.offset_values(Table::Work, number);
        for (at, (slot, value)) in offset.iter_mut().zip(values).enumerate() {
            *slot = value * self.program_factor(at);
        }
        Kernel::set_offset(self, Table::Work, number, offset)
    }

    fn tool(&self) -> u32 {
        self.channel.state.place.tools.current
    }

    fn modes(&self) -> Modes {
        Modes(self.channel.state.modal.saved())
    }

    fn restore_modes(&mut self, modes: &Modes) {
        self.put_modes_back(&modes.0);
    }
}
