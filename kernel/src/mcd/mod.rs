//! NC program text (machine control data): sources, layouts, words, the reader.

mod heads;
pub(crate) mod key_words;
pub(crate) mod layout;
pub mod program;
pub mod source;
pub mod sources;
pub(crate) mod special;
pub(crate) mod spot;
pub mod syntax;
pub(crate) mod tape;
