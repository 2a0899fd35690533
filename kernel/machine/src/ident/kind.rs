//! What codes are about, beyond their names.

pub mod arc;
pub mod axis;
pub mod coolant;
pub mod cycle;
pub mod thread;
