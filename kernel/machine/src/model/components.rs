//! What a composite machine is made of.
//!
//! A component is a machine definition of its own with the axes, channels, spindles and waits of the composite. *Invariant:* each
//! channel of a composite has a component; the first one of a channel is in work when its program begins. Facts: reference
//! control-emulator.md 8.1, 8.3.

use std::sync::Arc;

use super::Machine;

/// A component of a composite machine.
#[derive(Debug, Clone)]
pub struct Component {
    /// The minor word by which macros name it.
    pub designator: String,
    /// Name for people, 1–32 characters.
    pub name: String,
    /// Numbers of the channels that it may work in, ascending.
    pub channels: Vec<u16>,
    /// What its control does.
    pub machine: Arc<Machine>,
}
