//! Threads along circles in the plane of turning.
//!
//! Facts: reference okuma-osp.md 2 (G112, G113, M26, M27). *Invariant:* the path is the circle itself, its time that of
//! the lead. Decisions: docs/emulation.md, "Threads".

use counterpoint_event::event::Position;
use counterpoint_fault::{Acted, Halt};
use counterpoint_machine::ident::data;
use counterpoint_machine::ident::kind::thread::LeadChange;
use counterpoint_machine::index::AxisSlot;
use counterpoint_motion::arc::PlaneArc;
use counterpoint_program::block::PendingCode;

use super::Screw;
use crate::arc as circle;
use crate::context::{ActionContext, ThreadSteps};
use crate::thread::lead_seconds;

/// Cuts one pass along a circle.
pub(crate) fn thread(act: &mut ActionContext<'_, '_>, clockwise: bool, code: &PendingCode) -> Acted {
    let (pitch, _) = super::take_pitch(act);
    // Where one letter is both, it is the centre here (Fanuc K).
    let centers = [data::ARC_CENTER_X, data::ARC_CENTER_Y, data::ARC_CENTER_Z];
    let of_centers = centers.into_iter().fold(0, |bits, id| bits | act.registers_of(id));
    let is_center = act.registers_of(data::INTERP_THREAD_PITCH_VAR) & of_centers != 0;
    let may = if is_center { LeadChange::None } else { LeadChange::May };
    let change = super::take_change(act, may, code.modal);
    act.take(data::INTERP_THREAD_ANGLE);
    let starts = super::take_starts(act);
    act.channel_mut().state.threads.starts = starts;
    let cartesian = &act.channel().state.place.layout.cartesian;
    let along = act.channel().state.threads.along.and_then(|role| cartesian.get(role).copied().flatten());
    let screw = Screw { lead: pitch.unwrap_or(0.0) * starts, change: change * starts, along };
    act.channel_mut().state.threads.recorded = Some(screw);
    circle::threaded(act, clockwise, code, screw)?;
    crate::cutter::after_thread(act);
    Ok(())
}

impl ThreadSteps for ActionContext<'_, '_> {
    fn arc_thread_seconds(
        &mut self,
        to: &Position,
        (made, axes): (&PlaneArc, [AxisSlot; 2]),
        screw: &Screw,
    ) -> Result<f64, Halt> {
        let named = screw.along.and_then(|axis| axes.iter().position(|own| *own == axis));
        let way = named.map_or_else(|| made.travel(0).max(made.travel(1)), |coordinate| made.travel(coordinate));
        lead_seconds(self, to, way, screw)
    }
}
