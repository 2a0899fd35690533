//! What codes are about, beyond their names.

pub(crate) mod arc;
pub(crate) mod axis;
pub(crate) mod coolant;
pub(crate) mod cycle;
pub(crate) mod thread;
