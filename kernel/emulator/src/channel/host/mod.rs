//! A kernel as the host of its interpreter, by concern.
//!
//! Facts: reference control-emulator.md 2.2, 4.3, 5.4, 5.7. *Invariant:* nothing here knows which dialect asks.

mod coordination;
mod flow;
mod frames;
mod programs;
mod report;
mod values;
mod words;
