//! What the macros of a machine add to the way of a block, to its codes, its events and its program.

mod block;
mod codes;
mod embedded;
mod events;
mod program;
mod remarks;
mod run;
mod subprogram;
