//! Pre-processors: what turns a program line with variables and statements into plain words.

pub(crate) mod fanuc;
