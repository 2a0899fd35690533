//! NC program text (machine control data): sources, layouts, words, the reader.

pub mod block;
pub mod block_list;
pub mod by_first;
pub mod callers;
pub mod kept;
pub mod key_words;
pub mod layout;
pub mod line_up;
mod mains;
mod option_checks;
pub mod prefix_registers;
pub mod presets;
mod readers;
mod rules;
pub mod scan;
pub mod search;
pub mod sections;
pub mod shape;
pub mod source;
pub mod sources;
pub mod spec;
pub mod spot;
pub mod syntax;
pub mod tape;
pub mod visible;
