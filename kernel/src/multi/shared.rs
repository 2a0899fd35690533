//! What all channels of a job share besides waits: common variables and spindles.

use rustc_hash::FxHashMap;

use super::files::Written;
use super::waits::Set;
use crate::log::event::Direction;
use crate::state::burden::Hoard;

/// Shared state; touched only inside shared operations.
#[derive(Debug, Clone, Default)]
pub(crate) struct Shared {
    /// Common variables that have a value.
    pub(crate) variables: FxHashMap<u32, f64>,
    /// Variables with names that the pre-processors of all channels reach, those that have a value.
    pub(crate) named: FxHashMap<Box<str>, counterpoint_lang::value::Value>,
    /// Global variables of macros, by index.
    pub(crate) globals: Vec<counterpoint_lang::value::Value>,
    /// Memory of both.
    pub(crate) hoard: Hoard,
    /// Files that macros have written.
    pub(crate) files: Written,
    /// Spindles by index of the machine's list.
    pub(crate) spindles: Vec<Spindle>,
}

/// Commanded state of a spindle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Command {
    pub(crate) direction: Direction,
    /// Constant surface speed is on.
    pub(crate) css: bool,
    /// rev/min.
    pub(crate) rpm: f64,
    /// Surface speed as programmed (m/min or ft/min).
    pub(crate) surface: f64,
    /// Largest rev/min programmed.
    pub(crate) limit: f64,
    /// Channel whose X drives constant surface speed.
    pub(crate) driver: u16,
    /// Radius at which the surface speed counts, 0 = at X.
    pub(crate) radius: f64,
    /// Angle of the oriented stop, degrees.
    pub(crate) angle: f64,
}

impl Default for Command {
    fn default() -> Self {
        Self {
            direction: Direction::Off,
            css: false,
            rpm: 0.0,
            surface: 0.0,
            limit: f64::INFINITY,
            driver: 0,
            radius: 0.0,
            angle: 0.0,
        }
    }
}

/// A spindle with its last writer.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Spindle {
    pub(crate) command: Command,
    /// Speed now, rev/min: under constant surface speed by the X of the channel that commands it.
    pub(crate) now: f64,
    /// Channel that wrote last and not yet met the others since; 0 = none.
    pub(crate) writer: u16,
    /// Channels that have met the writer since its write.
    pub(crate) ordered: Set,
}

impl Shared {
    /// A meeting orders all earlier commands of the participants before all later ones.
    pub(crate) fn met(&mut self, channels: Set) {
        for spindle in &mut self.spindles {
            if channels.has(spindle.writer) {
                spindle.ordered = Set(spindle.ordered.0 | channels.0);
            }
        }
    }
}
