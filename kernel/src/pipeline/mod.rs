//! The way of one block: read, edit, pre-process, split, codes, leftovers, follow.
//!
//! Each stage is a function in a file of its own. A machine with macros adds hooks between the stages (`plan.hooks`); a
//! machine without macros has none of them and goes the same way. Facts: reference control-emulator.md 2.2, 2.3.

mod codes;
mod definitions;
mod edit;
mod follow;
mod leftovers;
mod read;
mod split;
