//! Stage *codes*, on machines where an axis moves by a change of the length: adds the move of that axis.
//!
//! Facts: parameter 5006#6 of Fanuc controls; B-63844EN/02 14.1.1 (a block without the axis moves it by the offset). *Invariant:*
//! a programmed word for the axis does not change; without such a word the block gets a word for the same point, or for a
//! distance of 0 in incremental mode.

use counterpoint_machine::ident::kind::CodeKind;
use counterpoint_machine::ident::{codes, data};
use counterpoint_machine::index::BySlot;
use counterpoint_program::block::Word;

use crate::channel::Kernel;
use crate::state::frames::offsets::BASE;
use crate::state::modal::group;
use counterpoint_machine::ident::dimension::Dimension;

impl Kernel<'_> {
    /// A code or a number of the block changes the length: the next move of its axis travels the change.
    #[cold]
    pub(super) fn length_words(&mut self) {
        let machine = self.channel.env.machine;
        let in_force = self.channel.state.place.in_force;
        let said = self.channel.block.pending.iter().rev().find_map(|code| match machine.codes[code.row].id.kind() {
            CodeKind::Length { sign, .. } => Some(f64::from(sign)),
            _ => None,
        });
        let word = self.plan.sources_of(data::COMP_LENGTH).iter().find_map(|of| self.channel.block.look(of.register));
        let alone = word.filter(|_| machine.compensation.numbers_alone && in_force.length_sign != 0.0);
        let Some(sign) = said.or(alone.map(|_| in_force.length_sign)) else { return };
        self.channel.block.flags.travels = true;
        let number = word.map_or(self.channel.state.remembered.length(), |word| word.value as u32);
        let Some(slot) = self.channel.state.place.layout.cartesian.get(2).copied().flatten() else { return };
        let length = if number == BASE { 0.0 } else { self.channel.worn_length(number).at(slot) };
        let id = self.channel.state.place.layout.axes[slot].data;
        let registers = self.plan.registers_of(id);
        let cycle = self.channel.state.modal.code(group::CYCLE).is_some_and(|code| code != codes::CYCLE_OFF);
        let stays = sign * length == self.channel.tool_shift().at(slot);
        let Some(source) = self.plan.sources_of(id).first() else { return };
        if stays || cycle || self.channel.has_any(registers) {
            return;
        }
        let mut queued = self.channel.block.pending.iter().rev().map(|code| &machine.codes[code.row]);
        let mode = queued.find(|row| row.group == group::POSITION).map(|row| row.id);
        let mode = mode.or_else(|| self.channel.state.modal.code(group::POSITION));
        let value = match mode {
            Some(codes::POSITION_RELATIVE) => 0.0,
            _ => self.channel.counted().at(slot) / self.channel.unit_factor(Dimension::Length) / source.mul,
        };
        let place = self.channel.block.words.len();
        self.channel.block.push(Word {
            register: source.register,
            incremental: false,
            used: false,
            value,
            start: 0,
            end: 0,
        });
        self.channel.block.index_word(place);
    }
}
