//! The views of a picture: the content of each view, and the projection of points.
//!
//! *Invariant:* a projection is linear, so that straight moves are straight in every view.

use super::Toolpath;
use crate::toolpath::ToolpathView;

/// The path that a view shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ViewedPath {
    /// The path in the work frame.
    Path,
    /// The path of live tools on the face of the part.
    Face,
}

/// How a point is seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Projection {
    /// Along an axis: the coordinates to the right and up.
    Along([usize; 2]),
    /// In space: X to the right, Y to the left, both rising, and Z upwards.
    Isometric,
}

impl Projection {
    /// Where a point is seen, to the right and up.
    pub(super) fn of(self, point: [f64; 3]) -> [f64; 2] {
        match self {
            Self::Along(axes) => axes.map(|axis| point.get(axis).copied().unwrap_or(0.0)),
            Self::Isometric => {
                let [x, y, z] = point;
                [(x - y) * COS, (x + y) * 0.5 + z]
            }
        }
    }
}

/// Cosine of 30 degrees.
const COS: f64 = 0.866_025_403_784_438_6;

/// The quantity of the upward scale of a view.
#[derive(Debug, Clone, Copy)]
pub(super) struct Upwards {
    pub(super) name: &'static str,
    /// Shown value of a coordinate of 1.
    pub(super) factor: f64,
    /// Values count upwards and downwards from zero.
    pub(super) both_ways: bool,
}

impl Upwards {
    fn plain(name: &'static str) -> Self {
        Self { name, factor: 1.0, both_ways: false }
    }

    pub(super) fn note(self) -> &'static str {
        if self.both_ways { ", lower turret below the axis" } else { "" }
    }
}

/// One view.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sight {
    pub(super) source: ViewedPath,
    pub(super) projection: Projection,
    pub(super) across: &'static str,
    pub(super) upwards: Upwards,
    /// Tools are seen from their end, so a hole is a point.
    pub(super) shows_holes: bool,
}

impl Sight {
    /// Coordinates can be read off its border.
    pub(super) fn has_scales(self) -> bool {
        self.projection != Projection::Isometric
    }
}

/// The views of a picture.
pub(super) fn sights(toolpath: &Toolpath) -> Vec<Sight> {
    let along = |axes, across, up| Sight {
        source: ViewedPath::Path,
        projection: Projection::Along(axes),
        across,
        upwards: Upwards::plain(up),
        shows_holes: axes == [0, 1],
    };
    match toolpath.view {
        ToolpathView::Zx => {
            let both_ways = toolpath.channels.iter().any(|c| c.lower);
            let upwards = Upwards { name: "X (diameter)", factor: 2.0, both_ways };
            let side = Sight { upwards, shows_holes: false, ..along([0, 1], "Z", "X") };
            let face = Sight { source: ViewedPath::Face, ..along([0, 1], "face: X (radius)", "Y") };
            let live = toolpath.channels.iter().any(|channel| channel.face.is_some());
            if live { vec![side, face] } else { vec![side] }
        }
        ToolpathView::Xyz => {
            let space = Sight { projection: Projection::Isometric, ..along([0, 2], "", "") };
            vec![along([0, 1], "X", "Y"), along([0, 2], "X", "Z"), space]
        }
    }
}
