//! The drilling cycles CYCLE81 to CYCLE89 and CYCLE840, as blocks of words.
//!
//! Facts: reference siemens-cycles.md 1. A resident program with one of these names has a head, which declares its
//! parameters, and no blocks. Instead of entering it, the kernel requests the blocks of the hole from
//! [`Siemens::hole`]. Decisions: a cycle reads the feed, the spindle and the tool when it starts; its blocks do not
//! test synchronised actions. *Invariants:* a cycle file of the user's machine is an ordinary program; all arguments
//! are checked before the first block of a hole is generated, except for blocks that select the plane.

mod arguments;
mod boring;
mod levels;
mod strokes;
mod tapping;
mod words;

use std::sync::Arc;

use super::calls::{Calling, mismatch};
use super::compiled::IndexedName;
use super::declaration::ProcHeader;
use super::{Outcome, Siemens};
use arguments::DrillingArguments;
use counterpoint_control_api::host::InterpreterHost;
use counterpoint_control_api::interpreter::MadeBlocks;
use counterpoint_event::FileId;
use counterpoint_program::shape::ProgramRange;
use words::HoleAxes;

/// Remaining depths below this count as 0.
const NEGLIGIBLE: f64 = 0.0001;
/// Maximum strokes of a hole.
const MOST_STROKES: u32 = 10_000;

/// A drilling cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Drilling {
    /// CYCLE81: centring.
    Centre,
    /// CYCLE82: counterboring.
    Counterbore,
    /// CYCLE83: deep holes.
    Deep,
    /// CYCLE84: rigid tapping.
    RigidTap,
    /// CYCLE840: tapping with a compensating chuck.
    FloatingTap,
    /// CYCLE85: reaming.
    Ream,
    /// CYCLE86: boring with an oriented stop.
    BoreOriented,
    /// CYCLE87 and CYCLE88: boring with a program stop; the latter dwells.
    BoreStopped { dwells: bool },
    /// CYCLE89: boring, with a retract at feed.
    Bore,
}

impl Drilling {
    /// The cycle with the name of a program.
    fn named(name: &str) -> Option<Self> {
        Some(match name {
            "CYCLE81" => Self::Centre,
            "CYCLE82" => Self::Counterbore,
            "CYCLE83" => Self::Deep,
            "CYCLE84" => Self::RigidTap,
            "CYCLE840" => Self::FloatingTap,
            "CYCLE85" => Self::Ream,
            "CYCLE86" => Self::BoreOriented,
            "CYCLE87" => Self::BoreStopped { dwells: false },
            "CYCLE88" => Self::BoreStopped { dwells: true },
            "CYCLE89" => Self::Bore,
            _ => return None,
        })
    }
}

/// A resident program that is a drilling cycle.
#[derive(Debug)]
pub(super) struct SiemensHoleCycle {
    drilling: Drilling,
    header: ProcHeader,
}

/// A hole while its blocks are generated.
struct SiemensHoleBuilder<'h> {
    siemens: &'h mut Siemens,
    host: &'h mut dyn InterpreterHost,
    blocks: &'h mut MadeBlocks,
    /// Name of the cycle, for messages.
    name: &'h str,
    arguments: DrillingArguments,
    axes: HoleAxes,
}

impl Siemens {
    /// Generates the blocks of the drilling cycle that the block calls; false if the program is not such a cycle.
    pub(super) fn hole(
        &mut self,
        host: &mut dyn InterpreterHost,
        (file, range): (FileId, ProgramRange),
        blocks: &mut MadeBlocks,
    ) -> Outcome<bool> {
        let known = self.held.holes.get(&file).cloned();
        let cycle = match known {
            Some(known) => known,
            None => {
                let header = self.header_of(host, file, range);
                let cycle = header.and_then(|header| {
                    Some(Arc::new(SiemensHoleCycle { drilling: Drilling::named(&header.name)?, header }))
                });
                self.held.holes.insert(file, cycle.clone());
                cycle
            }
        };
        let Some(cycle) = cycle else { return Ok(false) };
        let line = host.place().line;
        let given = match &self.calling {
            Some(Calling { line: of, part: false, given, .. }) if *of == line => given.as_slice(),
            _ => &[],
        };
        let arguments = DrillingArguments::new(&cycle.header, given).or_else(mismatch)?;
        if self.modal_from.is_some_and(|level| host.level() <= level) {
            self.modal_from = None;
        }
        blocks.restores_codes = cycle.header.save;
        let axes = HoleAxes::of(host);
        let name = &cycle.header.name;
        let mut hole = SiemensHoleBuilder { siemens: self, host, blocks, name, arguments, axes };
        match cycle.drilling {
            Drilling::Centre => hole.centre(),
            Drilling::Counterbore => hole.counterbore(),
            Drilling::Deep => hole.deep(),
            Drilling::RigidTap => hole.rigid_tap(),
            Drilling::FloatingTap => hole.floating_tap(),
            Drilling::Ream => hole.ream(),
            Drilling::BoreOriented => hole.bore_oriented(),
            Drilling::BoreStopped { dwells } => hole.bore_stopped(dwells),
            Drilling::Bore => hole.bore(),
        }?;
        Ok(true)
    }
}

