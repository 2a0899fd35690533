//! The drilling cycles of the control that move along the axis of the tool alone: 200, 201, 203, 205 to 207 and 240, as
//! blocks of words.
//!
//! Facts: reference heidenhain-cycles.md; programming manuals of the control, drilling cycles. A stored program of
//! these numbers has a head and no blocks: the kernel asks for the blocks of the hole ([`Heidenhain::hole`]) where it
//! would enter the program. Decisions: a cycle reads its parameters, the feed and the spindle when it begins.
//! *Invariants:* a cycle file of the user's machine is an ordinary program; a hole makes no block before the sign of
//! its depth has been checked.

mod pecking;
mod tapping;
mod words;

use counterpoint_fault::Halt;

use super::Heidenhain;
use super::flow;
use super::formula::{Kind, Name};
use super::variables::Value;
use crate::host::Host;
use crate::interpreter::MadeBlocks;
use counterpoint_fault as diag;
pub(super) use words::HoleWords;

/// Most infeeds of a hole.
const MOST_INFEEDS: u32 = 10_000;
/// Rests of a hole below this are nothing.
const NEGLIGIBLE: f64 = 0.0001;

/// A drilling cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum HoleCycle {
    /// 200: in infeeds, out to the clearance after each.
    Drill,
    /// 201: back at feed.
    Ream,
    /// 203: infeeds that shrink, chip breaks.
    Universal,
    /// 205: infeeds that shrink, stops before the last depth, chip breaks.
    Peck,
    /// 206: tapping with a floating holder.
    FloatingTap,
    /// 207: rigid tapping.
    RigidTap,
    /// 240: centring.
    Centre,
}

impl HoleCycle {
    fn numbered(number: u32) -> Option<Self> {
        Some(match number {
            200 => Self::Drill,
            201 => Self::Ream,
            203 => Self::Universal,
            205 => Self::Peck,
            206 => Self::FloatingTap,
            207 => Self::RigidTap,
            240 => Self::Centre,
            _ => return None,
        })
    }
}

/// A hole while its blocks are made.
struct Hole<'h> {
    control: &'h mut Heidenhain,
    host: &'h mut dyn Host,
    blocks: &'h mut MadeBlocks,
    words: HoleWords,
    /// Feed of the program that calls.
    feed: f64,
    levels: Levels,
}

/// Levels along the axis of the tool.
#[derive(Debug, Clone, Copy)]
struct Levels {
    surface: f64,
    clearance: f64,
    /// The second clearance, if it counts.
    second: Option<f64>,
    depth: f64,
}

impl Heidenhain {
    /// Makes the blocks of a drilling cycle that the block calls; whether the program is one.
    pub(super) fn hole(&mut self, host: &mut dyn Host, blocks: &mut MadeBlocks) -> Result<bool, Halt> {
        let defined = &self.cycles.defined;
        let number = defined.program.as_deref().filter(|_| defined.stored).and_then(|name| name.parse().ok());
        let is_cycle = self.calling == Some(flow::Kind::Cycle);
        let Some(cycle) = number.filter(|_| is_cycle).and_then(HoleCycle::numbered) else { return Ok(false) };
        self.calling = None;
        let made = self.hole_of(host, cycle, blocks);
        for (name, value) in std::mem::take(&mut self.cycles.running.changed) {
            self.variables.set(name, Value::Number(value));
        }
        made.map(|()| true)
    }

    fn hole_of(&mut self, host: &mut dyn Host, cycle: HoleCycle, blocks: &mut MadeBlocks) -> Result<(), Halt> {
        let depth = self.parameter(201);
        if depth == 0.0 {
            return Ok(());
        }
        if depth > 0.0 && cycle != HoleCycle::Centre {
            let text = format!(
                "error 1098: the depth Q201 is above 0 in '{}'; the control drills towards smaller values",
                host.block_text()
            );
            return Err(host.alarm(&diag::MACRO_ALARM, text));
        }
        let feed = self.system_number(host, 20.0, 9.0, None)?;
        let (surface, second) = (self.parameter(203), self.parameter(204));
        let clearance = self.parameter(200);
        let levels = Levels {
            surface,
            clearance: surface + clearance,
            second: (second >= clearance).then_some(surface + second),
            depth: surface + depth,
        };
        let words = *self.cycles.holes.get_or_insert_with(|| HoleWords::of(host));
        let mut hole = Hole { control: self, host, blocks, words, feed, levels };
        hole.rapid(hole.levels.clearance);
        match cycle {
            HoleCycle::Drill => hole.drill(),
            HoleCycle::Ream => hole.ream(),
            HoleCycle::Universal => hole.universal(),
            HoleCycle::Peck => hole.peck(),
            HoleCycle::FloatingTap => hole.floating_tap(),
            HoleCycle::RigidTap => hole.rigid_tap(),
            HoleCycle::Centre => hole.centre(),
        }?;
        hole.leave();
        Ok(())
    }

    /// A Q parameter, 0 without a value.
    fn parameter(&self, index: u32) -> f64 {
        self.number(Name { kind: Kind::Q, index })
    }
}

impl Hole<'_> {
    /// A Q parameter, 0 without a value.
    fn parameter(&self, index: u32) -> f64 {
        self.control.parameter(index)
    }

    /// A feed by its parameter; the feed of drilling, Q206, for 0.
    fn feed_or_drilling(&self, index: u32) -> f64 {
        let feed = self.parameter(index);
        if feed == 0.0 { self.parameter(206) } else { feed }
    }

    /// From the clearance to the second one, if that is above, with the feed of the program.
    fn leave(&mut self) {
        if let Some(second) = self.levels.second {
            self.rapid(second);
        }
        self.set_feed(self.feed);
    }

    /// The angle of the tip of the tool by its table, 0 without one.
    fn tip_angle(&mut self) -> Result<f64, Halt> {
        self.control.system_number(self.host, 50.0, 32.0, None)
    }

    /// Q395 = 1: the depth is that of the full diameter.
    fn add_tip(&mut self) -> Result<(), Halt> {
        if self.parameter(395) == 0.0 {
            return Ok(());
        }
        let angle = self.tip_angle()?;
        if angle != 0.0 {
            let [_, radius] = self.host.tool_in_force().map(|length| length / self.host.length_factor());
            self.levels.depth -= cone(radius, angle);
        }
        Ok(())
    }

    /// 201.
    fn ream(&mut self) -> Result<(), Halt> {
        let back = self.feed_or_drilling(208);
        self.line(self.levels.depth, self.parameter(206));
        self.dwell(self.parameter(211));
        self.line(self.levels.clearance, back);
        Ok(())
    }

    /// 240. Q343 = 1: the depth follows from the diameter Q344, at 90 degrees without an angle in the tool table.
    fn centre(&mut self) -> Result<(), Halt> {
        if self.parameter(343) != 0.0 {
            let angle = self.tip_angle()?;
            let angle = if angle == 0.0 { 90.0 } else { angle };
            self.levels.depth = self.levels.surface - cone(self.parameter(344).abs() / 2.0, angle);
        }
        self.line(self.levels.depth, self.parameter(206));
        self.dwell(self.parameter(211));
        self.rapid(self.levels.clearance);
        Ok(())
    }
}

/// Height of a cone with this radius and this angle at its tip.
fn cone(radius: f64, angle: f64) -> f64 {
    let half = (angle / 2.0).to_radians();
    radius * libm::cos(half) / libm::sin(half)
}
