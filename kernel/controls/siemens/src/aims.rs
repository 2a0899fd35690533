//! Words about the direction of the tool that the machine's tables do not know: angles, normals, axes of cones.
//!
//! *Invariant:* a component that the block does not have is 0.

/// A word about the direction of the tool.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Aim {
    /// A component of a vector, or one of the angles.
    Part(Vector, usize),
    /// An angle of its own.
    Angle(Angle),
}

/// Data with three components.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Vector {
    /// `A2 B2 C2`, angles of a direction.
    Turned,
    /// `A4 B4 C4`, the normal of the surface at the start of the block.
    NormalAtStart,
    /// `A5 B5 C5`, that at its end.
    NormalAtEnd,
    /// `A6 B6 C6`, the axis of a cone.
    Axis,
    /// `A7 B7 C7`, a direction between start and end.
    Between,
}

/// Angles by their own addresses, degrees.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Angle {
    Lead,
    Tilt,
    /// `NUT`, the opening of a cone.
    Opening,
}

impl Aim {
    /// The word of an address.
    pub(super) fn of(address: &str) -> Option<Self> {
        let [letter, digit] = address.as_bytes() else {
            return Some(Self::Angle(match address {
                "LEAD" => Angle::Lead,
                "TILT" => Angle::Tilt,
                "NUT" => Angle::Opening,
                _ => return None,
            }));
        };
        let vector = match digit {
            b'2' => Vector::Turned,
            b'4' => Vector::NormalAtStart,
            b'5' => Vector::NormalAtEnd,
            b'6' => Vector::Axis,
            b'7' => Vector::Between,
            _ => return None,
        };
        Some(Self::Part(vector, b"ABC".iter().position(|known| known == letter)?))
    }
}

/// The words of a block.
#[derive(Debug, Default)]
pub(super) struct Aims {
    vectors: [Option<[f64; 3]>; 5],
    angles: [Option<f64>; 3],
}

impl Aims {
    pub(super) fn set(&mut self, aim: Aim, value: f64) {
        match aim {
            Aim::Part(vector, at) => {
                if let Some(slot) =
                    self.vectors.get_mut(vector as usize).and_then(|vector| vector.get_or_insert_default().get_mut(at))
                {
                    *slot = value;
                }
            }
            Aim::Angle(angle) => {
                if let Some(slot) = self.angles.get_mut(angle as usize) {
                    *slot = Some(value);
                }
            }
        }
    }

    pub(super) fn vector(&self, vector: Vector) -> Option<[f64; 3]> {
        self.vectors.get(vector as usize).copied().flatten()
    }

    pub(super) fn angle(&self, angle: Angle) -> Option<f64> {
        self.angles.get(angle as usize).copied().flatten()
    }
}
