//! The allowance of roughing on a contour: amounts along both axes.
//!
//! *Invariant:* the pieces of the result follow each other without gaps and do not turn back along the cut; where an
//! allowance does not fit into the contour there is none.

use super::NOISE;
use super::parts::ContourPart;
use crate::contour::element::Spot;

/// Parts with amounts left along the cut and across it: rising parts begin earlier, falling ones later, all are higher.
pub(super) fn leave(parts: Vec<ContourPart>, [along, across]: Spot) -> Option<Vec<ContourPart>> {
    let mut left: Vec<ContourPart> = Vec::with_capacity(parts.len());
    for part in parts {
        let slope = slope(&part);
        let by = |[a, b]: Spot| [a - f64::from(slope) * along, b + across];
        let mut part =
            ContourPart { from: by(part.from), to: by(part.to), arc: part.arc.map(|(center, cw)| (by(center), cw)) };
        while let Some(last) = left.last_mut() {
            let gap = part.from[0] - last.to[0];
            if gap.abs() <= NOISE {
                break;
            }
            match (self::slope(last), self::slope(&part)) {
                // A level part fits itself between its neighbours.
                (0, _) if part.from[0] >= last.from[0] - NOISE => {
                    last.to[0] = part.from[0];
                    break;
                }
                (_, 0) if last.to[0] <= part.to[0] + NOISE => {
                    part.from[0] = last.to[0];
                    break;
                }
                // It has no room left: the flanks beside it meet.
                (0, _) => {
                    left.pop();
                }
                (_, 0) => return None,
                _ if gap > 0.0 => {
                    let (from, to) = (last.to, part.from);
                    left.push(ContourPart { from, to, arc: None });
                    break;
                }
                (-1, 1) => {
                    let place = crossing(last, &part)?;
                    last.to = place;
                    part.from = place;
                    break;
                }
                _ => return None,
            }
        }
        left.push(part);
    }
    Some(left)
}

/// +1 for a part that rises along the cut, −1 for one that falls, 0 for a level one.
fn slope(part: &ContourPart) -> i8 {
    let rise = part.to[1] - part.from[1];
    if rise.abs() <= NOISE {
        0
    } else if rise > 0.0 {
        1
    } else {
        -1
    }
}

/// Where a falling part meets the rising one after it.
fn crossing(falling: &ContourPart, rising: &ContourPart) -> Option<Spot> {
    let (mut low, mut high) = (falling.to[1].max(rising.from[1]), falling.from[1].min(rising.to[1]));
    let apart = |height: f64| rising.meets(height) - falling.meets(height);
    if low > high || apart(low) > 0.0 || apart(high) < 0.0 {
        return None;
    }
    // Halved until nothing is left between them.
    for _ in 0..100 {
        let middle = f64::midpoint(low, high);
        if apart(middle) > 0.0 { high = middle } else { low = middle }
    }
    Some([falling.meets(low), low])
}
