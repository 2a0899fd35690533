//! `[compensation]`: how cutter and nose radius compensation begins, ends and goes around corners.
//!
//! Invariant: the angle is one of 0 to 180 degrees.

use crate::model::{Compensation, OutsideCorner};
use crate::toml::section::Section;

/// Reads `[compensation]`.
pub(super) fn read(top: &mut Section<'_>) -> Compensation {
    let mut made = Compensation { rapid: true, arcs: false, corner: OutsideCorner::Angle, corner_angle: 90.0 };
    let Some(mut section) = top.table("compensation", "[compensation]") else { return made };
    made.rapid = section.flag("rapid").unwrap_or(made.rapid);
    made.arcs = section.flag("arcs").unwrap_or(made.arcs);
    let corners = [("angle", OutsideCorner::Angle), ("linear", OutsideCorner::Linear), ("arc", OutsideCorner::Arc)];
    made.corner = section.choice("corner", &corners).unwrap_or(made.corner);
    if let Some(angle) = section.at_least_zero("corner_angle") {
        if angle > 180.0 {
            section.error("corner_angle", format!("`corner_angle` is 0 to 180 degrees, not {angle}"));
        }
        made.corner_angle = angle.min(180.0);
    }
    section.finish();
    made
}