impl SiemensHoleBuilder<'_> {
    /// Raises an alarm of the cycle.
    fn alarm(&mut self, number: u32, text: &str) -> Outcome<()> {
        let text = format!("{} sets alarm {number}: {text}", self.name);
        self.siemens.raise(self.host, number, text)
    }

    /// Reads a numeric system variable.
    fn variable(&mut self, name: &str) -> Outcome<f64> {
        let name = IndexedName { name: name.to_owned(), index: Vec::new() };
        super::conversions::number(&self.siemens.read(self.host, &name)?)
    }

    /// CYCLE81(RTP, RFP, SDIS, DP, DPR, DTB, _GMODE, _DMODE, _AMODE).
    fn centre(&mut self) -> Outcome<()> {
        let [modes, dwell] = [6, 5];
        self.depth_modes(modes, 19, Some(dwell), 22)?;
        if self.arguments.number(modes) >= 10.0 {
            // The depth is the diameter that the tip cuts at the reference plane.
            let depth = self.tip_depth(self.arguments.number(3).abs() / 2.0)?;
            self.arguments.set(4, depth);
        }
        let levels = self.levels()?;
        self.rapid_absolute(levels.start);
        self.feed(levels.bottom);
        self.dwell(self.arguments.number(dwell));
        self.rapid(levels.retract);
        Ok(())
    }

    /// CYCLE82(RTP, RFP, SDIS, DP, DPR, DTB, _GMODE, _DMODE, _AMODE, _VARI, S_ZA, S_FA, S_ZD, S_FD).
    fn counterbore(&mut self) -> Outcome<()> {
        let [modes, dwell, kind] = [6, 5, 9];
        self.depth_modes(modes, 19, Some(dwell), 99_922)?;
        if self.arguments.number(kind) != 0.0 {
            let text = format!(
                "_VARI is {}; depths with separate feeds before and behind the hole are not emulated, expected 0",
                self.arguments.number(kind)
            );
            self.alarm(61002, &text)?;
        }
        let mut levels = self.levels()?;
        if self.arguments.number(modes) >= 10.0 {
            levels.bottom += levels.sign * self.shank_depth()?;
        }
        self.rapid_absolute(levels.start);
        self.feed(levels.bottom);
        self.dwell(self.arguments.number(dwell));
        self.rapid(levels.retract);
        Ok(())
    }

    /// CYCLE85(RTP, RFP, SDIS, DP, DPR, DTB, FFR, RFF, _GMODE, _DMODE, _AMODE).
    fn ream(&mut self) -> Outcome<()> {
        let [dwell, inwards, outwards, modes] = [5, 6, 7, 8];
        self.depth_modes(modes, 99_999, Some(dwell), 22)?;
        let levels = self.levels()?;
        let feed = self.variable("$P_F")?;
        self.rapid_absolute(levels.start);
        if self.arguments.number(inwards) > 0.0 {
            self.set_feed(self.arguments.number(inwards));
        }
        self.feed(levels.bottom);
        self.dwell(self.arguments.number(dwell));
        if self.arguments.number(outwards) > 0.0 {
            self.set_feed(self.arguments.number(outwards));
        }
        self.feed(levels.start);
        self.rapid(levels.retract);
        self.set_feed(feed);
        Ok(())
    }
}
