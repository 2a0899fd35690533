//! Frames: maps between programmed points, the part and the machine.

pub mod affine;
pub mod beside;
pub mod circle;
pub mod kinematics;
pub mod local;
pub mod orient;
pub mod plane;
pub mod tool_direction;
