//! The macro language of the control emulator. Knows nothing of machines, programs, channels or I/O.
//!
//! Now here: the numeric output format that listings, registers and macros share ([`format`]).

pub mod format;
