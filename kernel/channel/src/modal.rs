//! Modal codes of a channel.
//!
//! *Invariant:* a group has one active code at most.

use counterpoint_event::event::FeedUnit;
use counterpoint_machine::ident::{CodeId, DataId, codes, data};
use counterpoint_machine::index::CodeRowId;

/// Modal groups that the kernel itself uses (reference control-emulator.md 3.2).
pub mod group {
    /// Motion.
    pub const MOTION: u16 = 1;
    /// Plane.
    pub const PLANE: u16 = 2;
    /// Interpolation on a cylinder or a face.
    pub const PART_INTERPOLATION: u16 = 26;
    /// Absolute or incremental positions.
    pub const POSITION: u16 = 3;
    /// Feed mode.
    pub const FEED: u16 = 5;
    /// Units.
    pub const UNITS: u16 = 6;
    /// Cutter radius compensation.
    pub const DIAMETER: u16 = 7;
    /// Canned cycle.
    pub const CYCLE: u16 = 9;
    /// Return level of cycles.
    pub const RETRACT: u16 = 10;
    /// Exact stop.
    pub const EXACT_STOP: u16 = 15;
    /// Coolant.
    pub const COOLANT: u16 = 54;
    /// Coolant of the other side.
    pub const COOLANT_SIDE: u16 = 540;
    /// Spindle.
    pub const SPINDLES: u16 = 67;
    /// Rigid tapping.
    pub const RIGID: u16 = 101;
    /// Head.
    pub const HEAD: u16 = 68;
    /// Diameter programming of X.
    pub const DIAMETER_X: u16 = 109;
}

/// Modal codes.
#[derive(Debug, Clone)]
pub struct ModalCodes {
    /// Active code of each group with its row, `None` = `CODE_NONE`. The machine may start with a code that it has no
    /// row of.
    groups: Vec<Option<(CodeId, Option<CodeRowId>)>>,
    /// Groups that have had an active code, in ascending order; these are only a few of all groups.
    known: Vec<u16>,
    /// Groups whose active code fires again on blocks without a code of the group; `true` = in every block.
    pub refires: Vec<(u16, bool)>,
}

impl ModalCodes {
    /// A channel without modal codes.
    pub fn empty() -> Self {
        Self { groups: vec![None; 1000], known: Vec::new(), refires: Vec::new() }
    }

    /// Active code of a group.
    pub fn code(&self, group: u16) -> Option<CodeId> {
        self.groups.get(usize::from(group)).copied().flatten().map(|(id, _)| id)
    }

    /// Active row of a group.
    pub fn row(&self, group: u16) -> Option<CodeRowId> {
        self.groups.get(usize::from(group)).copied().flatten().and_then(|(_, row)| row)
    }

    /// Makes a code the active one of its group (group 0 has none).
    pub fn activate(&mut self, group: u16, id: CodeId, row: Option<CodeRowId>) {
        if group != 0
            && let Some(slot) = self.groups.get_mut(usize::from(group))
        {
            if slot.replace((id, row)).is_none() {
                self.note_group(group);
            }
            if !self.refires.is_empty() {
                self.refires.retain(|&(g, _)| g != group);
            }
        }
    }

    #[cold]
    fn note_group(&mut self, group: u16) {
        if let Err(at) = self.known.binary_search(&group) {
            self.known.insert(at, group);
        }
    }

    /// Whether a code is the active one of its group.
    pub fn has(&self, code: CodeId) -> bool {
        self.known.iter().any(|&group| self.code(group) == Some(code))
    }

    /// Makes a code active that fires again in every block.
    pub fn activate_persistent(&mut self, group: u16, id: CodeId, row: Option<CodeRowId>) {
        self.activate(group, id, row);
        if group != 0 {
            self.refires.push((group, true));
        }
    }

    /// The active code of the group fires once on the next block without a code of the group.
    pub fn refire_once(&mut self, group: u16) {
        if self.code(group).is_some() && !self.refires.iter().any(|&(g, _)| g == group) {
            self.refires.push((group, false));
        }
    }

    /// Active codes of all groups.
    pub fn saved(&self) -> Vec<(u16, CodeId, Option<CodeRowId>)> {
        let active = |&group: &u16| self.groups.get(usize::from(group)).copied().flatten().map(|of| (group, of));
        self.known.iter().filter_map(active).map(|(group, (id, row))| (group, id, row)).collect()
    }

    /// Puts active codes back; groups that had none have none again.
    pub fn restore(&mut self, saved: &[(u16, CodeId, Option<CodeRowId>)]) {
        for &group in &self.known {
            if let Some(slot) = self.groups.get_mut(usize::from(group)) {
                *slot = None;
            }
        }
        for &(group, id, row) in saved {
            if let Some(slot) = self.groups.get_mut(usize::from(group)) {
                *slot = Some((id, row));
                self.note_group(group);
            }
        }
        let groups = &self.groups;
        self.refires.retain(|&(group, _)| groups.get(usize::from(group)).is_some_and(Option::is_some));
    }
}

/// Plane of arcs: names for listings and the roles of its axes (first, second), and the identifiers of their
/// centre words.
#[derive(Debug, Clone, Copy)]
pub struct Plane {
    /// Role of its first axis.
    pub first: usize,
    /// Role of its second axis.
    pub second: usize,
    /// Centre words along these axes.
    pub centers: [DataId; 2],
}

/// Plane of a plane code.
pub fn plane(code: CodeId) -> Option<Plane> {
    match code {
        codes::PLANE_XY => Some(Plane { first: 0, second: 1, centers: [data::ARC_CENTER_X, data::ARC_CENTER_Y] }),
        codes::PLANE_ZX => Some(Plane { first: 2, second: 0, centers: [data::ARC_CENTER_Z, data::ARC_CENTER_X] }),
        codes::PLANE_YZ => Some(Plane { first: 1, second: 2, centers: [data::ARC_CENTER_Y, data::ARC_CENTER_Z] }),
        _ => None,
    }
}

/// Identifier and unit of the feed under a feed mode.
pub fn feed_of(mode: Option<CodeId>) -> (DataId, FeedUnit) {
    match mode {
        Some(codes::FEED_UPR) => (data::FEED_UPR, FeedUnit::PerRevolution),
        Some(codes::FEED_1T) => (data::FEED_1T, FeedUnit::InverseTime),
        _ => (data::FEED_UPM, FeedUnit::PerMinute),
    }
}
