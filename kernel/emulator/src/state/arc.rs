//! What codes have said about circles to come: centre, radius, direction.
//!
//! *Invariant:* a defined centre is a point and stays until another definition.

use counterpoint_machine::ident::kind::arc::By;

/// What is known about the circles of a channel.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Arcs {
    /// Defined centre by X, Y and Z: radius values in the work frame.
    pub(crate) center: [Option<f64>; 3],
    /// Defined radius.
    pub(crate) radius: Option<f64>,
    /// Clockwise, as the last circle or code of direction said.
    pub(crate) clockwise: Option<bool>,
    /// Form defined last, and on which block.
    pub(crate) by: By,
    pub(crate) block: u64,
}
