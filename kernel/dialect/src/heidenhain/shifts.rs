//! Cycles 7 and 10: what incremental values add to.
//!
//! Facts: programming manuals of the control: a datum shift by incremental values adds to the shift in force, a rotation
//! by IROT to the angle in force; cycle 247 takes both away. Invariant: the tables of the machine get absolute values.

use super::path::{AXES, axis};
use super::words::{Seen, shown};

/// Values in force.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Shifts {
    datum: [f64; AXES.len()],
    angle: f64,
}

impl Shifts {
    /// The shift of an axis, 0 for X.
    pub(super) fn datum(&self, axis: usize) -> Option<f64> {
        self.datum.get(axis).copied()
    }

    /// The words of a cycle: notes what they set, and makes incremental ones absolute.
    pub(super) fn define(&mut self, cycle: u32, seen: &mut [Seen]) {
        match cycle {
            7 => {
                for word in seen {
                    let (Some((at, incremental)), Some(value)) = (axis(&word.name), word.value) else { continue };
                    let Some(slot) = self.datum.get_mut(at) else { continue };
                    *slot = if incremental { *slot + value } else { value };
                    if incremental {
                        *word = Seen::made(AXES.get(at).copied().unwrap_or_default(), *slot);
                    }
                }
            }
            10 => {
                for word in seen {
                    let Some(value) = word.value else { continue };
                    match &*word.name {
                        "ROT" => self.angle = value,
                        "IROT" => {
                            self.angle += value;
                            let sign = if self.angle < 0.0 { "" } else { "+" };
                            let text = format!("ROT{sign}{}", shown(self.angle));
                            *word = Seen { name: "ROT".into(), value: Some(self.angle), text };
                        }
                        _ => {}
                    }
                }
            }
            247 => *self = Self::default(),
            _ => {}
        }
    }
}
